//! Parameters of the board in a file, one a line: NAME VALUE, as ground stations and `pitchid plan` write them.

use crate::failure::Failure;
use std::path::Path;
use sysid::files::read_text;

/// Reads a file; what stands behind a # is a remark.
pub fn read(path: &Path) -> Result<Vec<(String, f32)>, Failure> {
    let name = path.display();
    let text = read_text(path, "name a file that pitchid plan wrote")?;
    let mut all: Vec<(String, f32)> = Vec::new();
    for (line, content) in text.lines().enumerate() {
        let content = content.split('#').next().unwrap_or_default();
        let separated = |c: char| c.is_whitespace() || c == ',' || c == '=';
        let words: Vec<&str> = content.split(separated).filter(|word| !word.is_empty()).collect();
        let wrong = |found: String| {
            Failure::new(
                format!("{name}: line {}: {found}", line + 1),
                "write NAME VALUE, one parameter a line",
            )
        };
        match words.as_slice() {
            [] => {}
            [parameter, value] => {
                let value: f32 = value.parse().map_err(|_| wrong(format!("{value:?} is no number")))?;
                if all.iter().any(|(known, _)| known == parameter) {
                    return Err(wrong(format!("{parameter} a second time")));
                }
                all.push(((*parameter).to_owned(), value));
            }
            _ => return Err(wrong(format!("{:?}", content.trim()))),
        }
    }
    if all.is_empty() {
        return Err(Failure::new(format!("{name}: no parameters"), "write NAME VALUE, one parameter a line"));
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_as_file(text: &str) -> Result<Vec<(String, f32)>, Failure> {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), text).unwrap();
        read(file.path())
    }

    #[test]
    fn names_and_values_are_read_and_what_is_neither_is_told_by_line() {
        let found = read_as_file("# plan\nEXC_AMPL 0.01\nLIM_THETA,0.3 # rad\n\n").unwrap();
        assert_eq!(found, [("EXC_AMPL".to_owned(), 0.01), ("LIM_THETA".to_owned(), 0.3)]);
        let told = |text: &str| read_as_file(text).unwrap_err().to_string();
        assert!(told("EXC_AMPL 0.01\nLIM_THETA high\n").contains("line 2: \"high\" is no number"));
        assert!(told("EXC_AMPL 0.01 rad\n").contains("line 1"));
        assert!(told("A 1\nA 2\n").contains("line 2: A a second time"));
        assert!(told("# nothing\n").contains("no parameters"));
    }
}
