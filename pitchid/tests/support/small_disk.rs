//! A disk that is full.

use std::path::Path;
use std::process::Command;

/// Runs `script` in `folder`, with the program as `$1`, where `disk` is a file system of so many kilobytes: what it ended with, and
/// its standard error without line breaks. None where the system lends no such thing.
pub fn on_a_small_disk(folder: &Path, kilobytes: u32, script: &str) -> Option<(i32, String)> {
    const NONE: i32 = 99;
    std::fs::create_dir_all(folder.join("disk")).unwrap();
    let mounted = format!("mount -t tmpfs -o size={kilobytes}k none disk || exit {NONE}\n{script}");
    let shell = ["--user", "--map-root-user", "--mount", "sh", "-c", &mounted, "sh"];
    let mut command = Command::new("unshare");
    command.args(shell).arg(env!("CARGO_BIN_EXE_pitchid")).current_dir(folder);
    let output = command.output().ok();
    let told = |bytes: &[u8]| String::from_utf8_lossy(bytes).split_whitespace().collect::<Vec<_>>().join(" ");
    match output.map(|output| (output.status.code().unwrap(), told(&output.stderr))) {
        // `unshare` itself ends with 1 where it may not
        None | Some((1 | NONE, _)) => {
            println!("skipped: the system lends no file system of its own");
            None
        }
        answer => answer,
    }
}
