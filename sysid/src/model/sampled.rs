//! The linear grey box sampled exactly, with a delay of any length, and its derivatives to the parameters.
//!
//! ```text
//! states (q, qP, δ, θP) with a mount, (q, θ) without;   δ = ω (θP − θ),  ω² = k/J,  2 ζ ω = c/J
//! q̇  = (∂M/∂q)/I q + (2ζω J/I) (qP − q) + (ω J/I) δ + (∂M/∂u)/I u(t−τ)
//! q̇P = −2ζω (qP − q) − ω δ,     δ̇ = ω (qP − q),     θ̇P = qP
//! x[k+1] = Φ x[k] + Σ_j g_j u[k+1−m−j],  j = 0..3,    τ = (m + f) T,  0 ≤ f < 1
//! ```
//!
//! A held input changes once within a sample, at f T: g₁ = Γ((1−f)T), g₂ = Φ((1−f)T) Γ(fT), g₀ = 0, with
//! Γ(h) = ∫₀ʰ e^As B ds. An interpolated one has its kink there: with R(h) = ∫₀ʰ e^A(h−s) s B ds / T, g₀ = R((1−f)T),
//! g₁ = Γ((1−f)T) − g₀ + Φ((1−f)T) ((1−f) Γ(fT) + R(fT)), g₂ = Φ((1−f)T) (f Γ(fT) − R(fT)).
//!
//! Derivatives of Φ and Γ come from the exponential of \[M dM; 0 M\] (Van Loan, IEEE Transactions on Automatic Control 23,
//! 1978); those to τ and ∂M/∂u are closed forms.

use crate::model::plant::Plant;
use nalgebra::{Matrix4, SMatrix, Vector4};

/// A parameter to differentiate by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parameter {
    /// ∂M/∂q, N m s/rad.
    DmDq,
    /// ∂M/∂u, N m per unit of the input.
    DmDu,
    /// τ, s.
    Delay,
    /// ln ω: the mount's undamped frequency, at fixed ζ and J.
    MountMode,
    /// ln ζ: the mount's damping ratio, at fixed ω and J.
    MountDamping,
    /// ln J: the inertia that the mount carries, at fixed ω and ζ.
    MountInertia,
}

/// Φ and g_0, g_1, g_2, or their derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Φ.
    pub transition: Matrix4<f64>,
    /// g_0, g_1, g_2.
    pub input: [Vector4<f64>; 3],
}

/// The plant, ready to be sampled.
pub struct SampledPlant {
    plant: Plant,
    step: f64,
    held: bool,
    a: Matrix4<f64>,
    b: Vector4<f64>,
    /// m, samples.
    pub delay_samples: usize,
    /// f.
    fraction: f64,
}

/// Φ(h), Γ(h) and ∫₀ʰ e^A(h−s) s B ds.
type Blocks = (Matrix4<f64>, Vector4<f64>, Vector4<f64>);

/// A delay this close below a whole number of samples is that number, and not nearly one sample of the next.
const HAIR: f64 = 1e-9;

impl SampledPlant {
    /// For the sample period `step` in s; `held` tells whether the input is held or interpolated between samples.
    #[must_use]
    pub fn new(plant: &Plant, step: f64, held: bool) -> Self {
        let samples = plant.delay.max(0.0) / step;
        let whole = (samples + HAIR).floor();
        let mut b = Vector4::zeros();
        b[0] = plant.dm_du / plant.inertia;
        Self {
            plant: *plant,
            step,
            held,
            a: state_matrix(plant),
            b,
            delay_samples: whole as usize,
            fraction: (samples - whole).max(0.0),
        }
    }

    /// Number of states: those behind it are not used. `angle` tells whether the output is the angle or the rate.
    #[must_use]
    pub fn order(&self, angle: bool) -> usize {
        (if self.plant.mount.is_some() { 3 } else { 1 }) + usize::from(angle)
    }

