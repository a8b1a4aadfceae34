//! Links of the book that lead to a file: each has to be there, and each page has to stand in the summary.

use crate::Outcome;
use std::fs;
use std::path::{Path, PathBuf};

pub fn check(docs: &Path) -> Outcome {
    let mut pages = Vec::new();
    collect(docs, &mut pages)?;
    let summary =
        fs::read_to_string(docs.join("SUMMARY.md")).map_err(|error| format!("SUMMARY.md: {error}"))?;
    let mut faults = Vec::new();
    for page in &pages {
        let text = fs::read_to_string(page).map_err(|error| format!("{}: {error}", page.display()))?;
        let name = page.strip_prefix(docs).unwrap_or(page).to_string_lossy().into_owned();
        if name != "SUMMARY.md" && !summary.contains(&format!("({name})")) {
            faults.push(format!("{name} does not stand in SUMMARY.md"));
        }
        for target in targets(&text) {
            let file = target.split('#').next().unwrap_or_default();
            let place = page.parent().unwrap_or(docs).join(file);
            if !file.is_empty() && !file.contains("://") && !place.exists() {
                faults.push(format!("{name}: a link leads to {target}, which is not there"));
            }
        }
    }
    if faults.is_empty() {
        println!("links: {} pages, all lead somewhere", pages.len());
        return Ok(());
    }
    Err(faults.join("\n"))
}

fn collect(folder: &Path, pages: &mut Vec<PathBuf>) -> Outcome {
    let mut entries: Vec<PathBuf> = fs::read_dir(folder)
        .map_err(|error| error.to_string())?
        .flatten()
        .map(|entry| entry.path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            collect(&path, pages)?;
        } else if path.extension().is_some_and(|extension| extension == "md") {
            pages.push(path);
        }
    }
    Ok(())
}

/// What stands in the round brackets of `[text](target)`, outside of code blocks.
fn targets(text: &str) -> Vec<&str> {
    let mut found = Vec::new();
    let mut code = false;
    for line in text.lines() {
        code ^= line.trim_start().starts_with("```");
        if !code {
            found.extend(line.split("](").skip(1).filter_map(|rest| rest.split(')').next()));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    #[test]
    fn links_are_found_outside_of_code() {
        let text = "[a](a.md) ![b](b.svg)\n```\n[c](c.md)\n```\n[d](https://d.org/x#y)";
        assert_eq!(super::targets(text), ["a.md", "b.svg", "https://d.org/x#y"]);
    }
}
