//! A page for each effect: what the catalogue says, what the program says of a vehicle with it, its rivals, the rig.

use crate::{Outcome, output};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;
use sysid::catalogue::CATALOGUE;
use sysid::dataset::Amplitudes;
use sysid::estimate::{Estimate, digits};
use sysid::model::effect::{Effect, Parameter};

/// Signals of the size that the reference experiment has, as on the page of the catalogue.
const SIZES: Amplitudes = Amplitudes {
    inertia: 1.0,
    u: 0.015,
    q: 0.3,
    theta: 0.1,
    turned: 0.8,
    angles: [0.0; 3],
    moment: 0.345,
    moves: 0.0,
    step: 0.02,
    duration: 90.0,
    rate_limit: None,
};

/// Largest picture, bytes.
const LARGEST_PICTURE: u64 = 60_000;

type Prose = BTreeMap<String, BTreeMap<String, String>>;

pub fn write(root: &Path, pitchid: &Path) -> Outcome {
    let folder = root.join("docs/effects");
    let prose =
        fs::read_to_string(folder.join("rivals.toml")).map_err(|error| format!("rivals.toml: {error}"))?;
    let prose: Prose = toml::from_str(&prose).map_err(|error| format!("rivals.toml: {error}"))?;
    let work = root.join("target/book-effects");
    fs::create_dir_all(&work).map_err(|error| error.to_string())?;
    let mut list = String::from(
        "# The effects, one page each\n\n| effect | what is missing | what the program says |\n| --- | --- | --- |\n",
    );
    for effect in CATALOGUE {
        let about = effect.about();
        let id = about.id;
        let words = prose.get(id).ok_or(format!("rivals.toml says nothing of {id}"))?;
        let test = fly(id, words.get("beside"), &folder, &work, pitchid)?;
        let page = page(*effect, words, &test)?;
        fs::write(folder.join(format!("{id}.md")), page).map_err(|error| error.to_string())?;
        let _ = writeln!(list, "| [`{id}`]({id}.md) | {} | {} |", about.sentence, test.short(id));
        println!("{id}: {}", test.short(id));
    }
    fs::write(folder.join("index.md"), list).map_err(|error| error.to_string())
}

/// What came of a test with an effect.
struct Test {
    /// The options that conceal it.
    effects: Vec<String>,
    model: &'static str,
    concealed: String,
    answer: Value,
    /// The picture in `docs/effects`, and whether it is that of the effect itself.
    of_the_effect: bool,
}

impl Test {
    fn short(&self, id: &str) -> String {
        let names: Vec<&str> = self.names().collect();
        let verdict = self.answer["verdict"].as_str().unwrap_or("-").replace('_', " ");
        match (names.as_slice(), names.contains(&id)) {
            ([], _) => format!("{verdict}, no term"),
            ([_], true) => format!("{verdict}, this effect"),
            (_, true) => format!("{verdict}, this effect and others: {}", names.join(", ")),
            (_, false) => format!("{verdict}, not this effect: {}", names.join(", ")),
        }
    }
    fn names(&self) -> impl Iterator<Item = &str> {
        self.answer["effects"].as_array().into_iter().flatten().filter_map(|effect| effect["id"].as_str())
    }
}

/// Flies a test with the effect at its usual size, and with the one `beside` which it shows, and diagnoses it against the nominal
/// model.
fn fly(id: &str, beside: Option<&String>, folder: &Path, work: &Path, pitchid: &Path) -> Outcome<Test> {
    let (recording, truth, answer) =
        (work.join("test.csv"), work.join("truth.json"), work.join("answer.json"));
    let pictures = work.join("pictures");
    if pictures.exists() {
        fs::remove_dir_all(&pictures).map_err(|error| error.to_string())?;
    }
    // a soft mount replaces the vehicle's own
    let model = if id == "imu_mount" { "rigid.toml" } else { "nominal.toml" };
    let read = |path: &Path| -> Outcome<Value> {
        let text = fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))
    };
    let ids = std::iter::once(id).chain(beside.map(String::as_str));
    let effects: Vec<String> = ids.flat_map(|id| ["--effect".to_owned(), id.to_owned()]).collect();
    output(
        Command::new(pitchid)
            .arg("simulate")
            .args(&effects)
            .arg("--out")
            .arg(&recording)
            .arg("--truth")
            .arg(&truth),
    )?;
    output(
        Command::new(pitchid)
            .arg("diagnose")
            .arg(&recording)
            .arg("--model")
            .arg(folder.join(model))
            .arg("--json")
            .arg(&answer)
            .arg("--pictures")
            .arg(&pictures),
    )?;
    let own = pictures.join(format!("term-{id}.svg"));
    let of_the_effect = own.exists();
    let picture = if of_the_effect { own } else { pictures.join("dependence.svg") };
    let place = folder.join(format!("{id}.svg"));
    if picture.exists() {
        let size = fs::copy(&picture, &place).map_err(|error| error.to_string())?;
        if size > LARGEST_PICTURE {
            return Err(format!("{}: {size} bytes, more than {LARGEST_PICTURE}", place.display()));
        }
    } else if place.exists() {
        fs::remove_file(&place).map_err(|error| error.to_string())?;
    }
    let truth = read(&truth)?;
    let concealed = truth["effects"]
        .as_array()
        .into_iter()
        .flatten()
        .flat_map(|effect| effect["parameters"].as_array().into_iter().flatten());
    let concealed: Vec<String> = concealed.map(|p| value(p, None)).collect();
    Ok(Test { effects, model, concealed: concealed.join(", "), answer: read(&answer)?, of_the_effect })
}

