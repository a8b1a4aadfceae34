//! Files that are no recording and no log, but something that people have beside them.

use crate::failure::Failure;

/// How a file begins, what it is then, and what to do.
const BEGINNINGS: [(&[u8], &str, &str); 8] = [
    (b"%PDF", "a PDF document", "export its numbers as CSV from the program that made it"),
    (b"\x89PNG", "a picture (PNG)", "name the log that it was drawn from"),
    (b"\xff\xd8\xff", "a picture (JPEG)", "name the log that it was drawn from"),
    (b"<?xml", "an XML or SVG file", "name the recording that it was made from"),
    (b"<svg", "a picture (SVG)", "name the recording that it was drawn from"),
    (b"<!DOCTYPE", "an HTML page", "name the recording that it was made from"),
    (b"7z\xbc\xaf\x27\x1c", "a 7z archive", "unpack it first"),
    (b"\x7fELF", "a program", "name the log that it wrote"),
];

/// Words in a text file that the project writes itself, what it is then, and what to do.
const OWN: [(&str, &str, &str); 5] = [
    (
        "pitchid.monitor/",
        "a monitor file",
        "name a recording, and this with pitchid monitor RECORDING --monitor FILE",
    ),
    (
        "pitchid.taps/",
        "the taps of a board",
        "name a recording, and this with pitchid identify RECORDING --taps FILE",
    ),
    ("[plant]", "a model file", "name a recording, and this with pitchid diagnose RECORDING --model FILE"),
    ("inertia_kg_m2 =", "a model or vehicle file", "name a recording; a model is given with --model FILE"),
    ("\"schema\": \"pitchid.", "an answer of pitchid as JSON", "name the recording that it was made from"),
];

/// Why what begins like this cannot be read; `None` where it may be a recording.
pub fn refusal(name: &str, head: &[u8]) -> Option<Failure> {
    let refuse =
        |what: &str, help: &str| Some(Failure::new(format!("{name}: this is {what}, no recording"), help));
    let start = head.trim_ascii_start();
    if let Some((_, what, help)) = BEGINNINGS.iter().find(|(begin, _, _)| start.starts_with(begin)) {
        return refuse(what, help);
    }
    let text = std::str::from_utf8(head).ok()?;
    let first = text.lines().map(str::trim).find(|line| !line.is_empty() && !line.starts_with('#'))?;
    // the header of a table has commas
    let is_toml = first.starts_with('[') || first.contains(" = ");
    if !(is_toml || first.starts_with('{')) || first.contains("t_s,") {
        return None;
    }
    let (_, what, help) = OWN.iter().find(|(word, _, _)| text.contains(word))?;
    refuse(what, help)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_people_have_beside_their_logs_is_told_from_them() {
        for (head, says) in [
            (&b"%PDF-1.7\n"[..], "PDF"),
            (b"\n<!DOCTYPE html>", "HTML"),
            (b"# a comment\n[plant]\ninertia_kg_m2 = 0.2\n", "a model file"),
            (b"schema = \"pitchid.monitor/1\"\nstep_s = 0.02\n", "a monitor file"),
            (b"{\n  \"schema\": \"pitchid.taps/1\",\n", "the taps"),
            (b"{\n  \"schema\": \"pitchid.diagnosis/1\",\n", "an answer"),
        ] {
            let refusal = refusal("x", head).map(|refusal| refusal.to_string()).unwrap_or_default();
            assert!(refusal.contains(says), "{says}: {refusal:?}");
        }
        for head in [&b"t_s,u_rad,q_rad_s\n0,0,0\n"[..], b"", b"\x00\x01", b"# [plant]\nt_s,u_rad,q_rad_s\n"]
        {
            assert!(refusal("x", head).is_none());
        }
    }
}
