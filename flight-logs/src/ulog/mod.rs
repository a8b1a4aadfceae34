//! PX4 ULog: <https://docs.px4.io/main/en/dev_log/ulog_file_format.html>, versions 0 and 1.
//!
//! A header of 16 bytes, then messages: length u16, type u8, body; all little endian. Subscriptions (`A`) give a number
//! to a format (`F`) and an instance; data (`D`) carry that number. There are no checksums: a message is taken where
//! its type is known and its length fits, and after damage reading goes on where four such messages follow each other.

mod formats;

use std::collections::HashMap;
use std::io::Read;
use std::rc::Rc;

use crate::bytes::{Number, array, text};
use crate::damage::Damage;
use crate::{Error, Field, Format, Known, Log, Place, Topic};
use formats::{Formats, Layout};

/// The first bytes of a ULog file; its version follows.
pub(crate) const MAGIC: [u8; 7] = *b"ULog\x01\x12\x35";
const HEADER: usize = 16;
/// Where the body of the message of flags begins, if there is one, and where it ends.
const FLAGS: usize = HEADER + 3;
const FLAGS_END: usize = FLAGS + 40;
const SYNC: [u8; 8] = [0x2f, 0x73, 0x13, 0x20, 0x25, 0x0c, 0xbb, 0x12];
/// The colon after the name of a format comes before this.
const LONGEST_NAME: usize = 256;
/// Messages in a row that tell order from damage.
const CHAIN: usize = 4;
/// Bytes that so many messages have at most: what has to be in memory beyond the message that is read.
const AHEAD: usize = CHAIN * (3 + u16::MAX as usize);
/// Bytes that are read at once.
const BLOCK: usize = 1 << 22;

/// Reads a ULog file from its start; of the file a block is in memory at a time.
pub(crate) fn read(source: &mut impl Read) -> Result<Log, Error> {
    let mut start = Vec::with_capacity(FLAGS_END);
    fill(source, &mut start, FLAGS_END)?;
    if start.len() < HEADER {
        let found = format!("a ULog that ends after {} bytes", start.len());
        return Err(
            Error::new(found, "log again: nothing was written").expecting("a ULog header of 16 bytes")
        );
    }
    let mut reader = Reader::default();
    let mut ends = appended(&start)?;
    ends.push(usize::MAX);
    let mut window = Window { bytes: start.split_off(HEADER), offset: HEADER };
    reader.fields_left = HEADER + window.bytes.len();
    for end in ends {
        reader.section(source, &mut window, end)?;
    }
    reader.finish()
}

/// Adds up to `count` bytes; fewer at the end of the source.
fn fill(source: &mut impl Read, bytes: &mut Vec<u8>, count: usize) -> Result<usize, Error> {
    let read = source.take(count as u64).read_to_end(bytes);
    read.map_err(|error| Error::from_io("", &error))
}

/// Where the parts written after a crash begin, in order; `start` holds the header and the message of flags.
fn appended(start: &[u8]) -> Result<Vec<usize>, Error> {
    if start.get(HEADER + 2) != Some(&b'B') || start.len() < FLAGS_END {
        return Ok(Vec::new());
    }
    let flags: [u8; 8] = array(start, FLAGS + 8).unwrap_or_default();
    if flags[0] & !1 != 0 || flags[1..] != [0; 7] {
        return Err(Error::new(
            format!("incompatible flags {flags:02x?}"),
            "read the log with a newer version of this program",
        )
        .at(Place::Offset(FLAGS + 8))
        .expecting("none but appended data (01)"));
    }
    let offsets = (0..3).filter_map(|i| Some(u64::from_le_bytes(array(start, FLAGS + 16 + 8 * i)?)));
    let mut offsets: Vec<usize> = offsets
        .filter_map(|offset| usize::try_from(offset).ok())
        .filter(|&offset| offset > FLAGS_END && flags[0] & 1 == 1)
        .collect();
    offsets.sort_unstable();
    Ok(offsets)
}

/// The part of the file that is in memory.
struct Window {
    bytes: Vec<u8>,
    /// Where in the file it begins.
    offset: usize,
}

/// A subscription; its topic comes to be with its first row.
struct Source {
    name: String,
    instance: u8,
    layout: Rc<Layout>,
    topic: Option<usize>,
}

#[derive(Default)]
struct Reader {
    formats: Formats,
    layouts: HashMap<String, Option<Rc<Layout>>>,
    /// Fields that further layouts may have: fewer than bytes read, as in every log with a row each.
    fields_left: usize,
    sources: HashMap<u16, Source>,
    topics: Vec<Topic>,
    log: Option<Log>,
    known: Known,
    last_s: f64,
    dropouts_ms: Vec<u16>,
    damage: Damage,
    messages: usize,
    unusable: Vec<String>,
}