    /// Index of the state that is measured.
    #[must_use]
    pub fn measured(&self, angle: bool) -> usize {
        match (self.plant.mount.is_some(), angle) {
            (true, false) | (false, true) => 1,
            (true, true) => 3,
            (false, false) => 0,
        }
    }

    /// Φ and g.
    #[must_use]
    pub fn coefficients(&self) -> Coefficients {
        let (f, t) = (self.fraction, self.step);
        let (late, early) = (self.blocks((1.0 - f) * t), self.blocks(f * t));
        let transition = late.0 * early.0;
        let input = if self.held {
            [Vector4::zeros(), late.1, late.0 * early.1]
        } else {
            let [before, after] = kinked(&early, f, t);
            [late.2 / t, late.1 - late.2 / t + late.0 * after, late.0 * before]
        };
        Coefficients { transition, input }
    }

    /// Derivatives of Φ and g to `parameter`.
    #[must_use]
    pub fn slope(&self, parameter: Parameter) -> Coefficients {
        match parameter {
            Parameter::DmDu => {
                let unit =
                    Self::new(&Plant { dm_du: 1.0, ..self.plant }, self.step, self.held).coefficients();
                Coefficients { transition: Matrix4::zeros(), ..unit }
            }
            Parameter::Delay => self.slope_to_delay(),
            _ => self.slope_to_matrix(&self.matrix_slope(parameter)),
        }
    }

    fn slope_to_delay(&self) -> Coefficients {
        let (f, t) = (self.fraction, self.step);
        let transition = Matrix4::zeros();
        if self.held {
            let switch = self.blocks((1.0 - f) * t).0 * self.b;
            return Coefficients { transition, input: [Vector4::zeros(), -switch, switch] };
        }
        let (late, early) = (self.blocks((1.0 - f) * t), self.blocks(f * t));
        let (late, early) = (late.1 / t, late.0 * early.1 / t);
        Coefficients { transition, input: [-late, late - early, early] }
    }

    fn slope_to_matrix(&self, da: &Matrix4<f64>) -> Coefficients {
        let (f, t) = (self.fraction, self.step);
        let ((late, late_slope), (early, early_slope)) =
            (self.blocks_with_slope(da, (1.0 - f) * t), self.blocks_with_slope(da, f * t));
        let transition = late_slope.0 * early.0 + late.0 * early_slope.0;
        let carried = |own: &Vector4<f64>, slope: &Vector4<f64>| late_slope.0 * own + late.0 * slope;
        let input = if self.held {
            [Vector4::zeros(), late_slope.1, carried(&early.1, &early_slope.1)]
        } else {
            let ([before, after], [before_slope, after_slope]) =
                (kinked(&early, f, t), kinked(&early_slope, f, t));
            let ramp = late_slope.2 / t;
            [ramp, late_slope.1 - ramp + carried(&after, &after_slope), carried(&before, &before_slope)]
        };
        Coefficients { transition, input }
    }

    fn generator(&self) -> SMatrix<f64, 6, 6> {
        let mut m = SMatrix::<f64, 6, 6>::zeros();
        m.fixed_view_mut::<4, 4>(0, 0).copy_from(&self.a);
        m.fixed_view_mut::<4, 1>(0, 4).copy_from(&self.b);
        m[(4, 5)] = 1.0;
        m
    }

    fn blocks(&self, h: f64) -> Blocks {
        if h == 0.0 {
            return (Matrix4::identity(), Vector4::zeros(), Vector4::zeros());
        }
        cut(&(self.generator() * h).exp())
    }

    fn blocks_with_slope(&self, da: &Matrix4<f64>, h: f64) -> (Blocks, Blocks) {
        if h == 0.0 {
            return (self.blocks(h), (Matrix4::zeros(), Vector4::zeros(), Vector4::zeros()));
        }
        let mut both = SMatrix::<f64, 12, 12>::zeros();
        let m = self.generator();
        both.fixed_view_mut::<6, 6>(0, 0).copy_from(&m);
        both.fixed_view_mut::<6, 6>(6, 6).copy_from(&m);
        both.fixed_view_mut::<4, 4>(0, 6).copy_from(da);
        let exp = (both * h).exp();
        (cut(&exp.fixed_view::<6, 6>(0, 0).into_owned()), cut(&exp.fixed_view::<6, 6>(0, 6).into_owned()))
    }

