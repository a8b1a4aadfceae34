//! TOML files as people write them: each key with its line, each value that cannot be with what is legal, and all that is wrong
//! with a file at once.

use crate::error::{Error, ErrorKind, nearest};
use crate::legal::Legal;
use std::cell::RefCell;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The text of a file, and what is wrong with it.
pub struct Source<'t> {
    text: &'t str,
    /// Where each line begins.
    starts: Vec<usize>,
    wrong: RefCell<Vec<Error>>,
}

/// A table of a file.
#[derive(Clone, Copy)]
pub struct Table<'s> {
    source: &'s Source<'s>,
    entries: &'s DeTable<'s>,
    /// Where it begins, counted from 1.
    pub line: usize,
}

/// A key with its value.
#[derive(Clone, Copy)]
pub struct Entry<'s> {
    source: &'s Source<'s>,
    /// The key.
    pub key: &'s str,
    value: &'s Spanned<DeValue<'s>>,
    /// Its line, counted from 1.
    pub line: usize,
}

impl<'t> Source<'t> {
    /// Of a text; a mark of the byte order before it is passed over.
    pub fn new(text: &'t str) -> Self {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(end, _)| end + 1)).collect();
        Self { text, starts, wrong: RefCell::default() }
    }

    /// The document.
    ///
    /// # Errors
    /// No TOML, with the line; `advice` says what to write.
    pub fn document(&self, advice: &str) -> Result<Spanned<DeTable<'t>>, Error> {
        DeTable::parse(self.text).map_err(|error| {
            let found = error.message().trim().replace('\n', ", ");
            let line = self.line(error.span().map_or(0, |span| span.start));
            Error::new(ErrorKind::Model, found, advice).at_line(line)
        })
    }

    /// The outermost table of the document.
    pub fn root<'s>(&'s self, document: &'s Spanned<DeTable<'s>>) -> Table<'s> {
        Table { source: self, entries: document.get_ref(), line: 1 }
    }

    /// Keeps what is wrong at a key of `line` until [`Self::finish`].
    pub fn refuse(&self, line: usize, key: &str, found: impl Into<Box<str>>, advice: &str) {
        self.keep(wrong(line, key, found, advice));
    }

    /// The same, with what is legal.
    pub fn expect(
        &self,
        line: usize,
        key: &str,
        found: impl Into<Box<str>>,
        legal: impl Into<Box<str>>,
        advice: &str,
    ) {
        self.keep(wrong(line, key, found, advice).expecting(legal));
    }

    /// Keeps an error until [`Self::finish`].
    pub fn keep(&self, error: Error) {
        self.wrong.borrow_mut().push(error);
    }

    /// Whether anything is wrong so far.
    pub fn refused(&self) -> bool {
        !self.wrong.borrow().is_empty()
    }

    /// `value` where nothing was wrong.
    ///
    /// # Errors
    /// What was, in order of the lines.
    pub fn finish<T>(&self, value: Option<T>) -> Result<T, Error> {
        let mut wrong = self.wrong.take();
        wrong.sort_by_key(|error| error.line);
        let count = wrong.len();
        match (Error::of_several(wrong, count), value) {
            (None, Some(value)) => Ok(value),
            (Some(error), _) => Err(error),
            (None, None) => {
                Err(Error::new(ErrorKind::Model, "nothing that can be used", "see docs/formats.md"))
            }
        }
    }

    fn line(&self, offset: usize) -> usize {
        self.starts.partition_point(|start| *start <= offset).max(1)
    }

    /// A value as it stands in the file, on one short line.
    fn as_written(&self, span: Range<usize>) -> String {
        const LONGEST: usize = 40;
        let text = self.text.get(span).unwrap_or_default();
        let mut shown: String =
            text.chars().take(LONGEST).map(|c| if c.is_control() { ' ' } else { c }).collect();
        if text.chars().nth(LONGEST).is_some() {
            shown.push('…');
        }
        shown
    }
}

fn wrong(line: usize, key: &str, found: impl Into<Box<str>>, advice: &str) -> Error {
    Error::new(ErrorKind::Model, found, advice).at_line(line).in_column(key)
}

impl<'s> Table<'s> {
    /// Its entries, in the order of their keys.
    pub fn entries(&self) -> impl Iterator<Item = Entry<'s>> + use<'s> {
        let source = self.source;
        self.entries.iter().map(move |(key, value)| Entry {
            source,
            key: key.get_ref(),
            value,
            line: source.line(key.span().start),
        })
    }

