//! Arithmetic over columns, as the right side of `--column`: `0.25*(m1+m2-m3-m4)`, `-gyro_y*pi/180`.
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = signed { ("*" | "/") signed }
//! signed  = { "-" | "+" } primary
//! primary = number | "pi" | name | "(" sum ")"
//! name    = letter or "_", then letters, digits, "_", ".", "[", "]"; anything between `...` or "..."
//! ```
//!
//! A quote stands for itself where it is doubled. Length and depth are bounded, so that no text can hang or overflow.

use std::fmt;
use std::str::FromStr;

use crate::error::{Error, ErrorKind, quote};

/// Parentheses and signs inside each other.
const DEEPEST: usize = 40;
/// Numbers, names and operators.
const LONGEST: usize = 200;
/// What can begin an operand.
const OPERAND: &str = "a number, a name, pi, - or (";

/// An arithmetic expression over named columns.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// Each name once, in order of appearance.
    names: Vec<String>,
    tree: Node,
}

#[derive(Clone, Debug, PartialEq)]
enum Node {
    Number(f64),
    /// Place in the list of names.
    Name(usize),
    Negative(Box<Node>),
    Pair(Operator, Box<Node>, Box<Node>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Operator {
    Plus,
    Minus,
    Times,
    Over,
}

impl Operator {
    const ALL: [(char, Self); 4] =
        [('+', Self::Plus), ('-', Self::Minus), ('*', Self::Times), ('/', Self::Over)];

    fn of(sign: char) -> Option<Self> {
        Self::ALL.iter().find(|(known, _)| *known == sign).map(|&(_, operator)| operator)
    }

    fn sign(self) -> char {
        Self::ALL.iter().find(|(_, known)| *known == self).map_or('?', |&(sign, _)| sign)
    }

    fn binds(self) -> u8 {
        if matches!(self, Self::Plus | Self::Minus) { 1 } else { 2 }
    }

    fn apply(self, left: f64, right: f64) -> f64 {
        match self {
            Self::Plus => left + right,
            Self::Minus => left - right,
            Self::Times => left * right,
            Self::Over => left / right,
        }
    }
}

impl Expression {
    /// One column as it is.
    #[must_use]
    pub fn column(name: impl Into<String>) -> Self {
        Self { names: vec![name.into()], tree: Node::Name(0) }
    }

    /// The columns in it, each once.
    #[must_use]
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The name of the column, where it is one and nothing else.
    #[must_use]
    pub fn as_column(&self) -> Option<&str> {
        match self.tree {
            Node::Name(place) => self.names.get(place).map(String::as_str),
            _ => None,
        }
    }

    /// As messages name it: a column by its bare name.
    #[must_use]
    pub fn label(&self) -> String {
        self.as_column().map_or_else(|| self.to_string(), str::to_owned)
    }

    /// The value where the columns, in the order of [`names`](Self::names), have these values; not finite where it
    /// divides by zero.
    #[must_use]
    pub fn value(&self, values: &[f64]) -> f64 {
        evaluate(&self.tree, values)
    }

    /// This times `factor`, as an option has it.
    pub(super) fn scaled(&self, factor: f64) -> Self {
        let (left, right) = (Box::new(self.tree.clone()), Box::new(Node::Number(factor)));
        Self { names: self.names.clone(), tree: Node::Pair(Operator::Times, left, right) }
    }

    /// The constant that multiplies the whole, and the rest: `-x*pi/180` is −π/180 and `x`.
    pub(super) fn without_factor(self) -> (f64, Self) {
        let (mut factor, mut tree) = (1.0, self.tree);
        loop {
            tree = match tree {
                Node::Negative(inner) => {
                    factor = -factor;
                    *inner
                }
                Node::Pair(Operator::Times, rest, constant) | Node::Pair(Operator::Times, constant, rest)
                    if is_constant(&constant) =>
                {
                    factor *= evaluate(&constant, &[]);
                    *rest
                }
                Node::Pair(Operator::Over, rest, constant) if is_constant(&constant) => {
                    factor /= evaluate(&constant, &[]);
                    *rest
                }
                tree => return (factor, Self { names: self.names, tree }),
            };
        }
    }
}

fn is_constant(node: &Node) -> bool {
    match node {
        Node::Number(_) => true,
        Node::Name(_) => false,
        Node::Negative(inner) => is_constant(inner),
        Node::Pair(_, left, right) => is_constant(left) && is_constant(right),
    }
}

fn evaluate(node: &Node, values: &[f64]) -> f64 {
    match node {
        Node::Number(number) => *number,
        Node::Name(place) => values.get(*place).copied().unwrap_or(f64::NAN),
        Node::Negative(inner) => -evaluate(inner, values),
        Node::Pair(operator, left, right) => operator.apply(evaluate(left, values), evaluate(right, values)),
    }
}

/// As it can be read again.
impl fmt::Display for Expression {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.written(&self.tree, 0))
    }
}

