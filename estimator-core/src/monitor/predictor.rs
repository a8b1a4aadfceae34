//! The innovations of the identified model, and what a unit of each cause would leave in them.
//!
//! | cause | drives a filter with | and adds |
//! | --- | --- | --- |
//! | effectiveness | Γ b c, the predictor's own response to the command | |
//! | lag | Γ b (c behind a lag − c) / its length | |
//! | damping, friction, stiffness | −Γ q̂, −Γ q̂ / (|q̂| + q0), −Γ θ | |
//! | gyro scale | −L_q q̂ | W q̂ |
//! | trim moment, gyro bias | nothing: what they leave is constant | |

use super::filter::Filter;
use super::model::{CAUSES, MonitorModel};
use crate::constants::MAX_INPUT_DELAY;

const SLOTS: usize = MAX_INPUT_DELAY as usize + 2;

/// The filters of predictor and causes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Predictor {
    commands: [f32; SLOTS],
    newest: usize,
    lagging: f32,
    by_command: Filter,
    by_motion: Filter,
    lag: Filter,
    damping: Filter,
    friction: Filter,
    scale: Filter,
    stiffness: Filter,
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
        let caused = self.by_command.output(&model.output);
        let ([c_q, c_t], [m_q, m_t]) = (caused, self.by_motion.output(&model.output));
        let [rest_q, rest_t] = model.rest;
        let innovation = [w_qq * q - (c_q + m_q + rest_q), w_tq * q + w_tt * theta - (c_t + m_t + rest_t)];
        let limited = innovation.map(|e| e.max(-limit).min(limit));
        let [e_q, _] = limited;
        let predicted = q - e_q / w_qq;
        let [s_q, s_t] = self.scale.output(&model.output);
        let traces = [
            caused,
            self.lag.output(&model.output),
            model.trim,
            self.damping.output(&model.output),
            self.friction.output(&model.output),
            model.bias,
            [w_qq * predicted + s_q, w_tq * predicted + s_t],
            self.stiffness.output(&model.output),
        ];

        let (arriving, lagging) = self.arrive(model, u);
        let ([_, length], [l_q, l_t]) = (model.lag, &model.correction);
        let (f, moment) = (&model.transition, &model.moment);
        self.by_command.advance(f, moment, model.gain * arriving);
        self.by_motion.advance(f, l_q, q);
        self.by_motion.add(l_t, theta);
        self.lag.advance(f, moment, model.gain * (lagging - arriving) / length);
        self.damping.advance(f, moment, -predicted);
        self.friction.advance(f, moment, -predicted / (predicted.abs() + model.friction_rate));
        self.scale.advance(f, l_q, -predicted);
        self.stiffness.advance(f, moment, -theta);
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
