//! The page of the equations: what the modules of the method say of themselves, in the order of the method.

use crate::Outcome;
use std::fmt::Write;
use std::fs;
use std::path::Path;

/// Chapters, each with its modules.
const CHAPTERS: [(&str, &[&str]); 9] = [
    (
        "Excitation and supervision",
        &["estimator-core/src/prbs.rs", "estimator-core/src/supervisor.rs", "estimator-core/src/attitude.rs"],
    ),
    ("On-board estimate", &["estimator-core/src/lms.rs", "estimator-core/src/convergence.rs"]),
    (
        "Linear identification",
        &[
            "sysid/src/identify/kung.rs",
            "sysid/src/identify/pi_moesp.rs",
            "sysid/src/identify/cross_validation.rs",
            "sysid/src/identify/continuous.rs",
            "sysid/src/identify/hinf_norm.rs",
            "sysid/src/identify/butterworth.rs",
            "sysid/src/identify/bootstrap.rs",
        ],
    ),
    (
        "Likelihood and noise model",
        &[
            "sysid/src/likelihood/problem.rs",
            "sysid/src/likelihood/fit.rs",
            "sysid/src/likelihood/free_run.rs",
            "sysid/src/likelihood/horizon.rs",
        ],
    ),
    (
        "Evidence, priors and calibration",
        &[
            "sysid/src/likelihood/evidence.rs",
            "sysid/src/diagnosis/prior.rs",
            "sysid/src/diagnosis/posterior.rs",
        ],
    ),
    (
        "Search, rotation and held-out data",
        &[
            "sysid/src/diagnosis/search.rs",
            "sysid/src/diagnosis/selection.rs",
            "sysid/src/diagnosis/rotation.rs",
            "sysid/src/diagnosis/ceiling.rs",
        ],
    ),
    (
        "Tests of what is left",
        &[
            "sysid/src/diagnosis/adequacy/mod.rs",
            "sysid/src/diagnosis/adequacy/score.rs",
            "sysid/src/diagnosis/adequacy/features.rs",
            "sysid/src/diagnosis/adequacy/line.rs",
            "sysid/src/diagnosis/adequacy/burst.rs",
            "sysid/src/diagnosis/adequacy/tails.rs",
            "sysid/src/diagnosis/adequacy/switches.rs",
            "sysid/src/diagnosis/adequacy/constancy.rs",
            "sysid/src/diagnosis/adequacy/sizes.rs",
            "sysid/src/diagnosis/adequacy/p_values.rs",
        ],
    ),
    (
        "Verdict",
        &[
            "sysid/src/diagnosis/verdict.rs",
            "sysid/src/diagnosis/judgement.rs",
            "sysid/src/diagnosis/materiality.rs",
            "sysid/src/diagnosis/gust.rs",
        ],
    ),
    (
        "Validation",
        &[
            "sysid/src/validate/vaf.rs",
            "sysid/src/validate/whiteness.rs",
            "sysid/src/validate/cross_correlation.rs",
            "sysid/src/validate/coherence.rs",
        ],
    ),
];

pub fn write(root: &Path) -> Outcome {
    fs::write(root.join("docs/equations.md"), page(root)?).map_err(|error| error.to_string())
}

/// The page has to be what the modules say now.
pub fn check(root: &Path) -> Outcome {
    let found = fs::read_to_string(root.join("docs/equations.md"))
        .map_err(|error| format!("equations.md: {error}"))?;
    if found == page(root)? {
        Ok(())
    } else {
        Err("docs/equations.md is stale: run `cargo xtask book`".into())
    }
}

fn page(root: &Path) -> Outcome<String> {
    let mut page = String::from(
        "# Equations, symbols and sources\n\nWritten by `cargo xtask book` from what each module of the method says of itself.\n",
    );
    for (chapter, modules) in CHAPTERS {
        let _ = writeln!(page, "\n## {chapter}");
        for module in modules {
            let source =
                fs::read_to_string(root.join(module)).map_err(|error| format!("{module}: {error}"))?;
            let text: Vec<&str> = source
                .lines()
                .map_while(|line| line.strip_prefix("//!"))
                .map(|line| line.strip_prefix(' ').unwrap_or(line))
                .collect();
            if text.is_empty() {
                return Err(format!("{module} says nothing of itself"));
            }
            let _ = writeln!(page, "\n### {module}\n\n{}", text.join("\n"));
        }
    }
    Ok(page)
}
