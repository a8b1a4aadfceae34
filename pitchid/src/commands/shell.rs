//! `pitchid completions` and `pitchid man`: what a shell and a manual want to know of the command.

use super::Cli;
use crate::failure::Failure;
use crate::output;
use clap::{Args, CommandFactory};
use clap_complete::Shell;

/// Prints the completions of a shell: what can stand where, as the tab key asks
#[derive(Args)]
#[command(after_help = "\
Examples:
  pitchid completions bash > ~/.local/share/bash-completion/completions/pitchid
  pitchid completions zsh > ~/.zfunc/_pitchid
  pitchid completions fish > ~/.config/fish/completions/pitchid.fish")]
pub struct Completions {
    shell: Shell,
}

/// Prints the manual page of pitchid, or of one of its commands
#[derive(Args)]
#[command(after_help = "\
Examples:
  pitchid man | man -l -
  pitchid man diagnose > pitchid-diagnose.1")]
pub struct Man {
    /// One of the commands; without it, pitchid itself
    command: Option<String>,
}

/// Prints completions.
pub fn completions(arguments: &Completions) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "pitchid", &mut text);
    output::print_asked(&String::from_utf8_lossy(&text))
}

/// Prints a manual page.
pub fn man(arguments: &Man) -> Result<(), Failure> {
    let mut all = Cli::command();
    all.build();
    let page = match &arguments.command {
        None => all,
        Some(name) => {
            let known: Vec<String> =
                all.get_subcommands().map(|command| command.get_name().to_owned()).collect();
            all.find_subcommand(name).cloned().ok_or_else(|| {
                Failure::new(
                    format!("there is no command {name}"),
                    format!("name one of {}", known.join(", ")),
                )
            })?
        }
    };
    let mut text = Vec::new();
    let rendered = clap_mangen::Man::new(page).render(&mut text);
    rendered
        .map_err(|error| Failure::new(format!("the page could not be made: {error}"), "ask for --help"))?;
    output::print_asked(&String::from_utf8_lossy(&text))
}
