//! Rows of a DataFlash log, gathered into topics.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use super::formats::{ARRAY, Column, Definition, Kind};
use crate::bytes::{Number, text};
use crate::{Field, Format, Known, Log, Topic};

/// A topic in the making.
struct Rows {
    topic: Topic,
    /// For rows without a time stamp, their place among all messages.
    places: Vec<usize>,
}

impl Rows {
    fn new(definition: &Definition) -> Self {
        let mut topic = Topic::new(definition.name.as_str(), 0);
        topic.fields = definition.channels().flat_map(|(_, column)| fields(column)).collect();
        Self { topic, places: Vec::new() }
    }

    fn push(&mut self, definition: &Definition, body: &Body, time_s: f64, place: Option<usize>) {
        self.topic.time_s.push(time_s);
        self.places.extend(place);
        let mut fields = self.topic.fields.iter_mut();
        for (index, column) in definition.channels() {
            let width = match column.kind {
                Kind::Number(..) => 1,
                Kind::Array => ARRAY,
                Kind::Text(_) => 0,
            };
            for (i, field) in fields.by_ref().take(width).enumerate() {
                field.values.push(match column.kind {
                    Kind::Array => body.element(column, i),
                    _ => body.number(index, column),
                });
            }
        }
    }
}

/// What `FMTU` says of a type: a character for each column.
struct Units {
    units: Vec<u8>,
    multipliers: Vec<u8>,
}

/// The values of a message.
enum Body<'a> {
    Binary(&'a [u8]),
    Cells(&'a [&'a str]),
}

impl Body<'_> {
    fn number(&self, index: usize, column: &Column) -> f64 {
        match (self, column.kind) {
            (Self::Binary(body), Kind::Number(number, factor)) => {
                number.read(body, column.at).map_or(f64::NAN, |value| value * factor)
            }
            (Self::Cells(cells), _) => {
                cells.get(index).and_then(|cell| cell.parse().ok()).unwrap_or(f64::NAN)
            }
            _ => f64::NAN,
        }
    }

    fn text(&self, index: usize, column: &Column) -> String {
        match (self, column.kind) {
            (Self::Binary(body), Kind::Text(length)) => {
                text(body.get(column.at..column.at + length).unwrap_or_default())
            }
            (Self::Cells(cells), _) => cells.get(index).copied().unwrap_or_default().to_owned(),
            _ => String::new(),
        }
    }

    fn element(&self, column: &Column, i: usize) -> f64 {
        match self {
            Self::Binary(body) => Number::I16.read(body, column.at + 2 * i).unwrap_or(f64::NAN),
            Self::Cells(_) => f64::NAN,
        }
    }
}

pub(super) struct Collector {
    log: Log,
    definitions: HashMap<u8, Rc<Definition>>,
    rows: HashMap<u8, Rows>,
    units: HashMap<u8, Units>,
    labels: HashMap<u8, String>,
    multipliers: HashMap<u8, f64>,
    known: Known,
    /// Place among all messages, and time, of those that carry one.
    stamps: Vec<(usize, f64)>,
    messages: usize,
    unusable: Vec<String>,
}

impl Collector {
    pub(super) fn new(format: Format) -> Self {
        Self {
            log: Log::new(format),
            definitions: HashMap::new(),
            rows: HashMap::new(),
            units: HashMap::new(),
            labels: HashMap::new(),
            multipliers: HashMap::new(),
            known: Known::new(),
            stamps: Vec::new(),
            messages: 0,
            unusable: Vec::new(),
        }
    }

    pub(super) fn definition(&self, kind: u8) -> Option<&Definition> {
        self.definitions.get(&kind).map(Rc::as_ref)
    }

    /// Takes in a definition; one that differs from the type's first is left out, for the rows so far follow that.
    pub(super) fn define(&mut self, kind: u8, definition: Definition) {
        let usable = definition.usable || self.log.format == Format::DataFlashText;
        if !usable && !self.unusable.contains(&definition.name) {
            self.unusable.push(definition.name.clone());
        }
        self.definitions.entry(kind).or_insert_with(|| Rc::new(definition));
    }

