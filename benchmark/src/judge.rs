//! One answer against one truth.
//!
//! A gust is transparent where the truth is something else: a coloured disturbance really is there, so naming it
//! beside the true effect costs nothing, and named alone where nothing is concealed it is no false alarm unless the
//! background is clean.

use crate::truth::{Beside, Said, Sparse, Truth};
use host_sim::proof_case::Kind;
use serde::Serialize;
use serde_json::Value;
use std::collections::BTreeMap;

const GUST: &str = "gust_disturbance";
/// Physics that is the same moment as two others together, which no motion tells apart: told either way it is found.
const SAME_TOGETHER: [(&str, [&str; 2]); 1] = [("asymmetric_friction", ["coulomb_friction", "trim_offset"])];
/// A probability from which on a wrong name is a confident one.
const CONFIDENT: f64 = 0.9;
/// Most candidates that an undecided answer may list to count as right.
const MOST_LISTED: usize = 3;
/// Least gap to the true model that is worth closing, points of VAF.
const GAP_POINTS: f64 = 2.0;
/// Loss of held-out VAF that a correction is blamed for, points.
const LOWERED_POINTS: f64 = 0.5;

/// What came of one case.
#[derive(Clone, Debug, Serialize)]
pub struct Outcome {
    pub case: u64,
    pub kind: Kind,
    pub ids: Vec<String>,
    pub level: String,
    pub size: String,
    pub cost_points: f64,
    pub imu_rigid: bool,
    pub verdict: String,
    /// Names in the answer: the first, its rivals, what was added besides.
    pub listed: Vec<String>,
    pub probability: Option<f64>,
    /// Named, and the first name is right.
    pub right: bool,
    /// Right, or undecided among three at most of which one is right.
    pub among_three: bool,
    /// Every concealed effect was added.
    pub all_found: bool,
    /// At least one was.
    pub one_found: bool,
    /// Something was added that is not there.
    pub companions: bool,
    /// Unlisted, or named with a remainder: the answer for what is outside the catalogue.
    pub unlisted: bool,
    /// A wrong name with a probability of 0.9 or more; outside the catalogue, without a remainder.
    pub confidently_wrong: bool,
    /// ... that is not even a near relative.
    pub far: bool,
    /// Answers that nothing is missing, or none at all.
    pub missed: bool,
    /// A named effect where nothing is concealed.
    pub false_alarm: bool,
    /// Whether the time windows of the answer touch the true one, and lie mostly inside it.
    pub window: Option<[bool; 2]>,
    pub parameters: Vec<Parameter>,
    pub vaf: Option<Vaf>,
    pub sparse: SparseOutcome,
}

/// One parameter that was found.
#[derive(Clone, Debug, Serialize)]
pub struct Parameter {
    pub name: String,
    pub relative_error: f64,
    pub covered: bool,
}

/// VAF on held-out sections, mean, %.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Vaf {
    pub baseline: f64,
    pub extended: f64,
    /// Baseline and extended on sections that were held out in turn, or else the two above.
    pub in_turn: [f64; 2],
    pub true_model: f64,
    pub sparse: Option<f64>,
    pub black_box: Option<f64>,
}

/// What came of the sparse regression.
#[derive(Clone, Debug, Serialize)]
pub struct SparseOutcome {
    pub terms: Vec<String>,
    /// Exactly the concealed effects' terms were kept, each of which stands for one id alone.
    pub right: bool,
    /// The same, where a term may stand for several ids.
    pub among: bool,
}

impl Vaf {
    /// Share of the gap between the baseline and the true model that `reached` closes; none where there is no gap.
    pub fn closed(&self, reached: f64) -> Option<f64> {
        let gap = self.true_model - self.baseline;
        (gap >= GAP_POINTS).then(|| (reached - self.baseline) / gap)
    }
}

/// Whether a correction lowers the VAF by more than counts.
pub fn lowered([before, after]: [f64; 2]) -> bool {
    after < before - LOWERED_POINTS
}

