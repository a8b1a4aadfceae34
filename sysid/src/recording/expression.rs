//! Arithmetic over columns, as the right side of `--column`: `0.25*(m1+m2-m3-m4)`, `-gyro_y*pi/180`.
//!
//! ```text
//! sum     = product { ("+" | "-") product }
//! product = signed { ("*" | "/") signed }
//! signed  = { "-" | "+" } primary
//! primary = number | "pi" | name | "(" sum ")" | "limit" "(" sum "," sum "," sum ")"
//! name    = letter or "_", then letters, digits, "_", ".", "[", "]", and blanks within; anything between `...` or "..."
//! ```
//!
//! `limit(u, -100, 100)` is u held between the two: a command as the actuator gets it, where the log has it before its limit.
//!
//! A quote stands for itself where it is doubled. Length and depth are bounded, so that no text can hang or overflow.

mod parser;

use std::fmt;

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
    /// The first held between the second and the third.
    Limited(Box<[Node; 3]>),
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

    /// This held between two values.
    pub(super) fn limited(&self, [low, high]: [f64; 2]) -> Self {
        let number = |value: f64| match value < 0.0 {
            true => Node::Negative(Box::new(Node::Number(-value))),
            false => Node::Number(value),
        };
        let parts = Box::new([self.tree.clone(), number(low), number(high)]);
        Self { names: self.names.clone(), tree: Node::Limited(parts) }
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
        Node::Limited(parts) => parts.iter().all(is_constant),
    }
}

fn evaluate(node: &Node, values: &[f64]) -> f64 {
    match node {
        Node::Number(number) => *number,
        Node::Name(place) => values.get(*place).copied().unwrap_or(f64::NAN),
        Node::Negative(inner) => -evaluate(inner, values),
        Node::Pair(operator, left, right) => operator.apply(evaluate(left, values), evaluate(right, values)),
        Node::Limited(parts) => {
            let [value, low, high] = parts.each_ref().map(|part| evaluate(part, values));
            if low <= high { value.clamp(low, high) } else { f64::NAN }
        }
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
            Node::Limited(parts) => {
                let [value, low, high] = parts.each_ref().map(|part| self.written(part, 0));
                (format!("limit({value},{low},{high})"), 3)
            }
        };
        if binds < outer { format!("({text})") } else { text }
    }
}

/// A name, quoted where it has to be.
fn written_name(name: &str) -> String {
    let plain = name.starts_with(parser::begins_name) && name.chars().all(parser::is_in_name) && name != "pi";
    let mark = if name.contains('`') { '"' } else { '`' };
    let doubled = || name.replace(mark, &format!("{mark}{mark}"));
    if plain { name.to_owned() } else { format!("{mark}{}{mark}", doubled()) }
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
            ("Channel 3*2 - roll rate", &["Channel 3", "roll rate"], 0.0),
            ("limit(4*b, -5, a+2) - limit", &["b", "a", "limit"], 1.0),
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
        assert_eq!(parsed("Channel 3").limited([-100.0, 100.0]).to_string(), "limit(`Channel 3`,-100,100)");
    }

    #[test]
    fn errors_name_place_and_expectation() {
        for (text, place, says) in [
            ("", 1, "it ends too early"),
            ("a+", 3, "expected: a number, a name"),
            ("a `b`", 3, "found \"`\""),
            ("2 b", 3, "found \"b\""),
            ("limit(a, 1)", 11, "expected: +, -, *, / or ,"),
            ("limit(a, 1, -1)", 15, "the lower end of a limit is above the upper one"),
            ("limit(a, 1, 2", 14, "expected: +, -, *, / or )"),
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
