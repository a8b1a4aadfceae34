//! `pitchid`: what is missing from the model of a pitch axis, from recordings of it.
//!
//! The command only reads arguments, calls the libraries, and shows what they answer: on the terminal, as JSON, and as a
//! report of one HTML file. What it answers can be had in another program as well: [`answers`].

pub mod answers;
mod axes;
mod board;
mod commands;
mod export;
mod failure;
mod format;
mod input;
mod logs;
mod output;
mod progress;
mod report;
mod text;
mod vehicle;

pub use failure::{Failure, Place};

use clap::Parser;
use std::process::ExitCode;

/// Input that could not be used; clap uses the same status for arguments that it cannot read.
const UNUSABLE: u8 = 2;

/// The command: reads the arguments of this process, and answers.
#[must_use]
pub fn main() -> ExitCode {
    failure::install();
    match commands::run(commands::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            ExitCode::from(UNUSABLE)
        }
    }
}