/// Holds an answer against the truth; an answer is missing where the diagnosis refused the recording.
pub fn judge(truth: &Truth, said: Option<&Said>, beside: &Beside) -> Outcome {
    let verdict = said.map_or("refused", |said| said.verdict.as_str());
    let added = said.map_or_else(Vec::new, |said| added(truth, said));
    let listed = said.map_or_else(Vec::new, |said| listed(truth, said, &added));
    let first = listed.first().map(String::as_str);
    let probability = said.and_then(|s| s.effects.iter().find(|e| Some(e.id.as_str()) == first)?.probability);
    let told_as = |id: &str| {
        let same = SAME_TOGETHER.iter().find(|(one, _)| *one == id).map(|(_, together)| together);
        same.filter(|together| together.iter().all(|id| added.iter().any(|name| name == id)))
    };
    let found = |id: &String| added.contains(id) || told_as(id).is_some();
    let concealed = |id: &str| {
        truth.ids.iter().any(|one| one == id || told_as(one).is_some_and(|together| together.contains(&id)))
    };
    let first_is_true = first.is_some_and(concealed);
    let named = verdict == "named";
    let right = named && first_is_true;
    let undecided = verdict == "ambiguous" && listed.len() <= MOST_LISTED;
    let wrong = named && first.is_some_and(|id| !concealed(id) && id != "unlisted");
    let remainder = said.is_some_and(|said| said.remainder.is_object());
    let outside = matches!(truth.kind, Kind::Outside | Kind::Untouched);
    let confidently_wrong = wrong && probability.is_none_or(|p| p >= CONFIDENT) && !(outside && remainder);
    let only_gust = !added.is_empty() && added.iter().all(|id| id == GUST);
    let silent = verdict == "no_mismatch" || verdict == "not_excited";
    Outcome {
        case: truth.case,
        kind: truth.kind,
        ids: truth.ids.clone(),
        level: truth.level.clone(),
        size: truth.size.clone(),
        cost_points: truth.cost_points,
        imu_rigid: truth.imu_rigid,
        verdict: verdict.to_owned(),
        probability,
        right,
        among_three: right || (undecided && listed.iter().any(|id| concealed(id))),
        all_found: truth.ids.iter().all(found),
        one_found: truth.ids.iter().any(found),
        companions: added.iter().any(|id| !concealed(id)),
        unlisted: verdict == "unlisted" || (named && remainder),
        confidently_wrong,
        far: confidently_wrong && !truth.near.iter().any(|id| Some(id.as_str()) == first),
        missed: silent || verdict == "refused",
        false_alarm: truth.kind == Kind::Nothing && !silent && !(only_gust && truth.level != "clean"),
        window: said.and_then(|said| window(truth, said)),
        parameters: said.map_or_else(Vec::new, |said| parameters(truth, said)),
        vaf: said.and_then(|said| held_out(truth, said, beside)),
        sparse: sparse(truth, &beside.sparse),
        listed,
    }
}

/// Ids that were added, without a gust that is no finding.
fn added(truth: &Truth, said: &Said) -> Vec<String> {
    let ids: Vec<&String> = said.effects.iter().map(|effect| &effect.id).collect();
    let gust_counts = truth.ids.iter().any(|id| id == GUST) || ids.iter().all(|id| *id == GUST);
    ids.into_iter().filter(|id| gust_counts || *id != GUST).cloned().collect()
}

/// The first name, its rivals by probability, the other names; each once.
fn listed(truth: &Truth, said: &Said, added: &[String]) -> Vec<String> {
    let first = said.effects.iter().find(|effect| added.first() == Some(&effect.id));
    let mut rivals: Vec<(f64, &String)> = first
        .map_or(&[][..], |effect| &effect.alternatives)
        .iter()
        .map(|rival| (rival.probability.unwrap_or(0.0), &rival.id))
        .collect();
    rivals.sort_by(|a, b| b.0.total_cmp(&a.0));
    let names = added.iter().take(1).chain(rivals.into_iter().map(|(_, id)| id)).chain(added.iter().skip(1));
    let mut listed: Vec<String> = Vec::new();
    for name in names {
        let is_gust = name == GUST && !truth.ids.contains(name) && added.iter().any(|id| id != GUST);
        if !listed.contains(name) && !is_gust {
            listed.push(name.clone());
        }
    }
    listed
}

