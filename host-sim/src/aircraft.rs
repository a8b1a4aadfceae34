//! The aircraft over one tick: delay → effects → plant → IMU.
//!
//! u_k is held over [t_k, t_k + Ts) and reaches the servo τ later, for any real τ ≥ 0. Within one tick the
//! delayed command therefore changes once, at t_k + (τ mod Ts); the tick is cut there, and both parts are
//! integrated in equal steps of at most 1 ms. So a delay that is no multiple of Ts is as exact as one that is.

use crate::disturbance::ColouredMoment;
use crate::effects::{Effect, Motion, Setting};
use crate::plant::{Loads, Plant, State};
use crate::reading::{Beside, Others, Reading};
use crate::surroundings::Surroundings;

/// Ts, s.
pub const SAMPLE_PERIOD_S: f64 = 0.02;
/// Longest integration step where nothing else is asked for, s.
const STEP_S: f64 = 1e-3;

/// Plant, effects and disturbance, at some time.
#[derive(Debug)]
pub struct Aircraft {
    plant: Plant,
    effects: Vec<Box<dyn Effect>>,
    background: Option<ColouredMoment>,
    state: State,
    commands: Vec<f64>,
    q_dot: f64,
    /// Command at which background and gyro noise have their full strength, where they grow with it, rad.
    full_at: Option<f64>,
    /// Command that reaches the servo, rad.
    arrived: f64,
    around: Around,
    /// Length of a tick, s.
    period_s: f64,
    /// Longest integration step, s.
    step_s: f64,
    /// Factor on the background moment.
    gusts: f64,
    /// Time before which the effects are not there, s, and the parameters from then on.
    change: Option<(f64, Plant)>,
}

/// Where that comes from which goes on beside the pitch axis.
#[derive(Clone, Debug)]
enum Around {
    /// Drawn, as a function of time.
    Drawn(Box<Surroundings>),
    /// Told before every tick.
    Given(Beside, Others),
}

impl Aircraft {
    /// At rest and level at t = 0. `seed` is for effects that are random themselves, and for what goes on beside the
    /// pitch axis where they need it.
    #[must_use]
    pub fn new(plant: Plant, effects: &[Setting], background: Option<ColouredMoment>, seed: u64) -> Self {
        let mut effects: Vec<Box<dyn Effect>> = effects.iter().map(|setting| setting.build(seed)).collect();
        effects.sort_by_key(|effect| effect.of_thrust());
        let needed = effects.iter().fold(Others::default(), |needed, effect| needed.and(effect.others()));
        let around = Around::Drawn(Box::new(Surroundings::drawn(seed, needed)));
        let (state, commands) = (State::default(), Vec::new());
        Self {
            plant,
            effects,
            background,
            state,
            commands,
            q_dot: 0.0,
            full_at: None,
            arrived: 0.0,
            around,
            period_s: SAMPLE_PERIOD_S,
            step_s: STEP_S,
            gusts: 1.0,
            change: None,
        }
    }

    /// Lets the effects begin at `from_s`, and the plant be another from then on: until then the aircraft is without them.
    #[must_use]
    pub fn changing_at(self, from_s: f64, plant: Plant) -> Self {
        Self { change: Some((from_s, plant)), ..self }
    }

    fn acting(&self, t: f64) -> &[Box<dyn Effect>] {
        if self.change.is_some_and(|(from_s, _)| t < from_s) { &[] } else { &self.effects }
    }

    fn acting_mut(&mut self, t: f64) -> &mut [Box<dyn Effect>] {
        if self.change.is_some_and(|(from_s, _)| t < from_s) { &mut [] } else { &mut self.effects }
    }

    /// Holds commands for `period_s` instead of Ts, and integrates in steps of `step_s` at most. To be asked for before
    /// the first tick.
    #[must_use]
    pub fn sampled_every(self, period_s: f64, step_s: f64) -> Self {
        let around = match self.around {
            Around::Drawn(surroundings) => Around::Drawn(Box::new(surroundings.held_for(period_s))),
            given @ Around::Given(..) => given,
        };
        Self { period_s, step_s, around, ..self }
    }

