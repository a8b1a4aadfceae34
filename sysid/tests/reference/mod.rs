//! The reference campaigns, as the subspace methods take them.

use std::path::PathBuf;
use sysid::identify::fir::Piece;
use sysid::recording::{ReadOptions, Recording, read};

/// The recordings of amplitude 12, 15 and 19 mrad; `None` where the reference data are absent.
pub fn campaign(kind: &str) -> Option<Vec<Recording>> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared/data/reference"));
    let path = |amplitude: &str| folder.join(format!("data_{kind}_{amplitude}_seed0.csv"));
    if !path("a015").exists() {
        println!("skipped: the reference campaigns are not in {}", folder.display());
        return None;
    }
    Some(["a012", "a015", "a019"].map(|a| read(&path(a), &ReadOptions::default()).unwrap()).into())
}

/// Section I of each, one after the other as if it were one record: what the independent program learnt from.
#[allow(dead_code)]
pub fn joined(recordings: &[Recording]) -> [Vec<f64>; 2] {
    let mut joined = [Vec::new(), Vec::new()];
    for recording in recordings {
        let rows = recording.section("I").unwrap().rows.clone();
        joined[0].extend_from_slice(&recording.u[rows.clone()]);
        joined[1].extend_from_slice(&recording.q.as_deref().unwrap()[rows]);
    }
    joined
}

/// One section of a recording (not every test takes them apart), as a piece of run number `run`.
#[allow(dead_code)]
pub fn piece<'a>(recording: &'a Recording, section: &str, run: usize) -> Piece<'a> {
    let rows = recording.section(section).unwrap().rows.clone();
    let q = recording.q.as_deref().unwrap();
    Piece { u: &recording.u, y: q, supervised: &recording.supervised, rows, run, step: recording.step }
}
