//! What the columns of a file may be, by their names: options to be looked at by whoever knows the log.

use super::columns::Role;
use super::expression::Expression;
use super::options::ColumnMap;

const TIME: [&str; 13] = [
    "t",
    "time",
    "zeit",
    "tempo",
    "temps",
    "tiempo",
    "timestamp",
    "timestamps",
    "stamp",
    "millis",
    "micros",
    "elapsed",
    "clock",
];
const INPUT: [&str; 16] = [
    "u",
    "cmd",
    "command",
    "input",
    "pwm",
    "duty",
    "throttle",
    "elevator",
    "aileron",
    "rudder",
    "torque",
    "voltage",
    "current",
    "stellgröße",
    "motor",
    "servo",
];
const RATE: [&str; 12] = [
    "q", "gyro", "gyroy", "gyroadc", "gy", "rate", "nickrate", "omega", "dps", "angvel", "velocity", "thdot",
];
const ANGLE: [&str; 11] =
    ["theta", "pitch", "nick", "angle", "angulo", "winkel", "theta_m", "pos", "position", "th", "posicion"];
/// What tells the pitch axis from the others.
const PITCH: [&str; 5] = ["y", "pitch", "nick", "gy", "gyroy"];

/// The options that map what is missing among the columns `header`, with NAME for what no name tells; the units that names do not
/// tell are those of the format.
pub(super) fn options(header: &[String], has: impl Fn(fn(Role) -> bool) -> bool) -> String {
    let mut options = Vec::new();
    if !has(|role| role == Role::Time) {
        let found = named(header, &TIME).map(|name| {
            let factor = match unit(name).as_str() {
                "ms" | "millis" => 1e-3,
                "us" | "µs" | "micros" => 1e-6,
                "ns" => 1e-9,
                _ => 1.0,
            };
            option("t_s", name, factor)
        });
        options.push(found.unwrap_or_else(|| "--column 't_s=row*0.01'".to_owned()));
    }
    if !has(|role| matches!(role, Role::Input(_))) {
        let found = named(header, &INPUT).map(|name| {
            // a servo's pulses, about the middle of their range
            if matches!(unit(name).as_str(), "us" | "µs" | "micros") {
                return format!("--column 'u_norm=({}-1500)/500'", Expression::column(name));
            }
            let target = match unit(name).as_str() {
                "%" | "pct" | "percent" => "u_pct",
                "v" => "u_V",
                "a" => "u_A",
                "n" => "u_N",
                "nm" => "u_N_m",
                "deg" | "°" => "u_deg",
                "rad" => "u_rad",
                _ => "u_norm",
            };
            option(target, name, 1.0)
        });
        options.push(found.unwrap_or_else(|| "--column u_norm=NAME".to_owned()));
    }
    if !has(|role| matches!(role, Role::Q | Role::Theta)) {
        let in_degrees = |name: &str| {
            let unit = unit(name);
            unit.contains("deg") || unit.contains('°') || unit == "dps"
        };
        let of = |header: &[String], words: &[&str], targets: [&str; 2]| {
            named(header, words).map(|name| option(targets[usize::from(in_degrees(name))], name, 1.0))
        };
        let is_rate = |name: &String| tokens(name).iter().any(|token| RATE.contains(&token.as_str()));
        let angles: Vec<String> = header.iter().filter(|name| !is_rate(name)).cloned().collect();
        let found =
            [of(header, &RATE, ["q_rad_s", "q_deg_s"]), of(&angles, &ANGLE, ["theta_rad", "theta_deg"])];
        let none = found.iter().all(Option::is_none);
        options.extend(found.into_iter().flatten());
        options.extend(none.then(|| "--column q_rad_s=NAME".to_owned()));
    }
    options.join(" ")
}

fn option(target: &str, name: &str, factor: f64) -> String {
    ColumnMap { target: target.into(), source: Expression::column(name), factor }.option_to_scale(1.0)
}

/// The first column called by one of the `words`, one of the pitch axis before others.
fn named<'h>(header: &'h [String], words: &[&str]) -> Option<&'h String> {
    let called = |name: &&String| tokens(name).iter().any(|token| words.contains(&token.as_str()));
    let of_pitch = |name: &&String| tokens(name).iter().any(|token| PITCH.contains(&token.as_str()));
    let all = || header.iter().filter(called);
    all().find(of_pitch).or_else(|| all().next())
}

/// The words of a name in small letters, without its unit between brackets.
fn tokens(name: &str) -> Vec<String> {
    let bare = name.split(['(', '[']).next().unwrap_or_default().to_lowercase();
    bare.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty()).map(str::to_owned).collect()
}

/// The unit of a name, in small letters: what stands between brackets, or its last word.
fn unit(name: &str) -> String {
    let name = name.to_lowercase();
    let bracketed = name.split_once(['(', '[']).and_then(|(_, rest)| rest.split([')', ']']).next());
    let last = || name.split(|c: char| !c.is_alphanumeric() && c != '%').next_back();
    bracketed.or_else(last).unwrap_or_default().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn proposed(header: &str) -> String {
        let header: Vec<String> = header.split(',').map(str::to_owned).collect();
        options(&header, |_| false)
    }

    #[test]
    fn names_and_units_that_are_usual_are_mapped_in_one_line() {
        assert_eq!(
            proposed("time_ms,cmd,gyro_x,gyro_y"),
            "--column 't_s=time_ms*0.001' --column 'u_norm=cmd' --column 'q_rad_s=gyro_y'"
        );
        assert_eq!(
            proposed("Zeit [s],Stellgröße [%],Nickrate [°/s]"),
            "--column 't_s=`Zeit [s]`' --column 'u_pct=`Stellgröße [%]`' --column 'q_deg_s=`Nickrate [°/s]`'"
        );
        assert_eq!(
            proposed("time (us),motor_V,pitch_deg"),
            "--column 't_s=`time (us)`*0.000001' --column 'u_V=motor_V' --column 'theta_deg=pitch_deg'"
        );
        assert_eq!(
            proposed("t,cmd,pitch_rate_dps"),
            "--column 't_s=t' --column 'u_norm=cmd' --column 'q_deg_s=pitch_rate_dps'"
        );
        assert_eq!(
            proposed("t_ms,pwm_us,gyro_y_dps,angle_deg"),
            "--column 't_s=t_ms*0.001' --column 'u_norm=(pwm_us-1500)/500' --column 'q_deg_s=gyro_y_dps' --column 'theta_deg=angle_deg'"
        );
    }

    #[test]
    fn what_no_name_tells_is_left_to_the_user() {
        assert_eq!(proposed("a,b"), "--column 't_s=row*0.01' --column u_norm=NAME --column q_rad_s=NAME");
        let header = vec!["millis".to_owned(), "x".to_owned()];
        let lacking = options(&header, |of| of(Role::Q));
        assert_eq!(lacking, "--column 't_s=millis*0.001' --column u_norm=NAME");
    }
}