    /// Takes in a binary message without head and type.
    pub(super) fn binary(&mut self, kind: u8, body: &[u8]) {
        let known = self.definitions.get(&kind).filter(|definition| definition.usable);
        if let Some(definition) = known.map(Rc::clone) {
            self.message(kind, &definition, &Body::Binary(body));
        }
    }

    /// Takes in the values of a line; false where they do not fit the definition.
    pub(super) fn line(&mut self, name: &str, rest: &str) -> bool {
        let found = self.definitions.iter().find(|(_, definition)| definition.name == name);
        let Some((&kind, definition)) = found else { return false };
        let definition = Rc::clone(definition);
        let columns = definition.columns.len();
        // Text at the end may hold commas.
        let cells: Vec<&str> = rest.splitn(columns.max(1), ',').map(str::trim).collect();
        if cells.len() != columns {
            return columns == 0;
        }
        self.message(kind, &definition, &Body::Cells(&cells));
        true
    }

    fn message(&mut self, kind: u8, definition: &Definition, body: &Body) {
        self.messages += 1;
        let column =
            |name: &str| definition.columns.iter().enumerate().find(|(_, column)| column.name == name);
        let number = |name: &str| column(name).map(|(index, column)| body.number(index, column));
        let words = |name: &str| column(name).map(|(index, column)| body.text(index, column));
        let time = definition.time;
        let time_s = time.map_or(f64::NAN, |(index, per_second)| {
            body.number(index, &definition.columns[index]) / per_second
        });
        if time_s.is_finite() {
            self.stamps.push((self.messages, time_s));
        }
        let now = self.stamps.last().map_or(0.0, |&(_, time_s)| time_s);
        match definition.name.as_str() {
            "PARM" => {
                if let (Some(name), Some(value)) = (words("Name"), number("Value")) {
                    self.log.set_parameter(now, &name, value, &mut self.known);
                }
            }
            "MSG" => self.log.messages.extend(words("Message").map(|words| (now, words))),
            "UNIT" => {
                if let (Some(id), Some(label)) = (number("Id"), words("Label")) {
                    self.labels.insert(id as u8, label);
                }
            }
            "MULT" => {
                if let (Some(id), Some(factor)) = (number("Id"), number("Mult")) {
                    self.multipliers.insert(id as u8, factor);
                }
            }
            "FMTU" => {
                if let (Some(of), Some(units), Some(multipliers)) =
                    (number("FmtType"), words("UnitIds"), words("MultIds"))
                {
                    let units = Units { units: units.into(), multipliers: multipliers.into() };
                    self.units.insert(of as u8, units);
                }
            }
            "FMT" => {}
            _ => {
                let place = (!time_s.is_finite()).then_some(self.messages);
                let rows = self.rows.entry(kind).or_insert_with(|| Rows::new(definition));
                rows.push(definition, body, now, place);
            }
        }
    }

    /// The log, if it holds any message.
    pub(super) fn finish(mut self) -> Option<Log> {
        if self.messages == 0 {
            return None;
        }
        let mut unstamped: Vec<String> = Vec::new();
        for (kind, mut rows) in std::mem::take(&mut self.rows) {
            if rows.places.len() == rows.topic.time_s.len() {
                rows.topic.time_s = rows.places.iter().map(|&place| self.time_at(place)).collect();
                unstamped.push(rows.topic.name.clone());
            }
            let instance = self.name_units(kind, &mut rows.topic);
            split(rows.topic, instance, &mut self.log.topics);
        }
        unstamped.sort();
        if !unstamped.is_empty() {
            self.log.notes.push(format!(
                "{} without time stamps: their times are spread between those of the messages around them",
                unstamped.join(", ")
            ));
        }
        if !self.unusable.is_empty() {
            self.log.notes.push(format!("messages without a usable format: {}", self.unusable.join(", ")));
        }
        let stack = |text: &&str| {
            ["Ardu", "APM:", "Rover", "Blimp", "AntennaTracker"].iter().any(|name| text.starts_with(name))
        };
        let mut said = self.log.messages.iter().map(|(_, text)| text.as_str());
        self.log.firmware = said.clone().find(stack).map(str::to_owned);
        self.log.vehicle = said.find(|text| text.starts_with("Frame: ")).map(|text| text[7..].to_owned());
        Some(self.log.finish())
    }