impl Expression {
    /// A node beside an operator that binds as `outer`.
    fn written(&self, node: &Node, outer: u8) -> String {
        let (text, binds) = match node {
            Node::Number(number) => (number.to_string(), 3),
            Node::Name(place) => (self.names.get(*place).map_or_else(String::new, |n| written_name(n)), 3),
            Node::Negative(inner) => (format!("-{}", self.written(inner, 3)), 3),
            Node::Pair(operator, left, right) => {
                let binds = operator.binds();
                let (left, right) = (self.written(left, binds), self.written(right, binds + 1));
                (format!("{left}{}{right}", operator.sign()), binds)
            }
        };
        if binds < outer { format!("({text})") } else { text }
    }
}

fn begins_name(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

fn is_in_name(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '.' | '[' | ']')
}

/// A name, quoted where it has to be.
fn written_name(name: &str) -> String {
    let plain = name.starts_with(begins_name) && name.chars().all(is_in_name) && name != "pi";
    let mark = if name.contains('`') { '"' } else { '`' };
    let doubled = || name.replace(mark, &format!("{mark}{mark}"));
    if plain { name.to_owned() } else { format!("{mark}{}{mark}", doubled()) }
}

impl FromStr for Expression {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self, Error> {
        let characters = text.chars().collect();
        let mut parser = Parser { text: characters, at: 0, names: Vec::new(), pieces: 0 };
        let tree = parser.sum(0)?;
        match parser.peek() {
            None => Ok(Self { names: parser.names, tree }),
            Some(_) => Err(parser.refuse("+, -, *, / or the end")),
        }
    }
}

struct Parser {
    text: Vec<char>,
    at: usize,
    names: Vec<String>,
    pieces: usize,
}

impl Parser {
    /// The next character that is no blank.
    fn peek(&mut self) -> Option<char> {
        while self.text.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
        self.text.get(self.at).copied()
    }

    fn refuse(&mut self, expected: &str) -> Error {
        let found = match self.peek() {
            Some(c) => format!("found {}", quote(&c.to_string())),
            None => "it ends too early".into(),
        };
        self.error(&found).expecting(expected)
    }

    fn error(&self, found: &str) -> Error {
        let advice = "write +, -, *, / and parentheses over columns; put names with other signs than letters, digits, \
                      _ . [ ] between `backticks` or \"quotes\"";
        Error::new(ErrorKind::Options, format!("at character {}: {found}", self.at + 1), advice)
    }

    /// Counts a piece.
    fn node(&mut self, node: Node) -> Result<Node, Error> {
        self.pieces += 1;
        if self.pieces > LONGEST {
            return Err(self.error(&format!("more than {LONGEST} numbers, names and operators")));
        }
        Ok(node)
    }

    fn sum(&mut self, depth: usize) -> Result<Node, Error> {
        let mut left = self.product(depth)?;
        while let Some(operator) = self.operator(1) {
            let right = self.product(depth)?;
            left = self.node(Node::Pair(operator, Box::new(left), Box::new(right)))?;
        }
        Ok(left)
    }

