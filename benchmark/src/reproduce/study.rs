//! Many seeds of one condition, and their summary.

use super::campaign::{Campaign, Condition, closed_loop_label, fly_campaign, prbs_label};
use crate::Error;
use estimator_core::convergence::ConvergenceConfig;
use estimator_core::lms::LmsConfig;
use host_sim::Plant;
use rayon::prelude::*;
use serde::Serialize;
use sysid::identify::compare::{Settings, identify_on};
use sysid::identify::fir::pieces;
use sysid::identify::linear_model::LinearModel;
use sysid::identify::lms::replay;
use sysid::progress::{Counted, Progress};
use sysid::validate::vaf::vaf;

/// Everything that was computed.
#[derive(Serialize)]
pub struct Paper {
    /// Campaign of the paper.
    pub campaign: u8,
    /// Seeds per condition.
    pub seeds: u32,
    /// One for each condition.
    pub studies: Vec<Study>,
}

/// One condition.
#[derive(Serialize)]
pub struct Study {
    /// What was flown.
    pub condition: Condition,
    /// Seed by seed.
    pub seeds: Vec<SeedResult>,
}

/// One seed.
#[derive(Serialize)]
pub struct SeedResult {
    /// The seed.
    pub seed: u64,
    /// Share of the rows to learn from that the supervisor overrode.
    pub supervised: f64,
    /// Method by method.
    pub methods: Vec<MethodFigures>,
    /// VAF of the H∞ match against PI-MOESP, responses to the PRBS, per cent.
    pub agreement_percent: Option<f64>,
    /// Grey boxes: relative errors of ∂M/∂q and ∂M/∂u, per cent.
    pub parameter_errors: Vec<ParameterErrors>,
}

/// VAF of one method, per cent.
#[derive(Clone, Serialize)]
pub struct MethodFigures {
    /// The method.
    pub name: String,
    /// Closed loop; `None` where there is no stable model.
    pub closed_loop: Option<f64>,
    /// Unused PRBS.
    pub prbs: Option<f64>,
}

/// Errors of one grey box.
#[derive(Clone, Serialize)]
pub struct ParameterErrors {
    /// The method.
    pub name: String,
    /// Of ∂M/∂q.
    pub dm_dq_percent: f64,
    /// Of ∂M/∂u.
    pub dm_du_percent: f64,
}

/// Runs all seeds on all cores; the answer does not depend on their number.
pub fn study(condition: Condition, campaign: u8, seeds: u32, say: &Progress<'_>) -> Result<Study, Error> {
    let what = format!("flying and identifying campaigns, {}", condition.told());
    let counted = Counted::new(say, &what, seeds as usize);
    let one = |seed: u32| -> Result<SeedResult, Error> {
        let result = one_seed(condition, campaign, seed.into());
        counted.one();
        result
    };
    let seeds: Result<Vec<SeedResult>, Error> = (1..=seeds).into_par_iter().map(one).collect();
    Ok(Study { condition, seeds: seeds? })
}

fn one_seed(condition: Condition, campaign: u8, seed: u64) -> Result<SeedResult, Error> {
    let flown = fly_campaign(condition, campaign, seed)?;
    let settings = Settings { replicates: 0, thorough: false, ..Settings::default() };
    let found = identify_on(&flown.data, &flown.split, &flown.baseline, &settings, &|_| ())?;
    let mut names: Vec<String> = Vec::new();
    let mut methods: Vec<MethodFigures> = found
        .methods
        .iter()
        .map(|method| {
            // the two likelihoods differ in what they assume, which the name does not say
            let again = names.contains(&method.name);
            names.push(method.name.clone());
            let name = if again { format!("{}, coloured noise", method.name) } else { method.name.clone() };
            let vaf = |label: String| method.vaf_percent.get(&label).copied();
            MethodFigures { name, closed_loop: vaf(closed_loop_label()), prbs: vaf(prbs_label()) }
        })
        .collect();
    methods.insert(0, slow_lms(&flown)?);
    let ceiling = |label: String| found.ceiling_vaf_percent.get(&label).copied();
    methods.push(MethodFigures {
        name: "ceiling".into(),
        closed_loop: ceiling(closed_loop_label()),
        prbs: ceiling(prbs_label()),
    });
    let truth = Plant::nominal();
    let errors = |name: &str, list: &[sysid::estimate::Estimate]| {
        let of = |parameter: &str, truth: f64| {
            let estimate = list.iter().find(|e| e.name == parameter)?;
            Some(100.0 * (estimate.value / truth - 1.0))
        };
        Some(ParameterErrors {
            name: name.into(),
            dm_dq_percent: of("dM_dq", truth.dm_dq)?,
            dm_du_percent: of("dM_du", truth.dm_du)?,
        })
    };
    let matched = found.hinf.as_ref();
    let parameter_errors = [
        errors("grey-box ML", &found.parameters),
        errors("grey-box ML, coloured noise", &found.parameters_coloured),
        matched.and_then(|hinf| errors("H∞ match", &hinf.parameters)),
    ];
    Ok(SeedResult {
        seed,
        supervised: flown.supervised,
        methods,
        agreement_percent: matched.and_then(|hinf| hinf.agreement_percent.get(&prbs_label()).copied()),
        parameter_errors: parameter_errors.into_iter().flatten().collect(),
    })
}

