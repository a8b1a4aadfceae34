//! Equations of motion and their integration.
//!
//! ```text
//! Iyy q̇  = (∂M/∂q) q + (∂M/∂u) ua + k (θP−θ) + c (qP−q) + Σ Mi − Mf
//! J   q̇P = −k (θP−θ) − c (qP−q)              θ̇ = q,  θ̇P = qP
//! ```
//!
//! In free flight θ̇ = q cos φ − r sin φ, and θ̇P alike.
//!
//! ua: what the blades do over the step, rad; Mi: moments of the effects and of the disturbance, N m; Mf: dry
//! friction, Mc sign q in motion, and at rest whatever holds the airframe, up to Mc; Mc may be another each way.
//!
//! Classical Runge–Kutta of fourth order over steps of 1 ms at most. Friction is discontinuous, so a step that
//! would carry q through zero is cut at the crossing; there the airframe sticks if the other moments stay
//! within Mc, and goes on in their direction if not. No smoothing, no velocity threshold.

use crate::plant::{Mount, Plant};
use crate::reading::RollYaw;

/// x = (q, qP, θ, θP), rad/s and rad: airframe, and IMU on its mount.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Airframe rate, rad/s.
    pub q: f64,
    /// IMU rate, rad/s.
    pub q_p: f64,
    /// Airframe angle, rad.
    pub theta: f64,
    /// IMU angle, rad.
    pub theta_p: f64,
}

impl State {
    fn plus(&self, rate: &Self, dt: f64) -> Self {
        Self {
            q: self.q + dt * rate.q,
            q_p: self.q_p + dt * rate.q_p,
            theta: self.theta + dt * rate.theta,
            theta_p: self.theta_p + dt * rate.theta_p,
        }
    }
}

/// What acts on the plant during one step.
pub struct Loads<'a> {
    /// Parameters as they are at this time.
    pub plant: Plant,
    /// ua, rad.
    pub blade: f64,
    /// Mc against a rate upward, and downward, N m; 0 without dry friction.
    pub dry_friction: [f64; 2],
    /// Σ Mi (N m) at a state.
    pub moment: &'a dyn Fn(&State) -> f64,
    /// Motion about the other axes: θ̇ = q cos φ − r sin φ.
    pub roll_yaw: RollYaw,
}

impl Loads<'_> {
    /// All moments on the airframe but dry friction, N m.
    fn drive(&self, x: &State) -> f64 {
        self.plant.dm_dq * x.q
            + self.plant.dm_du * self.blade
            + mount_moment(&self.plant, x)
            + (self.moment)(x)
    }

    /// ẋ with a friction moment of `friction` N m.
    fn rate(&self, x: &State, friction: f64) -> State {
        let q_dot = (self.drive(x) - friction) / self.plant.inertia_kg_m2;
        self.with_mount(x, q_dot)
    }

    fn with_mount(&self, x: &State, q_dot: f64) -> State {
        let q_p_dot = self.plant.mount.map_or(q_dot, |m| -mount_moment(&self.plant, x) / m.j);
        let q_p = if self.plant.mount.is_some() { x.q_p } else { x.q };
        let RollYaw { r, phi, .. } = self.roll_yaw;
        let (sine, cosine) = phi.sin_cos();
        let angle_rate = |q: f64| q * cosine - r * sine;
        State { q: q_dot, q_p: q_p_dot, theta: angle_rate(x.q), theta_p: angle_rate(q_p) }
    }

    /// ẋ as an accelerometer at the IMU would have it.
    #[must_use]
    pub fn rate_at(&self, x: &State) -> State {
        let drive = self.drive(x);
        if self.sticks(x) {
            return self.with_mount(x, 0.0);
        }
        let direction = if x.q == 0.0 { drive } else { x.q };
        self.rate(x, self.friction(direction))
    }

    /// Friction moment in a motion of this `direction`, N m.
    fn friction(&self, direction: f64) -> f64 {
        let [upward, downward] = self.dry_friction;
        if direction > 0.0 { upward } else { -downward }
    }

    fn rubs(&self) -> bool {
        self.dry_friction.iter().any(|level| *level > 0.0)
    }

    fn sticks(&self, x: &State) -> bool {
        let [upward, downward] = self.dry_friction;
        self.rubs() && x.q == 0.0 && (-downward..=upward).contains(&self.drive(x))
    }

    /// x one step of `dt` s later.
    #[must_use]
    pub fn step(&self, x: &State, dt: f64) -> State {
        if !self.rubs() {
            return runge_kutta(x, dt, |x| self.rate(x, 0.0));
        }
        let (reached, left) = self.step_to_rest(x, dt);
        // after a crossing: stick or go on the other way for the rest of the step
        if left > 0.0 { self.step_to_rest(&reached, left).0 } else { reached }
    }

    /// One step, or the part of it until q reaches zero, and the time left.
    fn step_to_rest(&self, x: &State, dt: f64) -> (State, f64) {
        if self.sticks(x) {
            return (runge_kutta(x, dt, |x| self.with_mount(x, 0.0)), 0.0);
        }
        let direction = if x.q == 0.0 { self.drive(x).signum() } else { x.q.signum() };
        let slip = |dt| runge_kutta(x, dt, |x| self.rate(x, self.friction(direction)));
        let next = slip(dt);
        if x.q == 0.0 || next.q * direction > 0.0 {
            return (next, 0.0);
        }
        let until = dt * (x.q / (x.q - next.q)).clamp(0.0, 1.0);
        let mut at_rest = slip(until);
        at_rest.q = 0.0;
        if self.plant.mount.is_none() {
            at_rest.q_p = 0.0;
        }
        (at_rest, dt - until)
    }
}

