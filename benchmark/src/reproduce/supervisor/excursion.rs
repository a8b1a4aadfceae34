//! How far beyond the limit a vehicle can go, by its delay; and how far it went.
//!
//! Let θ pass the limit θₜ outward at the rate q₁, with b = ∂M/∂u / Iyy. The sample that shows it comes Ts later at the latest, the
//! command that answers it acts τ after that. Until then, for T = Ts + τ (and Ts more for each sample that is lost just then), what was
//! sent before acts: at most g, outward. From then on the controller commands at least
//!
//! ```text
//! uc = min(umax, Kp θₜ − Kd ν − z)         ν: what the gyro shows too little, z: the trim at the crossing, outward
//! ```
//!
//! inward, for what it sees lies beyond θₜ, and its trim only falls there. With α = b g and β = b uc, and J the impulse per inertia of
//! all that b u does not tell (damping, lags, gusts, whatever is concealed), at its largest over the excursion:
//!
//! ```text
//! q(t) ≤ q₁ + J + α min(t, T) − β max(t − T, 0)
//! θ − θₜ ≤ δ + q T + ½ α T² + (q + α T)² / (2 β)          q = max(q₁ + J, 0)
//! ```
//!
//! δ is what the angle shows too little, and what other axes add to θ̇. Without any of it, on the nominal craft (b = 135 1/s², τ = 0.06 s)
//! at 0.8 rad/s and 0.4 rad, under an excitation of 0.015 rad, that is 0.21 rad. q₁ is held by the limit of the rate, 2 rad/s, which is watched in the same way.

use estimator_core::AttitudeConfig;
use estimator_core::constants::SAMPLE_PERIOD_S;
use serde::Serialize;

/// Ts, s.
const TS: f64 = SAMPLE_PERIOD_S as f64;

/// One tick of a flight, as it was and as the core saw it.
#[derive(Clone, Copy, Debug)]
pub struct Tick {
    /// True angle and rate of the airframe, rad and rad/s.
    pub truth: [f64; 2],
    /// The angle and the rate that the core acted on.
    pub seen: Option<[f64; 2]>,
    /// The core's command, rad.
    pub u: f64,
    /// The controller's trim before this tick, rad.
    pub trim: f64,
}

/// What bounds an excursion beside what happens in it.
#[derive(Clone, Copy, Debug)]
pub struct Bounded {
    /// θₜ, rad.
    pub limit_rad: f64,
    /// b, 1/s² per rad.
    pub authority: f64,
    /// τ, s.
    pub delay_s: f64,
    /// The controller.
    pub attitude: AttitudeConfig,
}

/// One stay beyond the limit.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Excursion {
    /// When it passed the limit, s.
    pub t_s: f64,
    /// How far beyond the limit the airframe went, rad.
    pub excess_rad: f64,
    /// How far it may; none where the controller cannot be relied on to push inward.
    pub bound_rad: Option<f64>,
    /// How much of that the sensor's error is, rad.
    pub unseen_rad: f64,
    /// q₁, rad/s.
    pub rate_rad_s: f64,
}

impl Bounded {
    /// θ − θₜ at the most, rad, for a crossing at `rate` (rad/s), an answer after `wait` (s), `outward` (rad) sent before, and `inward`
    /// (rad) from then on.
    #[must_use]
    pub fn most(&self, rate: f64, wait: f64, outward: f64, inward: f64) -> Option<f64> {
        let [alpha, beta] = [outward, inward].map(|u| self.authority * u);
        let rate = rate.max(0.0);
        let free = rate * wait + 0.5 * alpha * wait * wait;
        (beta > 0.0).then(|| free + (rate + alpha * wait).powi(2) / (2.0 * beta))
    }

    /// The excursions of a flight, in order of their beginning.
    #[must_use]
    pub fn excursions(&self, ticks: &[Tick]) -> Vec<Excursion> {
        let mut found: Vec<Excursion> = Vec::new();
        for side in [1.0, -1.0] {
            let mut k = 1;
            while k < ticks.len() {
                let beyond = |k: usize| side * ticks[k].truth[0] > self.limit_rad;
                if !beyond(k) || beyond(k - 1) {
                    k += 1;
                    continue;
                }
                let end = (k..ticks.len()).find(|&k| !beyond(k)).unwrap_or(ticks.len());
                found.push(self.excursion(ticks, side, k - 1, end));
                k = end;
            }
        }
        found.sort_by(|a, b| a.t_s.total_cmp(&b.t_s));
        found
    }

