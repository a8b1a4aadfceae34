//! The frames of a flight, decoded into topics: `main`, `slow`, `gps`.

use super::encoding::{Encoding, Predictor, Stream};
use super::header::{Header, Part};
use crate::bytes::array;
use crate::damage::Damage;
use crate::{Error, Field, Format, Log, Place, Topic};

const KINDS: &[u8] = b"IPSGHE";
/// A longer step than this between main frames has to be confirmed by those that follow, µs and iterations.
const LONGEST_STEP: u32 = 10_000_000;
const MOST_ITERATIONS: u32 = 5000;
/// Main frames in order that confirm a step.
const CONFIRMING: usize = 4;
/// The largest "P interval" that is believed.
const SPARSEST: i64 = 10_000;

/// What predictions are made from.
#[derive(Clone, Default)]
struct History {
    /// The main frame before, and the one before that; empty before the first, and after damage.
    previous: Vec<i64>,
    before: Vec<i64>,
    home: Vec<i64>,
}

struct Decoder<'a> {
    header: &'a Header,
    history: History,
    iteration: Option<usize>,
    time: usize,
    motor: Option<usize>,
    /// Loop iteration and time of the last main frame taken, or of the logger's word that it resumes; the time in µs,
    /// beyond the 32 bits of the log.
    last: Option<(u32, i64)>,
    min_throttle: i64,
    min_motor: i64,
    battery: i64,
    interval: (i64, i64, i64),
}

/// Decodes the flight between `start` and `end`.
pub(super) fn flight(bytes: &[u8], start: usize, end: usize) -> Result<Log, Error> {
    let (header, first) = Header::read(bytes, start, end)?;
    let index = |name: &str| header.intra.iter().position(|part| part.name == name);
    let time = index("time").ok_or_else(|| {
        Error::new("no field time in the main frames", "log again: the header is incomplete")
            .at(Place::Offset(start))
    })?;
    let mut decoder = Decoder {
        header: &header,
        history: History::default(),
        iteration: index("loopIteration"),
        time,
        motor: index("motor[0]"),
        last: None,
        min_throttle: header.number("minthrottle", 0).unwrap_or(1150),
        min_motor: header.number("motorOutput", 0).unwrap_or(0),
        battery: header.number("vbatref", 0).unwrap_or(4095),
        interval: header.intervals(),
    };
    let mut log = Log::new(Format::Blackbox);
    header.describe(&mut log);
    let mut topics = [topic("main", &header.intra), topic("slow", &header.slow), topic("gps", &header.gps)];
    let mut damage = Damage::default();
    let bytes = bytes.get(..end).unwrap_or(bytes);
    let mut stream = Stream { bytes, at: first };
    let mut rejected = 0_usize;
    while stream.at < end {
        let from = stream.at;
        match decoder.frame(&mut stream, &mut topics, &mut log.messages) {
            Taken::Frame => {}
            Taken::OutOfOrder => rejected += 1,
            Taken::End => break,
            Taken::Nothing => {
                decoder.history.previous.clear();
                let rest = bytes.get(from..).unwrap_or_default();
                if rest.iter().all(|&byte| byte == 0xff) || rest.iter().all(|&byte| byte == 0) {
                    break;
                }
                damage.skip(from, 1);
                stream.at = from + 1;
            }
        }
    }
    finish(log, topics, &header, &damage, rejected, first)
}

fn finish(
    mut log: Log,
    topics: [Topic; 3],
    header: &Header,
    damage: &Damage,
    rejected: usize,
    first: usize,
) -> Result<Log, Error> {
    let [mut main, mut slow, gps] = topics;
    let Some(&start_s) = main.time_s.first() else {
        return Err(Error::new("no main frame can be read", "log again: the flight is damaged or empty")
            .at(Place::Offset(first))
            .expecting("a frame I of the main loop"));
    };
    for time_s in slow.time_s.iter_mut().filter(|time_s| time_s.is_nan()) {
        *time_s = start_s;
    }
    let scale = header.gyro_scale();
    for field in main.fields.iter_mut().filter(|field| field.name.starts_with("gyro")) {
        field.unit = Some("rad/s".to_owned());
        field.values.iter_mut().for_each(|value| *value *= scale);
    }
    log.notes.extend(damage.note());
    if rejected > 0 {
        log.notes.push(format!("{rejected} main frames without a sound one before them: skipped"));
    }
    log.topics = vec![main, slow, gps];
    Ok(log.finish())
}

fn topic(name: &str, parts: &[Part]) -> Topic {
    let mut topic = Topic::new(name, 0);
    topic.fields =
        parts.iter().filter(|part| part.name != "time").map(|part| Field::new(part.name.as_str())).collect();
    topic
}

