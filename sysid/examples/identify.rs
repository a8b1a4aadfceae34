//! All methods of identification side by side, judged on sections that none has seen.
//!
//! `cargo run --release -p sysid --example identify -- flight.csv`

use std::path::Path;
use sysid::error::Error;
use sysid::identify::compare::identify;
use sysid::recording::{ReadOptions, read};

fn main() -> Result<(), Error> {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: identify RECORDING.csv");
        std::process::exit(2);
    };
    let recording = read(Path::new(&path), &ReadOptions::default())?;
    let found = identify(&[recording], None, &|step| eprintln!("{step}"))?;
    for method in &found.methods {
        println!("{} ({}): {:?}", method.name, method.detail, method.vaf_percent);
    }
    Ok(())
}
