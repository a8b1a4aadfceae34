//! `cargo xtask image | chip-test | flash`: the flight image, built, tested in the emulator, put on a board.
//! `cargo xtask book | book-check`: the book's pages of the effects, and the book built and held to what it says.
//! `cargo xtask browser`: the pages of the program in a real browser.
//! `cargo xtask fuzz`: arbitrary bytes into every reader, the board's link and the diagnosis.
//! `cargo xtask messages`: the code of the messages from their definitions.
//! `cargo xtask wheel`: the package for Python as a wheel.

mod book;
mod browser;
mod budget;
mod chip_test;
mod fuzz;
mod image;
mod messages;
mod no_panic;
mod wheel;

use std::process::{Command, ExitCode};

type Outcome<T = ()> = Result<T, String>;

const USAGE: &str = "usage: cargo xtask COMMAND
  image       build the flight image and print its size
  no-panic    prove that the control interrupt cannot panic, with a negative control
  chip-test   build the images and run everything that needs the emulated chip
  flash       build the flight image and put it on a board (probe-rs)
  book        write the book's pages of the effects: simulates and diagnoses each
  book-check  build the book (mdbook), follow its links, run its commands
  fuzz        arbitrary bytes into every target of fuzz/ [--seconds N for all together] [--seed N] [TARGET...]
  messages    write the code of the board's messages from their definitions (mavlink-bindgen)
  wheel       build the package for Python as a wheel (maturin, installed beside it)
  browser     look at the pages of the program in Chromium";

fn main() -> ExitCode {
    let command = std::env::args().nth(1);
    let outcome = match command.as_deref() {
        Some("image") => image(),
        Some("no-panic") => no_panic::check(),
        Some("chip-test") => chip_test::run(),
        Some("flash") => flash(),
        Some("book") => book::pages(),
        Some("book-check") => book::check(),
        Some("fuzz") => fuzz::run(std::env::args().skip(2)),
        Some("messages") => messages::write(),
        Some("wheel") => wheel::build(),
        Some("browser") => browser::check(),
        _ => Err(USAGE.to_owned()),
    };
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}

fn image() -> Outcome {
    let images = image::build(None)?;
    let mut ledger = budget::Ledger::open()?;
    budget::sizes(&images.flight, &mut ledger)?;
    println!("{}", images.flight.display());
    ledger.close()
}

fn flash() -> Outcome {
    let images = image::build(None)?;
    let status =
        Command::new("probe-rs").args(["run", "--chip", "STM32F405RGTx"]).arg(&images.flight).status();
    let status = status
        .map_err(|error| format!("probe-rs cannot be run ({error}); `cargo install probe-rs-tools`"))?;
    if status.success() {
        Ok(())
    } else {
        Err("probe-rs did not finish: is the board powered and the probe connected?".into())
    }
}

/// Runs a command to its end and returns what it printed.
fn output(command: &mut Command) -> Outcome<String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.output().map_err(|error| format!("{name} cannot be run ({error})"))?;
    if !output.status.success() {
        return Err(format!("{name} failed:\n{}", String::from_utf8_lossy(&output.stderr)));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}
