//! The book: `docs/`, built by mdBook. `pages` writes a page for each effect of the catalogue from a diagnosis of it;
//! `check` builds the book, follows its links and runs its commands.

mod check;
mod equations;
mod links;
mod pages;

use crate::{Outcome, output};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Writes `docs/effects/`: each effect concealed in the nominal vehicle, flown, and diagnosed without the truth.
pub fn pages() -> Outcome {
    equations::write(&root())?;
    pages::write(&root(), &pitchid()?)
}

/// Builds the book, follows its links, runs its commands, and looks for every field of their answers.
pub fn check() -> Outcome {
    let root = root();
    equations::check(&root)?;
    links::check(&root.join("docs"))?;
    output(
        Command::new("mdbook")
            .arg("build")
            .arg(root.join("docs"))
            .arg("--dest-dir")
            .arg(root.join("target/book")),
    )
    .map_err(|why| format!("{why}\n`cargo install mdbook --locked --no-default-features` installs it"))?;
    println!("book: {}", root.join("target/book/index.html").display());
    check::run(&root, &pitchid()?)
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").canonicalize().expect("the checkout is there")
}

/// The command itself: that of the variable PITCHID, or else built now.
fn pitchid() -> Outcome<PathBuf> {
    if let Some(path) = std::env::var_os("PITCHID") {
        return Ok(path.into());
    }
    output(Command::new("cargo").args(["build", "--release", "--locked", "--bin", "pitchid"]))?;
    let metadata = output(Command::new("cargo").args(["metadata", "--format-version", "1", "--no-deps"]))?;
    let metadata: serde_json::Value = serde_json::from_str(&metadata).map_err(|error| error.to_string())?;
    let target = metadata["target_directory"].as_str().ok_or("cargo metadata names no target directory")?;
    Ok(Path::new(target).join("release/pitchid"))
}