fn push(topic: &mut Topic, parts: &[Part], values: &[i64], time_s: f64) {
    topic.time_s.push(time_s);
    let values = parts.iter().zip(values).filter(|(part, _)| part.name != "time");
    for (field, (_, &value)) in topic.fields.iter_mut().zip(values) {
        field.values.push(value as f64);
    }
}

/// What stood at a place.
enum Taken {
    Frame,
    /// A main frame that does not follow on the one before.
    OutOfOrder,
    End,
    Nothing,
}

impl Decoder<'_> {
    fn frame(
        &mut self,
        stream: &mut Stream,
        topics: &mut [Topic; 3],
        said: &mut Vec<(f64, String)>,
    ) -> Taken {
        let header = self.header;
        let Some(kind) = stream.byte() else { return Taken::Nothing };
        if kind == b'E' {
            return match event(stream) {
                Some(Event::End) => Taken::End,
                Some(_) if !at_frame(stream) => Taken::Nothing,
                Some(Event::Resumed { iteration, time }) => {
                    self.last = Some((iteration, self.unwrapped(time)));
                    Taken::Frame
                }
                Some(Event::Said(text)) => {
                    said.push((self.last_s().unwrap_or(0.0), text));
                    Taken::Frame
                }
                Some(Event::Silent) => Taken::Frame,
                None => Taken::Nothing,
            };
        }
        let parts = match kind {
            b'I' => &header.intra,
            b'P' => &header.inter,
            b'S' => &header.slow,
            b'G' => &header.gps,
            b'H' => &header.home,
            _ => return Taken::Nothing,
        };
        if parts.is_empty() {
            return Taken::Nothing;
        }
        let skipped = if kind == b'P' { self.skipped() } else { 0 };
        let Some(values) = self.decode(parts, &self.history, skipped, stream) else { return Taken::Nothing };
        if !at_frame(stream) {
            return Taken::Nothing;
        }
        let [main, slow, gps] = topics;
        match kind {
            b'S' => push(slow, parts, &values, self.last_s().unwrap_or(f64::NAN)),
            b'G' => {
                let now = parts.iter().position(|part| part.name == "time");
                let now = now
                    .and_then(|index| values.get(index))
                    .map(|&time| self.unwrapped(time as u32) as f64 / 1e6);
                push(gps, parts, &values, now.or(self.last_s()).unwrap_or(0.0));
            }
            b'H' => self.history.home = values,
            _ => {
                if kind == b'P' && self.history.previous.is_empty() {
                    return Taken::OutOfOrder;
                }
                let sound = self.follows(&values)
                    || (kind == b'I' && self.confirmed(&values, stream.bytes, stream.at));
                if !sound {
                    self.history.previous.clear();
                    return Taken::OutOfOrder;
                }
                self.last = Some((self.iteration_of(&values), self.unwrapped(values[self.time] as u32)));
                push(main, parts, &values, self.last_s().unwrap_or(0.0));
                remember(&mut self.history, values, kind);
            }
        }
        Taken::Frame
    }

    fn last_s(&self) -> Option<f64> {
        self.last.map(|(_, time)| time as f64 / 1e6)
    }

    /// The log's time (µs) beyond its 32 bits, which wrap after 71.6 min.
    fn unwrapped(&self, time: u32) -> i64 {
        self.last.map_or(i64::from(time), |(_, last)| last + i64::from(time.wrapping_sub(last as u32) as i32))
    }

    fn iteration_of(&self, values: &[i64]) -> u32 {
        self.iteration.and_then(|index| values.get(index)).map_or(0, |&value| value as u32)
    }

    fn follows(&self, values: &[i64]) -> bool {
        let Some((iteration, time)) = self.last else { return true };
        (values[self.time] as u32).wrapping_sub(time as u32) < LONGEST_STEP
            && self.iteration_of(values).wrapping_sub(iteration) < MOST_ITERATIONS
    }

    /// Whether the main frames after this one follow on it.
    fn confirmed(&self, values: &[i64], bytes: &[u8], at: usize) -> bool {
        let mut ahead = Decoder { history: self.history.clone(), ..*self };
        let mut stream = Stream { bytes, at };
        ahead.last = Some((ahead.iteration_of(values), values[ahead.time]));
        remember(&mut ahead.history, values.to_vec(), b'I');
        for _ in 0..CONFIRMING {
            let kind = stream.byte();
            let parts = match kind {
                Some(b'I') => &self.header.intra,
                Some(b'P') => &self.header.inter,
                Some(_) => return true,
                None => return false,
            };
            let skipped = ahead.skipped();
            let Some(values) = ahead.decode(parts, &ahead.history, skipped, &mut stream) else {
                return false;
            };
            if !at_frame(&stream) || !ahead.follows(&values) {
                return false;
            }
            ahead.last = Some((ahead.iteration_of(&values), values[ahead.time]));
            remember(&mut ahead.history, values, kind.unwrap_or_default());
        }
        true
    }

    /// Loop iterations after the last that are not logged.
    fn skipped(&self) -> i64 {
        let Some((last, _)) = self.last else { return 0 };
        let (intra, numerator, denominator) = self.interval;
        let logged = |iteration: i64| (iteration % intra + numerator - 1) % denominator < numerator;
        let most = denominator.min(SPARSEST);
        (0..most).take_while(|ahead| !logged(i64::from(last) + 1 + ahead)).count() as i64
    }

    fn decode(
        &self,
        parts: &[Part],
        history: &History,
        skipped: i64,
        stream: &mut Stream,
    ) -> Option<Vec<i64>> {
        let mut values: Vec<i64> = Vec::with_capacity(parts.len());
        while let Some(part) = parts.get(values.len()) {
            let at = values.len();
            let rest = parts.iter().skip(at).take(part.encoding.together());
            // The groups of three and four are always whole; only that of eight is cut by another encoding.
            let count = match part.encoding {
                Encoding::Tag8x8 => rest.take_while(|other| other.encoding == part.encoding).count(),
                _ => rest.len(),
            };
            let raw = part.encoding.read(stream, count)?;
            for (part, &raw) in parts[at..at + count].iter().zip(&raw) {
                let predicted = self.predict(part, values.len(), &values, history, skipped);
                let raw = if part.predictor == Predictor::Increment { 0 } else { raw };
                let sum = (predicted as u32).wrapping_add(raw as u32);
                values.push(if part.signed { i64::from(sum as i32) } else { i64::from(sum) });
            }
        }
        Some(values)
    }

    fn predict(&self, part: &Part, index: usize, values: &[i64], history: &History, skipped: i64) -> i64 {
        let previous = history.previous.get(index).copied().unwrap_or(0);
        let before = history.before.get(index).copied().unwrap_or(previous);
        match part.predictor {
            Predictor::Zero => 0,
            Predictor::Previous => previous,
            Predictor::StraightLine => 2 * previous - before,
            Predictor::Average2 => (previous + before) / 2,
            Predictor::MinThrottle => self.min_throttle,
            Predictor::Motor0 => self.motor.and_then(|motor| values.get(motor)).copied().unwrap_or(0),
            Predictor::Increment => previous + 1 + skipped,
            Predictor::HomeCoordinate => {
                history.home.get(usize::from(part.name.ends_with("[1]"))).copied().unwrap_or(0)
            }
            Predictor::Middle1500 => 1500,
            Predictor::BatteryReference => self.battery,
            Predictor::MainTime => history.previous.get(self.time).copied().unwrap_or(0),
            Predictor::MinMotor => self.min_motor,
        }
    }
}

