//! A damped oscillator, stepped exactly.

/// Moves (x, ẋ) over a step of `dt` s by ẍ = ω² (rest − x) − 2ζω ẋ with ω in rad/s and ζ < 1, `rest` constant over it.
pub fn oscillate(s: &mut [f64], omega: f64, zeta: f64, rest: f64, dt: f64) {
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let (x, v) = (s[0] - rest, s[1]);
    let decay = (-zeta * omega * dt).exp();
    let (sin, cos) = (damped * dt).sin_cos();
    let b = (v + zeta * omega * x) / damped;
    s[0] = rest + decay * (x * cos + b * sin);
    s[1] = decay * (v * cos - (zeta * omega * b + damped * x) * sin);
}