impl Reader {
    /// Reads the messages up to `end`, an offset in the file.
    fn section(&mut self, source: &mut impl Read, window: &mut Window, end: usize) -> Result<(), Error> {
        loop {
            let missing = end.saturating_sub(window.offset + window.bytes.len()).min(BLOCK);
            let read = fill(source, &mut window.bytes, missing)?;
            self.fields_left += read;
            let here = end.saturating_sub(window.offset).min(window.bytes.len());
            let last = read < missing || window.offset + here == end;
            let bytes = window.bytes.get(..here).unwrap_or_default();
            let sure = if last { here } else { here.saturating_sub(AHEAD) };
            let taken = self.messages_of(bytes, sure, window.offset);
            window.bytes.drain(..taken);
            window.offset += taken;
            if last {
                return Ok(());
            }
        }
    }

    /// Takes the messages that begin before `sure`, and says where the next one begins.
    fn messages_of(&mut self, bytes: &[u8], sure: usize, offset: usize) -> usize {
        let mut at = 0;
        while at < sure {
            if let Some(next) = self.next(bytes, at) {
                self.message(bytes[at + 2], &bytes[at + 3..next]);
                self.messages += 1;
                at = next;
            } else {
                let next = (at + 1..sure).find(|&from| self.chain(bytes, from)).unwrap_or(sure);
                self.damage.skip(offset + at, next - at);
                at = next;
            }
        }
        at
    }

    /// The end of the message at `at`, if it can be one.
    fn next(&self, bytes: &[u8], at: usize) -> Option<usize> {
        let size = usize::from(u16::from_le_bytes(array(bytes, at)?));
        let body = bytes.get(at + 3..at + 3 + size)?;
        let good = match bytes[at + 2] {
            b'D' => {
                let source = self.sources.get(&u16::from_le_bytes(array(body, 0)?))?;
                (source.layout.shortest + 2..=source.layout.longest + 2).contains(&size)
            }
            b'S' => body == SYNC,
            b'O' => size == 2,
            b'R' => size == 2,
            b'L' => size >= 9,
            b'C' => size >= 11,
            b'A' => self.formats.contains(body.get(3..)?),
            b'B' => size >= 40,
            b'F' => body.iter().take(LONGEST_NAME).any(|&byte| byte == b':'),
            b'I' | b'P' => key_value(body, 0).is_some(),
            b'M' | b'Q' => key_value(body, 1).is_some(),
            _ => false,
        };
        good.then_some(at + 3 + size)
    }

    fn chain(&self, bytes: &[u8], from: usize) -> bool {
        let mut at = from;
        for _ in 0..CHAIN {
            match self.next(bytes, at) {
                Some(next) => at = next,
                None => return false,
            }
            if at == bytes.len() {
                return true;
            }
        }
        true
    }

    fn message(&mut self, kind: u8, body: &[u8]) {
        match kind {
            b'D' => self.data(body),
            b'F' => self.formats.define(&text(body)),
            b'A' => self.subscribe(body),
            b'R' => {
                self.sources.remove(&u16::from_le_bytes(array(body, 0).unwrap_or_default()));
            }
            b'P' => {
                if let Some((of, name, value)) = key_value(body, 0) {
                    let number = if of == "int32_t" { Number::I32 } else { Number::F32 };
                    if let Some(value) = number.read(value, 0) {
                        let log = self.log.get_or_insert_with(|| Log::new(Format::ULog));
                        log.set_parameter(self.last_s, name, value, &mut self.known);
                    }
                }
            }
            b'I' | b'M' => self.info(kind, body),
            b'L' => self.said(body, 1, 9),
            b'C' => self.said(body, 3, 11),
            b'O' => {
                let lost = u16::from_le_bytes(array(body, 0).unwrap_or_default());
                self.dropouts_ms.push(lost);
                self.say(self.last_s, format!("dropout: {lost} ms were not logged"));
            }
            _ => {}
        }
    }

    fn say(&mut self, time_s: f64, text: String) {
        self.log.get_or_insert_with(|| Log::new(Format::ULog)).messages.push((time_s, text));
    }

    fn said(&mut self, body: &[u8], time: usize, words: usize) {
        let time_s = Number::U64.read(body, time).unwrap_or_default() / 1e6;
        self.say(time_s, text(body.get(words..).unwrap_or_default()));
    }