    /// Makes the background moment `factor` times as strong as it was drawn, from now on.
    pub const fn gust_by(&mut self, factor: f64) {
        self.gusts = factor;
    }

    /// Lets `others` go on beside the pitch axis too, whether an effect needs them or not.
    #[must_use]
    pub fn among(self, others: Others, seed: u64) -> Self {
        let surroundings = Surroundings::drawn(seed, self.others().and(others)).held_for(self.period_s);
        Self { around: Around::Drawn(Box::new(surroundings)), ..self }
    }

    /// Takes what goes on beside the pitch axis from outside, until it is told otherwise.
    pub fn tell(&mut self, now: Beside, others: Others) {
        self.around = Around::Given(now, others);
    }

    /// Which signals beside those of the pitch axis there are.
    #[must_use]
    pub const fn others(&self) -> Others {
        match &self.around {
            Around::Drawn(surroundings) => surroundings.others(),
            Around::Given(_, others) => *others,
        }
    }

    /// What goes on beside the pitch axis at `t`.
    #[must_use]
    pub fn beside(&self, t: f64) -> Beside {
        match &self.around {
            Around::Drawn(surroundings) => surroundings.at(t),
            Around::Given(now, _) => *now,
        }
    }

    /// Lets background moment and gyro noise grow with the command, to their full strength at `amplitude_rad`; at
    /// an amplitude of nought they stay as they are.
    #[must_use]
    pub fn growing_with_command(self, amplitude_rad: f64) -> Self {
        Self { full_at: (amplitude_rad > 0.0).then_some(amplitude_rad), ..self }
    }

    /// Strength of the background moment and of the gyro's noise: (1 + |u| / a) / 2, u the command that reaches the
    /// servo, where they grow with it to the amplitude a; 1 where they do not.
    #[must_use]
    pub fn strength(&self) -> f64 {
        self.full_at.map_or(1.0, |amplitude| (1.0 + self.arrived.abs() / amplitude) / 2.0)
    }

    /// The true state.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// Puts plant and IMU into another state; delay line and effects keep theirs. An IMU without a mount moves
    /// as the airframe, and that as the IMU of `state` says.
    pub fn set_state(&mut self, state: State) {
        let State { q_p, theta_p, .. } = state;
        let mounted = self.plant_at(self.now()).mount.is_some();
        self.state = if mounted { state } else { State { q: q_p, q_p, theta: theta_p, theta_p } };
    }

    /// The time, s.
    #[must_use]
    pub fn now(&self) -> f64 {
        self.commands.len() as f64 * self.period_s
    }

    /// What the IMU reads now, without noise and beyond its limits. Called once per tick.
    pub fn read(&mut self) -> Reading {
        let t = self.now();
        let (q, theta) = (self.state.q_p, self.state.theta_p);
        let roll_yaw = self.beside(t).roll_yaw;
        let mut reading = Reading { q, theta, q_dot: self.q_dot, roll_yaw };
        for effect in self.acting_mut(t) {
            effect.measure(t, &mut reading);
        }
        reading
    }

    /// Limits a reading, after noise was added if there is to be any.
    pub fn limit(&self, reading: &mut Reading) {
        self.acting(self.now()).iter().for_each(|effect| effect.limit(reading));
    }

    /// The time whose command the log shows at `t`, s.
    #[must_use]
    pub fn logged_at(&self, t: f64) -> f64 {
        self.acting(t).iter().fold(t, |t, effect| effect.logged_at(t))
    }

    /// The parameters as they are at `t`.
    fn plant_at(&self, t: f64) -> Plant {
        let mut plant = self.change.filter(|(from_s, _)| t >= *from_s).map_or(self.plant, |(_, plant)| plant);
        self.acting(t).iter().for_each(|effect| effect.plant(t, &mut plant));
        plant
    }

