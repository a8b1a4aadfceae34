//! What can be asked for. Each subcommand reads its arguments, calls the libraries and shows what they answer.

mod board_arguments;
pub mod compare;
mod convert;
mod demo;
pub mod diagnose;
mod doctor;
mod effect_spec;
mod fly;
pub mod identify;
mod monitor;
pub mod plan;
pub mod prove;
pub mod reading;
mod record;
mod reproduce;
mod shell;
pub mod show;
pub mod simulate;

use crate::failure::Failure;
use crate::output;
use clap::{Parser, Subcommand};

/// Finds out what the model of a vehicle's pitch axis leaves out: locates it, names it, adds it to the model, and shows what
/// that gains.
#[derive(Parser)]
#[command(version, arg_required_else_help = true, after_help = AFTER_HELP)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,

    /// Print no progress, and no words beside what goes to - or a file; what is wrong is said all the same
    #[arg(long, short, global = true)]
    quiet: bool,
}

const AFTER_HELP: &str = "\
Examples:
  pitchid demo                                        see it all at work, without data of your own
  pitchid show flight.ulg                             what a log holds, and whether it can serve
  pitchid diagnose flight.csv --model sim.toml --report flight.html
  pitchid identify test1.csv test2.csv --out-model fitted.toml
  pitchid compare before.csv after.csv                what changed on the craft
  pitchid monitor flight.csv --monitor craft.toml     is the craft still what it was, and if not, what changed
  pitchid plan --mass 5 --arm 0.415 --out bench       the first experiment, before it is flown
  pitchid convert flight.ulg roll.csv --axis roll     a log's axis as a table
  pitchid doctor flight.ulg                           why a log fails, and what to do
  pitchid reproduce paper --seeds 20
  pitchid simulate --effect coulomb_friction:Mc=0.1 --out friction.csv
  pitchid prove                                       conceal, seal, diagnose, count: how often it is right
  pitchid fly /dev/ttyUSB0 --campaign 4 --out flight.csv

Exit status:
  0  the question was answered, whatever the answer is
  2  the input or the arguments could not be used; the message says where and what to do

The book: docs/introduction.md; every column, key and field of the files: docs/formats.md";

#[derive(Subcommand)]
enum Command {
    Compare(compare::Arguments),
    Completions(shell::Completions),
    Convert(convert::Arguments),
    Demo(demo::Arguments),
    Diagnose(diagnose::Arguments),
    Doctor(doctor::Arguments),
    Fly(fly::Arguments),
    Identify(identify::Arguments),
    Man(shell::Man),
    Monitor(monitor::Arguments),
    Plan(plan::Arguments),
    Prove(prove::Arguments),
    Record(record::Arguments),
    Reproduce(reproduce::Arguments),
    Show(show::Arguments),
    Simulate(simulate::Arguments),
}

/// Does what was asked for.
///
/// # Errors
/// Input that cannot be used, with a message for people.
pub fn run(cli: Cli) -> Result<(), Failure> {
    output::be_quiet(cli.quiet);
    match cli.command {
        Command::Compare(arguments) => compare::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Demo(arguments) => demo::run(&arguments),
        Command::Diagnose(arguments) => diagnose::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::Fly(arguments) => fly::run(&arguments),
        Command::Identify(arguments) => identify::run(&arguments),
        Command::Man(arguments) => shell::man(&arguments),
        Command::Monitor(arguments) => monitor::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Prove(arguments) => prove::run(&arguments),
        Command::Record(arguments) => record::run(&arguments),
        Command::Reproduce(arguments) => reproduce::run(&arguments),
        Command::Show(arguments) => show::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
    }
}
