//! Text and JSON files.

use crate::Error;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::Path;

/// Makes a folder and those that it lies in.
pub fn make_folder(path: &Path) -> Result<(), Error> {
    fs::create_dir_all(path).map_err(|e| Error::unwritable(path, &e))
}

/// Writes a file.
pub fn write(path: &Path, text: &str) -> Result<(), Error> {
    write_whole(path, text.as_bytes()).map_err(|e| Error::unwritable(path, &e))
}

/// Writes a file that appears whole or not at all: beside its place, synced, then moved there. What stood there until then stays
/// when the disk is full or the program is killed. What is no plain file, as a device or a pipe, is written as it is.
///
/// # Errors
/// No place, no leave, no such folder.
pub fn write_whole(path: &Path, bytes: &[u8]) -> io::Result<()> {
    // a link stays a link
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let present = fs::metadata(&place).ok();
    if present.as_ref().is_some_and(|present| !present.is_file()) {
        return fs::write(&place, bytes);
    }
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".pitchid-");
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut beside = builder.tempfile_in(folder)?;
    beside.write_all(bytes)?;
    if let Some(present) = present {
        beside.as_file().set_permissions(present.permissions())?;
    }
    beside.as_file().sync_all()?;
    beside.persist(&place)?;
    // not every system can sync a folder, and the file is whole either way
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}

/// Whether [`write_whole`] would find a place for this file: asked before the work whose answer it is to take.
///
/// # Errors
/// No leave, no such folder, a system that takes no files.
pub fn probe(path: &Path) -> io::Result<()> {
    let place = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    // a pipe that is opened and closed is one that has ended
    if fs::metadata(&place).is_ok_and(|present| !present.is_file()) {
        return Ok(());
    }
    let folder = place.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    tempfile::Builder::new().prefix(".pitchid-").tempfile_in(folder).map(drop)
}

/// JSON text, indented.
pub fn json(value: &impl Serialize) -> Result<String, Error> {
    let text = serde_json::to_string_pretty(value);
    text.map(|t| t + "\n").map_err(|e| Error::new(format!("the JSON could not be made: {e}"), "begin anew"))
}

/// Reads a file of a case.
pub fn read(path: &Path) -> Result<String, Error> {
    let help = "remove the case's folder and prove again with --resume";
    Ok(sysid::files::read_text(path, help)?)
}

/// Reads a JSON file of a case.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    parse(path, &read(path)?)
}

/// What the JSON text of a file says.
pub fn parse<T: DeserializeOwned>(path: &Path, text: &str) -> Result<T, Error> {
    serde_json::from_str(text).map_err(|e| unreadable(path, &e.to_string()))
}

fn unreadable(path: &Path, why: &str) -> Error {
    let help = "remove the case's folder and prove again with --resume";
    Error::new(format!("{}: cannot be read: {why}", path.display()), help)
}

#[cfg(test)]
mod tests {
    use super::write_whole;
    use std::fs;
    use std::path::Path;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_is_left_in_its_folder() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("answer.json");
        for text in ["first", "the second, which is longer", "3"] {
            write_whole(&file, text.as_bytes()).unwrap();
            assert_eq!(fs::read_to_string(&file).unwrap(), text);
        }
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(write_whole(&folder.path().join("no/such"), b"x").is_err());
        assert!(write_whole(folder.path(), b"x").is_err());
    }

    #[cfg(unix)]
    #[test]
    fn links_rights_and_devices_stay_what_they_are() {
        use std::os::unix::fs::{PermissionsExt, symlink};
        let folder = tempfile::tempdir().unwrap();
        let [file, link] = ["file", "link"].map(|name| folder.path().join(name));
        fs::write(&file, "old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        symlink(&file, &link).unwrap();
        write_whole(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(fs::metadata(&file).unwrap().permissions().mode() & 0o777, 0o640);
        write_whole(Path::new("/dev/null"), b"gone").unwrap();
        assert!(!fs::metadata("/dev/null").unwrap().is_file());
    }
}
