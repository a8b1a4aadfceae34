//! Parameters of the board in a file, one a line: NAME VALUE, as ground stations and `pitchid plan` write them.

use std::path::Path;
use sysid::error::{Error, ErrorKind, quote};
use sysid::files::read_text;

/// Longest name of a parameter, characters: that of MAVLink.
const LONGEST: usize = 16;
const ADVICE: &str = "write NAME VALUE, one parameter a line";

/// Reads a file; what stands behind a # is a remark. Which names there are and what is legal of each, the board says.
///
/// # Errors
/// A file that cannot be read, a line that is no name and finite number, a name twice, no parameter.
pub fn read(path: &Path) -> Result<Vec<(String, f32)>, Error> {
    let text = read_text(path, "name a file that pitchid plan wrote")?;
    parse(&text).map_err(|error| error.in_file(path.display().to_string()))
}

/// The same of the text of a file.
///
/// # Errors
/// As [`read`].
pub fn parse(text: &str) -> Result<Vec<(String, f32)>, Error> {
    let mut all: Vec<(String, f32)> = Vec::new();
    let mut known = std::collections::BTreeSet::new();
    for (line, content) in text.lines().enumerate() {
        let content = content.split('#').next().unwrap_or_default();
        let separated = |c: char| c.is_whitespace() || c == ',' || c == '=';
        let mut words = content.split(separated).filter(|word| !word.is_empty());
        let wrong = |found: String| Error::new(ErrorKind::Model, found, ADVICE).at_line(line + 1);
        let (name, value) = match (words.next(), words.next(), words.next()) {
            (None, ..) => continue,
            (Some(name), Some(value), None) => (name, value),
            _ => {
                return Err(
                    wrong(format!("found {}", quote(content.trim()))).expecting("a name and a number")
                );
            }
        };
        if name.len() > LONGEST {
            let found = format!("found {}", quote(name));
            return Err(wrong(found).expecting(format!("a name of at most {LONGEST} characters")));
        }
        let number: Option<f32> = value.parse().ok().filter(|number: &f32| number.is_finite());
        let number = number.ok_or_else(|| {
            wrong(format!("found {}", quote(value))).in_column(name).expecting("a finite number")
        })?;
        if !known.insert(name.to_owned()) {
            return Err(wrong("a second time".to_owned()).in_column(name).expecting("each parameter once"));
        }
        all.push((name.to_owned(), number));
    }
    if all.is_empty() { Err(Error::new(ErrorKind::Model, "no parameters", ADVICE)) } else { Ok(all) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_values_are_read_and_what_is_neither_is_told_by_line() {
        let found = parse("# plan\nEXC_AMPL 0.01\nLIM_THETA,0.3 # rad\n\n").unwrap();
        assert_eq!(found, [("EXC_AMPL".to_owned(), 0.01), ("LIM_THETA".to_owned(), 0.3)]);
        let told = |text: &str| parse(text).unwrap_err().to_string();
        for value in ["high", "nan", "inf", "-inf", "1e300"] {
            let told = told(&format!("EXC_AMPL 0.01\nLIM_THETA {value}\n"));
            let expected = format!("line 2, key LIM_THETA: found \"{value}\"\n  expected: a finite number");
            assert!(told.starts_with(&expected), "{told}");
        }
        assert!(told("EXC_AMPL 0.01 rad\n").contains("line 1: found \"EXC_AMPL 0.01 rad\""));
        assert!(told("A 1\nA 2\n").contains("line 2, key A: a second time"));
        assert!(told("# nothing\n").contains("no parameters"));
        assert!(told("A_NAME_THAT_IS_FAR_TOO_LONG 1\n").contains("at most 16 characters"));
    }
}
