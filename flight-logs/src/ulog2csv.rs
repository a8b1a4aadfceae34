//! CSV files that `ulog2csv` writes from a ULog file: one for each topic and instance, `PREFIX_TOPIC_INSTANCE.csv`.
//!
//! A header line, then rows of numbers; `timestamp` in µs since start. Files that are given together are one log.

use crate::{Error, Field, Format, Log, Place, Topic};

/// Topics that this crate has a use for: where PREFIX ends cannot be told otherwise.
const TOPICS: [&str; 13] = [
    "actuator_controls_0",
    "actuator_motors",
    "actuator_outputs",
    "battery_status",
    "rate_ctrl_status",
    "sensor_combined",
    "sensor_gyro",
    "vehicle_angular_velocity",
    "vehicle_attitude",
    "vehicle_attitude_setpoint",
    "vehicle_rates_setpoint",
    "vehicle_thrust_setpoint",
    "vehicle_torque_setpoint",
];

/// Reads the files of one log, each a name and its bytes.
pub(crate) fn parse(files: &[(String, Vec<u8>)]) -> Result<Log, Error> {
    let mut log = Log::new(Format::Ulog2Csv);
    for (name, bytes) in files {
        let topic = table(name, bytes, &mut log.notes).map_err(|error| error.in_file(name))?;
        if log.topic(&topic.name, topic.instance).is_some() {
            let found = format!("{} instance {} twice", topic.name, topic.instance);
            return Err(Error::new(found, "name each file once, and files of one log only").in_file(name));
        }
        log.topics.push(topic);
    }
    Ok(log.finish())
}

fn table(name: &str, bytes: &[u8], notes: &mut Vec<String>) -> Result<Topic, Error> {
    let mut reader = csv::ReaderBuilder::new().flexible(true).trim(csv::Trim::All).from_reader(bytes);
    let unreadable = |error: &csv::Error| {
        let line = error.position().map_or(1, |position| position.line() as usize);
        Error::new(format!("no line of CSV: {error}"), "write the file anew with ulog2csv")
            .at(Place::Line(line))
    };
    let header = reader.headers().map_err(|error| unreadable(&error))?.clone();
    let time = header.iter().position(|cell| cell == "timestamp").ok_or_else(|| {
        Error::new("no column timestamp", "write the file with ulog2csv").at(Place::Line(1))
    })?;
    let (title, instance) = title(name);
    let mut topic = Topic::new(title, instance);
    topic.fields =
        header.iter().enumerate().filter(|&(i, _)| i != time).map(|(_, name)| Field::new(name)).collect();
    let mut bad = Vec::new();
    let mut record = csv::ByteRecord::new();
    while reader.read_byte_record(&mut record).map_err(|error| unreadable(&error))? {
        let number = |cell: &[u8]| std::str::from_utf8(cell).ok().and_then(|cell| cell.parse::<f64>().ok());
        let time_us = record.get(time).and_then(number).filter(|time_us| time_us.is_finite());
        let Some(time_us) = time_us.filter(|_| record.len() == header.len()) else {
            bad.push(record.position().map_or(0, csv::Position::line));
            continue;
        };
        topic.time_s.push(time_us / 1e6);
        let cells = record.iter().enumerate().filter(|&(i, _)| i != time);
        for (field, (_, cell)) in topic.fields.iter_mut().zip(cells) {
            field.values.push(number(cell).unwrap_or(f64::NAN));
        }
    }
    if topic.time_s.is_empty() {
        return Err(Error::new("no row can be read", "write the file anew with ulog2csv").at(Place::Line(2)));
    }
    if let Some(first) = bad.first() {
        notes.push(format!("{}: {} bad lines, the first is line {first}: skipped", topic.title(), bad.len()));
    }
    Ok(topic)
}

/// Topic and instance by the file's name; the whole name for a topic that is not known.
fn title(file: &str) -> (String, u8) {
    let name = file.rsplit(['/', '\\']).next().unwrap_or(file);
    let stem = name.strip_suffix(".csv").unwrap_or(name);
    let numbered = stem.rsplit_once('_').and_then(|(rest, number)| Some((rest, number.parse().ok()?)));
    // actuator_controls_0.csv is a topic without instance, actuator_controls_0_0.csv one with.
    for (stem, instance) in numbered.into_iter().chain([(stem, 0)]) {
        let ends = |topic: &&&str| {
            stem.strip_suffix(**topic).is_some_and(|before| before.is_empty() || before.ends_with('_'))
        };
        if let Some(topic) = TOPICS.iter().filter(ends).max_by_key(|topic| topic.len()) {
            return ((*topic).to_owned(), instance);
        }
    }
    numbered.map_or((stem.to_owned(), 0), |(stem, instance)| (stem.to_owned(), instance))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topic_and_instance_by_name() {
        for (file, topic, instance) in [
            ("a/log_sensor_combined_0.csv", "sensor_combined", 0),
            ("log_actuator_controls_0_0.csv", "actuator_controls_0", 0),
            ("log_actuator_controls_0.csv", "actuator_controls_0", 0),
            ("my_log_vehicle_attitude_setpoint_1.csv", "vehicle_attitude_setpoint", 1),
            ("log_esc_status_2.csv", "log_esc_status", 2),
            ("vehicle_attitude.csv", "vehicle_attitude", 0),
        ] {
            assert_eq!(title(file), (topic.to_owned(), instance), "{file}");
        }
    }
}
