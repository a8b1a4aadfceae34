//! `pitchid`: what is missing from the model of a pitch axis, from recordings of it.
//!
//! The command only reads arguments, calls the libraries, and shows what they answer: on the terminal
//! ([`text`]), as JSON, and as a report of one HTML file ([`report`]).

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

use clap::Parser;
use std::process::ExitCode;

/// Input that could not be used; clap uses the same status for arguments that it cannot read.
const UNUSABLE: u8 = 2;

fn main() -> ExitCode {
    failure::install();
    match commands::run(commands::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            failure.print();
            ExitCode::from(UNUSABLE)
        }
    }
}
