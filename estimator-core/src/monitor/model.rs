//! What the board is told of the identified vehicle: the predictor, and how each cause would show.

use core::fmt;

use super::filter::{BLOCKS, Column, Rows, STATES, Transition};
use crate::constants::MAX_INPUT_DELAY;

/// Causes that are watched for.
pub const CAUSES: usize = 8;
/// Sizes at which a cause is tested, both signs together.
pub const SIZES: usize = 6;
/// Numbers of a model, in the order of its fields.
pub const NUMBERS: usize =
    4 * BLOCKS + STATES + 2 * STATES + 2 * STATES + 3 + 2 + 7 + 4 + (4 + SIZES) * CAUSES;

/// What a flight can show to have changed.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Cause {
    /// ∂M/∂u, as a share of the identified.
    Effectiveness,
    /// A lag or delay of the command beside the identified, s.
    Lag,
    /// A constant moment beside the identified, N m.
    Trim,
    /// A moment against the rate in proportion to it, N m s/rad.
    Damping,
    /// A moment against the rate of one size, N m.
    Friction,
    /// An addition to the measured rate, rad/s.
    GyroBias,
    /// A share of the rate added to the measured one.
    GyroScale,
    /// A moment against the angle in proportion to it, N m/rad: none of the named, and the sign of something else.
    Stiffness,
}

impl Cause {
    /// All, in the order in which they are kept.
    pub const ALL: [Self; CAUSES] = [
        Self::Effectiveness,
        Self::Lag,
        Self::Trim,
        Self::Damping,
        Self::Friction,
        Self::GyroBias,
        Self::GyroScale,
        Self::Stiffness,
    ];

    /// Its name in texts.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Effectiveness => "effectiveness",
            Self::Lag => "lag",
            Self::Trim => "trim moment",
            Self::Damping => "damping",
            Self::Friction => "friction",
            Self::GyroBias => "gyro bias",
            Self::GyroScale => "gyro scale",
            Self::Stiffness => "moment with the angle",
        }
    }

    /// The unit in which it is told, and its size per unit of the model; `specific` where moments are per unit inertia.
    #[must_use]
    pub const fn unit(self, specific: bool) -> (&'static str, f32) {
        match self {
            Self::Effectiveness | Self::GyroScale => ("%", 100.0),
            Self::Lag => ("ms", 1000.0),
            Self::GyroBias => ("rad/s", 1.0),
            Self::Trim | Self::Friction => (if specific { "rad/s2" } else { "N m" }, 1.0),
            Self::Damping => (if specific { "1/s" } else { "N m s/rad" }, 1.0),
            Self::Stiffness => (if specific { "1/s2" } else { "N m/rad" }, 1.0),
        }
    }
}

/// How one cause is tested.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Test {
    /// Sizes up to this one are no change: too small to matter, or within the errors of the identification.
    pub dead_zone: f32,
    /// Variance of the score over the innovations' variance, from the identification's own recording; 1 where they are white.
    pub calibration: f32,
    /// Share of the lasting trace that shows in the first block, and the share of the rest that each block adds.
    pub onset: [f32; 2],
    /// Sizes tested, each beyond the dead zone; 0 for none.
    pub sizes: [f32; SIZES],
}

/// The identified vehicle in innovations form, for a sample period of 0.02 s.
///
/// ```text
/// c[k] = (1−f) u[k−m] + f u[k−m−1]
/// x[k+1] = F x[k] + Γ b c[k] + L_q q[k] + L_θ θ[k]
/// e[k] = W y[k] − C x[k] − e0,     y = (q, θ),  cov e = I
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MonitorModel {
    /// F.
    pub transition: Transition,
    /// Γ: what a unit moment, held over one sample, adds.
    pub moment: Column,
    /// L_q and L_θ.
    pub correction: [Column; 2],
    /// C, whitened.
    pub output: Rows,
    /// W, lower triangle: of q in the first channel, of q and of θ in the second.
    pub whitening: [f32; 3],
    /// e0: what the identified trim and gyro offset leave.
    pub rest: [f32; 2],
    /// 1 where moments are per unit inertia, 0 where they are in N m.
    pub specific: f32,
    /// b = ∂M/∂u, N m/rad.
    pub gain: f32,
    /// m, whole samples, 0 to [`MAX_INPUT_DELAY`].
    pub delay_samples: f32,
    /// f, 0 to 1.
    pub delay_fraction: f32,
    /// Share by which the lag that is tested for approaches the command in one sample, and its length, s.
    pub lag: [f32; 2],
    /// Rate at which dry friction is half grown, rad/s.
    pub friction_rate: f32,
    /// What a unit constant moment leaves in e.
    pub trim: [f32; 2],
    /// What a unit gyro offset leaves in e.
    pub bias: [f32; 2],
    /// How each of [`Cause::ALL`] is tested.
    pub tests: [Test; CAUSES],
}

/// Why a model is not taken.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Refusal {
    /// A number is not finite, or beyond 10⁸.
    Number {
        /// Its place in [`MonitorModel::to_numbers`].
        place: usize,
    },
    /// A block of F has a pole on or outside the unit circle.
    Unstable {
        /// The block.
        block: usize,
    },
    /// A quantity lies outside its range.
    Range {
        /// Its name.
        name: &'static str,
    },
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Number { place } => write!(f, "number {place} of the model is not finite or too large"),
            Self::Unstable { block } => write!(f, "block {block} of the predictor is not stable"),
            Self::Range { name } => write!(f, "{name} lies outside its range"),
        }
    }
}

