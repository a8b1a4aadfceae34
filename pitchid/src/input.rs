//! What is read: files by name, and standard input for `-`.

use crate::failure::Failure;
use crate::logs::quoted;
use crate::output;
use std::fs::File;
use std::io::Read;
use std::path::Path;
use sysid::error::Error;

/// The name that stands for standard input.
const STDIN: &str = "-";
/// What messages call it.
const STDIN_NAME: &str = "standard input";

/// Whether this path stands for standard input.
pub fn is_stdin(path: &Path) -> bool {
    path == Path::new(STDIN)
}

/// The name for messages.
pub fn name_of(path: &Path) -> String {
    if is_stdin(path) { STDIN_NAME.to_owned() } else { path.display().to_string() }
}

/// What was [`name_of`] a path, as an argument of a shell.
pub fn argument(name: &str) -> String {
    if name == STDIN_NAME { STDIN.to_owned() } else { quoted(Path::new(name)) }
}

/// Opens a file, a pipe or a device, or standard input.
pub fn open(path: &Path) -> Result<Box<dyn Read>, Failure> {
    if is_stdin(path) {
        return Ok(Box::new(std::io::stdin()));
    }
    let file = match path.is_dir() {
        true => Err(std::io::ErrorKind::IsADirectory.into()),
        false => File::open(path),
    };
    Ok(Box::new(file.map_err(|error| Error::from_io(&name_of(path), &error))?))
}

/// Size of a file that is told before it is read, bytes.
const LARGE: u64 = 8 << 20;

/// Says on standard error which of the files are large; not with `--quiet`.
pub fn say_what_is_large<'a>(paths: impl IntoIterator<Item = &'a Path>) {
    for path in paths.into_iter().filter(|_| !output::is_quiet()) {
        let size = path.metadata().map_or(0, |found| if found.is_file() { found.len() } else { 0 });
        if size >= LARGE {
            eprintln!("{}: {} MB to read", path.display(), size / 1_000_000);
        }
    }
}

/// Refuses standard input as more than one of the inputs: it can be read only once.
pub fn once<'a>(paths: impl IntoIterator<Item = &'a Path>) -> Result<(), Failure> {
    if paths.into_iter().filter(|path| is_stdin(path)).count() < 2 {
        return Ok(());
    }
    let help = "write one of them to a file, and name that";
    Err(Failure::new("- stands for standard input, which can be read only once", help))
}
