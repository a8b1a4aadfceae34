//! Sealed recordings of an independent simulator that once were answered wrongly, each for a reason of its own.

use std::path::Path;
use sysid::catalogue::model_file::read_model;
use sysid::diagnosis::answer::Verdict;
use sysid::diagnosis::diagnose;
use sysid::recording::{ReadOptions, read};

/// What is concealed, and where a search went astray once.
const CASES: [(&str, &str); 4] = [
    ("c029", "gyroscopic_coupling"), // kinematics that did not turn the mount along
    ("c034", "gust_disturbance"),    // a disturbance that no term can repeat
    ("c058", "inertia_step"),        // a gain that kept to the old inertia
    ("c059", "gyro_lag"),            // a gain that did not know the filter
];

#[test]
fn cases_that_went_wrong_once_stay_right() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/sealed/practice");
    if !folder.is_dir() {
        println!("skipped: no sealed recordings beside this checkout");
        return;
    }
    for (case, concealed) in CASES {
        let recording =
            read(&folder.join(case).join("recording.csv"), &ReadOptions::default()).expect("it reads");
        let model = read_model(&folder.join(case).join("model.toml"), None).expect("it reads");
        let answer = diagnose(&[recording], Some(&model), &|_| ()).expect("there is an answer").answer;
        let ids: Vec<&str> = answer.effects.iter().map(|e| e.id.as_str()).collect();
        assert_eq!((answer.verdict, ids), (Verdict::Named, vec![concealed]), "{case}: {}", answer.summary);
    }
}
