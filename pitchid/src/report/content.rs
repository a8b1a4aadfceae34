//! What a diagnosis says, ready to be shown: the same content feeds the terminal, the report and its embedded JSON.

use crate::format::{self, Shown};
use serde::Serialize;
use sysid::catalogue;
use sysid::catalogue::scaled_shape::UNLISTED;
use sysid::diagnosis::answer::{Answer, EffectAnswer, PlaceboAnswer, Verdict};
use sysid::diagnosis::data_checks::{self, DullCause, State};
use sysid::diagnosis::evaluation::Trace;
use sysid::estimate::Estimate;
use sysid::model::file::ModelFile;

/// Windows that cover this share of the data mark nothing.
const NEARLY_EVERYTHING: f64 = 0.9;

/// Everything that a report says in words and numbers.
#[derive(Clone, Debug, Serialize)]
pub struct Content {
    /// Version of this program.
    pub version: &'static str,
    /// Names of the recordings.
    pub recordings: Vec<String>,
    /// Name of the user's model file.
    pub model: Option<String>,
    /// The verdict in two or three words.
    pub verdict: &'static str,
    /// What was found, as one sentence.
    pub headline: String,
    /// How much the verdict asks of the reader: `good`, `found`, `open` or `none`.
    pub tone: &'static str,
    /// VAF by section.
    pub fit: Vec<FitRow>,
    /// What could make model and data differ without missing physics.
    pub dull: DullRows,
    /// Effects that were added.
    pub effects: Vec<EffectRow>,
    /// What a term of the same size gains that nothing calls for.
    pub placebo: Option<String>,
    /// Parameters.
    pub parameters: Vec<ParameterRow>,
    /// Time, band, variable.
    pub location: Option<LocationRow>,
    /// The whole answer, as `--json` writes it.
    pub answer: Answer,
}

/// Dull causes by what became of them.
#[derive(Clone, Debug, Serialize)]
pub struct DullRows {
    /// Those that are there: name and words.
    pub found: Vec<(String, String)>,
    /// Names of those that the data cannot tell.
    pub unknown: String,
    /// Names of those that are ruled out.
    pub ruled_out: String,
}

/// VAF of one section, per cent.
#[derive(Clone, Debug, Serialize)]
pub struct FitRow {
    /// Section.
    pub section: String,
    /// Whether anything was fitted on it.
    pub held_out: bool,
    /// Before.
    pub baseline: String,
    /// After.
    pub extended: String,
    /// What the best unstructured linear model reaches.
    pub ceiling: String,
}

/// An effect in words.
#[derive(Clone, Debug, Serialize)]
pub struct EffectRow {
    /// Id of the catalogue.
    pub id: String,
    /// What it is.
    pub sentence: String,
    /// Its term.
    pub equation: String,
    /// Where it sits.
    pub locus: String,
    /// What speaks for it.
    pub evidence: String,
    /// What the data cannot rule out instead.
    pub alternatives: Option<String>,
}

/// A parameter before and after.
#[derive(Clone, Debug, Serialize)]
pub struct ParameterRow {
    /// Name in model files and JSON.
    pub name: String,
    /// What it is.
    pub meaning: String,
    /// Unit; empty for a pure number.
    pub unit: String,
    /// Value in the user's model.
    pub given: Option<String>,
    /// Baseline, estimated again.
    pub baseline: Option<Shown>,
    /// With the effects.
    pub extended: Option<Shown>,
}

/// Where the mismatch is, in words.
#[derive(Clone, Debug, Serialize)]
pub struct LocationRow {
    /// Where in the loop.
    pub locus: String,
    /// When.
    pub condition: String,
    /// Time windows.
    pub time: String,
    /// Band.
    pub band: String,
    /// Signal that the residual moment depends on most.
    pub variable: String,
    /// Share of the residual moment that each signal explains, per cent, largest first.
    pub shares: Vec<(String, f64)>,
}

impl Content {
    /// Puts an answer into words. `traces` give the order of the sections, `model` the values in use today.
    pub fn new(
        answer: &Answer,
        traces: &[Trace],
        recordings: Vec<String>,
        model: Option<(&str, &ModelFile)>,
    ) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            recordings,
            model: model.map(|(name, _)| name.to_owned()),
            verdict: match answer.verdict {
                Verdict::Unlisted if data_checks::stop(&answer.dull_causes) => "the data first",
                other => verdict(other),
            },
            headline: headline(answer),
            tone: match answer.verdict {
                Verdict::NoMismatch => "good",
                Verdict::Named => "found",
                Verdict::Ambiguous | Verdict::Unlisted => "open",
                Verdict::NotExcited => "none",
            },
            fit: fit_rows(answer, traces),
            dull: dull_rows(&answer.dull_causes),
            effects: answer.effects.iter().filter(|e| was_added(e)).map(effect_row).collect(),
            placebo: answer.fit.placebo.as_ref().map(placebo_words),
            parameters: parameter_rows(answer, model.map(|(_, model)| model)),
            location: location_row(answer, traces),
            answer: answer.clone(),
        }
    }
}