    /// dA to `parameter`.
    fn matrix_slope(&self, parameter: Parameter) -> Matrix4<f64> {
        let mut da = Matrix4::zeros();
        let Some(parts) = MountParts::of(&self.plant) else {
            da[(0, 0)] = if parameter == Parameter::DmDq { 1.0 / self.plant.inertia } else { 0.0 };
            return da;
        };
        match parameter {
            Parameter::DmDq => da[(0, 0)] = 1.0 / self.plant.inertia,
            // every term of the mount is linear in ω, the damping terms in ζ, the reaction on the airframe in J
            Parameter::MountMode => parts.add(&mut da, 1.0, 1.0, 1.0),
            Parameter::MountDamping => parts.add(&mut da, 1.0, 0.0, 1.0),
            Parameter::MountInertia => parts.add(&mut da, 1.0, 1.0, 0.0),
            Parameter::DmDu | Parameter::Delay => {}
        }
        da
    }
}

fn cut(exp: &SMatrix<f64, 6, 6>) -> Blocks {
    (
        exp.fixed_view::<4, 4>(0, 0).into_owned(),
        exp.fixed_view::<4, 1>(0, 4).into_owned(),
        exp.fixed_view::<4, 1>(0, 5).into_owned(),
    )
}

/// What the samples before and after make of the state over f T, in which the input ends its way from the one to the other.
fn kinked(early: &Blocks, f: f64, t: f64) -> [Vector4<f64>; 2] {
    [early.1 * f - early.2 / t, early.1 * (1.0 - f) + early.2 / t]
}

fn state_matrix(plant: &Plant) -> Matrix4<f64> {
    let mut a = Matrix4::zeros();
    a[(0, 0)] = plant.dm_dq / plant.inertia;
    match MountParts::of(plant) {
        Some(parts) => {
            parts.add(&mut a, 1.0, 1.0, 1.0);
            a[(3, 1)] = 1.0;
        }
        None => a[(1, 0)] = 1.0,
    }
    a
}

/// What the mount adds to A.
struct MountParts {
    omega: f64,
    damping: f64,
    /// J/I.
    share: f64,
}

impl MountParts {
    fn of(plant: &Plant) -> Option<Self> {
        let mount = plant.mount?;
        let omega = (mount.stiffness / mount.inertia).sqrt();
        Some(Self { omega, damping: mount.damping / mount.inertia, share: mount.inertia / plant.inertia })
    }