    /// The one to `side` whose last tick within the limit is `before`, and that is over at `end`.
    fn excursion(&self, ticks: &[Tick], side: f64, before: usize, end: usize) -> Excursion {
        let angle = |k: usize| side * ticks[k].truth[0];
        let peak = (before..end).max_by(|&a, &b| angle(a).total_cmp(&angle(b))).unwrap_or(before);
        let excess_rad = angle(peak) - self.limit_rad;
        // what the channel shows less than there is, at the most
        let hidden = |channel: usize| {
            let error = |tick: &Tick| tick.seen.map(|seen| side * (tick.truth[channel] - seen[channel]));
            ticks[before..=peak].iter().filter_map(error).fold(0.0, f64::max)
        };
        let [unseen_rad, unseen_rate] = [0, 1].map(hidden);
        let of = |from: usize, rate_rad_s: f64, bound_rad: Option<f64>| Excursion {
            t_s: from as f64 * TS,
            excess_rad,
            bound_rad,
            unseen_rad,
            rate_rad_s,
        };
        let surely_seen = self.limit_rad + unseen_rad;
        let rate_at = |k: usize| side * ticks[k].truth[1];
        let Some(from) = (before..peak).rev().find(|&k| angle(k) <= surely_seen) else {
            return of(before, rate_at(before), Some(unseen_rad));
        };
        let answer = (from + 1..=peak).find(|&k| ticks[k].seen.is_some()).unwrap_or(peak);
        let sent = from.saturating_sub((self.delay_s / TS).ceil() as usize)..answer;
        let outward = ticks[sent].iter().map(|tick| side * tick.u).fold(0.0, f64::max);
        let AttitudeConfig { angle_gain, rate_gain_s, output_limit_rad, .. } = self.attitude;
        let [kp, kd, most] = [angle_gain, rate_gain_s, output_limit_rad].map(f64::from);
        let inward = (kp * self.limit_rad - kd * unseen_rate - side * ticks[from].trim).min(most);
        let [impulse, drift] = self.untold(ticks, side, from..peak);
        let wait = (answer - from) as f64 * TS + self.delay_s;
        let told = self.most(rate_at(from) + impulse, wait, outward, inward);
        of(from, rate_at(from), told.map(|told| unseen_rad + drift + told))
    }

    /// J, and what other axes add to θ, at their largest from the beginning of `span` on.
    fn untold(&self, ticks: &[Tick], side: f64, span: std::ops::Range<usize>) -> [f64; 2] {
        let samples = (self.delay_s / TS + 1e-9).floor();
        let share = (self.delay_s / TS - samples).max(0.0);
        let command = |k: usize, age: usize| k.checked_sub(age).map_or(0.0, |k| ticks[k].u);
        let age = samples as usize;
        let (mut impulse, mut drift, mut most) = (0.0_f64, 0.0_f64, [0.0_f64; 2]);
        for k in span {
            let ([theta, q], [next_theta, next_q]) = (ticks[k].truth, ticks[k + 1].truth);
            let u = (1.0 - share) * command(k, age) + share * command(k, age + 1);
            impulse += side * (next_q - q - self.authority * TS * u);
            drift += side * (next_theta - theta - 0.5 * TS * (q + next_q));
            most = [most[0].max(impulse), most[1].max(drift)];
        }
        most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NOMINAL: Bounded = Bounded {
        limit_rad: 0.4,
        authority: 23.0 / 0.1705,
        delay_s: 0.06,
        attitude: AttitudeConfig {
            angle_gain: 0.06,
            integral_gain_per_s: 0.0,
            rate_gain_s: 0.0,
            output_limit_rad: 0.04,
            reference_limit_rad: 0.3,
        },
    };

    #[test]
    fn the_bound_of_the_page_is_the_worst_case_integrated() {
        let (rate, outward, inward) = (0.8, 0.015, 0.024);
        let (mut theta, mut q, mut t, dt) = (0.0, rate, 0.0, 1e-6);
        while q > 0.0 {
            let u = if t < 0.08 { outward } else { -inward };
            theta += dt * (q + 0.5 * dt * NOMINAL.authority * u);
            q += dt * NOMINAL.authority * u;
            t += dt;
        }
        let bound = NOMINAL.most(rate, 0.08, outward, inward).unwrap();
        assert!((bound - theta).abs() < 1e-5, "{bound} {theta}");
        assert!((bound - 0.213).abs() < 0.001, "{bound}");
    }

    /// A craft without damping that meets its limit under an excitation of 0.015 rad: the command turns at tick `turned`.
    fn flown(turned: usize, seen: impl Fn(usize, [f64; 2]) -> Option<[f64; 2]>) -> Vec<Tick> {
        let mut ticks: Vec<Tick> = Vec::new();
        let (mut theta, mut q) = (0.25, 0.8);
        for k in 0..50 {
            let u = if k < turned { 0.015 } else { -0.024 };
            ticks.push(Tick { truth: [theta, q], seen: seen(k, [theta, q]), u, trim: 0.0 });
            let acts = if k < 3 { 0.0 } else { ticks[k - 3].u };
            theta += TS * (q + 0.5 * TS * NOMINAL.authority * acts);
            q += TS * NOMINAL.authority * acts;
        }
        ticks
    }

    #[test]
    fn an_answer_in_time_stays_within_the_bound_and_a_late_one_does_not() {
        let crossing =
            flown(100, |_, truth| Some(truth)).iter().position(|tick| tick.truth[0] > 0.4).unwrap();
        let within = |turned: usize| {
            let found = NOMINAL.excursions(&flown(turned, |_, truth| Some(truth)));
            assert_eq!(found.len(), 1);
            (found[0].excess_rad / found[0].bound_rad.unwrap(), found[0].unseen_rad)
        };
        let (ratio, unseen) = within(crossing);
        assert!((0.7..=1.0).contains(&ratio) && unseen == 0.0, "{ratio}");
        assert!(within(crossing + 4).0 > 1.0);
    }

    #[test]
    fn what_the_angle_hides_widens_the_bound() {
        let blind = |k: usize, [theta, q]: [f64; 2]| {
            Some([if k.is_multiple_of(2) { theta } else { theta - 0.05 }, q])
        };
        let crossing =
            flown(100, |_, truth| Some(truth)).iter().position(|tick| tick.truth[0] > 0.4).unwrap();
        let found = NOMINAL.excursions(&flown(crossing + 1, blind))[0];
        assert!((found.unseen_rad - 0.05).abs() < 1e-12);
        assert!(found.excess_rad < found.bound_rad.unwrap());
    }
}
