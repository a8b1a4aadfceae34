//! Steady-state Kalman gain of a sampled system: the innovations form's gain from a physical noise model.
//!
//! ```text
//! P = A P Aᵀ − A P Cᵀ (C P Cᵀ + R)⁻¹ C P Aᵀ + Q,     K = P Cᵀ (C P Cᵀ + R)⁻¹
//! ```
//!
//! Solved by the structure-preserving doubling algorithm (Chu, Fan, Lin, 2004): quadratic convergence, a dozen
//! steps of 8×8 products.

use crate::model::plant::{State, StateMatrix};

/// One measured channel: the state it reads and the variance of its white noise.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    /// Index of the state.
    pub state: usize,
    /// Variance of the measurement noise, positive.
    pub variance: f64,
}

/// Gain K, one column per channel, by which the innovation corrects the state before it is propagated.
///
/// `transition` is the state matrix over one sample, `process` the covariance of the process noise gathered over one
/// sample. `None` where the recursion does not settle (an undetectable growing mode).
pub fn steady_gain(
    transition: &StateMatrix,
    process: &StateMatrix,
    channels: &[Channel],
) -> Option<Vec<State>> {
    let mut a = transition.transpose();
    let mut g = StateMatrix::zeros();
    for channel in channels {
        g[(channel.state, channel.state)] += 1.0 / channel.variance;
    }
    let mut h = *process;
    for _ in 0..60 {
        let w = (StateMatrix::identity() + g * h).try_inverse()?;
        let aw = a * w;
        let h_next = h + a.transpose() * h * w * a;
        g += aw * g * a.transpose();
        a = aw * a;
        let settled = (h_next - h).amax() <= 1e-10 * h_next.amax();
        h = (h_next + h_next.transpose()) * 0.5;
        if !h.iter().all(|x| x.is_finite()) {
            return None;
        }
        if settled {
            // a process noise that is less than another reading has told leaves less than nothing
            let sound = channels.iter().all(|channel| h[(channel.state, channel.state)] >= 0.0);
            return sound.then(|| gain(&h, channels));
        }
    }
    None
}

/// Sequential update, channel by channel: white noises of different channels are independent.
fn gain(covariance: &StateMatrix, channels: &[Channel]) -> Vec<State> {
    let mut p = *covariance;
    let mut columns: Vec<State> = Vec::with_capacity(channels.len());
    for channel in channels {
        let pc: State = p.column(channel.state).into_owned();
        let k = pc / (pc[channel.state] + channel.variance);
        for earlier in &mut columns {
            let shift = earlier[channel.state];
            *earlier -= k * shift;
        }
        columns.push(k);
        p -= k * pc.transpose();
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_random_walk_has_the_closed_form_gain() {
        let mut process = StateMatrix::zeros();
        process[(0, 0)] = 0.25;
        let mut transition = StateMatrix::zeros();
        transition[(0, 0)] = 1.0;
        let k = steady_gain(&transition, &process, &[Channel { state: 0, variance: 1.0 }]).unwrap();
        let p = (0.25 + (0.25f64 * 0.25 + 4.0 * 0.25).sqrt()) / 2.0;
        assert!((k[0][0] - p / (p + 1.0)).abs() < 1e-9, "{}", k[0][0]);
    }

    #[test]
    fn two_channels_agree_with_the_joint_formula() {
        let transition = StateMatrix::from_fn(|i, j| {
            if i == j {
                0.9
            } else if j == i + 1 {
                0.1
            } else {
                0.0
            }
        });
        let process = StateMatrix::identity() * 0.3;
        let channels = [Channel { state: 0, variance: 1.0 }, Channel { state: 2, variance: 0.5 }];
        let k = steady_gain(&transition, &process, &channels).unwrap();
        let mut p = StateMatrix::identity();
        let mut joint = [State::zeros(); 2];
        for _ in 0..2000 {
            let c = |i: usize| p.column(channels[i].state).into_owned();
            let s =
                nalgebra::Matrix2::new(c(0)[0] + 1.0, c(1)[0], c(0)[2], c(1)[2] + 0.5).try_inverse().unwrap();
            joint = [c(0) * s[(0, 0)] + c(1) * s[(1, 0)], c(0) * s[(0, 1)] + c(1) * s[(1, 1)]];
            p -= joint[0] * p.row(0) + joint[1] * p.row(2);
            p = transition * p * transition.transpose() + process;
        }
        assert!((k[0] - joint[0]).amax() < 1e-8 && (k[1] - joint[1]).amax() < 1e-8, "{k:?} {joint:?}");
    }
}
