//! The text of an expression, read by descent.

use super::{Expression, Node, Operator, evaluate, is_constant};
use crate::error::{Error, ErrorKind, quote};
use std::str::FromStr;

/// Parentheses and signs inside each other.
const DEEPEST: usize = 40;
/// Numbers, names and operators.
const LONGEST: usize = 200;
/// What can begin an operand.
const OPERAND: &str = "a number, a name, pi, - or (";
const LIMIT: &str = "limit";

pub(super) fn begins_name(c: char) -> bool {
    c.is_alphabetic() || c == '_'
}

pub(super) fn is_in_name(c: char) -> bool {
    c.is_alphanumeric() || matches!(c, '_' | '.' | '[' | ']')
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
                      blanks, _ . [ ] between `backticks` or \"quotes\"";
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
                self.end(')')?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if begins_name(c) => {
                let name = self.words();
                match name.as_str() {
                    "pi" => self.node(Node::Number(std::f64::consts::PI)),
                    LIMIT if self.peek() == Some('(') => self.limited(depth + 1),
                    _ => self.name(name),
                }
            }
            Some(mark @ ('`' | '"')) => self.quoted(mark),
            _ => Err(self.refuse(OPERAND)),
        }
    }

    /// Takes what ends a sum.
    fn end(&mut self, mark: char) -> Result<(), Error> {
        if self.peek() != Some(mark) {
            return Err(self.refuse(&format!("+, -, *, / or {mark}")));
        }
        self.at += 1;
        Ok(())
    }

    /// Takes a name, with the blanks within it as they are: two words beside each other are one name.
    fn words(&mut self) -> String {
        let begin = self.at;
        loop {
            while self.text.get(self.at).is_some_and(|c| is_in_name(*c)) {
                self.at += 1;
            }
            let end = self.at;
            if !self.peek().is_some_and(is_in_name) {
                self.at = end;
                return self.text[begin..end].iter().collect();
            }
        }
    }

    /// Takes the three parts of a limit.
    fn limited(&mut self, depth: usize) -> Result<Node, Error> {
        self.at += 1;
        let value = self.sum(depth)?;
        self.end(',')?;
        let low = self.sum(depth)?;
        self.end(',')?;
        let high = self.sum(depth)?;
        if is_constant(&low) && is_constant(&high) && evaluate(&low, &[]) > evaluate(&high, &[]) {
            return Err(self.error("the lower end of a limit is above the upper one"));
        }
        self.end(')')?;
        self.node(Node::Limited(Box::new([value, low, high])))
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
