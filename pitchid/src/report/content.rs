//! What a diagnosis says, ready to be shown: the same content feeds the terminal, the report and its embedded JSON.

use crate::format::{self, Shown};
use serde::Serialize;
use sysid::catalogue;
use sysid::diagnosis::answer::{Answer, EffectAnswer, Verdict, WithError};
use sysid::diagnosis::axis_words::of_axis;
use sysid::diagnosis::data_checks::{DataCheck, State};
use sysid::diagnosis::traces::Trace;
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
    pub checks: CheckRows,
    /// Effects that were added.
    pub effects: Vec<EffectRow>,
    /// What is left beside them.
    pub remainder: Option<String>,
    /// Parameters.
    pub parameters: Vec<ParameterRow>,
    /// Time, band, variable.
    pub location: Option<LocationRow>,
    /// The whole answer, as `--json` writes it.
    pub answer: Answer,
}

/// Checks of the data by what became of them.
#[derive(Clone, Debug, Serialize)]
pub struct CheckRows {
    /// Those that are there and that no question has told: name and words.
    pub found: Vec<(String, String)>,
    /// Names of those that the data cannot tell.
    pub unknown: String,
    /// Names of those that are ruled out.
    pub ruled_out: String,
}

/// VAF of one section that was held out, per cent.
#[derive(Clone, Debug, Serialize)]
pub struct FitRow {
    /// Section.
    pub section: String,
    /// Free run, before.
    pub baseline: String,
    /// Free run, after.
    pub extended: String,
    /// By horizon: the seconds ahead, before, after.
    pub horizons: Vec<[String; 3]>,
    /// Predictions 1 s ahead, before.
    pub near_baseline: String,
    /// Predictions 1 s ahead, after.
    pub near_extended: String,
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
            verdict: verdict_of(answer),
            headline: headline(answer),
            tone: match answer.verdict {
                Verdict::NoMismatch => "good",
                Verdict::Named => "found",
                Verdict::Ambiguous | Verdict::Unlisted => "open",
                Verdict::NotExcited | Verdict::CheckData => "none",
            },
            fit: fit_rows(answer, traces),
            checks: check_rows(answer),
            effects: answer
                .effects
                .iter()
                .map(|effect| effect_row(effect, by_balance(answer, effect)))
                .collect(),
            remainder: remainder_words(answer),
            parameters: parameter_rows(answer, model.map(|(_, model)| model)),
            location: location_row(answer, traces),
            answer: answer.clone(),
        }
    }

    /// Its own words for the axis that the answer tells of.
    pub fn of_axis(mut self, axis: &str) -> Self {
        let mut words: Vec<&mut String> = vec![&mut self.headline];
        words.extend(self.effects.iter_mut().flat_map(|effect| [&mut effect.sentence, &mut effect.locus]));
        words.extend(self.location.iter_mut().map(|location| &mut location.locus));
        words.extend(self.parameters.iter_mut().map(|parameter| &mut parameter.meaning));
        for text in words {
            *text = of_axis(text, axis);
        }
        self
    }
}

/// The verdict in two or three words.
pub fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoMismatch => "no mismatch",
        Verdict::Named => "missing physics named",
        Verdict::Ambiguous => "missing physics, ambiguous",
        Verdict::Unlisted => "missing physics, unlisted",
        Verdict::NotExcited => "not excited",
        Verdict::CheckData => "the data first",
    }
}

/// The same of an answer: a disturbance alone is nothing that a model lacks.
pub fn verdict_of(answer: &Answer) -> &'static str {
    if answer.disturbance_alone() { "no mismatch but gusts" } else { verdict(answer.verdict) }
}

/// What was found, as one sentence.
pub fn headline(answer: &Answer) -> String {
    // a gust is no answer to the input, and stands behind what is
    let is_gust = |e: &EffectAnswer| e.id == "gust_disturbance";
    let alone = answer.effects.iter().all(is_gust);
    let told = answer.effects.iter().filter(|e| alone || !is_gust(e));
    let sentences: Vec<String> = told.map(|e| sentence(&e.id)).collect();
    match answer.verdict {
        Verdict::NoMismatch if answer.remainder.is_some() => "Nothing is missing that matters".into(),
        Verdict::NoMismatch => "Nothing is missing that these data would show".into(),
        Verdict::NotExcited => "These data cannot tell".into(),
        Verdict::CheckData => "The data are to be put right first".into(),
        Verdict::Unlisted if answer.tells_a_name() => {
            "Something is missing, and no name for it is sure".into()
        }
        Verdict::Unlisted => "Something is missing that the catalogue does not list".into(),
        Verdict::Named if answer.disturbance_alone() => {
            format!("What answers to the input is all in the model; {}", sentences.join("; and "))
        }
        Verdict::Named => capitalised(&sentences.join("; and ")),
        Verdict::Ambiguous => {
            let mut rivals: Vec<String> = Vec::new();
            for rival in answer.effects.iter().flat_map(|e| &e.alternatives) {
                let rival = sentence(&rival.id);
                if !rivals.contains(&rival) {
                    rivals.push(rival);
                }
            }
            format!("{}; or instead {}", capitalised(&sentences.join("; and ")), rivals.join("; or "))
        }
    }
}

