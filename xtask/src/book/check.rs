//! Every command of the book's own pages, run in one folder, in page order but for the effects' pages; and every field of what
//! they write.
//!
//! A block marked ```` ```sh ```` holds commands, one a line; only those that begin with `pitchid` are run. One marked
//! ```` ```sh board ```` or ```` ```sh data ```` needs what a bare machine has not, and is told as skipped.

use crate::{Outcome, output};
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Fields whose names are names of the recording or of the model: sections, horizons, terms, causes, methods.
const MAPS: [&str; 9] = [
    "by_part",
    "held_out",
    "vaf_percent",
    "chosen_in",
    "ceiling_vaf_percent",
    "agreement_percent",
    "most_evidence",
    "tests",
    "horizon_vaf_percent",
];

pub fn run(root: &Path, pitchid: &Path) -> Outcome {
    let docs = root.join("docs");
    let work = root.join("target/book-commands");
    if work.exists() {
        fs::remove_dir_all(&work).map_err(|error| error.to_string())?;
    }
    fs::create_dir_all(&work).map_err(|error| error.to_string())?;
    for model in ["nominal.toml", "rigid.toml"] {
        fs::copy(docs.join("effects").join(model), work.join(model))
            .map_err(|error| format!("{model}: {error}"))?;
    }
    let summary = fs::read_to_string(docs.join("SUMMARY.md")).map_err(|error| error.to_string())?;
    let pages = summary.split('(').skip(1).filter_map(|rest| rest.split(')').next());
    let (effects, read): (Vec<&str>, Vec<&str>) = pages.partition(|page| page.starts_with("effects/"));
    // a page goes on with what the pages before it wrote; that of an effect stands alone
    let mut chains: Vec<Vec<&str>> = effects.into_iter().map(|page| vec![page]).collect();
    chains.insert(0, read);
    let ran = chains.par_iter().map(|pages| in_order(pages, &docs, &work, pitchid));
    let run: usize = ran.collect::<Outcome<Vec<_>>>()?.iter().sum();
    println!("commands: {run} ran");
    if run == 0 {
        return Err("the book has no command to run".into());
    }
    fields(&docs, &work)
}

/// Runs the commands of `pages`, one after the other; how many.
fn in_order(pages: &[&str], docs: &Path, work: &Path, pitchid: &Path) -> Outcome<usize> {
    let mut run = 0;
    for page in pages {
        let text = fs::read_to_string(docs.join(page)).map_err(|error| format!("{page}: {error}"))?;
        for (command, needs) in commands(&text) {
            if let Some(what) = needs {
                println!("{page}: skipped, needs a {what}: {command}");
                continue;
            }
            // the words are those of a shell; the program stands in place of its name
            let line = command.replacen("pitchid", &format!("'{}'", pitchid.display()), 1);
            output(Command::new("sh").args(["-c", &line]).current_dir(work))
                .map_err(|why| format!("{page}: {command}\n{why}"))?;
            run += 1;
        }
    }
    Ok(run)
}

/// The commands of a page, each with what it needs beyond this checkout.
fn commands(text: &str) -> Vec<(&str, Option<&str>)> {
    let mut found = Vec::new();
    let mut block: Option<Option<&str>> = None;
    for line in text.lines() {
        if let Some(mark) = line.strip_prefix("```") {
            block = match (block, mark.split_whitespace().collect::<Vec<_>>().as_slice()) {
                (None, ["sh"]) => Some(None),
                (None, ["sh", needs]) => Some(Some(*needs)),
                _ => None,
            };
        } else if let (Some(needs), true) = (block, line.starts_with("pitchid ")) {
            found.push((line, needs));
        }
    }
    found
}

/// Every key of the JSON and TOML files that the commands wrote has to stand on the page of the formats.
fn fields(docs: &Path, work: &Path) -> Outcome {
    let read = |name: &str| fs::read_to_string(docs.join(name)).map_err(|error| format!("{name}: {error}"));
    // the parameters of the effects stand on the catalogue's page
    let page = read("formats.md")? + &read("catalogue.md")?;
    let mut keys = BTreeSet::new();
    for entry in fs::read_dir(work).map_err(|error| error.to_string())?.flatten() {
        let path = entry.path();
        let text = || fs::read_to_string(&path).map_err(|error| error.to_string());
        let value: Value = match path.extension().and_then(|extension| extension.to_str()) {
            Some("json") => {
                serde_json::from_str(&text()?).map_err(|error| format!("{}: {error}", path.display()))?
            }
            Some("toml") => {
                toml::from_str(&text()?).map_err(|error| format!("{}: {error}", path.display()))?
            }
            _ => continue,
        };
        walk(&value, false, &mut keys);
    }
    let missing: Vec<&String> = keys.iter().filter(|key| !page.contains(&format!("`{key}`"))).collect();
    if missing.is_empty() {
        println!("fields: all {} stand in formats.md", keys.len());
        return Ok(());
    }
    Err(format!("docs/formats.md does not tell: {missing:?}"))
}

fn walk(value: &Value, names: bool, keys: &mut BTreeSet<String>) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map {
                if !names {
                    keys.insert(key.clone());
                }
                walk(inner, MAPS.contains(&key.as_str()), keys);
            }
        }
        Value::Array(list) => list.iter().for_each(|inner| walk(inner, false, keys)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn commands_are_those_of_marked_blocks() {
        let text = "```sh\npitchid demo\n# no\n```\n```sh board\npitchid fly x\n```\n```\npitchid no\n```";
        assert_eq!(super::commands(text), [("pitchid demo", None), ("pitchid fly x", Some("board"))]);
    }

    #[test]
    fn names_of_sections_are_no_fields_but_what_is_below_them_is() {
        let answer = serde_json::json!({"by_part": {"IV": [{"value": 1.0}]}});
        let mut keys = std::collections::BTreeSet::new();
        super::walk(&answer, false, &mut keys);
        assert_eq!(keys.into_iter().collect::<Vec<_>>(), ["by_part", "value"]);
    }
}
