//! The model in a free run at full rate, and its parameters by output error.
//!
//! ```text
//! y_k = θ_k + e_k        min over parameters and the state at the start of Σ e_k²
//! ```

use super::piece::Piece;
use sysid::catalogue::find;
use sysid::dataset::Amplitudes;
use sysid::model::effect::Scale;
use sysid::model::noise::Disturbance;
use sysid::model::pitch::{PitchModel, Term};
use sysid::model::plant::{Plant, Q, THETA};
use sysid::optim::levenberg_marquardt::{Coordinate, Effort, minimize};

/// A simulation has no noise: any noise model serves.
const NO_NOISE: Disturbance = Disturbance {
    intensity: 0.0,
    frequency: 1.0,
    damping: 1.0,
    zero: 0.0,
    angle_noise: 1.0,
    third: None,
    corrects: None,
};
const EFFORT: Effort = Effort { iterations: 80, tolerance: 0.05 };
/// The whole is divided by these, one after the other: where friction holds, a position once lost stays lost, and a free run over
/// all of it from a start that is far off has many minima.
const SHARES: [usize; 4] = [8, 4, 2, 1];
/// Unknowns before those of the terms: ∂M/∂q, ∂M/∂u, delay, rate and angle at the start.
const FIRST: usize = 5;
/// A moment that every rig may have: its sensors and drives have offsets.
pub const CONSTANT: &str = "trim_offset";
/// Bounds of the catalogue are those of vehicles; of other rigs they are so many times wider.
const WIDER: f64 = 100.0;

/// A model that can be run.
#[derive(Clone)]
pub struct Simulation {
    /// The plant.
    pub plant: Plant,
    /// Physics beside it.
    pub terms: Vec<Term>,
    /// Sizes of the signals that it was fitted to.
    pub sizes: Amplitudes,
}

impl Simulation {
    /// A plant with terms, and a constant moment where they have none. `sizes` are those of the signals.
    pub fn new(plant: Plant, mut terms: Vec<Term>, sizes: Amplitudes) -> Self {
        if let Some(effect) = find(CONSTANT)
            && terms.iter().all(|term| term.effect.about().id != CONSTANT)
        {
            terms.push(Term { effect, values: vec![0.0] });
        }
        Self { plant, terms, sizes }
    }

    /// Free run over `piece` from rate and position at its first sample. `None` where it diverges.
    pub fn run(&self, piece: &Piece, start: [f64; 2], samples: usize) -> Option<Vec<f64>> {
        let model = PitchModel::new(&self.plant, &self.terms, &NO_NOISE, piece.run.step, &self.sizes)?;
        let mut point = model.start(&piece.run);
        (point.x[Q], point.x[THETA]) = (start[0], start[1]);
        let fine = model.simulate(&piece.run, 0..samples * piece.finer, point)?;
        Some(fine.iter().step_by(piece.finer).map(|y| y[1]).collect())
    }

    fn errors(&self, piece: &Piece, start: [f64; 2], samples: usize) -> Option<Vec<[f64; 2]>> {
        let simulated = self.run(piece, start, samples)?;
        Some(piece.y.iter().zip(&simulated).map(|(y, s)| [y - s, 0.0]).collect())
    }

    /// Rate and position at the first sample, by least squares over the first `samples`.
    pub fn initialised(&self, piece: &Piece, samples: usize) -> Option<[f64; 2]> {
        let guess = self.guess(piece, samples);
        let coordinates = [("rate", self.sizes.q), ("position", self.sizes.theta)].map(|c| free(c.0, c.1));
        let errors = |v: &[f64]| self.errors(piece, [v[0], v[1]], samples);
        let found = minimize(&errors, 1, &coordinates, &guess, EFFORT)?;
        Some([found.values[0], found.values[1]])
    }

    /// Slope and first value of a line through the first samples.
    fn guess(&self, piece: &Piece, samples: usize) -> [f64; 2] {
        let last = samples.clamp(2, piece.len()) - 1;
        let time = last as f64 * piece.run.step * piece.finer as f64;
        [(piece.y[last] - piece.y[0]) / time, piece.y[0]]
    }

    /// Root mean square error of the free run after `samples` of initialisation, up to sample `end`.
    pub fn error(&self, piece: &Piece, samples: usize, end: usize) -> Option<f64> {
        let start = self.initialised(piece, samples)?;
        let errors = self.errors(piece, start, end)?;
        let counted = errors.get(samples..)?;
        Some((counted.iter().map(|e| e[0] * e[0]).sum::<f64>() / counted.len() as f64).sqrt())
    }

