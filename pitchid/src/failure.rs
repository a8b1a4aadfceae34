//! What stops a command, as people see it: what was found and where, the line itself, what to do about it.

use miette::{Diagnostic, LabeledSpan, MietteHandlerOpts, NamedSource, Report, SourceCode};
use std::fmt::Display;
use std::io::{IsTerminal, Write};
use std::path::Path;

/// Longest line of a file that is worth showing in a message, bytes.
const LONGEST_LINE: usize = 160;
/// Largest file that is read again to show a line of it, bytes.
const LARGEST_FILE: u64 = 1 << 24;

/// A message for people.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    message: String,
    help: String,
    excerpt: Option<Box<Excerpt>>,
    place: Place,
}

/// Where in the input a message points.
#[derive(Clone, Debug, Default)]
pub struct Place {
    /// The file.
    pub file: Option<String>,
    /// Its line, counted from 1.
    pub line: Option<usize>,
    /// The column of a recording, or the key of a file.
    pub column: Option<String>,
}

/// The line of a file that a message is about.
#[derive(Debug)]
struct Excerpt {
    source: NamedSource<String>,
    span: LabeledSpan,
}

impl Failure {
    /// A message and what to do.
    pub fn new(message: impl Into<String>, help: impl Into<String>) -> Self {
        Self { message: message.into(), help: help.into(), excerpt: None, place: Place::default() }
    }

    /// What to do.
    pub fn help(&self) -> &str {
        &self.help
    }

    /// Where in the input.
    #[must_use]
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// A file that could not be written.
    pub fn unwritable(file: &Path, error: &std::io::Error) -> Self {
        benchmark::Error::unwritable(file, error).into()
    }

    /// Prints the message to standard error; one that is closed is no reason to fail in another way.
    pub fn print(self) {
        let _ = writeln!(std::io::stderr(), "{:?}", Report::new(self));
    }
}

/// Sets how messages are drawn: lines are wrapped on a terminal only, so that a log can be searched.
pub fn install() {
    let terminal = std::io::stderr().is_terminal();
    // a second hook cannot be: this is called once
    let _ = miette::set_hook(Box::new(move |_| {
        let options = MietteHandlerOpts::new().terminal_links(false).context_lines(1);
        Box::new(options.wrap_lines(terminal).break_words(false).build())
    }));
}

impl Diagnostic for Failure {
    fn help(&self) -> Option<Box<dyn Display + '_>> {
        Some(Box::new(&self.help))
    }
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.excerpt.as_ref().map(|e| &e.source as &dyn SourceCode)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        self.excerpt.as_ref().map(|e| Box::new(std::iter::once(e.span.clone())) as _)
    }
}

impl From<sysid::error::Error> for Failure {
    fn from(error: sysid::error::Error) -> Self {
        let full = error.to_string();
        let (first, _) = full.split_once("\n  ").unwrap_or((&full, ""));
        let message = std::iter::once(first.to_owned()).chain(error.others()).collect::<Vec<_>>().join("\n");
        let help = match &error.expected {
            Some(expected) => format!("expected {expected}; {}", error.advice),
            None => error.advice.to_string(),
        };
        let excerpt = error.file.as_deref().zip(error.line).and_then(|(file, line)| excerpt(file, line));
        let place = Place {
            file: error.file.map(String::from),
            line: error.line,
            column: error.column.map(String::from),
        };
        Self { message, help, excerpt, place }
    }
}

impl From<flight_logs::Error> for Failure {
    fn from(error: flight_logs::Error) -> Self {
        let full = error.to_string();
        let (message, _) = full.split_once("\n  ").unwrap_or((&full, ""));
        let help = match &error.expected {
            Some(expected) => format!("expected {expected}; {}", error.advice),
            None => error.advice.to_string(),
        };
        let place = Place { file: error.file.map(String::from), ..Place::default() };
        Self { place, ..Self::new(message, help) }
    }
}

impl From<benchmark::Error> for Failure {
    fn from(error: benchmark::Error) -> Self {
        match error {
            benchmark::Error::Simulator(error) => error.into(),
            benchmark::Error::Estimation(error) => error.into(),
            benchmark::Error::Plan(error) => error.into(),
            benchmark::Error::Place { message, help } => Self::new(message, help),
        }
    }
}

impl From<experiment::Error> for Failure {
    fn from(error: experiment::Error) -> Self {
        match error {
            experiment::Error::Simulator(error) => error.into(),
            experiment::Error::Estimation(error) => error.into(),
            experiment::Error::Craft { message, help } => Self::new(message, help),
        }
    }
}

impl From<host_sim::Error> for Failure {
    fn from(error: host_sim::Error) -> Self {
        let help = match &error {
            host_sim::Error::BlownUp { .. } => "correct that value in the model file or of --effect",
            host_sim::Error::Plant { .. } => "correct that value under [plant] of the model file",
            _ => "see pitchid simulate --help for effects, parameters and ranges",
        };
        Self::new(error.to_string(), help)
    }
}

/// The line of the file, if both are of a size to be shown.
fn excerpt(file: &str, line: usize) -> Option<Box<Excerpt>> {
    let small = std::fs::metadata(file).ok().filter(|m| m.is_file() && m.len() <= LARGEST_FILE);
    let text = small.and_then(|_| std::fs::read_to_string(file).ok())?;
    let start: usize = text.split_inclusive('\n').take(line.checked_sub(1)?).map(str::len).sum();
    let shown = text.get(start..)?.lines().next()?;
    let printable = shown.chars().all(|c| !c.is_control() || c == '\t');
    if shown.is_empty() || !printable || context(&text, line).any(|l| l.len() > LONGEST_LINE) {
        return None;
    }
    let span = LabeledSpan::new(Some("here".into()), start, shown.len());
    Some(Box::new(Excerpt { source: NamedSource::new(file, text), span }))
}

/// The line with its neighbours, which are shown too.
fn context(text: &str, line: usize) -> impl Iterator<Item = &str> {
    text.lines().skip(line.saturating_sub(2)).take(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_the_file_is_shown() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "t_s,u_rad\n0.0,1\n0.02,abc\n").unwrap();
        let found = excerpt(file.path().to_str().unwrap(), 3).unwrap();
        assert_eq!((found.span.offset(), found.span.len()), (16, 8));
    }

    #[test]
    fn no_excerpt_of_what_cannot_be_shown() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let name = file.path().to_str().unwrap().to_owned();
        std::fs::write(file.path(), format!("a\n{}\n", "x".repeat(5000))).unwrap();
        assert!(excerpt(&name, 2).is_none());
        assert!(excerpt(&name, 1).is_none(), "its neighbour would be shown");
        assert!(excerpt(&name, 9).is_none());
        assert!(excerpt("/nowhere/at/all.csv", 1).is_none());
        assert!(excerpt(&name, 0).is_none());
    }
}