    fn info(&mut self, kind: u8, body: &[u8]) {
        let skip = usize::from(kind == b'M');
        let Some((of, key, value)) = key_value(body, skip) else { return };
        let shown = match formats::number(of) {
            Some(number) => number.read(value, 0).map(|value| value.to_string()).unwrap_or_default(),
            None => text(value),
        };
        let log = self.log.get_or_insert_with(|| Log::new(Format::ULog));
        let continued = kind == b'M' && body.first() == Some(&1);
        match log.info.last_mut() {
            Some((last, text)) if continued && last == key => text.push_str(&shown),
            _ => log.info.push((key.to_owned(), shown)),
        }
    }

    fn subscribe(&mut self, body: &[u8]) {
        let (Some(&instance), Some(id)) = (body.first(), array(body, 1)) else { return };
        let name = text(body.get(3..).unwrap_or_default());
        match self.layout(&name) {
            Some(layout) => {
                self.sources.insert(u16::from_le_bytes(id), Source { name, instance, layout, topic: None });
            }
            None if self.unusable.contains(&name) => {}
            None => self.unusable.push(name),
        }
    }

    fn layout(&mut self, name: &str) -> Option<Rc<Layout>> {
        if let Some(layout) = self.layouts.get(name) {
            return layout.clone();
        }
        let layout = self.formats.layout(name, self.fields_left).map(Rc::new);
        if let Some(layout) = &layout {
            self.fields_left -= layout.fields.len();
        }
        self.layouts.insert(name.to_owned(), layout.clone());
        layout
    }

    fn data(&mut self, body: &[u8]) {
        let id = u16::from_le_bytes(array(body, 0).unwrap_or_default());
        let Some(source) = self.sources.get_mut(&id) else { return };
        let body = body.get(2..).unwrap_or_default();
        if let Some(time_us) = source.layout.time.and_then(|time| time.number.read(body, time.at)) {
            self.last_s = time_us / 1e6;
        }
        let same = |topic: &Topic| topic.name == source.name && topic.instance == source.instance;
        let index = source.topic.or_else(|| self.topics.iter().position(same)).unwrap_or_else(|| {
            let mut topic = Topic::new(source.name.as_str(), source.instance);
            topic.fields = source.layout.fields.iter().map(|part| Field::new(part.name.as_str())).collect();
            self.topics.push(topic);
            self.topics.len() - 1
        });
        source.topic = Some(index);
        let topic = &mut self.topics[index];
        topic.time_s.push(self.last_s);
        for (field, part) in topic.fields.iter_mut().zip(&source.layout.fields) {
            field.values.push(part.number.read(body, part.at).unwrap_or(f64::NAN));
        }
    }

    fn finish(self) -> Result<Log, Error> {
        let mut log = self.log.unwrap_or_else(|| Log::new(Format::ULog));
        if self.messages == 0 {
            return Err(Error::new("no message can be read", "log again: nothing but a header was written")
                .at(Place::Offset(HEADER))
                .expecting("ULog messages"));
        }
        log.topics = self.topics;
        log.vehicle = log.info("ver_hw").map(str::to_owned);
        log.firmware = firmware(&log);
        log.notes.extend(self.damage.note());
        if let Some(longest) = self.dropouts_ms.iter().max() {
            let total: u64 = self.dropouts_ms.iter().map(|&ms| u64::from(ms)).sum();
            let count = self.dropouts_ms.len();
            log.notes.push(format!("{count} dropouts: {total} ms were not logged, the longest {longest} ms"));
        }
        if !self.unusable.is_empty() {
            log.notes.push(format!("topics without a usable format: {}", self.unusable.join(", ")));
        }
        Ok(log.finish())
    }
}

/// Type, name and value of a body that starts with `skip` bytes, the length of "type name" and that text.
fn key_value(body: &[u8], skip: usize) -> Option<(&str, &str, &[u8])> {
    let length = usize::from(*body.get(skip)?);
    let key = std::str::from_utf8(body.get(skip + 1..skip + 1 + length)?).ok()?;
    let (of, name) = key.split_once(' ')?;
    (!name.is_empty()).then_some((of, name, body.get(skip + 1 + length..)?))
}

/// "PX4 v1.15.1 (hash)": the release is coded in one number, 0xMMmmpptt.
fn firmware(log: &Log) -> Option<String> {
    let system = log.info("sys_name").unwrap_or("PX4");
    let release = log.info("ver_sw_release").and_then(|text| text.parse::<u32>().ok());
    let version = release.filter(|&code| code != 0).map(|code| {
        let [major, minor, patch, _] = code.to_be_bytes();
        format!(" v{major}.{minor}.{patch}")
    });
    let hash = log.info("ver_sw").map(|hash| format!(" ({})", hash.chars().take(10).collect::<String>()));
    (version.is_some() || hash.is_some())
        .then(|| format!("{system}{}{}", version.unwrap_or_default(), hash.unwrap_or_default()))
}
