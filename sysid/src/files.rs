//! Files as bytes and as text, never more than a stated size: a device or a pipe may have no end.

use crate::error::{Error, ErrorKind};
use std::fs::File;
use std::io::Read;
use std::path::Path;

/// Largest recording that is read, bytes: ten hours at 250 Hz as CSV are half of it.
pub const LARGEST_RECORDING: u64 = 1 << 30;
/// Largest model file, monitor's file or file of taps that is read, bytes.
pub const LARGEST_TEXT: u64 = 1 << 24;

/// The bytes of a file, a pipe or a device, up to `largest` of them.
///
/// # Errors
/// A directory, what cannot be read, and what is larger; a file that says so beforehand is not read at all.
pub fn read(path: &Path, largest: u64) -> Result<Vec<u8>, Error> {
    let name = path.display().to_string();
    let unreadable = |error: std::io::Error| Error::from_io(&name, &error);
    if path.is_dir() {
        return Err(unreadable(std::io::ErrorKind::IsADirectory.into()));
    }
    let file = File::open(path).map_err(unreadable)?;
    if file.metadata().map_err(unreadable)?.len() > largest {
        return Err(too_large(&name, largest));
    }
    read_from(&name, file, largest)
}

/// The bytes of a source that may have no end, up to `largest` of them; `name` stands for it in messages.
///
/// # Errors
/// What cannot be read, and what is larger.
pub fn read_from(name: &str, source: impl Read, largest: u64) -> Result<Vec<u8>, Error> {
    let mut bytes = Vec::new();
    source.take(largest + 1).read_to_end(&mut bytes).map_err(|error| Error::from_io(name, &error))?;
    if bytes.len() as u64 > largest { Err(too_large(name, largest)) } else { Ok(bytes) }
}

fn too_large(name: &str, largest: u64) -> Error {
    let found = format!("more than {} MiB", largest >> 20);
    let advice = "check that it is the file that you mean; a longer recording is cut in parts first";
    Error::new(ErrorKind::File, found, advice).in_file(name)
}

/// The text of a small file.
///
/// # Errors
/// As [`read`] up to [`LARGEST_TEXT`], and what is not UTF-8; `advice` says what to do then.
pub fn read_text(path: &Path, advice: &str) -> Result<String, Error> {
    String::from_utf8(read(path, LARGEST_TEXT)?).map_err(|error| {
        let found = format!("not UTF-8 text: offset {}", error.utf8_error().valid_up_to());
        Error::new(ErrorKind::Format, found, advice).in_file(path.display().to_string())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_is_refused_whether_it_says_so_or_not() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("large");
        std::fs::write(&path, [b'x'; 11]).unwrap();
        assert_eq!(read(&path, 11).unwrap().len(), 11);
        assert!(read(&path, 10).unwrap_err().to_string().contains("more than"));
        // a file of 1 TiB that takes no room on the disk
        File::create(&path).unwrap().set_len(1 << 40).unwrap();
        assert!(read(&path, LARGEST_RECORDING).unwrap_err().to_string().contains("more than 1024 MiB"));
        #[cfg(target_os = "linux")]
        assert!(read(Path::new("/dev/zero"), 1 << 20).unwrap_err().to_string().contains("more than 1 MiB"));
    }
}
