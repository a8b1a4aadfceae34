//! The innovations of the identified model, and what a unit of each cause would leave in them.
//!
//! | cause | drives a filter with | and adds |
//! | --- | --- | --- |
//! | effectiveness | Γ b c, the predictor's own response to the command | |
//! | lag | Γ b (c behind a lag − c) / its length | |
//! | damping, friction, stiffness | −Γ q̂, −Γ q̂ / (|q̂| + q0), −Γ θ | |
//! | gyro scale | −L_q q̂ | W q̂ |
//! | trim moment, gyro bias | nothing: what they leave is constant | |

use super::filter::{Bank, Drive};
use super::model::{CAUSES, MonitorModel};
use super::{larger, smaller};
use crate::constants::MAX_INPUT_DELAY;

const SLOTS: usize = MAX_INPUT_DELAY as usize + 2;

/// The predictor, and the filters of the causes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Predictor {
    commands: [f32; SLOTS],
    newest: usize,
    lagging: f32,
    bank: Bank,
}

/// What one cycle shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Innovations of q and of θ in their identified deviations.
    pub innovation: [f32; 2],
    /// The same, no larger than the limit.
    pub limited: [f32; 2],
    /// ψ: what a unit of each of [`super::Cause::ALL`] would have left in them.
    pub traces: [[f32; 2]; CAUSES],
}

impl Predictor {
    /// Takes q\[k\], θ\[k\] and then u\[k\]; innovations count up to ±`limit`.
    #[inline]
    pub fn step(&mut self, model: &MonitorModel, [q, theta]: [f32; 2], u: f32, limit: f32) -> Shown {
        let [w_qq, w_tq, w_tt] = model.whitening;
        let outputs = self.bank.outputs(&model.output);
        let [caused, lag, damping, friction, stiffness, [m_q, m_t], [s_q, s_t]] = outputs;
        let [c_q, c_t] = caused;
        let [rest_q, rest_t] = model.rest;
        let innovation = [w_qq * q - (c_q + m_q + rest_q), w_tq * q + w_tt * theta - (c_t + m_t + rest_t)];
        let limited = innovation.map(|e| smaller(larger(e, -limit), limit));
        let [e_q, _] = limited;
        let predicted = q - e_q / w_qq;
        let traces = [
            caused,
            lag,
            model.trim,
            damping,
            friction,
            model.bias,
            [w_qq * predicted + s_q, w_tq * predicted + s_t],
            stiffness,
        ];

        let (arriving, lagging) = self.arrive(model, u);
        let [_, length] = model.lag;
        let inputs = [
            model.gain * arriving,
            model.gain * (lagging - arriving) / length,
            -predicted,
            -predicted / (predicted.abs() + model.friction_rate),
            -theta,
            q,
            -predicted,
        ];
        self.bank.advance(model, &Drive { inputs, theta });
        Shown { innovation, limited, traces }
    }

    /// The command that arrives until the next sample, and that behind the lag that is tested for, in the mean.
    fn arrive(&mut self, model: &MonitorModel, u: f32) -> (f32, f32) {
        self.newest = if self.newest + 1 >= SLOTS { 0 } else { self.newest + 1 };
        if let Some(place) = self.commands.get_mut(self.newest) {
            *place = u;
        }
        let whole = model.delay_samples as usize;
        let ago = |samples: usize| {
            let place = (self.newest + SLOTS).saturating_sub(samples);
            let place = if place >= SLOTS { place - SLOTS } else { place };
            self.commands.get(place).copied().unwrap_or(0.0)
        };
        let (early, late) = (ago(whole), ago(whole + 1));
        let arriving = early + model.delay_fraction * (late - early);
        let [share, _] = model.lag;
        let before = self.lagging;
        self.lagging += share * (arriving - before);
        (arriving, 0.5 * (before + self.lagging))
    }
}
