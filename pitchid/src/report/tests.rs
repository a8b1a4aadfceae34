use super::figures::{marked_windows, moments};
use super::fixture::{HOSTILE, model};
use super::*;
use sysid::diagnosis::answer::{Answer, FitAnswer, Verdict};
use sysid::diagnosis::component::{Branch, Component};
use sysid::diagnosis::left_over::{LeftOver, OneStep};
use sysid::diagnosis::map::Cell;
use sysid::diagnosis::over_time::{OverTime, ResidualMoment};
use sysid::diagnosis::spectra::Spectra;
use sysid::diagnosis::step_response::StepResponses;
use sysid::diagnosis::traces::Trace;
use sysid::model::file::ModelFile;
use sysid::validate::cross_correlation::cross_correlation;
use sysid::validate::whiteness::whiteness;

fn answer() -> Answer {
    fixture::answer(Verdict::Ambiguous, &[("coulomb_friction", 0.1)], &["servo_deadband"])
}

fn traces() -> Vec<Trace> {
    let t: Vec<f64> = (0..500).map(|k| 0.02 * f64::from(k)).collect();
    let wave: Vec<f64> = t.iter().map(|t| t.sin()).collect();
    let trace = |label: &str| Trace {
        label: label.into(),
        recording: 0,
        t: t.clone(),
        input: wave.clone(),
        angle: None,
        measured: wave.clone(),
        baseline: wave.clone(),
        extended: wave.clone(),
        unit: "rad/s",
    };
    vec![trace("I"), trace(HOSTILE)]
}

fn over_time() -> OverTime {
    let t: Vec<f64> = (50..500).map(|k| 0.02 * f64::from(k)).collect();
    let moment: Vec<f64> = t.iter().map(|t| 0.1 * t.sin()).collect();
    let run = ResidualMoment { recording: 0, extended: Some(moment.clone()), baseline: moment, t };
    OverTime { of_time: false, runs: vec![run] }
}

fn component() -> Component {
    let branch = Branch {
        data: vec![[-0.3, 0.1, 0.02], [0.3, -0.1, 0.02]],
        with: vec![[-0.3, 0.1], [0.3, -0.1]],
        without: vec![[-0.3, 0.0], [0.3, 0.0]],
    };
    let friction = sysid::catalogue::find("coulomb_friction").unwrap();
    Component {
        about: friction.about(),
        picture: friction.picture().unwrap(),
        input_unit: "rad",
        left: false,
        branches: vec![branch],
    }
}

fn left_over() -> LeftOver {
    let wave: Vec<f64> = (0..400).map(|k| (0.3 * f64::from(k)).sin()).collect();
    let one = OneStep { own: whiteness(&wave, 20), with_input: cross_correlation(&wave, &wave, 20) };
    LeftOver { before: one.clone(), after: Some(one), step: 0.02 }
}

fn found(answer: &Answer, traces: &[Trace]) -> Diagnosis {
    let judged = !answer.effects.is_empty();
    let response = || (0..50).map(|k| [0.02 * f64::from(k), 0.1 * f64::from(k), 0.01]).collect();
    let cell =
        |k: f64| Cell { recording: 0, time_s: [k, k + 1.0], band_rad_s: [1.0, 9.0], power: 9.0, chance: 3.0 };
    let map: Vec<Cell> = (0..9).map(|k| cell(f64::from(k))).collect();
    let power: Vec<[f64; 2]> = (1..40).map(|k| [f64::from(k), 1.0 / f64::from(k)]).collect();
    Diagnosis {
        answer: answer.clone(),
        traces: traces.to_vec(),
        over_time: over_time(),
        components: answer.effects.iter().map(|_| component()).collect(),
        left_over: judged.then(left_over),
        spectra: if judged {
            Spectra {
                measured: power.clone(),
                before: power.clone(),
                after: power.clone(),
                background: power,
                maps: [map.clone(), map],
            }
        } else {
            Spectra::default()
        },
        steps: judged.then(|| StepResponses { size: 0.1, before: response(), after: Some(response()) }),
        candidates: Vec::new(),
        model: ModelFile::unknown(),
    }
}

/// The page and the pictures of a diagnosis.
fn drawn(found: &Diagnosis) -> (String, Vec<(String, String)>) {
    let content = Content::new(&found.answer, &found.traces, vec![HOSTILE.into()], None);
    let repeat = Repeat { command: HOSTILE.into(), inputs: vec![(HOSTILE.into(), None)] };
    let report = Report { content: &content, found, recordings: &[], repeat };
    (report.html(), report.pictures())
}

fn page(answer: &Answer, traces: &[Trace]) -> String {
    drawn(&found(answer, traces)).0
}

#[test]
fn every_picture_is_a_file_of_its_own_name() {
    let mut found = found(&answer(), &traces());
    found.components.push(component());
    let (_, drawn) = drawn(&found);
    let names: Vec<&str> = drawn.iter().map(|(name, _)| name.as_str()).collect();
    for name in [
        "section-1.svg",
        "section-2.svg",
        "term-coulomb_friction.svg",
        "term-coulomb_friction-2.svg",
        "map-1.svg",
        "step.svg",
        "response.svg",
        "spectra.svg",
        "correlations.svg",
    ] {
        assert_eq!(names.iter().filter(|n| **n == name).count(), 1, "{names:?}");
    }
    assert!(drawn.iter().all(|(_, svg)| svg.starts_with("<svg xmlns=") && svg.contains("<style>")));
}

