//! What an angular impulse on the airframe leaves at the end of a substep, by when it falls.

use super::plant::{Q, State, StateMatrix};

/// Response to a unit impulse, N m s, with the share w of the substep left: exp(A Δt w) e_q / J, by Hermite's cubic from its ends.
pub struct Kick {
    ends: [State; 2],
    /// Derivatives with respect to w there.
    slopes: [State; 2],
}

impl Kick {
    /// `per_step` is A Δt, `transition` its exponential, `inertia` J in kg m².
    pub fn new(per_step: &StateMatrix, transition: &StateMatrix, inertia: f64) -> Self {
        let mut jump = State::zeros();
        jump[Q] = 1.0 / inertia;
        let ends = [jump, transition * jump];
        Self { ends, slopes: ends.map(|end| per_step * end) }
    }

    /// The state that a unit impulse adds with the share `w` of the substep left.
    pub fn left(&self, w: f64) -> State {
        let (square, cube) = (w * w, w * w * w);
        self.ends[0] * (2.0 * cube - 3.0 * square + 1.0)
            + self.slopes[0] * (cube - 2.0 * square + w)
            + self.ends[1] * (3.0 * square - 2.0 * cube)
            + self.slopes[1] * (cube - square)
    }
}

#[cfg(test)]
mod tests {
    use super::super::plant::THETA;
    use super::*;

    #[test]
    fn between_the_ends_it_is_the_exponential() {
        // A mode of 14 Hz over a step of 20 ms.
        let mut per_step = StateMatrix::zeros();
        (per_step[(Q, THETA)], per_step[(THETA, Q)]) = (-1.76, 1.76);
        let kick = Kick::new(&per_step, &per_step.exp(), 0.1);
        for w in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let exact = (per_step * w).exp().column(Q) * 10.0;
            assert!((kick.left(w) - exact).amax() < 0.3, "{w}: {}", kick.left(w) - exact);
        }
    }
}
