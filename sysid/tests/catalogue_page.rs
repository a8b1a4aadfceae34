//! docs/catalogue.md says what the catalogue says. `REWRITE=1 cargo test -p sysid --test catalogue_page` writes it anew.

use std::fmt::Write;
use std::path::Path;
use sysid::catalogue::CATALOGUE;
use sysid::dataset::Amplitudes;
use sysid::estimate::digits;
use sysid::model::effect::{Locus, Parameter};

/// Signals of the size that the reference experiment has.
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

const HEAD: &str = "# The catalogue: physics that a pitch model may leave out

Written by a test from the catalogue itself: `REWRITE=1 cargo test -p sysid --test catalogue_page`.

The sentence ends \"what is missing is that ...\". u_c is the command after the delay, u_a what the blades do, M the pitch
moment. Ranges are what is searched; those that follow the signals are given for signals of the reference experiment
(standard deviations 0.015 rad of the input, 0.3 rad/s, 0.1 rad and 0.345 N m, 90 s at 50 Hz). Units are those of a
recording whose input is in rad.
";

fn of_parameter(p: &Parameter) -> String {
    format!("`{}` {}: {} to {}", p.name, p.unit, digits(p.lower), digits(p.upper))
}

fn page() -> String {
    let mut page = String::from(HEAD);
    let loci = [
        (Locus::Actuator, "Actuation"),
        (Locus::PitchMoment, "Airframe"),
        (Locus::Sensor, "Sensors"),
        (Locus::Timing, "Timing"),
        (Locus::Environment, "Environment"),
    ];
    for (locus, title) in loci {
        let _ = writeln!(
            page,
            "\n## {title}\n\n| id | what | equation | parameters | source |\n| --- | --- | --- | --- | --- |"
        );
        for effect in CATALOGUE.iter().filter(|effect| effect.about().locus == locus) {
            let about = effect.about();
            let parameters: Vec<String> = effect.parameters(&SIZES).iter().map(of_parameter).collect();
            let cells = [
                &format!("`{}`", about.id),
                about.sentence,
                &format!("`{}`", about.equation),
                &parameters.join("; "),
                effect.source().unwrap_or("-"),
            ];
            let _ = writeln!(page, "| {} |", cells.map(|cell| cell.replace('|', "\\|")).join(" | "));
        }
    }
    page
}

#[test]
fn the_page_is_what_the_catalogue_says() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/catalogue.md");
    let expected = page();
    if std::env::var_os("REWRITE").is_some() {
        std::fs::write(&path, &expected).expect("the page can be written");
    }
    let found = std::fs::read_to_string(&path).unwrap_or_default();
    let (old, new): (Vec<&str>, Vec<&str>) = (found.lines().collect(), expected.lines().collect());
    let mut difference = String::new();
    for line in old.iter().filter(|line| !new.contains(line)) {
        let _ = writeln!(difference, "- {line}");
    }
    for line in new.iter().filter(|line| !old.contains(line)) {
        let _ = writeln!(difference, "+ {line}");
    }
    assert!(found == expected, "docs/catalogue.md is stale, run this test with REWRITE=1:\n{difference}");
}

#[test]
fn every_effect_is_told_in_full_and_starts_within_its_bounds() {
    for (i, effect) in CATALOGUE.iter().enumerate() {
        let about = effect.about();
        assert!(CATALOGUE[..i].iter().all(|other| other.about().id != about.id), "{} stands twice", about.id);
        for text in [about.sentence, about.equation, about.variable, about.condition] {
            assert!(!text.is_empty() && !text.ends_with('.'), "{}: {text}", about.id);
        }
        let parameters = effect.parameters(&SIZES);
        for start in effect.starts(&SIZES) {
            assert_eq!(start.len(), parameters.len(), "{}", about.id);
            for (p, value) in parameters.iter().zip(start) {
                assert!((p.lower..=p.upper).contains(&value), "{}.{} starts at {value}", about.id, p.name);
            }
        }
        assert!(effect.states() <= 2, "{}: a diagnosis has room for five effects of two states", about.id);
    }
    assert_eq!(CATALOGUE.len(), 48);
}