/// The on-board estimator with a step of a tenth, which the excitation is too short for.
fn slow_lms(flown: &Campaign) -> Result<MethodFigures, Error> {
    let usual = LmsConfig::default();
    let slow = LmsConfig { step: 0.1 * usual.step, ..usual };
    let training = pieces(&flown.data, &flown.split.training)?;
    let found = replay::<60>(&training, &slow, &ConvergenceConfig::default())?;
    let model = LinearModel::Impulse(found.fir);
    let held_out = pieces(&flown.data, &flown.split.held_out)?;
    let vaf_of = |label: String| {
        let place = flown.split.held_out.iter().position(|p| p.label == label)?;
        let piece = &held_out[place];
        Some(vaf(&piece.y[piece.rows.clone()], &model.simulate(piece)?))
    };
    Ok(MethodFigures {
        name: format!("LMS FIR, step {:.0e}", slow.step),
        closed_loop: vaf_of(closed_loop_label()),
        prbs: vaf_of(prbs_label()),
    })
}

/// Median, and the range of the middle 80 %.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// 10 and 90 % quantiles.
    pub range: [f64; 2],
    /// Number of values.
    pub count: usize,
}

impl Spread {
    /// Of `values`; `None` where there are none.
    pub fn of(values: impl Iterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.collect();
        sorted.sort_by(f64::total_cmp);
        let last = sorted.len().checked_sub(1)?;
        let at = |share: f64| {
            let place = share * last as f64;
            let low = place as usize;
            sorted[low] + place.fract() * (sorted[(low + 1).min(last)] - sorted[low])
        };
        Some(Self { median: at(0.5), range: [at(0.1), at(0.9)], count: sorted.len() })
    }
}

impl Study {
    /// Names of the methods, in order.
    pub fn methods(&self) -> Vec<&str> {
        self.seeds.first().map_or_else(Vec::new, |s| s.methods.iter().map(|m| m.name.as_str()).collect())
    }

    /// A figure of one method over the seeds.
    pub fn spread(&self, method: &str, figure: impl Fn(&MethodFigures) -> Option<f64>) -> Option<Spread> {
        Spread::of(self.seeds.iter().flat_map(|s| &s.methods).filter(|m| m.name == method).filter_map(figure))
    }

    /// Agreement of the H∞ match with PI-MOESP.
    pub fn agreement(&self) -> Option<Spread> {
        Spread::of(self.seeds.iter().filter_map(|s| s.agreement_percent))
    }

    /// A parameter error of one method.
    pub fn error(&self, method: &str, figure: impl Fn(&ParameterErrors) -> f64) -> Option<Spread> {
        Spread::of(
            self.seeds.iter().flat_map(|s| &s.parameter_errors).filter(|m| m.name == method).map(figure),
        )
    }

    /// Names of the grey boxes.
    pub fn grey_boxes(&self) -> Vec<&str> {
        self.seeds
            .first()
            .map_or_else(Vec::new, |s| s.parameter_errors.iter().map(|m| m.name.as_str()).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        let spread = Spread::of((0..=10).rev().map(f64::from)).unwrap();
        assert_eq!((spread.median, spread.range, spread.count), (5.0, [1.0, 9.0], 11));
        assert_eq!(Spread::of([2.0, 4.0].into_iter()).unwrap().median, 3.0);
        assert!(Spread::of(std::iter::empty()).is_none());
    }
}
