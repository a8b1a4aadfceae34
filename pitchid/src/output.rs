//! Where answers go: standard output, and files that overwrite no input.

use crate::failure::Failure;
use benchmark::files::{probe, write_whole};
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

/// The name that stands for standard output.
pub const STDOUT: &str = "-";

/// Whether this path stands for standard output.
pub fn is_stdout(path: Option<&Path>) -> bool {
    path.is_some_and(|p| p == Path::new(STDOUT))
}

/// Whether nothing is wanted on the terminal but what was asked for by name.
static QUIET: AtomicBool = AtomicBool::new(false);
/// Whether standard output belongs to one answer.
static TAKEN: AtomicBool = AtomicBool::new(false);

/// Silences [`print()`] and progress; set once, before anything is printed.
pub fn be_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Whether they are silenced.
pub fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Prints words to standard output; nothing with `--quiet`, or where an answer has standard output to itself.
pub fn print(text: &str) -> Result<(), Failure> {
    if is_quiet() || TAKEN.load(Ordering::Relaxed) { Ok(()) } else { print_asked(text) }
}

/// Prints what was asked for by name. A reader that has gone away (`| head`) wants no more, which is no error.
pub fn print_asked(text: &str) -> Result<(), Failure> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(Failure::new(format!("standard output: {error}"), "make room where it goes"))
        }
        _ => Ok(()),
    }
}

/// Columns of the terminal, within what reads well; 100 where standard output is no terminal.
pub fn width() -> u16 {
    terminal_size::terminal_size_of(std::io::stdout()).map_or(100, |(width, _)| width.0.clamp(60, 120))
}

/// Writes a file, or standard output for `-`.
pub fn write(path: &Path, text: &str) -> Result<(), Failure> {
    if is_stdout(Some(path)) {
        return print_asked(text);
    }
    write_bytes(path, text.as_bytes())
}

/// Writes a file, whole or not at all.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    write_whole(path, bytes).map_err(|error| Failure::unwritable(path, &error))
}

/// Makes a folder, and what it lies in, where it is not there.
pub fn folder(path: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(path).map_err(|error| Failure::unwritable(path, &error))
}

/// An answer as JSON text, indented.
pub fn json(answer: &impl serde::Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(answer);
    text.map(|t| t + "\n")
        .map_err(|e| Failure::new(format!("the JSON could not be made: {e}"), "leave out --json"))
}

/// Refuses, before any work is done, an output that is a folder, lies in no folder or where nothing can be written, or would overwrite
/// an input or another output.
/// One that is standard output has it to itself from now on.
pub fn check<'a>(outputs: impl IntoIterator<Item = &'a Path>, inputs: &[&Path]) -> Result<(), Failure> {
    let outputs: Vec<&Path> = outputs.into_iter().collect();
    let on_stdout = outputs.iter().filter(|output| is_stdout(Some(output))).count();
    if on_stdout > 1 {
        return Err(Failure::new(
            "- stands for standard output, which takes one answer",
            "name files for the others",
        ));
    }
    TAKEN.store(on_stdout == 1, Ordering::Relaxed);
    let mut taken: Vec<(PathBuf, &str)> =
        inputs.iter().filter_map(|i| Some((i.canonicalize().ok()?, "an input"))).collect();
    for output in outputs.into_iter().filter(|o| !is_stdout(Some(*o))) {
        let name = output.display();
        if output.is_dir() {
            return Err(Failure::new(format!("{name}: this is a directory"), "name a file inside it"));
        }
        let parent = output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let Ok(folder) = parent.canonicalize() else {
            let message = format!("{name}: there is no folder {}", parent.display());
            return Err(Failure::new(message, "make the folder, or name another"));
        };
        let place =
            output.canonicalize().unwrap_or_else(|_| folder.join(output.file_name().unwrap_or_default()));
        let same = |(other, _): &&(PathBuf, &str)| *other == place || is_same_file(other, &place);
        if let Some((_, what)) = taken.iter().find(same) {
            return Err(Failure::new(format!("{name}: would overwrite {what}"), "name another file"));
        }
        probe(&place).map_err(|error| Failure::unwritable(output, &error))?;
        taken.push((place, "another output"));
    }
    Ok(())
}

/// Whether two names stand for one file: hard links.
#[cfg(unix)]
fn is_same_file(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |path: &Path| {
        path.metadata().ok().filter(std::fs::Metadata::is_file).map(|found| (found.dev(), found.ino()))
    };
    identity(one).is_some_and(|own| identity(other) == Some(own))
}

#[cfg(not(unix))]
fn is_same_file(_one: &Path, _other: &Path) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_overwrite_neither_inputs_nor_each_other() {
        let folder = tempfile::tempdir().unwrap();
        let input = folder.path().join("in.csv");
        std::fs::write(&input, "x").unwrap();
        let [a, b] = ["a.json", "b.html"].map(|name| folder.path().join(name));
        let fresh = [a.as_path(), b.as_path(), Path::new("-")];
        assert!(check(fresh, &[&input]).is_ok());
        let refused = |outputs: &[&Path]| check(outputs.iter().copied(), &[&input]).unwrap_err().to_string();
        assert!(refused(&[&folder.path().join(".").join("in.csv")]).contains("an input"));
        assert!(refused(&[&a, &a]).contains("another output"));
        assert!(refused(&[folder.path()]).contains("directory"));
        assert!(refused(&[&folder.path().join("no/such.json")]).contains("no folder"));
    }
}
