//! `cargo xtask fuzz`: arbitrary bytes into every target of `fuzz/`, each for its share of the time.
//!
//! The targets are built with the coverage that libFuzzer steers by and without a sanitizer: nothing of ours that they reach is
//! unsafe. What is found is kept in `target/fuzz`; what is read at the start is `fuzz/corpus` and what earlier runs found.

use crate::Outcome;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

/// Coverage counters in every block, and the comparisons.
const FLAGS: &str = "--cfg fuzzing -Cpasses=sancov-module -Cllvm-args=-sanitizer-coverage-level=4 \
    -Cllvm-args=-sanitizer-coverage-inline-8bit-counters -Cllvm-args=-sanitizer-coverage-pc-table \
    -Cllvm-args=-sanitizer-coverage-trace-compares";
/// Longest time that one input may take, s, and most memory that it may, MB; in one piece as much as a page of a Parquet table may
/// claim, of which no more is touched than is there.
const LIMITS: [&str; 3] = ["-timeout=10", "-rss_limit_mb=1024", "-malloc_limit_mb=2200"];
/// Targets that run only where they are named: the `parquet` crate panics at some damaged pages (docs/trust.md).
const BY_NAME: [&str; 1] = ["table"];
/// Seconds for all targets together.
const USUAL_S: u64 = 70;

/// What is asked for: `--seconds N` for all targets together, `--seed N`, and names of targets.
struct Wish {
    seconds: u64,
    seed: u64,
    targets: Vec<String>,
}

impl Wish {
    fn of(mut arguments: impl Iterator<Item = String>) -> Outcome<Self> {
        let mut wish = Self { seconds: USUAL_S, seed: 1, targets: Vec::new() };
        while let Some(word) = arguments.next() {
            let mut number = || {
                let given = arguments.next().and_then(|number| number.parse().ok());
                given.ok_or_else(|| format!("{word} needs a whole number"))
            };
            match word.as_str() {
                "--seconds" => wish.seconds = number()?,
                "--seed" => wish.seed = number()?,
                _ => wish.targets.push(word),
            }
        }
        Ok(wish)
    }
}

/// Builds and runs the targets.
pub fn run(arguments: impl Iterator<Item = String>) -> Outcome {
    let wish = Wish::of(arguments)?;
    let all = targets()?;
    if let Some(unknown) = wish.targets.iter().find(|name| !all.contains(name)) {
        return Err(format!("no target {unknown}; there are {}", all.join(", ")));
    }
    let usual = wish.targets.is_empty();
    let wanted: Vec<&String> = all
        .iter()
        .filter(|name| wish.targets.contains(name) || usual && !BY_NAME.contains(&name.as_str()))
        .collect();
    let begun = Instant::now();
    let built = build()?;
    println!("built in {:.0} s", begun.elapsed().as_secs_f64());
    let share = (wish.seconds / wanted.len() as u64).max(1);
    println!("{:<18} {:>12} {:>8} {:>9} {:>8}", "target", "executions", "s", "peak MB", "edges");
    for name in wanted {
        one(&built, name, share, wish.seed)?;
    }
    println!("{:.0} s in all", begun.elapsed().as_secs_f64());
    Ok(())
}

/// Names of the targets.
fn targets() -> Outcome<Vec<String>> {
    let text =
        std::fs::read_to_string("fuzz/Cargo.toml").map_err(|error| format!("fuzz/Cargo.toml: {error}"))?;
    let manifest: toml::Table = text.parse().map_err(|error| format!("fuzz/Cargo.toml: {error}"))?;
    let bins = manifest.get("bin").and_then(toml::Value::as_array).into_iter().flatten();
    Ok(bins.filter_map(|bin| Some(bin.get("name")?.as_str()?.to_owned())).collect())
}

/// Builds all targets; the folder where they are.
fn build() -> Outcome<PathBuf> {
    let host = crate::output(Command::new("rustc").arg("-vV"))?;
    let host = host.lines().find_map(|line| line.strip_prefix("host: ")).ok_or("rustc names no host")?;
    let mut cargo = Command::new("cargo");
    cargo.args(["build", "--release", "--locked", "--bins", "--manifest-path", "fuzz/Cargo.toml"]);
    cargo.args(["--target-dir", "target/fuzz", "--target", host]).env("RUSTFLAGS", FLAGS);
    let status = cargo.status().map_err(|error| format!("cargo cannot be run ({error})"))?;
    if !status.success() {
        return Err("the targets could not be built; libFuzzer needs a C++ compiler".into());
    }
    Ok(Path::new("target/fuzz").join(host).join("release"))
}

/// Runs one target for `seconds`.
fn one(built: &Path, name: &str, seconds: u64, seed: u64) -> Outcome {
    let folder = |what: &str| Path::new("target/fuzz").join(what).join(name);
    let (found, artifacts) = (folder("found"), folder("artifacts"));
    for folder in [&found, &artifacts] {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let program = built.join(name);
    let mut run = Command::new(&program);
    run.args(LIMITS).args([format!("-max_total_time={seconds}"), format!("-seed={seed}")]);
    run.args(["-print_final_stats=1", "-verbosity=1"]);
    run.arg(format!("-artifact_prefix={}/", artifacts.display()));
    run.arg(&found).arg(Path::new("fuzz/corpus").join(name)).env("RAYON_NUM_THREADS", "1");
    let begun = Instant::now();
    let output = run.output().map_err(|error| format!("{}: {error}", program.display()))?;
    let told = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        let last: Vec<&str> = told.lines().rev().take(40).collect();
        let last: Vec<&str> = last.into_iter().rev().collect();
        return Err(format!(
            "{name}: {}\nto repeat it: {} FILE, with the FILE named above; mend it, and keep the input in a test",
            last.join("\n"),
            program.display()
        ));
    }
    let stat = |key: &str| {
        let value = told.lines().find_map(|line| line.strip_prefix("stat::")?.strip_prefix(key));
        value.map_or("-", |value| value.trim_start_matches(':').trim()).to_owned()
    };
    let edges = told.lines().rev().find_map(|line| line.split(" cov: ").nth(1)?.split(' ').next());
    println!(
        "{name:<18} {:>12} {:>8.0} {:>9} {:>8}",
        stat("number_of_executed_units"),
        begun.elapsed().as_secs_f64(),
        stat("peak_rss_mb"),
        edges.unwrap_or("-")
    );
    Ok(())
}