/// k (θP−θ) + c (qP−q), N m on the airframe.
fn mount_moment(plant: &Plant, x: &State) -> f64 {
    plant.mount.map_or(0.0, |Mount { k, c, .. }| k * (x.theta_p - x.theta) + c * (x.q_p - x.q))
}

fn runge_kutta(x: &State, dt: f64, rate: impl Fn(&State) -> State) -> State {
    let k1 = rate(x);
    let k2 = rate(&x.plus(&k1, dt / 2.0));
    let k3 = rate(&x.plus(&k2, dt / 2.0));
    let k4 = rate(&x.plus(&k3, dt));
    x.plus(&k1, dt / 6.0).plus(&k2, dt / 3.0).plus(&k3, dt / 3.0).plus(&k4, dt / 6.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGID: Plant = Plant { mount: None, ..Plant::nominal() };

    fn run(loads: &Loads<'_>, mut x: State, seconds: f64) -> State {
        for _ in 0..(seconds * 1000.0) as usize {
            x = loads.step(&x, 1e-3);
        }
        x
    }

    fn loads(plant: Plant, blade: f64, dry_friction: f64) -> Loads<'static> {
        Loads {
            plant,
            blade,
            dry_friction: [dry_friction; 2],
            moment: &|_| 0.0,
            roll_yaw: RollYaw::default(),
        }
    }

    #[test]
    fn step_response_of_the_rigid_plant_is_the_closed_form() {
        let x = run(&loads(RIGID, 0.015, 0.0), State::default(), 1.3);
        let (a, gain) = (0.27 / 0.1705, 23.0 * 0.015 / 0.27);
        let q = gain * (1.0 - (-a * 1.3_f64).exp());
        let theta = gain * (1.3 - (1.0 - (-a * 1.3_f64).exp()) / a);
        assert!((x.q - q).abs() < 1e-10 && (x.theta - theta).abs() < 1e-10, "{x:?}");
        assert_eq!((x.q_p, x.theta_p), (x.q, x.theta));
    }

    #[test]
    fn an_undamped_mount_keeps_its_energy_and_angular_momentum() {
        let mount = Mount { c: 0.0, ..Plant::nominal().mount.unwrap() };
        let plant = Plant { dm_dq: 0.0, mount: Some(mount), ..Plant::nominal() };
        let energy = |x: &State| {
            0.5 * plant.inertia_kg_m2 * x.q.powi(2)
                + 0.5 * mount.j * x.q_p.powi(2)
                + 0.5 * mount.k * (x.theta_p - x.theta).powi(2)
        };
        let momentum = |x: &State| plant.inertia_kg_m2 * x.q + mount.j * x.q_p;
        let start = State { q: 0.3, q_p: 0.0, theta: 0.0, theta_p: 0.02 };
        let end = run(&loads(plant, 0.0, 0.0), start, 2.0);
        // fourth order at ω dt = 0.09: relative loss (ω dt)⁶/72 per step of the mode's share
        assert!((energy(&end) / energy(&start) - 1.0).abs() < 1e-4);
        assert!((momentum(&end) / momentum(&start) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn friction_holds_below_breakaway_and_lets_go_above() {
        let breakaway = 0.1 / 23.0;
        assert_eq!(run(&loads(RIGID, 0.99 * breakaway, 0.1), State::default(), 1.0), State::default());
        assert!(run(&loads(RIGID, 1.01 * breakaway, 0.1), State::default(), 1.0).q > 0.0);
        assert!(run(&loads(RIGID, -1.01 * breakaway, 0.1), State::default(), 1.0).q < 0.0);
    }

    #[test]
    fn a_sliding_airframe_comes_to_rest_when_and_where_the_closed_form_says() {
        // I q̇ = Mq q − Mc  ⇒  rest at t = ln(1 + a q0 / f) / a with a = −Mq/I, f = Mc/I
        let (a, f) = (0.27 / 0.1705, 0.1 / 0.1705);
        let at = (1.0_f64 + a * 0.5 / f).ln() / a;
        let travel = (0.5 - f * at) / a;
        let start = State { q: 0.5, q_p: 0.5, ..State::default() };
        let just_before = run(&loads(RIGID, 0.0, 0.1), start, at - 2e-3);
        let after = run(&loads(RIGID, 0.0, 0.1), start, at + 2e-3);
        assert!(just_before.q > 0.0);
        assert_eq!((after.q, after.q_p), (0.0, 0.0));
        assert!((after.theta - travel).abs() < 1e-6, "{} {travel}", after.theta);
    }

    #[test]
    fn friction_dissipates_the_work_of_its_path() {
        let plant = Plant { dm_dq: 0.0, ..RIGID };
        let start = State { q: 0.5, q_p: 0.5, ..State::default() };
        let end = run(&loads(plant, 0.0, 0.05), start, 2.0);
        assert!((0.5 * 0.1705 * 0.25 - 0.05 * end.theta).abs() < 1e-8);
    }

    #[test]
    fn a_mount_with_friction_rests_with_the_airframe() {
        let start = State { theta_p: 0.01, ..State::default() };
        let end = run(&loads(Plant::nominal(), 0.0, 0.5), start, 2.0);
        assert_eq!((end.q, end.theta), (0.0, 0.0));
        assert!(end.theta_p.abs() < 1e-6);
    }
}