/// Whether an effect was added to the model, and not only described.
pub fn was_added(effect: &EffectAnswer) -> bool {
    effect.id != UNLISTED || !effect.parameters.is_empty()
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoMismatch => "no mismatch",
        Verdict::Named => "missing physics named",
        Verdict::Ambiguous => "missing physics, ambiguous",
        Verdict::Unlisted => "missing physics, unlisted",
        Verdict::NotExcited => "not excited",
    }
}

fn headline(answer: &Answer) -> String {
    let sentences: Vec<String> = answer.effects.iter().map(|e| sentence(&e.id)).collect();
    match answer.verdict {
        Verdict::NoMismatch => "Nothing is missing that these data would show".into(),
        Verdict::NotExcited => "These data cannot tell".into(),
        Verdict::Unlisted if data_checks::stop(&answer.dull_causes) => {
            "The data are to be put right first".into()
        }
        Verdict::Unlisted => "Something is missing that the catalogue does not list".into(),
        Verdict::Named => capitalised(&sentences.join("; and ")),
        Verdict::Ambiguous => {
            let rivals: Vec<&str> =
                answer.effects.iter().flat_map(|e| &e.alternatives).map(|a| a.id.as_str()).collect();
            format!("{}, or instead {}", capitalised(&sentences.join("; and ")), rivals.join(" or "))
        }
    }
}

fn capitalised(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or(String::new(), |first| first.to_uppercase().chain(chars).collect())
}

fn sentence(id: &str) -> String {
    catalogue::find(id)
        .map_or_else(|| "something that the catalogue does not list".into(), |e| e.about().sentence.into())
}

/// A word of the JSON (`pitch_moment`) as people write it.
pub fn spoken(word: &impl Serialize) -> String {
    let json = serde_json::to_value(word).ok();
    json.and_then(|v| v.as_str().map(|s| s.replace('_', " "))).unwrap_or_default()
}

fn dull_rows(causes: &[DullCause]) -> DullRows {
    let of = |state: State| causes.iter().filter(move |c| c.state == state);
    let names = |state: State| of(state).map(|c| spoken(&c.cause)).collect::<Vec<_>>().join(", ");
    DullRows {
        found: of(State::Found).map(|c| (spoken(&c.cause), c.words.clone())).collect(),
        unknown: names(State::CannotTell),
        ruled_out: names(State::RuledOut),
    }
}

fn fit_rows(answer: &Answer, traces: &[Trace]) -> Vec<FitRow> {
    let fit = &answer.fit;
    let mut sections: Vec<&String> = traces.iter().map(|t| &t.label).collect();
    for label in fit.baseline.vaf_percent.keys() {
        if !sections.contains(&label) {
            sections.push(label);
        }
    }
    let shown = |table: &std::collections::BTreeMap<String, f64>, section: &String| {
        table.get(section).map_or("-".into(), |v| format::percent(*v))
    };
    let row = |section: &String| FitRow {
        held_out: fit.held_out.contains(section),
        baseline: shown(&fit.baseline.vaf_percent, section),
        extended: shown(&fit.extended.vaf_percent, section),
        ceiling: shown(&fit.ceiling_vaf_percent, section),
        section: section.clone(),
    };
    sections.into_iter().map(row).collect()
}

fn placebo_words(placebo: &PlaceboAnswer) -> String {
    format!(
        "A placebo of the same size ({} of arbitrary frequency instead): gain in BIC {}, held-out VAF {:+.1} points, \
         held-out 2 ln likelihood {:+.0}",
        if placebo.parameters == 1 { "one sine".into() } else { format!("{} sines", placebo.parameters) },
        format::plain(placebo.delta_bic),
        placebo.vaf_gain_points,
        placebo.held_out_log_likelihood_gain,
    )
}

fn effect_row(effect: &EffectAnswer) -> EffectRow {
    let evidence = &effect.evidence;
    let chance =
        if evidence.p_value < 1e-12 { "< 1e-12".into() } else { format!("= {:.1e}", evidence.p_value) };
    let alternatives: Vec<String> =
        effect.alternatives.iter().map(|a| format!("{} ({:.0} %)", a.id, 100.0 * a.probability)).collect();
    EffectRow {
        id: effect.id.clone(),
        sentence: sentence(&effect.id),
        equation: effect.equation.clone(),
        locus: spoken(&effect.locus),
        evidence: format!(
            "probability {:.1} %, BIC lower by {}, p {chance}; held-out VAF {:+.1} points, held-out 2 ln likelihood {:+.0}",
            100.0 * effect.probability,
            format::plain(evidence.delta_bic),
            evidence.vaf_gain_points,
            evidence.held_out_log_likelihood_gain,
        ),
        alternatives: (!alternatives.is_empty()).then(|| alternatives.join(", ")),
    }
}