/// A parameter of an answer or a truth: name, value, unit and interval.
fn value(p: &Value, interval: Option<&Value>) -> String {
    let [name, unit] = ["name", "unit"].map(|key| p[key].as_str().unwrap_or("-").to_owned());
    let told_unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let ends: Vec<f64> =
        interval.and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_f64).collect();
    match (p["value"].as_f64(), ends.as_slice()) {
        (Some(value), &[low, high]) => Estimate { name, unit, value, ci95: [low, high] }.to_string(),
        (value, _) => format!("{name} = {}{told_unit}", value.map_or("-".to_owned(), digits)),
    }
}

fn of_parameter(p: &Parameter) -> String {
    format!("| `{}` | {} | {} to {} |", p.name, p.unit, digits(p.lower), digits(p.upper))
}

fn page(effect: &dyn Effect, words: &BTreeMap<String, String>, test: &Test) -> Outcome<String> {
    let about = effect.about();
    let id = about.id;
    let word = |key: &str| words.get(key).ok_or(format!("rivals.toml: {id} has no `{key}`"));
    let mut page =
        format!("# {id}\n\nWhat is missing: {}.\n\n```text\n{}\n```\n\n", about.sentence, about.equation);
    let _ = writeln!(
        page,
        "It shows {}. Source: {}.\n",
        about.condition,
        effect.source().unwrap_or("first principles; no single publication")
    );
    let _ = writeln!(
        page,
        "| parameter | unit | searched, for signals of the reference experiment |\n| --- | --- | --- |"
    );
    for p in effect.parameters(&SIZES) {
        let _ = writeln!(page, "{}", of_parameter(&p));
    }
    let _ = writeln!(
        page,
        "\n## What the program says of a vehicle with it\n\n```sh\npitchid simulate {} --out {id}.csv\npitchid diagnose {id}.csv --model {} --pictures pictures\n```\n",
        test.effects.join(" "),
        test.model
    );
    let _ = writeln!(page, "Concealed: {}. The answer: **{}**.\n", test.concealed, test.short(id));
    for named in test.answer["effects"].as_array().into_iter().flatten() {
        let found: Vec<String> =
            named["parameters"].as_array().into_iter().flatten().map(|p| value(p, p.get("ci95"))).collect();
        let share = named["share"]
            .as_f64()
            .map_or(String::new(), |share| format!("; {:.0} % of what can be closed", 100.0 * share));
        let _ = writeln!(page, "- `{}`: {}{share}", named["id"].as_str().unwrap_or("-"), found.join(", "));
    }
    let _ = writeln!(page, "\n> {}\n", test.answer["summary"].as_str().unwrap_or("-").replace('\n', " "));
    let caption = if test.of_the_effect {
        "The term as fitted, beside what the data say of it with the term taken out of the model."
    } else {
        "No picture of the term itself: it is no moment over one variable, or it is not in the answer. Instead: what the moment that the model leaves depends on."
    };
    if Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../docs/effects/{id}.svg")).exists() {
        let _ = writeln!(page, "![{id}]({id}.svg)\n\n{caption}\n");
    }
    let _ = writeln!(
        page,
        "## Rivals\n\n{}\n\n## How to confirm it on the rig\n\n{}",
        word("rivals")?.trim(),
        word("rig")?.trim()
    );
    Ok(page)
}
