//! The package for Python as a wheel, for every Python from 3.10 on.

use crate::{Outcome, image, output};
use std::process::Command;

/// What builds wheels.
const MATURIN: &str = "maturin>=1.9,<2";

/// Builds `target/wheels/*.whl`, with maturin in an environment of its own.
pub fn build() -> Outcome {
    let root = image::root();
    let (environment, wheels) = (root.join("target/maturin"), root.join("target/wheels"));
    output(Command::new("python3").args(["-m", "venv"]).arg(&environment))?;
    let program = environment.join(if cfg!(windows) { "Scripts" } else { "bin" });
    output(Command::new(program.join("python")).args(["-m", "pip", "install", "--quiet", MATURIN]))?;
    let mut maturin = Command::new(program.join("maturin"));
    maturin.args(["build", "--release", "--manifest-path"]).arg(root.join("python/Cargo.toml"));
    maturin.arg("--out").arg(&wheels).env("CARGO_TARGET_DIR", root.join("target"));
    output(&mut maturin)?;
    let files = std::fs::read_dir(&wheels).map_err(|error| format!("{}: {error}", wheels.display()))?;
    for file in files.flatten() {
        println!("{}", file.path().display());
    }
    Ok(())
}