/// Largest magnitude of a number.
const LARGEST: f32 = 1e8;

fn all_sound(numbers: &[f32; NUMBERS]) -> Result<(), Refusal> {
    // written so that NaN fails
    let sound = |number: &f32| number.abs() <= LARGEST;
    numbers.iter().position(|number| !sound(number)).map_or(Ok(()), |place| Err(Refusal::Number { place }))
}

impl MonitorModel {
    /// All numbers, in the order of the fields.
    #[must_use]
    pub fn to_numbers(&self) -> [f32; NUMBERS] {
        let mut numbers = [0.0; NUMBERS];
        let mut copy = *self;
        let mut to = numbers.iter_mut();
        copy.visit(&mut |value| {
            if let Some(place) = to.next() {
                *place = *value;
            }
        });
        numbers
    }

    /// The model of these numbers, checked.
    ///
    /// # Errors
    /// The first thing that is not as it has to be.
    pub fn from_numbers(numbers: &[f32; NUMBERS]) -> Result<Self, Refusal> {
        all_sound(numbers)?;
        let mut model = Self::EMPTY;
        let mut from = numbers.iter();
        model.visit(&mut |value| {
            if let Some(number) = from.next() {
                *value = *number;
            }
        });
        model.check_ranges().map(|()| model)
    }

    /// Whether a board may run it.
    ///
    /// # Errors
    /// The first thing that is not as it has to be.
    pub fn check(&self) -> Result<(), Refusal> {
        all_sound(&self.to_numbers())?;
        self.check_ranges()
    }

    fn check_ranges(&self) -> Result<(), Refusal> {
        // Schur–Cohn for two real or complex poles
        let stable = |[a, b, c, d]: &[f32; 4]| {
            let (trace, product) = (a + d, a * d - b * c);
            product.abs() < 1.0 && trace.abs() < 1.0 + product
        };
        if let Some(block) = self.transition.iter().position(|block| !stable(block)) {
            return Err(Refusal::Unstable { block });
        }
        let [share, length] = self.lag;
        let ranges = [
            ("specific", self.specific, [0.0, 1.0]),
            ("gain", self.gain.abs(), [1e-6, LARGEST]),
            ("delay_samples", self.delay_samples, [0.0, f32::from(MAX_INPUT_DELAY)]),
            ("delay_fraction", self.delay_fraction, [0.0, 1.0]),
            ("lag share", share, [1e-3, 1.0]),
            ("lag length", length, [1e-3, 10.0]),
            ("friction_rate", self.friction_rate, [1e-6, LARGEST]),
        ];
        let tests = self.tests.iter().map(|test| ("dead_zone", test.dead_zone, [0.0, LARGEST]));
        let calibrations = self.tests.iter().map(|test| ("calibration", test.calibration, [0.1, 1e3]));
        let onsets = self.tests.iter().flat_map(|test| test.onset.map(|share| ("onset", share, [0.0, 1.0])));
        ranges
            .into_iter()
            .chain(onsets)
            .chain(tests)
            .chain(calibrations)
            .find(|(_, found, [low, high])| !(found >= low && found <= high))
            .map_or(Ok(()), |(name, ..)| Err(Refusal::Range { name }))
    }

    /// A model that watches for nothing.
    pub const EMPTY: Self = Self {
        transition: [[0.0; 4]; BLOCKS],
        moment: [0.0; STATES],
        correction: [[0.0; STATES]; 2],
        output: [[0.0; STATES]; 2],
        whitening: [1.0, 0.0, 0.0],
        rest: [0.0; 2],
        specific: 0.0,
        gain: 1.0,
        delay_samples: 0.0,
        delay_fraction: 0.0,
        lag: [1.0; 2],
        friction_rate: 1.0,
        trim: [0.0; 2],
        bias: [0.0; 2],
        tests: [Test { dead_zone: 0.0, calibration: 1.0, onset: [1.0, 0.0], sizes: [0.0; SIZES] }; CAUSES],
    };

    fn visit(&mut self, see: &mut impl FnMut(&mut f32)) {
        self.transition.as_flattened_mut().iter_mut().for_each(&mut *see);
        self.moment.iter_mut().for_each(&mut *see);
        self.correction.as_flattened_mut().iter_mut().for_each(&mut *see);
        self.output.as_flattened_mut().iter_mut().for_each(&mut *see);
        self.whitening.iter_mut().for_each(&mut *see);
        self.rest.iter_mut().for_each(&mut *see);
        let [share, length] = &mut self.lag;
        see(&mut self.specific);
        let single = [&mut self.gain, &mut self.delay_samples, &mut self.delay_fraction, share, length];
        single.into_iter().for_each(&mut *see);
        see(&mut self.friction_rate);
        self.trim.iter_mut().chain(&mut self.bias).for_each(&mut *see);
        for test in &mut self.tests {
            see(&mut test.dead_zone);
            see(&mut test.calibration);
            test.onset.iter_mut().for_each(&mut *see);
            test.sizes.iter_mut().for_each(&mut *see);
        }
    }
}