/// With a capital letter at its beginning.
pub fn capitalised(text: &str) -> String {
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

fn check_rows(answer: &Answer) -> CheckRows {
    let of = |state: State| answer.data_checks.iter().filter(move |c| c.state == state);
    let told = |c: &&DataCheck| answer.questions.iter().any(|q| q.answer.contains(&c.words));
    let names = |state: State| of(state).map(|c| spoken(&c.cause)).collect::<Vec<_>>().join(", ");
    CheckRows {
        found: of(State::Found).filter(|c| !told(c)).map(|c| (spoken(&c.cause), c.words.clone())).collect(),
        unknown: names(State::CannotTell),
        ruled_out: names(State::RuledOut),
    }
}

fn fit_rows(answer: &Answer, traces: &[Trace]) -> Vec<FitRow> {
    let held = &answer.fit.held_out;
    let mut sections: Vec<&String> = Vec::new();
    for label in traces.iter().map(|t| &t.label).chain(held.keys()) {
        if !sections.contains(&label) {
            sections.push(label);
        }
    }
    let ahead = |vaf: Option<&WithError>| {
        vaf.map_or("-".into(), |v| {
            let error = v.standard_error;
            let error = if error > 100.0 { "over 100".into() } else { format::percent(error) };
            format!("{} ± {error}", format::percent(v.value))
        })
    };
    let row = |section: &&String| {
        let found = held.get(*section)?;
        let ceiling = answer.fit.ceiling_vaf_percent.get(*section);
        Some(FitRow {
            baseline: format::percent(found.baseline.free_run),
            extended: format::percent(found.extended.free_run),
            horizons: found
                .baseline
                .horizons
                .iter()
                .map(|(seconds, before)| {
                    let after = found.extended.horizons.get(seconds);
                    [(*seconds).to_owned(), ahead(Some(before)), ahead(after)]
                })
                .collect(),
            near_baseline: ahead(found.baseline.horizons.get("1.0")),
            near_extended: ahead(found.extended.horizons.get("1.0")),
            ceiling: ceiling.map_or("-".into(), |v| format::percent(*v)),
            section: (*section).clone(),
        })
    };
    sections.iter().filter_map(row).collect()
}

fn remainder_words(answer: &Answer) -> Option<String> {
    let left = answer.remainder.as_ref()?;
    let tests: Vec<String> =
        left.tests.iter().map(|t| format!("{} (p = {:.0e})", t.name, t.p_value)).collect();
    let failed =
        if tests.is_empty() { String::new() } else { format!(" Tests that fail: {}.", tests.join(", ")) };
    let equation = if left.equation.is_empty() { String::new() } else { format!(" {}.", left.equation) };
    Some(format!("{}: {:.1} % of what can be closed.{equation}{failed}", left.words, 100.0 * left.share))
}

/// Whether only the balance of the means shows it.
fn by_balance(answer: &Answer, effect: &EffectAnswer) -> bool {
    effect.id == "trim_offset" && answer.balance.as_ref().is_some_and(|balance| balance.out_of_trim)
}

fn effect_row(effect: &EffectAnswer, by_balance: bool) -> EffectRow {
    let evidence = &effect.evidence;
    let chance =
        if evidence.p_value < 1e-12 { "< 1e-12".into() } else { format!("= {:.1e}", evidence.p_value) };
    let alternatives: Vec<String> =
        effect.alternatives.iter().map(|a| format!("{} ({:.0} %)", a.id, 100.0 * a.probability)).collect();
    let sure = format!(
        "probability {}, log evidence {}, p {chance}",
        probability(effect.probability),
        format::plain(evidence.log_evidence)
    );
    EffectRow {
        id: effect.id.clone(),
        sentence: sentence(&effect.id),
        equation: effect.equation.clone(),
        locus: spoken(&effect.locus),
        evidence: if by_balance {
            format!("{sure}, by the mean of the command over time")
        } else {
            format!(
                "{sure}, {:.0} % of what can be closed; on held-out data, by this term alone: \
                 VAF {:+.1} ± {:.1} points, 2 ln likelihood {:+.0} ± {:.0}",
                100.0 * effect.share,
                evidence.vaf_gain_points.value,
                evidence.vaf_gain_points.standard_error,
                evidence.held_out_log_likelihood.value,
                evidence.held_out_log_likelihood.standard_error,
            )
        },
        alternatives: (!alternatives.is_empty()).then(|| alternatives.join(", ")),
    }
}

/// Never 0 or 100 %, which no data give.
pub fn probability(p: f64) -> String {
    if p > 0.999 { "over 99.9 %".into() } else { format!("{:.1} %", 100.0 * p) }
}

fn parameter_rows(answer: &Answer, model: Option<&ModelFile>) -> Vec<ParameterRow> {
    let (before, after) = (&answer.fit.baseline.parameters, &answer.fit.extended.parameters);
    let row = |estimate: &Estimate, baseline: Option<&Estimate>, extended: Option<&Estimate>| {
        let found = answer.effects.iter().map(|e| (&e.id, &e.parameters));
        let known = answer.in_model.iter().map(|e| (&e.id, &e.parameters));
        let of_effect = found.chain(known).find(|(_, own)| own.contains(estimate)).map_or("", |(id, _)| id);
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

/// Whether windows of time cover nearly everything, and so say nothing.
pub fn is_everywhere(windows: &[[f64; 2]], traces: &[Trace]) -> bool {
    let inside = |t: &f64| windows.iter().any(|[from, to]| (*from..=*to).contains(t));
    let all = || traces.iter().flat_map(|t| &t.t);
    let covered = all().filter(|t| inside(t)).count();
    covered as f64 >= NEARLY_EVERYTHING * all().count() as f64
}

/// A signal of the answer as it is written in formulae.
pub fn symbol(variable: &str) -> &str {
    match variable {
        "u_rate" => "change of u",
        "theta" => "θ",
        other => other,
    }
}