fn parameter_rows(answer: &Answer, model: Option<&ModelFile>) -> Vec<ParameterRow> {
    let (before, after) = (&answer.fit.baseline.parameters, &answer.fit.extended.parameters);
    let row = |estimate: &Estimate, baseline: Option<&Estimate>, extended: Option<&Estimate>| {
        let effect = answer.effects.iter().find(|e| e.parameters.contains(estimate));
        let of_effect = effect.map_or("", |e| e.id.as_str());
        let of_plant = plant_meaning(&estimate.name);
        ParameterRow {
            name: estimate.name.clone(),
            meaning: if of_plant.is_empty() { of_effect } else { of_plant }.into(),
            unit: format::unit(&estimate.unit).to_owned(),
            given: model.and_then(|m| given(m, &estimate.name, of_effect)),
            baseline: baseline.map(format::estimate),
            extended: extended.map(format::estimate),
        }
    };
    let mut left = before.iter().collect::<Vec<_>>();
    let mut rows = Vec::new();
    for estimate in after {
        // two effects may have parameters of one name: each partner is taken once
        let partner = left.iter().position(|b| b.name == estimate.name).map(|i| left.remove(i));
        rows.push(row(estimate, partner, Some(estimate)));
    }
    rows.extend(left.into_iter().map(|estimate| row(estimate, Some(estimate), None)));
    rows
}

/// What a parameter of the plant is; empty for any other.
pub fn plant_meaning(name: &str) -> &'static str {
    match name {
        "dM_dq" => "pitch damping ∂M/∂q",
        "dM_du" => "control effectiveness ∂M/∂u",
        "delay" => "loop delay τ",
        "mount_mode" => "mode of the IMU mount",
        "mount_zeta" => "damping ratio of the mount",
        _ => "",
    }
}

/// The value that the user's model has for a parameter of the plant, or of `effect`.
fn given(model: &ModelFile, name: &str, effect: &str) -> Option<String> {
    let plant = &model.plant;
    let mount = || Some((plant.mount_k?, plant.mount_c?, plant.mount_j?));
    let of_effect = || model.effects.iter().find(|e| e.id == effect)?.parameters.get(name).copied();
    match name {
        "dM_dq" => plant.dm_dq.map(format::as_given),
        "dM_du" => plant.dm_du.map(format::as_given),
        "delay" => plant.delay_s.map(format::as_given),
        "mount_mode" => mount().map(|(k, _, j)| format::plain((k / j).sqrt() / std::f64::consts::TAU)),
        "mount_zeta" => mount().map(|(k, c, j)| format::plain(c / (2.0 * (k * j).sqrt()))),
        _ => of_effect().map(format::as_given),
    }
}

fn location_row(answer: &Answer, traces: &[Trace]) -> Option<LocationRow> {
    let location = answer.location.as_ref()?;
    let mut windows: Vec<String> =
        location.time_s.iter().map(|[a, b]| format!("{a:.1} to {b:.1} s")).collect();
    if is_everywhere(&location.time_s, traces) {
        windows = vec!["nowhere in particular".into()];
    }
    Some(LocationRow {
        locus: spoken(&location.locus),
        condition: location.condition.clone(),
        time: windows.join(", "),
        band: {
            let [low, high] = location.band_rad_s;
            format!("{} to {} rad/s", format::plain(low), format::plain(high))
        },
        variable: symbol(&location.variable).into(),
        shares: location.dependence.iter().map(|d| (symbol(&d.variable).into(), 100.0 * d.share)).collect(),
    })
}

/// Whether windows of time cover nearly everything that was fitted on, and so say nothing.
pub fn is_everywhere(windows: &[[f64; 2]], traces: &[Trace]) -> bool {
    let inside = |t: &f64| windows.iter().any(|[from, to]| (*from..=*to).contains(t));
    let fitted = || traces.iter().filter(|t| !t.held_out).flat_map(|t| &t.t);
    let covered = fitted().filter(|t| inside(t)).count();
    covered as f64 >= NEARLY_EVERYTHING * fitted().count() as f64
}

/// A signal of the answer as it is written in formulae.
pub fn symbol(variable: &str) -> &str {
    match variable {
        "u_rate" => "change of u",
        "theta" => "θ",
        other => other,
    }
}
