//! The folder of a proof: where each case's files lie, and the seals of its truths.
//!
//! A truth is sealed by the SHA-256 of its file, which is published before the diagnosis begins; a truth that was
//! changed afterwards is refused. `seals.txt` is in the format of `sha256sum`, so `sha256sum -c seals.txt` checks all.

use crate::Error;
use crate::files::{json, make_folder, parse, read, read_json, write};
use host_sim::Air;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::path::{Path, PathBuf};

/// What was logged, and all that a diagnosis sees besides the model.
pub const RECORDING: &str = "recording.csv";
/// The user's model.
pub const MODEL: &str = "model.toml";
/// What was concealed.
pub const TRUTH: &str = "truth.json";
/// Hash of the truth.
pub const SEAL: &str = "truth.sha256";
/// What the diagnosis answered.
pub const ANSWER: &str = "answer.json";
/// What the two methods beside it answered.
pub const BESIDE: &str = "beside.json";

/// A folder of cases.
pub struct Folder(PathBuf);

/// What a folder's cases were drawn from.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Origin {
    seed: u64,
    version: String,
    #[serde(default)]
    air: Air,
}

impl Folder {
    /// Makes the folder, or goes on in one where a proof of the same seed and version was begun.
    pub fn open(path: &Path, seed: u64, air: Air, resume: bool) -> Result<Self, Error> {
        let folder = Self(path.to_owned());
        let origin = Origin { seed, version: env!("CARGO_PKG_VERSION").to_owned(), air };
        let place = folder.file("proof.json");
        let shown = path.display();
        if place.exists() {
            if !resume {
                let help = "add --resume to go on with it, or name another folder";
                return Err(Error::new(format!("{shown}: holds a proof already"), help));
            }
            let found: Origin = read_json(&place)?;
            if found != origin {
                let Origin { seed, version, air } = found;
                let message =
                    format!("{shown}: its proof is of seed {seed}, version {version} and air {air}");
                return Err(Error::new(message, "resume with the same seed and air, or name another folder"));
            }
        }
        std::fs::create_dir_all(folder.file("cases")).map_err(|e| Error::unwritable(path, &e))?;
        write(&place, &json(&origin)?)?;
        Ok(folder)
    }

    /// A file of the whole proof.
    pub fn file(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    /// A file of one case.
    pub fn of(&self, case: u64, name: &str) -> PathBuf {
        self.0.join("cases").join(format!("{case:04}")).join(name)
    }

    /// Makes the folder of a case.
    pub fn make(&self, case: u64) -> Result<(), Error> {
        make_folder(&self.of(case, ""))
    }

    /// Whether a case has this file.
    pub fn has(&self, case: u64, name: &str) -> bool {
        self.of(case, name).exists()
    }

    /// Writes the truth of a case and, last of all, its seal.
    pub fn seal(&self, case: u64, truth: &str) -> Result<(), Error> {
        write(&self.of(case, TRUTH), truth)?;
        write(&self.of(case, SEAL), &(sha256_hex(truth.as_bytes()) + "\n"))
    }

    /// The seal of a case: a line of `sha256sum`.
    pub fn seal_line(&self, case: u64) -> Result<String, Error> {
        let seal = read(&self.of(case, SEAL))?;
        Ok(format!("{}  cases/{case:04}/{TRUTH}\n", seal.trim()))
    }

    /// Opens a truth if it is still the one that was sealed.
    pub fn open_truth<T: DeserializeOwned>(&self, case: u64) -> Result<T, Error> {
        let path = self.of(case, TRUTH);
        let text = read(&path)?;
        if sha256_hex(text.as_bytes()) != read(&self.of(case, SEAL))?.trim() {
            let message = format!("{}: is not the file that was sealed", path.display());
            return Err(Error::new(message, "remove the case's folder and prove again with --resume"));
        }
        parse(&path, &text)
    }
}

/// SHA-256 in hexadecimal.
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hash_is_that_of_the_standard() {
        // FIPS 180-4, the message "abc"
        let expected = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
        assert_eq!(sha256_hex(b"abc"), expected);
    }

    #[test]
    fn a_truth_that_was_changed_is_refused() {
        let place = tempfile::tempdir().unwrap();
        let folder = Folder::open(place.path(), 1, Air::default(), false).unwrap();
        folder.make(3).unwrap();
        folder.seal(3, "[1, 2]").unwrap();
        assert_eq!(folder.open_truth::<Vec<u8>>(3).unwrap(), [1, 2]);
        assert!(folder.seal_line(3).unwrap().ends_with("  cases/0003/truth.json\n"));
        std::fs::write(folder.of(3, TRUTH), "[1, 3]").unwrap();
        assert!(folder.open_truth::<Vec<u8>>(3).unwrap_err().to_string().contains("not the file"));
    }

    #[test]
    fn a_folder_is_gone_on_with_only_where_that_was_asked_for_and_the_seed_is_the_same() {
        let place = tempfile::tempdir().unwrap();
        Folder::open(place.path(), 1, Air::default(), false).unwrap();
        assert!(Folder::open(place.path(), 1, Air::default(), false).is_err());
        assert!(Folder::open(place.path(), 1, Air::default(), true).is_ok());
        assert!(
            Folder::open(place.path(), 2, Air::default(), true)
                .is_err_and(|e| e.to_string().contains("seed 1"))
        );
    }
}