    /// The same structure with the parameters whose free run over `piece` is nearest. `None` where it diverges from here.
    pub fn fitted(&self, piece: &Piece, samples: usize) -> Option<Self> {
        let start = self.initialised(piece, samples)?;
        let own = self.terms.iter().flat_map(|term| term.values.iter().copied());
        let Plant { dm_dq, dm_du, delay, .. } = self.plant;
        let mut values: Vec<f64> = [dm_dq, dm_du, delay, start[0], start[1]].into_iter().chain(own).collect();
        for share in SHARES {
            let length = piece.len() / share;
            let errors = |v: &[f64]| self.with(v).errors(piece, [v[3], v[4]], length);
            values = minimize(&errors, 1, &self.coordinates(), &values, EFFORT)?.values;
        }
        Some(self.with(&values))
    }

    fn with(&self, values: &[f64]) -> Self {
        let mut next = self.clone();
        next.plant.dm_dq = values[0];
        next.plant.dm_du = values[1];
        next.plant.delay = values[2];
        let own = next.terms.iter_mut().flat_map(|term| &mut term.values);
        own.zip(&values[FIRST..]).for_each(|(own, value)| *own = *value);
        next
    }

    fn coordinates(&self) -> Vec<Coordinate> {
        let Amplitudes { q, theta, moment, step, .. } = self.sizes;
        let mut all = vec![
            free("dM_dq", 0.1 * moment / q),
            free("dM_du", 0.1 * self.plant.dm_du.abs()),
            free("delay", 0.1 * step),
            free("rate", 0.1 * q),
            free("position", 0.1 * theta),
        ];
        for term in &self.terms {
            all.extend(term.effect.parameters(&self.sizes).iter().map(|p| match p.scale {
                Scale::Log => {
                    Coordinate { bounds: [p.lower / WIDER, p.upper * WIDER], log: true, ..free(p.name, 1.0) }
                }
                Scale::Linear(unit) => {
                    Coordinate { bounds: [WIDER * p.lower, WIDER * p.upper], ..free(p.name, unit) }
                }
            }));
        }
        all
    }
}

fn free(name: &str, unit_step: f64) -> Coordinate {
    let bounds = [f64::NEG_INFINITY, f64::INFINITY];
    Coordinate { name: name.into(), unit: String::new(), bounds, log: false, unit_step, prior: None }
}

#[cfg(test)]
mod tests {
    use super::*;
    use sysid::recording::{ReadOptions, parse};

    const STEP: f64 = 0.01;
    const FRICTION: f64 = 0.3;

    /// A mass with damping and dry friction under a force of two tones, by Euler's method at a fiftieth of the step.
    fn drive() -> Piece {
        let (mut q, mut x) = (0.0_f64, 0.0);
        let mut text = String::from("t_s,u_N,theta_rad\n");
        for k in 0..1500 {
            let t = STEP * f64::from(k);
            let u = 1.5 * (2.0 * t).sin() + (3.7 * t).sin();
            text.push_str(&format!("{t:.2},{u},{x}\n"));
            for _ in 0..50 {
                q += STEP / 50.0 * (2.0 * u - 0.5 * q - FRICTION * (q / 1e-3).tanh());
                x += STEP / 50.0 * q;
            }
        }
        let recording = parse("drive.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        Piece::new(&recording, 0..1500, 1)
    }

    fn start() -> Simulation {
        let sizes = Amplitudes {
            inertia: 1.0,
            u: 1.3,
            q: 0.7,
            theta: 0.5,
            turned: 3.0,
            angles: [0.0; 3],
            moment: 2.6,
            moves: 0.0,
            step: STEP,
            duration: 15.0,
            rate_limit: None,
        };
        let plant = Plant { inertia: 1.0, dm_dq: -1.0, dm_du: 1.7, delay: 0.0, mount: None };
        let terms = vec![Term { effect: find("coulomb_friction").unwrap(), values: vec![0.1] }];
        Simulation::new(plant, terms, sizes)
    }

    #[test]
    fn the_free_run_finds_plant_and_friction() {
        let piece = drive();
        let fitted = start().fitted(&piece, 20).unwrap();
        let found = [fitted.plant.dm_du, fitted.plant.dm_dq, fitted.terms[0].values[0]];
        for (found, truth) in found.into_iter().zip([2.0, -0.5, FRICTION]) {
            assert!((found / truth - 1.0).abs() < 0.05, "{found} {truth}");
        }
        let (before, after) =
            (start().error(&piece, 20, 1500).unwrap(), fitted.error(&piece, 20, 1500).unwrap());
        assert!(after < 0.005 * before, "{before} {after}");
        let without = Simulation::new(fitted.plant, Vec::new(), fitted.sizes);
        let linear = without.fitted(&piece, 20).unwrap().error(&piece, 20, 1500).unwrap();
        assert!(linear > 3.0 * after, "{linear} {after}");
    }

    #[test]
    fn the_start_is_taken_from_the_first_samples_alone() {
        let (piece, simulation) = (drive(), start());
        let mut other = drive();
        other.y[20..].fill(9.0);
        let starts = [&piece, &other].map(|piece| simulation.initialised(piece, 20).unwrap());
        assert_eq!(starts[0], starts[1]);
    }
}
