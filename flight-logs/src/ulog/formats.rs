//! What a ULog message holds: "name:type field;type[length] field;", where a type may be another message.

use std::collections::HashMap;

use crate::bytes::Number;

/// A message's body is shorter than this, and so every field's offset.
const LONGEST: usize = u16::MAX as usize;
/// Messages within messages; PX4 nests twice.
const DEEPEST: usize = 8;
/// Characters in the name of a field; those of PX4 have up to 40.
const LONGEST_NAME: usize = 128;

/// A number of a message.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    pub(super) name: String,
    pub(super) number: Number,
    pub(super) at: usize,
}

/// Where in a message its numbers are.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Layout {
    /// All numbers but the time; neither text nor padding.
    pub(super) fields: Vec<Part>,
    /// `timestamp`, µs.
    pub(super) time: Option<TimeField>,
    /// Bytes up to the end of the last field that is no padding: loggers leave out padding at the end.
    pub(super) shortest: usize,
    /// Bytes of all fields.
    pub(super) longest: usize,
}

/// The time stamp of a message.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TimeField {
    pub(super) number: Number,
    pub(super) at: usize,
}

/// Everything that was defined so far.
#[derive(Debug, Default)]
pub(super) struct Formats(HashMap<String, Vec<Member>>);

#[derive(Debug)]
struct Member {
    of: String,
    count: Option<usize>,
    name: String,
}

/// The number that a type of ULog stands for; `None` for text and nested messages.
pub(super) fn number(of: &str) -> Option<Number> {
    Some(match of {
        "int8_t" => Number::I8,
        "uint8_t" | "bool" => Number::U8,
        "int16_t" => Number::I16,
        "uint16_t" => Number::U16,
        "int32_t" => Number::I32,
        "uint32_t" => Number::U32,
        "int64_t" => Number::I64,
        "uint64_t" => Number::U64,
        "float" => Number::F32,
        "double" => Number::F64,
        _ => return None,
    })
}

impl Formats {
    /// Whether a message of this name was defined.
    pub(super) fn contains(&self, name: &[u8]) -> bool {
        std::str::from_utf8(name).is_ok_and(|name| self.0.contains_key(name))
    }

    /// Takes in one definition, the first of its name; one that makes no sense is left out, and with it what needs it.
    pub(super) fn define(&mut self, format: &str) {
        let Some((name, members)) = format.split_once(':') else { return };
        let members = members.split(';').filter(|member| !member.is_empty()).map(|member| {
            let (of, name) = member.split_once(' ')?;
            let (of, count) = match of.split_once('[') {
                Some((of, count)) => (of, Some(count.strip_suffix(']')?.parse().ok()?)),
                None => (of, None),
            };
            if name.len() > LONGEST_NAME {
                return None;
            }
            Some(Member { of: of.to_owned(), count, name: name.to_owned() })
        });
        if let Some(members) = members.collect() {
            self.0.entry(name.to_owned()).or_insert(members);
        }
    }

    /// The layout of a message of up to `most` fields; `None` where a type is unknown or the message too long.
    pub(super) fn layout(&self, name: &str, most: usize) -> Option<Layout> {
        let mut layout = Layout::default();
        self.add(name, "", (0, most), &mut layout)?;
        Some(layout)
    }

    fn add(
        &self,
        name: &str,
        prefix: &str,
        (depth, most): (usize, usize),
        layout: &mut Layout,
    ) -> Option<()> {
        if depth > DEEPEST {
            return None;
        }
        for member in self.0.get(name)? {
            let padding = member.name.starts_with("_padding");
            let count = member.count.unwrap_or(1);
            let fields = most - layout.fields.len();
            if count > LONGEST || (count > fields && number(&member.of).is_some() && !padding) {
                return None;
            }
            for index in 0..count {
                let name = match member.count {
                    Some(_) => format!("{prefix}{}[{index}]", member.name),
                    None => format!("{prefix}{}", member.name),
                };
                let at = layout.longest;
                match number(&member.of) {
                    Some(number) => {
                        layout.longest += number.size();
                        if name == "timestamp" {
                            layout.time = Some(TimeField { number, at });
                        } else if !padding {
                            layout.fields.push(Part { name, number, at });
                        }
                    }
                    None if member.of == "char" => layout.longest += 1,
                    None => {
                        self.add(&member.of, &format!("{name}."), (depth + 1, most), layout)?;
                        // A message of no bytes could be repeated for ever.
                        if layout.longest == at {
                            return None;
                        }
                    }
                }
                if layout.longest > LONGEST || layout.fields.len() > most {
                    return None;
                }
                if !padding {
                    layout.shortest = layout.longest;
                }
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nested_arrays_and_padding() {
        let mut formats = Formats::default();
        formats.define("inner:uint8_t a;float[2] b;");
        formats.define("outer:uint64_t timestamp;inner[2] in;char[3] text;uint8_t[2] _padding0;");
        let layout = formats.layout("outer", 100).unwrap();
        let fields: Vec<(&str, usize)> = layout.fields.iter().map(|p| (p.name.as_str(), p.at)).collect();
        let expected = [("in[0].a", 8), ("in[0].b[0]", 9), ("in[0].b[1]", 13), ("in[1].a", 17)];
        assert_eq!(fields[..4], expected);
        assert_eq!((layout.shortest, layout.longest), (29, 31));
        assert_eq!(layout.time, Some(TimeField { number: Number::U64, at: 0 }));
    }

    #[test]
    fn formats_without_end_are_refused() {
        let mut formats = Formats::default();
        formats.define("self:self[9999999999] s;");
        formats.define("empty:");
        formats.define("many:empty[4000000000] e;");
        formats.define("long:double[60000] d;");
        formats.define("odd:float[-1] x;");
        for name in ["self", "many", "long", "odd", "absent"] {
            assert_eq!(formats.layout(name, usize::MAX), None, "{name}");
        }
        assert_eq!(formats.layout("empty", 0), Some(Layout::default()));
    }
}
