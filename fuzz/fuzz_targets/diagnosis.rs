//! The diagnosis of short recordings of any finite values, against any model, with a part of the catalogue.
#![no_main]

use arbitrary::Arbitrary;
use libfuzzer_sys::fuzz_target;
use sysid::catalogue::CATALOGUE;
use sysid::catalogue::model_file::parse_model;
use sysid::diagnosis::diagnose_with;
use sysid::recording::{ReadOptions, parse};

/// Rows at most: a run takes tens of milliseconds.
const MOST: usize = 160;

#[derive(Arbitrary, Debug)]
struct Case {
    step_ms: u8,
    rate: bool,
    angle: bool,
    interpolated: bool,
    closed: bool,
    /// Sizes of input, rate and angle as powers of ten.
    sizes: [i8; 3],
    /// ∂M/∂u, ∂M/∂q of what moves the recording.
    plant: [i8; 2],
    model: Option<[i8; 4]>,
    effects: [u8; 2],
    rows: Vec<[i8; 4]>,
}

fn text(case: &Case) -> String {
    let [u_size, q_size, theta_size] = case.sizes.map(|power| 10f64.powi(i32::from(power % 9)));
    let step = f64::from(case.step_ms.max(1)) * 1e-3;
    let mut text = "t_s,u_rad".to_owned();
    text += if case.rate { ",q_rad_s" } else { "" };
    text += if case.angle || !case.rate { ",theta_rad" } else { "" };
    text += ",section\n";
    let (mut q, mut theta) = (0.0, 0.0);
    let rows = case.rows.iter().cycle().take(if case.rows.is_empty() { 0 } else { MOST });
    for (k, [u, own, noise, kind]) in rows.enumerate() {
        let u = f64::from(*u) / 127.0;
        // a motion of its own where the row says so, whatever the input says otherwise
        let pushed = f64::from(case.plant[0]) * u + f64::from(case.plant[1]) * 0.05 * q;
        q = (q + step * pushed).clamp(-1e3, 1e3) + 0.1 * f64::from(*noise) / 127.0;
        if *kind == 0 {
            q = f64::from(*own);
        }
        theta += step * q;
        text += &format!("{:.4},{:e}", step * k as f64, u * u_size);
        if case.rate {
            text += &format!(",{:e}", q * q_size);
        }
        if case.angle || !case.rate {
            text += &format!(",{:e}", theta * theta_size);
        }
        text += if case.closed && k > MOST / 2 { ",IV\n" } else { ",I\n" };
    }
    text
}

fuzz_target!(|case: Case| {
    let mut options = ReadOptions::default();
    if case.interpolated {
        options.input_hold = sysid::recording::InputHold::Interpolated;
    }
    let Ok(recording) = parse("a.csv", text(&case).as_bytes(), &options) else { return };
    let power = |power: i8| 10f64.powi(i32::from(power % 6));
    let model = case.model.and_then(|[inertia, damping, gain, delay]| {
        let text = format!(
            "[plant]\ninertia_kg_m2 = {:e}\ndM_dq_N_m_s = {:e}\ndM_du_N_m = {:e}\ndelay_s = {:e}\n",
            power(inertia),
            f64::from(damping) * 0.1,
            f64::from(gain),
            f64::from(delay.unsigned_abs()) * 1e-3
        );
        parse_model("m.toml", &text, None).ok()
    });
    let chosen = case.effects.map(|effect| CATALOGUE[usize::from(effect) % CATALOGUE.len()]);
    if let Ok(found) = diagnose_with(&[recording], model.as_ref(), &chosen, &|_| {}) {
        let answer = serde_json::to_string(&found.answer).expect("an answer is JSON");
        assert!(!answer.contains("-0.0,"));
    }
});
