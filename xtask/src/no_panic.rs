//! No panic is reachable from the control interrupt: closure of the calls in the linked image.
//!
//! The image is disassembled; from the handler of TIM2 every branch that leaves its function is followed. The proof fails
//! when a function of the panic machinery is among those met, or when one calls through a register, for then its callee is
//! not known. The failsafe's reset is not a panic.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use crate::{Outcome, image, output};

/// Handler of the control cycle.
const ENTRY: &str = "TIM2";
const PANICS: [&str; 6] =
    ["panicking", "panic_", "rust_begin_unwind", "slice_index_fail", "unwrap_failed", "expect_failed"];

/// A disassembler that knows the chip.
pub fn objdump() -> Outcome<&'static str> {
    let known = ["arm-none-eabi-objdump", "llvm-objdump"];
    let found = known.into_iter().find(|name| Command::new(name).arg("--version").output().is_ok());
    found.ok_or_else(|| "no disassembler; install binutils-arm-none-eabi or llvm".into())
}

#[derive(Default)]
struct Function {
    name: String,
    branches: Vec<u64>,
    indirect: Vec<String>,
}

/// Feature that puts a panic into the control cycle, for the control of the proof.
pub const CONTROL: &str = "provoked-faults";

/// Proves it of the flight image, and that the proof would find a panic.
pub fn check() -> Outcome {
    match prove(&image::build(Some(CONTROL))?.flight) {
        Err(why) if why.starts_with("a panic is reachable") => {
            println!("negative control: the proof finds a panic put into the control cycle");
        }
        Err(why) => return Err(format!("negative control: {why}")),
        Ok(_) => return Err("negative control: a panic in the control cycle was not found".into()),
    }
    let met = prove(&image::build(None)?.flight)?;
    println!("no panic is reachable from the control interrupt ({met} functions)");
    Ok(())
}

/// The functions met, or how a panic is reached.
pub fn prove(flight: &Path) -> Outcome<usize> {
    let functions = disassemble(&output(Command::new(objdump()?).arg("-d").arg(flight))?);
    let entry = functions.iter().find(|(_, function)| function.name == ENTRY);
    let (&entry, _) = entry.ok_or_else(|| format!("the image has no handler {ENTRY}"))?;
    let mut met = BTreeSet::from([entry]);
    let mut way: Vec<(u64, Vec<String>)> = vec![(entry, Vec::new())];
    while let Some((address, mut path)) = way.pop() {
        let Some(function) = functions.get(&address) else { continue };
        path.push(function.name.clone());
        let here = || path.join("\n  -> ");
        if PANICS.iter().any(|panic| function.name.contains(panic)) {
            return Err(format!("a panic is reachable from {ENTRY}:\n  {}", here()));
        }
        if let Some(line) = function.indirect.first() {
            return Err(format!(
                "a call through a register, `{line}`, on the way from {ENTRY}:\n  {}",
                here()
            ));
        }
        for branch in &function.branches {
            let callee = functions.range(..=*branch).next_back().map_or(0, |(&start, _)| start);
            if met.insert(callee) {
                way.push((callee, path.clone()));
            }
        }
    }
    Ok(met.len())
}

/// Functions by address.
fn disassemble(text: &str) -> BTreeMap<u64, Function> {
    let mut functions: BTreeMap<u64, Function> = BTreeMap::new();
    let mut current = 0;
    for line in text.lines() {
        if let Some((address, name)) = label(line) {
            current = address;
            functions.entry(address).or_default().name = name;
        } else if let Some(function) = functions.get_mut(&current) {
            read(function, line);
        }
    }
    functions
}

fn label(line: &str) -> Option<(u64, String)> {
    let (address, name) = line.strip_suffix(">:")?.split_once(" <")?;
    // mapping symbols are no functions
    (!name.starts_with('$')).then_some(())?;
    Some((u64::from_str_radix(address, 16).ok()?, name.to_owned()))
}

fn read(function: &mut Function, line: &str) {
    let mut words = line.split(['\t', ' ']).filter(|word| !word.is_empty());
    let Some(mnemonic) = words.find(|word| branches(word)) else { return };
    let mut operands = words.map(|word| word.trim_end_matches(','));
    let Some(first) = operands.next() else { return };
    let operand = if mnemonic.starts_with("cb") { operands.next().unwrap_or_default() } else { first };
    match u64::from_str_radix(operand.trim_start_matches("0x"), 16) {
        Ok(address) if address >= 0x0800_0000 => function.branches.push(address),
        _ if operand == "lr" => {}
        _ => function.indirect.push(format!("{mnemonic} {operand}")),
    }
}

/// b, bl, bx, blx with any condition and width, cbz, cbnz; not bic, bfi, bkpt.
fn branches(word: &str) -> bool {
    let stem = word.split('.').next().unwrap_or_default();
    let conditions =
        ["", "eq", "ne", "cs", "hs", "cc", "lo", "mi", "pl", "vs", "vc", "hi", "ls", "ge", "lt", "gt", "le"];
    let is = |root: &str| stem.strip_prefix(root).is_some_and(|rest| conditions.contains(&rest));
    is("b") || is("bl") || is("bx") || is("blx") || stem == "cbz" || stem == "cbnz"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn calls_tail_calls_and_calls_through_registers_are_read() {
        let text = "08000100 <TIM2>:\n 8000100:\tb580      \tpush\t{r7, lr}\n 8000102:\tf000 f801 \tbl\t8000200 <core::panicking::panic>\n \
                    8000106:\tf000 b801 \tb.w\t8000300 <next>\n 800010a:\t4798      \tblx\tr3\n 800010c:\t4770      \tbx\tlr\n \
                    800010e:\tb10b      \tcbz\tr3, 8000114 <TIM2+0x14>\n";
        let functions = disassemble(text);
        let found = &functions[&0x0800_0100];
        assert_eq!(found.branches, [0x0800_0200, 0x0800_0300, 0x0800_0114]);
        assert_eq!(found.indirect, ["blx r3"]);
    }

    #[test]
    fn other_instructions_with_a_b_are_no_branches() {
        for word in ["bic.w", "bfi", "bkpt", "b580", "blx0"] {
            assert!(!branches(word), "{word}");
        }
        assert!(["b.n", "beq.w", "bl", "bls.n", "blt.n", "bxeq"].into_iter().all(branches));
    }
}