fn remember(history: &mut History, values: Vec<i64>, kind: u8) {
    history.before = if kind == b'I' { values.clone() } else { std::mem::take(&mut history.previous) };
    history.previous = values;
}

fn at_frame(stream: &Stream) -> bool {
    stream.bytes.get(stream.at).is_none_or(|byte| KINDS.contains(byte))
}

enum Event {
    End,
    Resumed { iteration: u32, time: u32 },
    Said(String),
    Silent,
}

/// Reads an event after its `E`; `None` for one that is unknown or cut off.
fn event(stream: &mut Stream) -> Option<Event> {
    Some(match stream.byte()? {
        0 => {
            stream.unsigned()?;
            Event::Silent
        }
        13 => {
            let function = stream.byte()?;
            let value = if function & 0x80 == 0 {
                f64::from(stream.signed()?)
            } else {
                let value = f32::from_le_bytes(array(stream.bytes, stream.at)?);
                stream.at += 4;
                f64::from(value)
            };
            Event::Said(format!("adjustment {} set to {value} in flight", function & 0x7f))
        }
        14 => Event::Resumed { iteration: stream.unsigned()?, time: stream.unsigned()? },
        15 => Event::Said(format!("disarmed, reason {}", stream.unsigned()?)),
        30 => {
            let (now, before) = (stream.unsigned()?, stream.unsigned()?);
            Event::Said(format!("flight mode flags {now:#x}, before {before:#x}"))
        }
        40 => Event::Said(format!("IMU failure {}", stream.unsigned()?)),
        255 => {
            const END: &[u8] = b"End of log";
            let rest = stream.bytes.get(stream.at..)?;
            rest.starts_with(END).then_some(Event::End)?
        }
        _ => return None,
    })
}
