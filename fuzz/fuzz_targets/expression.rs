//! `--column`, `--section` and the expressions in them.
#![no_main]

use libfuzzer_sys::fuzz_target;
use sysid::recording::{ColumnMap, Expression, SectionSpec};

fuzz_target!(|text: &str| {
    let _ = text.parse::<SectionSpec>();
    let _ = text.parse::<ColumnMap>();
    let Ok(expression) = text.parse::<Expression>() else { return };
    let values: Vec<f64> = (0..expression.names().len()).map(|k| 0.37 * (1.0 + k as f64)).collect();
    let again: Expression = expression.to_string().parse().expect("what is told reads back");
    assert_eq!(again.names(), expression.names());
    assert_eq!(again.value(&values).to_bits(), expression.value(&values).to_bits());
});