/// Whether the answer's windows touch the true one, and whether half of them or more lies inside.
fn window(truth: &Truth, said: &Said) -> Option<[bool; 2]> {
    let [from, to] = truth.flight.effects.iter().find_map(|effect| effect.location_time_s)?;
    let windows = said.location.as_ref().map_or(&[][..], |location| &location.time_s);
    let whole: f64 = windows.iter().map(|[a, b]| (b - a).max(0.0)).sum();
    let inside: f64 = windows.iter().map(|[a, b]| (b.min(to) - a.max(from)).max(0.0)).sum();
    Some([inside > 0.0, inside > 0.0 && inside >= 0.5 * whole])
}

/// Errors of the parameters of effects that were added and are there.
fn parameters(truth: &Truth, said: &Said) -> Vec<Parameter> {
    let mut found = Vec::new();
    for effect in &truth.flight.effects {
        let Some(answer) = said.effects.iter().find(|answer| answer.id == effect.id) else { continue };
        for parameter in &effect.parameters {
            let same = answer.parameters.iter().find(|p| p.name == parameter.name);
            let Some((estimate, value)) = same.and_then(|p| Some((p, p.value?))) else { continue };
            let low = estimate.ci95[0].unwrap_or(f64::NEG_INFINITY);
            let high = estimate.ci95[1].unwrap_or(f64::INFINITY);
            found.push(Parameter {
                name: format!("{} {}", effect.id, parameter.name),
                relative_error: (value - parameter.value).abs() / parameter.value.abs().max(1e-12),
                covered: (low..=high).contains(&parameter.value),
            });
        }
    }
    found
}

/// VAF on the sections that were held out; none where the answer names none.
fn held_out(truth: &Truth, said: &Said, beside: &Beside) -> Option<Vaf> {
    let black_box = &beside.black_box_vaf_percent;
    let labels: Vec<&str> = match &said.fit.held_out {
        Value::Array(labels) => labels.iter().filter_map(Value::as_str).collect(),
        // any section may be held out in turn; the methods beside are judged by one and the same
        Value::Object(sections) if black_box.is_empty() => sections.keys().map(String::as_str).collect(),
        Value::Object(_) => black_box.keys().map(String::as_str).collect(),
        _ => Vec::new(),
    };
    let mean = |vaf: &BTreeMap<String, f64>| -> Option<f64> {
        let values: Vec<f64> = labels.iter().map(|s| vaf.get(*s).copied()).collect::<Option<_>>()?;
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    };
    let baseline = mean(&said.fit.baseline.vaf_percent)?;
    let extended = mean(&said.fit.extended.vaf_percent)?;
    Some(Vaf {
        baseline,
        extended,
        in_turn: said.fit.held_out_in_turn().unwrap_or([baseline, extended]),
        true_model: mean(&truth.true_vaf_percent)?,
        sparse: mean(&beside.sparse.vaf_percent),
        black_box: mean(black_box),
    })
}

