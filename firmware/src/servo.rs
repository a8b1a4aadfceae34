//! Collective blade pitch of the two opposite rotors, as servo pulses.
//!
//! ```text
//! front = trim + u/2        rear = trim − u/2            (rad)
//! width = centre + gain · angle                          (µs), clipped to [shortest, longest]
//! ```
//!
//! u is the difference of the two, so its sum, the thrust, stays at the trim. *Neutral* is u = 0: both rotors at the trim.

use embedded_hal::pwm::SetDutyCycle;

/// One collective servo. The defaults are those of an ordinary 1 to 2 ms servo with 90°/ms on a 1:10 linkage.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ServoConfig {
    /// Collective pitch at which the machine hovers, rad.
    pub trim_rad: f32,
    /// Pulse width at blade pitch zero, µs.
    pub centre_us: f32,
    /// µs of pulse per rad of blade pitch.
    pub gain_us_per_rad: f32,
    /// Shortest and longest pulse the servo bears, µs.
    pub range_us: [f32; 2],
    /// Period of the pulses, µs.
    pub period_us: f32,
}

impl Default for ServoConfig {
    fn default() -> Self {
        Self {
            trim_rad: 0.08,
            centre_us: 1500.0,
            gain_us_per_rad: 2000.0,
            range_us: [1000.0, 2000.0],
            period_us: 5000.0,
        }
    }
}

impl ServoConfig {
    /// Pulse widths (µs) of the front and the rear rotor for the difference `u_rad`; neutral if that is no number.
    #[must_use]
    pub fn widths_us(&self, u_rad: f32) -> [f32; 2] {
        let half = if u_rad.is_finite() { 0.5 * u_rad } else { 0.0 };
        let [shortest, longest] = self.range_us;
        [self.trim_rad + half, self.trim_rad - half]
            .map(|angle| (self.centre_us + self.gain_us_per_rad * angle).max(shortest).min(longest))
    }

    /// Share of the period that a pulse of `width_us` takes, in steps of a timer that counts to `top`.
    #[must_use]
    pub fn duty(&self, width_us: f32, top: u16) -> u16 {
        // the conversion saturates
        libm::roundf(width_us / self.period_us * f32::from(top)) as u16
    }
}

/// The two channels.
#[derive(Debug)]
pub struct Servos<Front, Rear> {
    config: ServoConfig,
    front: Front,
    rear: Rear,
}

impl<Front: SetDutyCycle, Rear: SetDutyCycle> Servos<Front, Rear> {
    /// Takes the channels and sends neutral.
    ///
    /// # Errors
    /// The first channel that refuses its duty cycle.
    pub fn new(config: ServoConfig, front: Front, rear: Rear) -> Result<Self, ServoError> {
        let mut servos = Self { config, front, rear };
        servos.set(0.0)?;
        Ok(servos)
    }

    /// Sends the difference `u_rad`.
    ///
    /// # Errors
    /// The channel that refuses its duty cycle; the other one is set all the same.
    pub fn set(&mut self, u_rad: f32) -> Result<(), ServoError> {
        let [front, rear] = self.config.widths_us(u_rad);
        let front = self.front.set_duty_cycle(self.config.duty(front, self.front.max_duty_cycle()));
        let rear = self.rear.set_duty_cycle(self.config.duty(rear, self.rear.max_duty_cycle()));
        front.map_err(|_| ServoError::Front)?;
        rear.map_err(|_| ServoError::Rear)
    }
}

/// A channel refused its duty cycle.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum ServoError {
    /// The front rotor's.
    Front,
    /// The rear rotor's.
    Rear,
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_hal_mock::eh1::pwm::{Mock, Transaction};

    #[test]
    fn rotors_move_against_each_other_about_the_trim() {
        let [front, rear] = ServoConfig::default().widths_us(0.02);
        assert!((front - 1680.0).abs() < 1e-3 && (rear - 1640.0).abs() < 1e-3, "{front} {rear}");
    }

    #[test]
    fn pulses_stay_within_the_servo_and_nonsense_is_neutral() {
        let config = ServoConfig::default();
        assert_eq!(config.widths_us(9.0), [2000.0, 1000.0]);
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(config.widths_us(bad), config.widths_us(0.0));
        }
    }

    #[test]
    fn channels_get_neutral_first_and_then_the_command() {
        // 1660 µs of 5000 µs in 10000 steps are 3320
        let front = [3320, 3360].map(Transaction::set_duty_cycle);
        let rear = [3320, 3280].map(Transaction::set_duty_cycle);
        let with_top = |all: [Transaction; 2]| {
            all.into_iter().flat_map(|set| [Transaction::max_duty_cycle(10_000), set]).collect::<Vec<_>>()
        };
        let (mut front, mut rear) = (Mock::new(&with_top(front)), Mock::new(&with_top(rear)));
        let mut servos = Servos::new(ServoConfig::default(), front.clone(), rear.clone()).unwrap();
        servos.set(0.02).unwrap();
        front.done();
        rear.done();
    }
}