    /// The time of the message at `place`, linear between the stamps around it.
    fn time_at(&self, place: usize) -> f64 {
        let after = self.stamps.partition_point(|&(stamp, _)| stamp < place);
        let before = after.checked_sub(1).and_then(|index| self.stamps.get(index));
        match (before, self.stamps.get(after)) {
            (Some(&(a, from)), Some(&(b, to))) => {
                from + (to - from) * (place - a) as f64 / (b - a).max(1) as f64
            }
            (Some(&(_, time_s)), None) | (None, Some(&(_, time_s))) => time_s,
            (None, None) => 0.0,
        }
    }

    /// Gives the fields their units; the field that tells instances apart, if there is one.
    fn name_units(&self, kind: u8, topic: &mut Topic) -> Option<usize> {
        let units = self.units.get(&kind)?;
        let definition = self.definitions.get(&kind)?;
        let mut instance = None;
        for (index, column) in definition.columns.iter().enumerate() {
            let Some(&unit) = units.units.get(index) else { continue };
            let first = match column.kind {
                Kind::Array => format!("{}[0]", column.name),
                _ => column.name.clone(),
            };
            let Some(at) = topic.fields.iter().position(|field| field.name == first) else { continue };
            if unit == b'#' {
                instance = Some(at);
                continue;
            }
            let label = self.labels.get(&unit).filter(|label| !label.is_empty());
            let scaled = matches!(column.kind, Kind::Number(_, factor) if factor != 1.0);
            let multiplier = units.multipliers.get(index).and_then(|id| self.multipliers.get(id)).copied();
            let unit = label.map(|label| match multiplier {
                Some(factor) if !scaled && factor != 0.0 && factor != 1.0 => format!("{factor} {label}"),
                _ => label.clone(),
            });
            let width = if column.kind == Kind::Array { ARRAY } else { 1 };
            for field in topic.fields.iter_mut().skip(at).take(width) {
                field.unit.clone_from(&unit);
            }
        }
        instance
    }
}

fn fields(column: &Column) -> Vec<Field> {
    match column.kind {
        Kind::Number(..) => vec![Field::new(column.name.as_str())],
        Kind::Array => (0..ARRAY).map(|i| Field::new(format!("{}[{i}]", column.name))).collect(),
        Kind::Text(_) => Vec::new(),
    }
}

/// One topic for each value of the field `instance`, which goes.
fn split(mut topic: Topic, instance: Option<usize>, topics: &mut Vec<Topic>) {
    let Some(index) = instance else {
        topics.push(topic);
        return;
    };
    let of = topic.fields.remove(index).values;
    let mut parts: BTreeMap<u8, Topic> = BTreeMap::new();
    for (row, (&of, &time_s)) in of.iter().zip(&topic.time_s).enumerate() {
        let part = parts.entry(of as u8).or_insert_with(|| {
            let mut part = Topic::new(topic.name.as_str(), of as u8);
            part.fields =
                topic.fields.iter().map(|field| Field { values: Vec::new(), ..field.clone() }).collect();
            part
        });
        part.time_s.push(time_s);
        for (field, whole) in part.fields.iter_mut().zip(&topic.fields) {
            field.values.extend(whole.values.get(row));
        }
    }
    topics.extend(parts.into_values());
}