fn sparse(truth: &Truth, found: &Sparse) -> SparseOutcome {
    let same_number = found.ids.len() == truth.ids.len();
    let matched = |alone: bool| {
        let stands_for = |ids: &Vec<String>, id: &String| ids.contains(id) && (!alone || ids.len() == 1);
        same_number && truth.ids.iter().all(|id| found.ids.iter().any(|ids| stands_for(ids, id)))
    };
    SparseOutcome { terms: found.terms.clone(), right: matched(true), among: matched(false) }
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use serde_json::json;

    /// A truth of this kind with one parameter each.
    pub fn truth(kind: &str, ids: &[&str], level: &str) -> Truth {
        let effects: Vec<_> = ids
            .iter()
            .map(|id| json!({"id": id, "parameters": [{"name": "b", "value": 2.0}], "location_time_s": [40.0, 60.0]}))
            .collect();
        serde_json::from_value(json!({
            "case": 0, "kind": kind, "ids": ids, "near": ["coulomb_friction"], "level": level, "size": "moderate", "cost_points": 5.0,
            "imu_rigid": false, "true_vaf_percent": {"IV": 90.0}, "flight": {"effects": effects}
        }))
        .unwrap()
    }

    /// An answer with these effects, and rivals of the first.
    pub fn said(verdict: &str, ids: &[&str], rivals: &[&str]) -> Said {
        let alternatives: Vec<_> = rivals.iter().map(|id| json!({"id": id, "probability": 0.3})).collect();
        let effect = |id: &&str| {
            json!({"id": id, "probability": 0.95, "alternatives": alternatives,
                   "parameters": [{"name": "b", "value": 2.2, "ci95": [2.1, null]}]})
        };
        serde_json::from_value(json!({
            "verdict": verdict, "effects": ids.iter().map(effect).collect::<Vec<_>>(),
            "location": {"time_s": [[50.0, 70.0]]},
            "fit": {"baseline": {"vaf_percent": {"IV": 70.0}}, "extended": {"vaf_percent": {"IV": 85.0}}, "held_out": ["IV"]}
        }))
        .unwrap()
    }

    pub fn beside(ids: &[&[&str]]) -> Beside {
        let ids: Vec<Vec<String>> =
            ids.iter().map(|ids| ids.iter().map(|id| (*id).to_owned()).collect()).collect();
        let sparse = Sparse { terms: vec!["θ".into(); ids.len()], ids, vaf_percent: BTreeMap::new() };
        let black_box_vaf_percent = BTreeMap::from([("IV".to_owned(), 75.0)]);
        Beside { sparse, black_box_vaf_percent, black_box_parameters: 2 }
    }

    fn judged(truth: &Truth, said: &Said) -> Outcome {
        judge(truth, Some(said), &beside(&[]))
    }

    #[test]
    fn right_undecided_and_wrong_names_are_told_apart() {
        let drag = truth("effect", &["quadratic_drag"], "lab");
        let found = judged(&drag, &said("named", &["quadratic_drag"], &[]));
        assert!(found.right && found.among_three && found.all_found && !found.companions);
        let found = judged(&drag, &said("ambiguous", &["servo_lag"], &["gyro_lag", "quadratic_drag"]));
        assert!(!found.right && found.among_three && !found.confidently_wrong);
        assert_eq!(found.listed, ["servo_lag", "gyro_lag", "quadratic_drag"]);
        let found = judged(&drag, &said("named", &["servo_lag"], &[]));
        assert!(found.confidently_wrong && found.far && !found.among_three);
        let found = judged(&drag, &said("named", &["coulomb_friction"], &[]));
        assert!(found.confidently_wrong && !found.far);
        assert!(judged(&drag, &said("no_mismatch", &[], &[])).missed);
        assert!(judge(&drag, None, &beside(&[])).missed);
    }

    #[test]
    fn one_moment_may_be_told_as_the_two_that_it_is_the_same_as() {
        let friction = truth("effect", &["asymmetric_friction"], "lab");
        let found = judged(&friction, &said("named", &["trim_offset", "coulomb_friction"], &[]));
        assert!(found.right && found.all_found && !found.companions && !found.confidently_wrong);
        let half = judged(&friction, &said("named", &["coulomb_friction"], &[]));
        assert!(!half.right && !half.one_found && half.companions && half.confidently_wrong);
        let more = judged(&friction, &said("named", &["coulomb_friction", "trim_offset", "servo_lag"], &[]));
        assert!(more.right && more.companions);
    }

    #[test]
    fn a_gust_beside_the_true_name_costs_nothing_and_alone_is_an_alarm_only_where_it_is_calm() {
        let drag = truth("effect", &["quadratic_drag"], "lab");
        let found = judged(&drag, &said("named", &[GUST, "quadratic_drag"], &[]));
        assert!(found.right && !found.companions);
        let calm = |level| judged(&truth("nothing", &[], level), &said("named", &[GUST], &[])).false_alarm;
        assert_eq!(["clean", "lab", "paper"].map(calm), [true, false, false]);
        assert!(judged(&truth("nothing", &[], "paper"), &said("unlisted", &["unlisted"], &[])).false_alarm);
        assert!(!judged(&truth("nothing", &[], "paper"), &said("no_mismatch", &[], &[])).false_alarm);
    }

    #[test]
    fn parameters_gaps_and_windows_are_measured() {
        let found = judged(&truth("effect", &["servo_lag"], "lab"), &said("named", &["servo_lag"], &[]));
        assert!((found.parameters[0].relative_error - 0.1).abs() < 1e-12 && !found.parameters[0].covered);
        let vaf = found.vaf.unwrap();
        assert_eq!((vaf.closed(vaf.extended), vaf.closed(75.0)), (Some(0.75), Some(0.25)));
        assert!(lowered([70.0, 69.4]) && !lowered([70.0, 69.6]));
        assert_eq!(vaf.in_turn, [70.0, 85.0]);
        assert_eq!(found.window, Some([true, true]));
    }

    #[test]
    fn outside_the_catalogue_a_name_is_right_where_something_remains_beside_it() {
        let answered = |kind: &str, verdict: &str, remainder: Value| {
            let mut said = said(verdict, &["servo_lag"], &[]);
            said.remainder = remainder;
            let found = judged(&truth(kind, &["gust_burst"], "lab"), &said);
            (found.unlisted, found.confidently_wrong)
        };
        let kept = json!({"size": 0.1});
        for kind in ["outside", "untouched"] {
            assert_eq!(answered(kind, "unlisted", Value::Null), (true, false));
            assert_eq!(answered(kind, "named", kept.clone()), (true, false));
            assert_eq!(answered(kind, "named", Value::Null), (false, true));
            assert_eq!(answered(kind, "named", json!("text")), (false, true), "no object");
            assert_eq!(answered(kind, "ambiguous", kept.clone()), (false, false));
        }
        assert_eq!(
            answered("effect", "named", kept),
            (true, true),
            "a wrong name of the catalogue stays wrong"
        );
    }

    #[test]
    fn sections_held_out_in_turn_say_what_a_correction_costs() {
        let in_turn = |held_out: Value| {
            let mut said = said("named", &["servo_lag"], &[]);
            said.fit.held_out = held_out;
            judged(&truth("effect", &["servo_lag"], "lab"), &said).vaf.map(|vaf| vaf.in_turn)
        };
        let objects =
            json!({"baseline": {"free_run": 60.0, "one_step": 90.0}, "extended": {"free_run": 50.0}});
        let turned = |first: Value| json!({"I": first, "IV": objects});
        assert_eq!(in_turn(turned(json!({"baseline": 80.0, "extended": 90.0}))), Some([70.0, 70.0]));
        assert_eq!(in_turn(turned(json!({"baseline": null, "extended": 90.0}))), Some([60.0, 50.0]));
        assert_eq!(in_turn(json!({"IV": null})), Some([70.0, 85.0]), "as without");
        assert_eq!(in_turn(Value::Null), None);
    }

    #[test]
    fn a_regression_is_right_where_it_keeps_exactly_the_terms() {
        let stiff = truth("effect", &["gravity_stiffness"], "lab");
        let kept = |ids: &[&[&str]]| {
            let SparseOutcome { right, among, .. } = judge(&stiff, None, &beside(ids)).sparse;
            (right, among)
        };
        assert_eq!(kept(&[&["gravity_stiffness"]]), (true, true));
        assert_eq!(kept(&[&["gravity_stiffness", "end_stop"]]), (false, true));
        assert_eq!(kept(&[&["gravity_stiffness"], &["trim_offset"]]), (false, false));
        assert_eq!(kept(&[]), (false, false));
    }
}
