//! The rooms of the crate: data walk down the list, nothing imports upward.

use std::path::{Path, PathBuf};

/// Rooms from the bottom up; those of one row may use each other.
const ROOMS: [&[&str]; 10] = [
    &["error", "estimate", "files", "legal", "linalg", "moving_mean", "progress", "toml_file"],
    &["recording"],
    &["dataset"],
    &["held_out"],
    &["model"],
    &["catalogue"],
    &["optim", "validate"],
    &["likelihood"],
    &["identify", "compare", "monitor"],
    &["diagnosis"],
];

fn files(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            found.push(path);
        }
    }
}

fn height(room: &str) -> Option<usize> {
    ROOMS.iter().position(|row| row.contains(&room))
}

/// The rooms that a file names in its code, tests and comments left out.
fn imports(text: &str) -> Vec<String> {
    let code = text.split("#[cfg(test)]").next().unwrap_or("");
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
    lines.flat_map(|line| line.split("crate::").skip(1).map(name).collect::<Vec<String>>()).collect()
}

#[test]
fn nothing_imports_upward() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut all = Vec::new();
    files(&source, &mut all);
    assert!(all.len() > 80, "{}", all.len());
    let mut upward = Vec::new();
    for path in all {
        let inside = path.strip_prefix(&source).unwrap();
        let room = inside.iter().next().unwrap().to_str().unwrap().trim_end_matches(".rs").to_owned();
        // Tests may use what they like.
        if room == "lib" || inside.ends_with("tests.rs") {
            continue;
        }
        let own = height(&room).unwrap_or_else(|| panic!("{room} has no place in the list of rooms"));
        for import in imports(&std::fs::read_to_string(&path).unwrap()) {
            if height(&import).is_some_and(|other| other > own) {
                upward.push(format!("{} uses {import}", inside.display()));
            }
        }
    }
    assert!(upward.is_empty(), "{}", upward.join("\n"));
}

#[test]
fn simulator_and_identification_do_not_know_each_other() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    for (own, other) in [("sysid", "host-sim"), ("host-sim", "sysid")] {
        let manifest = std::fs::read_to_string(root.join(own).join("Cargo.toml")).unwrap();
        assert!(!manifest.contains(other), "{own} knows {other}");
    }
}
