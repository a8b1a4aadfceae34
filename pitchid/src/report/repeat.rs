//! Everything that is needed to come to the same answer again.

use crate::input;
use benchmark::seal::sha256_hex;
use maud::{Markup, html};
use std::path::Path;

/// How an answer was made.
#[derive(Clone, Debug, Default)]
pub struct Repeat {
    /// The command, as a shell takes it.
    pub command: String,
    /// The files that were read, with their SHA-256; none where a file could not be read again.
    pub inputs: Vec<(String, Option<String>)>,
}

impl Repeat {
    /// Of this run of the program.
    pub fn of_this_run(inputs: &[&Path]) -> Self {
        Self::of(std::env::args().skip(1), inputs)
    }

    /// Of a run with these arguments.
    pub fn of(arguments: impl Iterator<Item = String>, inputs: &[&Path]) -> Self {
        let arguments = arguments.map(|argument| quoted(&argument));
        let command = std::iter::once("pitchid".to_owned()).chain(arguments).collect::<Vec<_>>().join(" ");
        let hash = |path: &&Path| {
            // a pipe gives its bytes only once
            let bytes = path.is_file().then(|| std::fs::read(path).ok()).flatten();
            (input::name_of(path), bytes.map(|bytes| sha256_hex(&bytes)))
        };
        Self { command, inputs: inputs.iter().map(hash).collect() }
    }

    /// As the end of a page; nothing where it is not known.
    pub fn html(&self) -> Markup {
        html! {
            @if !self.command.is_empty() {
                h2 { "To repeat it" }
                p { code { (self.command) } }
                dl .hashes {
                    @for (name, hash) in &self.inputs {
                        dt { (name) }
                        dd { code { (hash.as_deref().unwrap_or("could not be read again")) } }
                    }
                }
                p .soft.small {
                    "SHA-256 of each file that was read. Nothing is drawn by chance that a fixed seed does not give: the same files and options \
                     give the same bytes, whatever the number of threads."
                }
            }
        }
    }
}

/// An argument in single quotes where a shell would take it apart.
fn quoted(argument: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=:,+@%".contains(c);
    if !argument.is_empty() && argument.chars().all(plain) {
        return argument.to_owned();
    }
    format!("'{}'", argument.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_argument_is_quoted_where_a_shell_needs_it() {
        assert_eq!(quoted("I=5..30"), "I=5..30");
        assert_eq!(quoted("q_rad_s=gyro y*0.01"), "'q_rad_s=gyro y*0.01'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }
}