    fn product(&mut self, depth: usize) -> Result<Node, Error> {
        let mut left = self.signed(depth)?;
        while let Some(operator) = self.operator(2) {
            let right = self.signed(depth)?;
            left = self.node(Node::Pair(operator, Box::new(left), Box::new(right)))?;
        }
        Ok(left)
    }

    /// Takes an operator of this strength.
    fn operator(&mut self, binds: u8) -> Option<Operator> {
        let operator = Operator::of(self.peek()?).filter(|operator| operator.binds() == binds)?;
        self.at += 1;
        Some(operator)
    }

    fn signed(&mut self, depth: usize) -> Result<Node, Error> {
        if depth > DEEPEST {
            return Err(self.error(&format!("more than {DEEPEST} parentheses and signs inside each other")));
        }
        match self.peek() {
            Some('-') => {
                self.at += 1;
                let inner = Box::new(self.signed(depth + 1)?);
                self.node(Node::Negative(inner))
            }
            Some('+') => {
                self.at += 1;
                self.signed(depth + 1)
            }
            Some('(') => {
                self.at += 1;
                let inner = self.sum(depth + 1)?;
                if self.peek() != Some(')') {
                    return Err(self.refuse("+, -, *, / or )"));
                }
                self.at += 1;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if begins_name(c) => {
                let name: String = self.text[self.at..].iter().take_while(|c| is_in_name(**c)).collect();
                self.at += name.chars().count();
                if name == "pi" { self.node(Node::Number(std::f64::consts::PI)) } else { self.name(name) }
            }
            Some(mark @ ('`' | '"')) => self.quoted(mark),
            _ => Err(self.refuse(OPERAND)),
        }
    }

    fn number(&mut self) -> Result<Node, Error> {
        let rest = &self.text[self.at..];
        let digits =
            |from: usize| rest[from.min(rest.len())..].iter().take_while(|c| c.is_ascii_digit()).count();
        let mut end = digits(0);
        if rest.get(end) == Some(&'.') {
            end += 1 + digits(end + 1);
        }
        if matches!(rest.get(end), Some('e' | 'E')) {
            let sign = usize::from(matches!(rest.get(end + 1), Some('+' | '-')));
            let exponent = digits(end + 1 + sign);
            end += if exponent > 0 { 1 + sign + exponent } else { 0 };
        }
        let number = rest[..end].iter().collect::<String>();
        match number.parse::<f64>() {
            Ok(value) if value.is_finite() => {
                self.at += end;
                self.node(Node::Number(value))
            }
            _ => Err(self.error(&format!("{} is no number", quote(&number)))),
        }
    }

    fn quoted(&mut self, mark: char) -> Result<Node, Error> {
        let (mut name, mut at) = (String::new(), self.at + 1);
        loop {
            match (self.text.get(at), self.text.get(at + 1)) {
                (Some(c), Some(next)) if *c == mark && *next == mark => {
                    name.push(mark);
                    at += 2;
                }
                (Some(c), _) if *c == mark => break,
                (Some(c), _) => {
                    name.push(*c);
                    at += 1;
                }
                (None, _) => return Err(self.error(&format!("the quote {mark} is opened and not closed"))),
            }
        }
        if name.is_empty() {
            return Err(self.error("a name without a character"));
        }
        self.at = at + 1;
        self.name(name)
    }

    fn name(&mut self, name: String) -> Result<Node, Error> {
        let place = self.names.iter().position(|known| *known == name).unwrap_or_else(|| {
            self.names.push(name);
            self.names.len() - 1
        });
        self.node(Node::Name(place))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn parsed(text: &str) -> Expression {
        text.parse().unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn values_follow_the_usual_rules() {
        for (text, names, value) in [
            ("0.25*(m1+m2-m3-m4)", &["m1", "m2", "m3", "m4"][..], -1.0),
            ("-a*pi/180", &["a"], -std::f64::consts::PI / 180.0),
            ("a-b-c", &["a", "b", "c"], -4.0),
            ("a/b/c*6", &["a", "b", "c"], 1.0),
            ("--a+-(b)", &["a", "b"], -1.0),
            ("a*-1e-1", &["a"], -0.1),
            (" a + .5 * 2. ", &["a"], 2.0),
            ("`a b`+\"c-d\"-`e``f`", &["a b", "c-d", "e`f"], 0.0),
            ("RATE.P+main.gyroADC[0]+a", &["RATE.P", "main.gyroADC[0]", "a"], 6.0),
            ("`pi`*a", &["pi", "a"], 2.0),
            ("a/(b-b)", &["a", "b"], f64::INFINITY),
        ] {
            let expression = parsed(text);
            assert_eq!(expression.names(), names, "{text}");
            // the first name is 1, the second 2, ...
            let found = expression.value(&[1.0, 2.0, 3.0, 4.0]);
            assert!(found == value || (found - value).abs() < 1e-12, "{text}: {found}");
            assert_eq!(parsed(&expression.to_string()).value(&[1.0, 2.0, 3.0, 4.0]), found, "{expression}");
        }
    }

    #[test]
    fn constant_factors_come_off() {
        for (text, factor, rest) in [
            ("gy*0.0174533", 0.0174533, "gy"),
            ("-gyro_y*pi/180", -std::f64::consts::PI / 180.0, "gyro_y"),
            ("2*(a+b)/-4", -0.5, "a+b"),
            ("a+1", 1.0, "a+1"),
            ("1/a", 1.0, "1/a"),
        ] {
            let (found, expression) = parsed(text).without_factor();
            assert!((found - factor).abs() < 1e-15 && expression.to_string() == rest, "{text}: {expression}");
        }
        assert_eq!(parsed("a+b").scaled(-1.0).to_string(), "(a+b)*-1");
        assert_eq!(parsed("a-(b-c)/(d*e)").to_string(), "a-(b-c)/(d*e)");
    }

    #[test]
    fn errors_name_place_and_expectation() {
        for (text, place, says) in [
            ("", 1, "it ends too early"),
            ("a+", 3, "expected: a number, a name"),
            ("a b", 3, "found \"b\""),
            ("(a+b", 5, "expected: +, -, *, / or )"),
            ("a+)", 3, "found \")\""),
            ("a^2", 2, "found \"^\""),
            ("2*`a b", 3, "not closed"),
            ("1e999*a", 1, "no number"),
            ("a+.", 3, "\".\" is no number"),
            ("``", 1, "without a character"),
        ] {
            let message = text.parse::<Expression>().unwrap_err().to_string();
            assert!(
                message.contains(&format!("at character {place}:")) && message.contains(says),
                "{message}"
            );
        }
        let deep = "(".repeat(100_000) + "a";
        assert!(deep.parse::<Expression>().unwrap_err().found.contains("inside each other"));
        assert!("-".repeat(100_000).parse::<Expression>().unwrap_err().found.contains("inside each other"));
        let long = vec!["a"; 100_000].join("+");
        assert!(long.parse::<Expression>().unwrap_err().found.contains("more than 200"));
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in "[-+*/(). a1e`\"\\[\\]piµ]{0,60}|\\PC{0,40}") {
            match text.parse::<Expression>() {
                Ok(read) => {
                    let values = vec![0.7; read.names().len()];
                    let again = parsed(&read.to_string());
                    let (found, same) = (again.value(&values), read.value(&values));
                    prop_assert!(found == same || (found.is_nan() && same.is_nan()), "{text}: {read}");
                    prop_assert_eq!(again.names(), read.names());
                }
                Err(error) => prop_assert!(error.found.contains("at character") && !error.advice.is_empty()),
            }
        }
    }
}
