//! The data as the methods take them, and how each method's model is judged.

use super::{MethodResult, ResidualTests};
use crate::dataset::{Dataset, Place};
use crate::error::{Error, ErrorKind};
use crate::held_out::Split;
use crate::identify::butterworth::Butterworth;
use crate::identify::fir::{Piece, ceiling_vaf, common_step};
use crate::identify::linear_model::LinearModel;
use crate::identify::output_error::Output;
use crate::recording::InputUnit;
use crate::validate::coherence::{Line, coherence};
use crate::validate::cross_correlation::cross_correlation;
use crate::validate::vaf::vaf;
use crate::validate::whiteness::whiteness;
use std::collections::BTreeMap;

/// Lags of the residual tests, s.
const TESTED_S: f64 = 1.0;
/// The paper's weight.
const PAPER: Butterworth = Butterworth { order: 15, cutoff: 7.0 };
/// Share of the output's power below the cutoff where the input is not blade pitch.
const POWER_BELOW: f64 = 0.9;

/// The data of one comparison.
pub(super) struct Work<'a> {
    pub data: &'a Dataset,
    pub split: &'a Split,
    pub training: Vec<Piece<'a>>,
    pub held_out: Vec<(&'a Place, Piece<'a>)>,
    pub step: f64,
    pub output: Output,
    pub held_input: bool,
}

impl<'a> Work<'a> {
    pub fn new(data: &'a Dataset, split: &'a Split) -> Result<Self, Error> {
        let pieces = |places: &'a [Place]| {
            places.iter().map(|place| piece(data, place)).collect::<Result<Vec<_>, _>>()
        };
        let (training, held_out) = (pieces(&split.training)?, pieces(&split.held_out)?);
        let step = common_step(&training)?;
        Ok(Self {
            data,
            split,
            training,
            held_out: split.held_out.iter().zip(held_out).collect(),
            step,
            output: if data.has_rate { Output::Rate } else { Output::Angle },
            held_input: data.runs.first().is_none_or(|run| run.held),
        })
    }

    /// Taps that cover the response: about 1.2 s.
    pub fn taps(&self) -> usize {
        if self.step < 0.01 { 256 } else { 60 }
    }

    /// A line for `model`: VAF by section, free runs and residual tests of those that were held out.
    pub fn line(&self, name: &str, detail: String, model: LinearModel, remark: String) -> MethodResult {
        let mut line = MethodResult {
            name: name.into(),
            detail,
            vaf_percent: BTreeMap::new(),
            remark,
            tests: BTreeMap::new(),
            simulated: BTreeMap::new(),
            model: None,
        };
        let held = self.held_out.iter().map(|(place, piece)| (*place, piece, true));
        let trained =
            self.split.training.iter().zip(&self.training).map(|(place, piece)| (place, piece, false));
        // the pieces of a section that gaps have cut are one section
        let mut sections: BTreeMap<&str, (Signals, Vec<f64>, bool)> = BTreeMap::new();
        for (place, piece, is_held) in trained.chain(held) {
            let Some(simulated) = model.simulate(piece) else { continue };
            let (signals, all, held) = sections.entry(place.label.as_str()).or_default();
            signals.add(piece);
            all.extend(simulated);
            *held = is_held;
        }
        for (label, (Signals { u, y }, simulated, is_held)) in sections {
            line.vaf_percent.insert(label.to_owned(), vaf(&y, &simulated));
            if is_held {
                let errors: Vec<f64> = y.iter().zip(&simulated).map(|(y, s)| y - s).collect();
                let lags = (TESTED_S / self.step).ceil() as usize;
                let tests = ResidualTests {
                    whiteness: whiteness(&errors, lags),
                    input: cross_correlation(&u, &errors, lags),
                };
                line.tests.insert(label.to_owned(), tests);
                line.simulated.insert(label.to_owned(), simulated);
            }
        }
        if line.vaf_percent.is_empty() {
            line.remark = format!("no finite free run: the model is unstable; {}", line.remark);
        }
        line.model = Some(model);
        line
    }

    /// A line for a method that has no answer.
    pub fn without_answer(&self, name: &str, error: &Error) -> MethodResult {
        MethodResult {
            name: name.into(),
            detail: "-".into(),
            vaf_percent: BTreeMap::new(),
            remark: error.found.clone().into(),
            tests: BTreeMap::new(),
            simulated: BTreeMap::new(),
            model: None,
        }
    }

    /// By held-out section, the best of taps fitted to it alone, and of each method with taps on what it leaves over.
    pub fn ceilings(&self, methods: &[MethodResult]) -> BTreeMap<String, f64> {
        let mut sections: BTreeMap<&str, Signals> = BTreeMap::new();
        for (place, piece) in &self.held_out {
            sections.entry(place.label.as_str()).or_default().add(piece);
        }
        let ceiling = |(label, Signals { u, y }): (&str, Signals)| {
            let (u, y) = (u.as_slice(), y.as_slice());
            let taps = self.taps().min(y.len() / 10).max(1);
            let alone = ceiling_vaf(u, y, taps).ok();
            let beyond = methods.iter().filter_map(|method| {
                let simulated = method.simulated.get(label).filter(|simulated| simulated.len() == y.len())?;
                let left: Vec<f64> = y.iter().zip(simulated).map(|(y, s)| y - s).collect();
                let explained = ceiling_vaf(u, &left, taps).unwrap_or(0.0);
                Some(100.0 - (100.0 - vaf(y, simulated)) * (100.0 - explained) / 100.0)
            });
            Some((label.to_owned(), alone.into_iter().chain(beyond).reduce(f64::max)?))
        };
        sections.into_iter().filter_map(ceiling).collect()
    }

    /// Response without a model, of the training sections.
    pub fn response(&self) -> Vec<Line> {
        let sections: Vec<[&[f64]; 2]> =
            self.training.iter().map(|p| [&p.u[p.rows.clone()], &p.y[p.rows.clone()]]).collect();
        coherence(&sections, self.step)
    }

    /// The paper's weight for its kind of vehicle; for others its cutoff lies where most of the motion is below.
    pub fn weight(&self) -> Butterworth {
        if self.data.input_unit == InputUnit::Rad {
            return PAPER;
        }
        let mut sum = 0.0;
        let response = self.response();
        let beyond = response.iter().find(|line| {
            sum += line.output_share;
            sum > POWER_BELOW
        });
        Butterworth { cutoff: beyond.map_or(PAPER.cutoff, |line| line.omega_rad_s.clamp(3.0, 60.0)), ..PAPER }
    }
}

/// Input and output of the pieces of a section, one after the other.
#[derive(Default)]
struct Signals {
    u: Vec<f64>,
    y: Vec<f64>,
}

impl Signals {
    fn add(&mut self, piece: &Piece) {
        self.u.extend(&piece.u[piece.rows.clone()]);
        self.y.extend(&piece.y[piece.rows.clone()]);
    }
}

/// A section with the signal that is judged: the rate, or the angle where no rate was measured.
fn piece<'a>(data: &'a Dataset, place: &Place) -> Result<Piece<'a>, Error> {
    let run = data.runs.get(place.run).ok_or_else(|| {
        let found = format!("section {} is of another data set", place.label);
        Error::new(ErrorKind::Section, found, "take the sections from this data set")
    })?;
    let y = run.rate.as_deref().or(run.angle.as_deref()).unwrap_or_default();
    Ok(Piece {
        u: &run.u,
        y,
        supervised: &run.supervised,
        rows: place.rows.clone(),
        run: place.run,
        step: run.step,
    })
}