#[test]
fn a_term_that_is_left_is_not_drawn_as_what_is_missing() {
    let mut found = found(&answer(), &traces());
    found.components = vec![Component { left: true, ..component() }];
    let (page, _) = drawn(&found);
    let [missing, left, picture] =
        ["What is missing, as the data have it", "What is left</h2>", "Dots:"].map(|words| page.find(words));
    assert!(missing.is_none() && left.is_some() && picture > left, "{left:?} {picture:?}");
    found.components = vec![component()];
    assert!(drawn(&found).0.contains("What is missing, as the data have it"));
}

#[test]
fn nothing_from_a_file_becomes_markup() {
    let page = page(&answer(), &traces());
    let ends = ["<script", "</script>"].map(|tag| page.matches(tag).count());
    assert_eq!(ends, [2, 2], "the JSON and what moves the charts");
    assert!(!page.contains("alert('x')</"));
}

#[test]
fn the_page_needs_nothing_else() {
    let page = page(&answer(), &traces());
    for external in ["http:", "https:", "src=", "href=", "@import", "url("] {
        assert!(!page.contains(external), "{external}");
    }
}

#[test]
fn the_embedded_json_is_the_content() {
    let page = page(&answer(), &traces());
    let (_, rest) = page.split_once("id=\"diagnosis\">").unwrap();
    let (json, _) = rest.split_once("</script>").unwrap();
    let content: serde_json::Value = serde_json::from_str(json).unwrap();
    assert_eq!(content["answer"]["verdict"], "ambiguous");
    assert_eq!(content["recordings"][0], HOSTILE);
}

#[test]
fn every_part_of_the_answer_is_shown() {
    let page = page(&answer(), &traces());
    let parts = [
        "coulomb_friction",
        "servo_deadband (30 %)",
        "79.6",
        "96.3",
        "97.0",
        "held out",
        "sign(q)",
        "a friction that falls with the speed",
    ];
    for part in parts {
        assert!(page.contains(part), "{part}");
    }
    assert!(page.contains("<dt>Is the loop closed?</dt>") && page.contains("cannot be told: half a sample"));
    assert!(!page.contains("<dt>feedback</dt>"), "what a question has told is not told twice");
    assert!(page.contains("<dd>input hold</dd>"));
    assert!(page.contains("<dd>rate sign</dd>"));
    assert!(
        page.contains("pitch damping")
            && page.contains("0.100")
            && page.contains("<strong>0.05 to 0.1 s</strong>")
    );
    assert_eq!(page.matches("class=\"chart\"").count(), 9, "each picture once");
    assert!(!page.contains("residual moment against"), "the picture of the term shows it as it is");
}

#[test]
fn an_answer_without_anything_is_a_page_too() {
    let nothing = || model(0.0, Vec::new());
    let fit = FitAnswer { baseline: nothing(), extended: nothing(), ..FitAnswer::default() };
    let empty = Answer {
        verdict: Verdict::NotExcited,
        effects: Vec::new(),
        location: None,
        remainder: None,
        fit,
        next_experiment: None,
        per_unit_inertia: false,
        notes: Vec::new(),
        ..answer()
    };
    let page = page(&empty, &[]);
    assert!(page.contains("These data cannot tell") && !page.contains("<svg"));
}

#[test]
fn the_moment_over_time_is_shown_where_the_time_matters() {
    let mut answer = answer();
    let shown = |answer: &Answer, of_time| {
        let content = Content::new(answer, &traces(), Vec::new(), None);
        moments(&content, &traces(), &OverTime { of_time, ..over_time() }).len()
    };
    assert_eq!(shown(&answer, false), 1, "a window is marked");
    if let Some(location) = answer.location.as_mut() {
        location.time_s = vec![[0.0, 10.0]];
    }
    assert_eq!((shown(&answer, false), shown(&answer, true)), (0, 1));
}

#[test]
fn windows_that_cover_nearly_everything_mark_nothing() {
    let mut answer = answer();
    assert_eq!(marked_windows(&answer, &traces()).len(), 1);
    if let Some(location) = answer.location.as_mut() {
        location.time_s = vec![[0.0, 9.5]];
    }
    assert!(marked_windows(&answer, &traces()).is_empty());
}

#[test]
fn parameters_of_one_name_belong_to_their_own_effects() {
    let twice = [("servo_deadband", 0.004), ("linkage_backlash", 0.001)];
    let rows = Content::new(&fixture::answer(Verdict::Named, &twice, &[]), &[], Vec::new(), None).parameters;
    let of =
        |row: &content::ParameterRow| (row.meaning.clone(), row.extended.as_ref().map(|s| s.value.clone()));
    assert_eq!(of(&rows[1]), ("servo_deadband".into(), Some("0.00400".into())));
    assert_eq!(of(&rows[2]), ("linkage_backlash".into(), Some("0.00100".into())));
    assert!(rows[0].baseline.is_some() && rows[1].baseline.is_none());
}

#[test]
fn columns_after_are_there_only_where_something_was_added() {
    let mut answer = fixture::answer(Verdict::Unlisted, &[("unlisted", 0.1)], &[]);
    let with = page(&answer, &traces());
    assert!(with.contains("What was added") && with.contains("after, 95 %"));
    answer.effects.clear();
    let without = page(&answer, &traces());
    assert!(!without.contains("What was added") && !without.contains("after, 95 %"));
}

#[test]
fn where_the_inertia_is_not_known_no_part_of_the_answer_tells_a_moment() {
    let mut told = answer();
    told.effects[0].equation = "a step of 0.53 ± 0.27 N m at q = 0.12 rad/s".into();
    told.remainder.as_mut().unwrap().equation = "M += 0.1 N m/rad θ".into();
    told.tell_per_inertia();
    let json = serde_json::to_string(&told).unwrap();
    assert!(
        json.contains("0.27 rad/s² at") && json.contains("0.1 1/s² θ") && !json.contains("N m"),
        "{json}"
    );
}
