//! What recordings of real rigs taught, each seen again in simulation: what is promised of it is the name of a test.
//!
//! | module | what it is about |
//! | --- | --- |
//! | `terms` | which terms the answer lists, with which values |
//! | `knowledge` | the user's own model: right, a little off, a placeholder, none |
//! | `experiments` | steps, ring-downs, dead tails, coarse sampling, inputs that follow the motion |
//! | `files` | stamps, clocks, wild samples, units, averages |
//! | `amounts` | several recordings, long ones, fast ones |
//! | `flights` | closed loops, several axes |

mod amounts;
mod experiments;
mod files;
mod flights;
mod knowledge;
mod terms;

use std::collections::BTreeMap;

use host_sim::{Bench, Plant, Setting, Table};
use sysid::diagnosis::answer::{Answer, EffectAnswer, KnownAnswer};
use sysid::diagnosis::data_checks::{DataCheck, State};
use sysid::diagnosis::{Diagnosis, diagnose};
use sysid::estimate::Estimate;
use sysid::model::file::{EffectEntry, ModelFile, PlantSection};
use sysid::recording::{ReadOptions, Recording, parse};

/// Effect of the simulator.
fn effect(id: &str, parameters: &[(&str, f64)]) -> Setting {
    Setting::new(id, parameters).expect("the simulator knows the effect")
}

/// Effect of a user's model.
fn entry(id: &str, parameters: &[(&str, f64)]) -> EffectEntry {
    let parameters: BTreeMap<String, f64> = parameters.iter().map(|(p, v)| ((*p).to_owned(), *v)).collect();
    EffectEntry { id: id.into(), shape: None, parameters, remark: None }
}

/// The user's model of `plant`, with every value right, and `effects` in it.
fn model_of(plant: &Plant, effects: Vec<EffectEntry>) -> ModelFile {
    let plant = PlantSection {
        inertia_kg_m2: plant.inertia_kg_m2,
        delay_s: Some(plant.delay_s),
        dm_dq: Some(plant.dm_dq),
        dm_du: Some(plant.dm_du),
        mount_k: plant.mount.map(|mount| mount.k),
        mount_c: plant.mount.map(|mount| mount.c),
        mount_j: plant.mount.map(|mount| mount.j),
    };
    ModelFile { plant, effects, intervals: BTreeMap::new() }
}

/// The nominal bench with `effects` concealed.
fn bench(seed: u64, effects: Vec<Setting>) -> Bench {
    Bench { effects, duration_s: 80.0, ..Bench::new(seed) }
}

fn logged(bench: &Bench) -> Table {
    bench.run().expect("the bench runs").table
}

fn read(table: &Table) -> Recording {
    read_with(table, &ReadOptions::default())
}

fn read_with(table: &Table, options: &ReadOptions) -> Recording {
    parse("flight.csv", table.to_csv().as_bytes(), options).expect("the recording reads")
}

/// The diagnosis, its answer printed.
fn ask(recordings: &[Recording], model: Option<&ModelFile>) -> Diagnosis {
    let diagnosis = diagnose(recordings, model, &|_| ()).expect("there is an answer");
    tell(&diagnosis.answer);
    diagnosis
}

fn ask_nominal(table: &Table) -> Answer {
    ask(&[read(table)], Some(&model_of(&Plant::nominal(), Vec::new()))).answer
}

fn tell(answer: &Answer) {
    println!("{:?}: {}", answer.verdict, answer.summary);
    for effect in &answer.effects {
        let EffectAnswer { id, probability, share, alternatives, evidence, .. } = effect;
        println!(
            "  {id} {} p {probability:.3} share {share:.2} {alternatives:?} evidence {:.1} held out {:.1}±{:.1}",
            in_words(&effect.parameters),
            evidence.log_evidence,
            evidence.held_out_log_likelihood.value,
            evidence.held_out_log_likelihood.standard_error,
        );
    }
    for KnownAnswer { id, given, parameters } in &answer.in_model {
        println!("  in the model: {id} {given:?} {}", in_words(parameters));
    }
    if let Some(remainder) = &answer.remainder {
        println!("  left ({:.2}): {}", remainder.share, remainder.words);
    }
    for check in answer.data_checks.iter().filter(|check| check.state == State::Found) {
        println!("  found: {} {}", check.cause, check.words);
    }
    answer.notes.iter().for_each(|note| println!("  note: {note}"));
}

fn in_words(parameters: &[Estimate]) -> String {
    let words =
        parameters.iter().map(|p| format!("{} {:.4} [{:.4}, {:.4}]", p.name, p.value, p.ci95[0], p.ci95[1]));
    words.collect::<Vec<_>>().join(", ")
}

fn ids(answer: &Answer) -> Vec<&str> {
    answer.effects.iter().map(|effect| effect.id.as_str()).collect()
}

/// Parameter `name` of effect `id`, whether it was added or in the model.
fn estimate<'a>(answer: &'a Answer, id: &str, name: &str) -> &'a Estimate {
    let added = answer.effects.iter().filter(|e| e.id == id).flat_map(|e| &e.parameters);
    let known = answer.in_model.iter().filter(|e| e.id == id).flat_map(|e| &e.parameters);
    added.chain(known).find(|p| p.name == name).unwrap_or_else(|| panic!("no {name} of {id} is told"))
}

fn check<'a>(answer: &'a Answer, cause: &str) -> &'a DataCheck {
    answer.data_checks.iter().find(|check| check.cause == cause).expect("the check is in the list")
}

/// Whether the interval holds `true_value`, and the estimate is within `tolerance` of it, relative.
fn is_right(estimate: &Estimate, true_value: f64, tolerance: f64) -> bool {
    let [low, high] = estimate.ci95;
    low <= true_value
        && true_value <= high
        && (estimate.value - true_value).abs() <= tolerance * true_value.abs()
}

/// All that the answer says in words.
fn words(answer: &Answer) -> String {
    let checks = answer.data_checks.iter().map(|check| check.words.clone());
    let all = std::iter::once(answer.summary.clone()).chain(answer.notes.clone()).chain(checks);
    all.chain(answer.remainder.iter().map(|r| r.words.clone())).collect::<Vec<_>>().join("\n")
}