    /// The reaction on the airframe and, `own` times, the mount's own motion; damping and stiffness terms by their
    /// factors.
    fn add(&self, a: &mut Matrix4<f64>, damping: f64, stiffness: f64, own: f64) {
        let (d, w) = (damping * self.damping, stiffness * self.omega);
        a[(0, 0)] -= d * self.share;
        a[(0, 1)] += d * self.share;
        a[(0, 2)] += w * self.share;
        a[(1, 0)] += own * d;
        a[(1, 1)] -= own * d;
        a[(1, 2)] -= own * w;
        // δ is scaled by ω
        a[(2, 0)] -= own * w;
        a[(2, 1)] += own * w;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::plant::Mount;

    fn plant(delay: f64, mount: bool) -> Plant {
        let mount = mount.then(|| Mount::from_mode(12.0, 0.2, 5e-4));
        Plant { inertia: 0.17, dm_dq: -0.4, dm_du: 25.0, delay, mount }
    }

    fn moved(plant: &Plant, parameter: Parameter, by: f64) -> Plant {
        let mut p = *plant;
        let mount = |mode: f64, zeta: f64, j: f64| {
            plant.mount.map(|m| {
                let omega = (m.stiffness / m.inertia).sqrt();
                let damping = m.damping / (2.0 * omega * m.inertia);
                Mount::from_mode(omega * mode / core::f64::consts::TAU, damping * zeta, m.inertia * j)
            })
        };
        match parameter {
            Parameter::DmDq => p.dm_dq += by,
            Parameter::DmDu => p.dm_du += by,
            Parameter::Delay => p.delay += by,
            Parameter::MountMode => p.mount = mount(by.exp(), 1.0, 1.0),
            Parameter::MountDamping => p.mount = mount(1.0, by.exp(), 1.0),
            Parameter::MountInertia => p.mount = mount(1.0, 1.0, by.exp()),
        }
        p
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        use Parameter::{Delay, DmDq, DmDu, MountDamping, MountInertia, MountMode};
        for (with_mount, held) in [(true, true), (true, false), (false, true), (false, false)] {
            let plant = plant(0.0537, with_mount);
            for parameter in [DmDq, DmDu, Delay, MountMode, MountDamping, MountInertia] {
                if !with_mount && matches!(parameter, MountMode | MountDamping | MountInertia) {
                    continue;
                }
                let h = 1e-6;
                let at = |by| SampledPlant::new(&moved(&plant, parameter, by), 0.02, held).coefficients();
                let (plus, minus) = (at(h), at(-h));
                let slope = SampledPlant::new(&plant, 0.02, held).slope(parameter);
                let differences = (plus.transition - minus.transition) / (2.0 * h);
                let size = 1.0
                    + slope
                        .transition
                        .amax()
                        .max(slope.input.map(|g| g.amax()).into_iter().fold(0.0, f64::max));
                assert!((differences - slope.transition).amax() < 1e-7 * size, "{parameter:?} {held}");
                for j in 0..3 {
                    let difference = (plus.input[j] - minus.input[j]) / (2.0 * h);
                    assert!((difference - slope.input[j]).amax() < 1e-7 * size, "{parameter:?} {held} {j}");
                }
            }
        }
    }

    #[test]
    fn a_rigid_plant_with_any_delay_has_its_closed_form() {
        let plant = plant(0.0537, false);
        let sampled = SampledPlant::new(&plant, 0.02, true);
        let own = sampled.coefficients();
        let (a, b) = (plant.dm_dq / plant.inertia, plant.dm_du / plant.inertia);
        let f = 0.0537 - 0.04;
        assert_eq!(sampled.delay_samples, 2);
        assert!((own.transition[(0, 0)] - (a * 0.02).exp()).abs() < 1e-14);
        assert!((own.input[1][0] - b / a * ((a * (0.02 - f)).exp() - 1.0)).abs() < 1e-12);
        assert!((own.input[2][0] - b / a * ((a * 0.02).exp() - (a * (0.02 - f)).exp())).abs() < 1e-12);
        assert_eq!(SampledPlant::new(&Plant { delay: 0.06, ..plant }, 0.02, true).delay_samples, 3);
    }

    #[test]
    fn the_sampled_response_is_that_of_the_transfer_function() {
        // whole delay: eq. 10 sampled by another road
        let plant = plant(0.06, true);
        let own = SampledPlant::new(&plant, 0.02, true).coefficients();
        let other = crate::identify::hinf_match::grey_box_response(&plant).unwrap().sampled(0.02).unwrap();
        let (mut x, mut pulse) = (Vector4::<f64>::zeros(), vec![0.0; 60]);
        pulse[0] = 1.0;
        let expected = other.simulate(&pulse, None);
        for (k, expected) in expected.iter().enumerate() {
            assert!((x[1] - expected).abs() < 1e-10, "{k}: {} {expected}", x[1]);
            let input = if k == 0 {
                own.input[1]
            } else if k == 1 {
                own.input[2]
            } else {
                Vector4::zeros()
            };
            x = own.transition * x + input;
        }
    }
}