    /// Holds `u` (rad) for one tick.
    pub fn advance(&mut self, u: f64) {
        let t = self.now();
        self.commands.push(u);
        let end = t + self.period_s;
        self.effects.iter_mut().for_each(|effect| effect.prepare(end));
        if let Some(background) = &mut self.background {
            background.extend_to(end);
        }
        let added: f64 = self.acting(t).iter().map(|effect| effect.delay_s(t)).sum();
        let delay = (self.plant_at(t).delay_s + added).max(0.0);
        // the small share keeps 0.06 / 0.02 at three samples
        let samples = (delay / self.period_s + 1e-9).floor();
        let change = (delay - samples * self.period_s).max(0.0);
        let samples = samples as usize;
        self.integrate(t, change, self.command(samples + 1));
        self.integrate(t + change, self.period_s - change, self.command(samples));
    }

    /// The command `age` ticks before the newest, 0 before the first.
    fn command(&self, age: usize) -> f64 {
        let newest = self.commands.len().wrapping_sub(1);
        newest.checked_sub(age).and_then(|k| self.commands.get(k)).copied().unwrap_or(0.0)
    }

    fn integrate(&mut self, from: f64, length: f64, command: f64) {
        if length < 1e-9 {
            return;
        }
        let steps = (length / self.step_s - 1e-6).ceil().max(1.0) as u32;
        let dt = length / f64::from(steps);
        self.arrived = command;
        let strength = self.strength();
        for step in 0..steps {
            let t = from + f64::from(step) * dt;
            let middle = t + dt / 2.0;
            let beside = self.beside(middle);
            self.acting_mut(t).iter_mut().for_each(|effect| effect.beside(&beside));
            let blade = self.acting_mut(t).iter_mut().fold(command, |u, effect| effect.blade(t, u, dt));
            let plant = self.plant_at(t);
            let background = strength * self.gusts * self.background.as_ref().map_or(0.0, |b| b.at(middle));
            let moment = |x: &State| {
                background + self.acting(t).iter().map(|e| e.moment(middle, x, blade)).sum::<f64>()
            };
            let before = self.state;
            let dry_friction = self.acting(t).iter().fold([0.0; 2], |[upward, downward], effect| {
                let added = effect.dry_friction(&before);
                [upward + added[0], downward + added[1]]
            });
            let roll_yaw = beside.roll_yaw;
            let loads = Loads { plant, blade, dry_friction, moment: &moment, roll_yaw };
            let after = loads.step(&before, dt);
            if step + 1 == steps {
                self.q_dot = loads.rate_at(&after).q_p;
            }
            self.state = after;
            let motion = Motion { t, dt, plant, blade, before, after };
            self.acting_mut(t).iter_mut().for_each(|effect| effect.follow(&motion));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disturbance::Colour;
    use crate::seeds::{Stream, generator};

    const RIGID: Plant = Plant { mount: None, dm_dq: 0.0, ..Plant::nominal() };

    /// Without damping a step of command gives q = b (t − τ), θ = b (t − τ)²/2, so the delay can be read off.
    fn after_a_step(plant: Plant, effects: &[Setting], ticks: usize) -> State {
        let mut aircraft = Aircraft::new(plant, effects, None, 0);
        (0..ticks).for_each(|_| aircraft.advance(0.01));
        aircraft.state()
    }

    #[test]
    fn any_delay_is_exact() {
        let b = 23.0 * 0.01 / 0.1705;
        for delay_s in [0.0, 0.02, 0.0537, 0.06, 0.0999] {
            let state = after_a_step(Plant { delay_s, ..RIGID }, &[], 25);
            assert!((state.q - b * (0.5 - delay_s)).abs() < 1e-12, "{delay_s}");
            assert!((state.theta - b * (0.5 - delay_s).powi(2) / 2.0).abs() < 1e-12, "{delay_s}");
        }
    }

    #[test]
    fn extra_delay_adds_to_the_plants() {
        let b = 23.0 * 0.01 / 0.1705;
        for delta in [-0.0313, 0.041] {
            let extra = Setting::new("extra_delay", &[("Delta", delta)]).unwrap();
            let state = after_a_step(RIGID, &[extra], 25);
            assert!((state.q - b * (0.44 - delta)).abs() < 1e-12);
        }
    }

    #[test]
    fn the_first_row_that_can_show_a_command_is_the_next() {
        let mut aircraft = Aircraft::new(Plant { delay_s: 0.0, ..RIGID }, &[], None, 0);
        assert_eq!(aircraft.read().q, 0.0);
        aircraft.advance(0.01);
        assert!((aircraft.read().q - 0.02 * 23.0 * 0.01 / 0.1705).abs() < 1e-12);
    }

    #[test]
    fn a_background_that_grows_with_the_command_is_half_as_strong_at_rest_and_full_at_the_amplitude() {
        const AMPLITUDE: f64 = 0.015;
        let moment = || {
            let colour = Colour::BandPass { omega: 5.0, zeta: 0.4 };
            Some(ColouredMoment::new(0.05, colour, generator(1, Stream::Background)))
        };
        let plant = Plant { delay_s: 0.0, ..RIGID };
        let flown = |mut aircraft: Aircraft, u: f64| {
            (0..50).for_each(|_| aircraft.advance(u));
            aircraft.state().q
        };
        for (u, strength) in [(0.0, 0.5), (AMPLITUDE, 1.0), (-AMPLITUDE, 1.0), (3.0 * AMPLITUDE, 2.0)] {
            let bare = flown(Aircraft::new(plant, &[], None, 1), u);
            let plain = flown(Aircraft::new(plant, &[], moment(), 1), u) - bare;
            let grown =
                flown(Aircraft::new(plant, &[], moment(), 1).growing_with_command(AMPLITUDE), u) - bare;
            assert!((grown - strength * plain).abs() < 1e-12, "{u}");
        }
    }

    #[test]
    fn the_strength_is_that_of_the_command_that_reaches_the_servo() {
        let mut aircraft = Aircraft::new(RIGID, &[], None, 0).growing_with_command(0.015);
        let strengths = [0; 5].map(|_| {
            aircraft.advance(0.015);
            aircraft.strength()
        });
        // three ticks of delay
        assert_eq!(strengths, [0.5, 0.5, 0.5, 1.0, 1.0]);
        assert_eq!(Aircraft::new(RIGID, &[], None, 0).growing_with_command(0.0).strength(), 1.0);
    }

    #[test]
    fn gravity_swings_with_its_period() {
        // G = 1.5 N m: small oscillation of period 2π √(I/G) = 2.1184 s
        let gravity = Setting::new("gravity_stiffness", &[("G", 1.5)]).unwrap();
        let mut aircraft = Aircraft::new(RIGID, &[gravity], None, 0);
        aircraft.set_state(State { theta: 0.01, theta_p: 0.01, ..State::default() });
        (0..106).for_each(|_| aircraft.advance(0.0));
        let omega = (1.5_f64 / 0.1705).sqrt();
        assert!((aircraft.state().theta - 0.01 * (omega * 2.12).cos()).abs() < 1e-6);
    }

    #[test]
    fn quadratic_drag_and_trim_meet_their_terminal_rate() {
        let drag = Setting::new("quadratic_drag", &[("D", 0.5)]).unwrap();
        let trim = Setting::new("trim_offset", &[("M0", -0.1)]).unwrap();
        let mut aircraft = Aircraft::new(RIGID, &[drag, trim], None, 0);
        (0..500).for_each(|_| aircraft.advance(0.0));
        assert!((aircraft.state().q + (0.1_f64 / 0.5).sqrt()).abs() < 1e-9);
    }
}