    /// The entry of `key`.
    pub fn get(&self, key: &str) -> Option<Entry<'s>> {
        self.entries().find(|entry| entry.key == key)
    }

    /// Refuses every key that is not one of `known`.
    pub fn only(&self, known: &[&str]) {
        for Entry { key, line, .. } in self.entries().filter(|entry| !known.contains(&entry.key)) {
            let legal = format!("one of {}", nearest(known.iter().copied(), key));
            self.source.expect(line, key, "unknown key", legal, "correct the key or delete the line");
        }
    }

    /// The number of `key`, where it is there and legal.
    pub fn number(&self, key: &str, legal: &Legal) -> Option<f64> {
        self.get(key)?.number(legal)
    }

    /// The number of `key`, which must be there.
    pub fn needed(&self, key: &str, legal: &Legal) -> Option<f64> {
        if self.get(key).is_none() {
            self.source.expect(self.line, key, "missing", legal.to_string(), "add the key");
        }
        self.number(key, legal)
    }

    /// The text of `key`; `legal` says what belongs there.
    pub fn text(&self, key: &str, legal: &str) -> Option<&'s str> {
        self.get(key)?.text(legal)
    }

    /// The table of `key`.
    pub fn table(&self, key: &str) -> Option<Self> {
        self.get(key)?.table()
    }
}

impl<'s> Entry<'s> {
    /// Its number, where it is legal.
    pub fn number(&self, legal: &Legal) -> Option<f64> {
        let number = number(self.value.get_ref()).filter(|value| legal.holds(*value));
        if number.is_none() {
            self.refuse(&legal.to_string());
        }
        number
    }

    /// Its text.
    pub fn text(&self, legal: &str) -> Option<&'s str> {
        let text = self.value.get_ref().as_str();
        if text.is_none() {
            self.refuse(&format!("{legal}, in quotes"));
        }
        text
    }

    /// Its table.
    pub fn table(&self) -> Option<Table<'s>> {
        let table = self.value.get_ref().as_table();
        if table.is_none() {
            self.refuse(&format!("a section [{}] with keys of its own", self.key));
        }
        table.map(|entries| Table { source: self.source, entries, line: self.line })
    }

    /// Its tables, `[[key]]`.
    pub fn tables(&self) -> Vec<Table<'s>> {
        let Some(array) = self.value.get_ref().as_array() else {
            self.refuse(&format!("sections [[{}]] with keys of their own", self.key));
            return Vec::new();
        };
        let table = |value: &'s Spanned<DeValue<'s>>| {
            let line = self.source.line(value.span().start);
            let entries = value.get_ref().as_table();
            if entries.is_none() {
                Entry { value, line, ..*self }
                    .refuse(&format!("sections [[{}]] with keys of their own", self.key));
            }
            entries.map(|entries| Table { source: self.source, entries, line })
        };
        array.iter().filter_map(table).collect()
    }

    /// Its two numbers, the first no greater than the second.
    pub fn interval(&self, legal: &Legal) -> Option<[f64; 2]> {
        let array = self.value.get_ref().as_array();
        let ends: Option<Vec<f64>> =
            array.and_then(|array| array.iter().map(|end| number(end.get_ref())).collect());
        let ends = ends.and_then(|ends| <[f64; 2]>::try_from(ends).ok());
        let ends = ends.filter(|[low, high]| low <= high && legal.holds(*low) && legal.holds(*high));
        if ends.is_none() {
            self.refuse(&format!("[low, high], low first, each {legal}"));
        }
        ends
    }

    /// Keeps that something else belongs here.
    pub fn refuse(&self, legal: &str) {
        let found = match self.value.get_ref() {
            DeValue::Table(_) => "a section".to_owned(),
            DeValue::Array(array) if array.iter().any(|entry| entry.get_ref().is_table()) => {
                "sections".to_owned()
            }
            _ => self.source.as_written(self.value.span()),
        };
        self.source.expect(self.line, self.key, format!("found {found}"), legal, "correct the value");
    }
}

/// A number, whole or not.
fn number(value: &DeValue<'_>) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|whole| whole as f64)
        }
        _ => None,
    }
}
