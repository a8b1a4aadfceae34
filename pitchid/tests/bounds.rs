//! Bounds on work: memory and processor time of every command that reads a recording grow no faster than its length. What an hour takes
//! is in docs/trust.md. Run by name, as it takes a minute: `cargo test --release -p pitchid --test bounds`.
#![cfg(target_os = "linux")]

use std::fs;
use std::io::Write as _;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// Rows of the recordings: four minutes and sixteen, at 250 Hz.
const ROWS: [usize; 2] = [60_000, 240_000];
/// Most memory: of the program itself, and by the row. A row of a diagnosis took 360 B, of everything else 200 B at most.
const PROGRAM_MB: f64 = 30.0;
const ROW_B: f64 = 400.0;

/// A motion under a random switching input, with dry friction and noise.
fn recording(path: &Path, rows: usize) {
    let mut out = std::io::BufWriter::new(fs::File::create(path).unwrap());
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    writeln!(out, "t_s,u_rad,q_rad_s,theta_rad,section").unwrap();
    let (step, mut u, mut q, mut theta, mut left) = (0.004, 0.015, 0.0_f64, 0.0_f64, 0);
    let mut sent = [0.0; 15];
    for k in 0..rows {
        if left == 0 {
            left = 100 + (100.0 * (random() + 0.5)) as usize;
            u = 0.015 * random().signum() - 0.05 * theta - 0.01 * q;
        }
        left -= 1;
        let arrived = std::mem::replace(&mut sent[k % 15], u);
        let moment = -0.27 * q + 23.0 * arrived - 0.05 * (q / 0.002).tanh() + 0.3 * random();
        q += step * moment / 0.1705;
        theta += step * q;
        let (seen, angle) = (q + 0.03 * random(), theta + 0.006 * random());
        let section = ["I", "II", "III", "IV"][4 * k / rows];
        writeln!(out, "{:.4},{u:.6},{seen:.6},{angle:.6},{section}", step * k as f64).unwrap();
    }
}

/// Runs a command to its end: its largest resident memory in MB and its processor time in s.
fn used(folder: &Path, arguments: &[&str]) -> [f64; 2] {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pitchid"));
    command.current_dir(folder).args(arguments).arg("--quiet").env("RAYON_NUM_THREADS", "2");
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let of = |name: &str| fs::read_to_string(format!("/proc/{}/{name}", child.id())).unwrap_or_default();
    let mut peak = 0.0_f64;
    let ticks = loop {
        let status = of("status");
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        peak = peak.max(line.map_or(0.0, |line| line.trim().trim_end_matches(" kB").parse().unwrap()));
        // its state, and user and system time, behind the name in parentheses
        let stat = of("stat");
        let fields: Vec<&str> = stat.rsplit(')').next().unwrap().split_whitespace().collect();
        if fields[0] == "Z" {
            break fields[11].parse::<f64>().unwrap() + fields[12].parse::<f64>().unwrap();
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    assert!(child.wait().unwrap().success(), "{arguments:?}");
    [peak / 1e3, ticks / 100.0]
}

#[test]
fn memory_and_work_grow_no_faster_than_the_recording() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let names = ROWS.map(|rows| format!("{rows}.csv"));
    for (name, rows) in names.iter().zip(ROWS) {
        recording(&folder.join(name), rows);
    }
    used(folder, &["identify", &names[0], "--monitor-out", "monitor.toml"]);
    let commands: [&[&str]; 5] = [
        &["show"],
        &["convert", "table.parquet"],
        &["monitor", "--monitor", "monitor.toml"],
        &["identify"],
        &["diagnose", "--report", "report.html"],
    ];
    for command in commands {
        let [short, long] = names
            .each_ref()
            .map(|name| used(folder, &[&[command[0], name.as_str()], &command[1..]].concat()));
        let told =
            format!("{}: {short:.1?} MB and s of {} rows, {long:.1?} of {}", command[0], ROWS[0], ROWS[1]);
        println!("{told}");
        let more = (ROWS[1] / ROWS[0]) as f64;
        let most = PROGRAM_MB + ROW_B * 1e-6 * ROWS[1] as f64;
        assert!(long[0] < most && long[0] < more * short[0], "{told}");
        assert!(long[1] < 2.0 * more * short[1].max(0.2), "{told}");
    }
}
