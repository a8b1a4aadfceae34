//! What the image costs, against `firmware/budgets.toml`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Command;

use crate::image::root;
use crate::no_panic::objdump;
use crate::{Outcome, output};

/// The limits, and what was found beyond them.
pub struct Ledger {
    limits: BTreeMap<String, u64>,
    exceeded: Vec<String>,
    unlisted: Vec<String>,
}

impl Ledger {
    /// Reads the limits.
    pub fn open() -> Outcome<Self> {
        let path = root().join("firmware/budgets.toml");
        let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        let limits = toml::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(Self { limits, exceeded: Vec::new(), unlisted: Vec::new() })
    }

    /// Enters and prints one figure.
    pub fn enter(&mut self, name: &str, found: u64) {
        let Some(&limit) = self.limits.get(name) else {
            self.unlisted.push(format!("{name} = {found} has no limit in firmware/budgets.toml"));
            return;
        };
        println!("  {name:18} {found:7} of {limit:7}");
        if found > limit {
            self.exceeded.push(format!("{name} is {found}, its limit {limit}"));
        }
    }

    /// Fails if anything was beyond its limit.
    pub fn close(self) -> Outcome {
        let wrong = [self.exceeded, self.unlisted].concat();
        if wrong.is_empty() { Ok(()) } else { Err(wrong.join("\n")) }
    }
}

/// Enters flash and the RAM that is taken before the stack.
pub fn sizes(flight: &Path, ledger: &mut Ledger) -> Outcome<u64> {
    let (mut flash, mut ram) = (0, 0);
    for (name, size, address) in sections(flight)? {
        if (0x0800_0000..0x0900_0000).contains(&address) || name == ".data" {
            flash += size;
        }
        if (0x2000_0000..0x3000_0000).contains(&address) {
            ram += size;
        }
    }
    ledger.enter("flash_bytes", flash);
    Ok(ram)
}

/// Name, size and address of each section that takes memory.
fn sections(flight: &Path) -> Outcome<Vec<(String, u64, u64)>> {
    let text = output(Command::new(objdump()?).arg("-h").arg(flight))?;
    let hexadecimal = |text: &str| u64::from_str_radix(text, 16).ok();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split_whitespace().collect();
        let [index, name, size, address, ..] = fields.as_slice() else { return None };
        index.parse::<u32>().ok()?;
        Some(((*name).to_owned(), hexadecimal(size)?, hexadecimal(address)?))
    };
    Ok(text.lines().filter_map(row).filter(|(_, _, address)| *address >= 0x0800_0000).collect())
}

/// Runs the self-test in the emulator, where an instruction takes a nanosecond, and enters what it counted.
pub fn count(selftest: &Path, ledger: &mut Ledger) -> Outcome {
    let mut qemu = Command::new("qemu-system-arm");
    qemu.args(["-machine", "netduinoplus2", "-nographic", "-monitor", "none", "-serial", "null"]);
    qemu.args(["-semihosting-config", "enable=on,target=native", "-icount", "shift=0", "-kernel"])
        .arg(selftest);
    let text = output(&mut qemu)?;
    let mut entered = 0;
    for line in text.lines() {
        if let Some((name, Ok(value))) = line.split_once(' ').map(|(name, value)| (name, value.parse())) {
            ledger.enter(name, value);
            entered += 1;
        }
    }
    if entered > 0 { Ok(()) } else { Err(format!("the self-test counted nothing:\n{text}")) }
}
