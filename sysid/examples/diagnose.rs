//! What does the model of a recording leave out?
//!
//! `cargo run --release -p sysid --example diagnose -- flight.csv [simulation.toml]`

use std::path::Path;
use sysid::catalogue::model_file::read_model;
use sysid::diagnosis::diagnose;
use sysid::error::Error;
use sysid::recording::{ReadOptions, read};

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let Some(recording) = arguments.next() else {
        eprintln!("usage: diagnose RECORDING.csv [MODEL.toml]");
        std::process::exit(2);
    };
    let recording = read(Path::new(&recording), &ReadOptions::default())?;
    let model = arguments.next().map(|path| read_model(Path::new(&path), None)).transpose()?;
    let found = diagnose(&[recording], model.as_ref(), &|step| eprintln!("{step}"))?;
    println!("{}", found.answer.summary);
    for effect in &found.answer.effects {
        for parameter in &effect.parameters {
            let [low, high] = parameter.ci95;
            println!(
                "{}.{} = {} {} ({low} to {high})",
                effect.id, parameter.name, parameter.value, parameter.unit
            );
        }
    }
    Ok(())
}
