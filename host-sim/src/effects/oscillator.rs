//! x″ + 2ζω x′ + ω² x = f, over steps in which f is constant, exactly.

/// A damped oscillator; ω > 0, 0 ≤ ζ < 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct Oscillator {
    omega: f64,
    zeta: f64,
    /// x.
    pub position: f64,
    /// x′.
    pub velocity: f64,
    /// x″ at the end of the last step.
    pub acceleration: f64,
}

impl Oscillator {
    /// At rest. A damping ratio of 1 or more is held just below, where the closed form still has a meaning.
    pub(super) const fn new(omega: f64, zeta: f64) -> Self {
        let zeta = zeta.clamp(0.0, 0.999);
        Self { omega: omega.max(1e-3), zeta, position: 0.0, velocity: 0.0, acceleration: 0.0 }
    }

    /// `dt` s later, under the force `f`.
    pub(super) fn advance(&mut self, f: f64, dt: f64) {
        let Self { omega, zeta, .. } = *self;
        let damped = omega * (1.0 - zeta * zeta).sqrt();
        let (sine, cosine) = (damped * dt).sin_cos();
        let decay = (-zeta * omega * dt).exp();
        let away = self.position - f / (omega * omega);
        let slope = (self.velocity + zeta * omega * away) / damped;
        let next = decay * (away * cosine + slope * sine);
        self.velocity = decay * damped * (slope * cosine - away * sine) - zeta * omega * next;
        self.position = next + f / (omega * omega);
        self.acceleration = f - 2.0 * zeta * omega * self.velocity - omega * omega * self.position;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_steps_are_one_step_and_rest_where_the_force_is_held() {
        let mut fine = Oscillator::new(12.0, 0.2);
        let mut whole = fine;
        (0..1000).for_each(|_| fine.advance(3.0, 1e-3));
        whole.advance(3.0, 1.0);
        assert!((fine.position - whole.position).abs() < 1e-12);
        assert!((fine.velocity - whole.velocity).abs() < 1e-12);
        whole.advance(3.0, 100.0);
        assert!((whole.position - 3.0 / 144.0).abs() < 1e-12);
    }

    #[test]
    fn without_damping_it_is_a_cosine() {
        let mut mode = Oscillator::new(7.0, 0.0);
        mode.position = 0.1;
        mode.advance(0.0, 0.33);
        assert!((mode.position - 0.1 * (7.0_f64 * 0.33).cos()).abs() < 1e-15);
        assert!((mode.velocity + 0.7 * (7.0_f64 * 0.33).sin()).abs() < 1e-14);
    }
}
