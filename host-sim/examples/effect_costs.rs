//! What leaving each effect out costs: the experiment behind `moderate_and_strong` of the catalogue.
//!
//! `cargo run --release -p host-sim --example effect_costs`

use host_sim::{Background, CATALOGUE, Scenario, Setting, cost_of_leaving_out};

const SEEDS: u64 = 8;
const SIZES: i32 = 6;

/// Median cost over the seeds, points of VAF on held-out sections.
fn median_cost(id: &str, size: f64) -> Result<f64, host_sim::Error> {
    let usual = Setting::usual(id, false)?;
    let names: Vec<(&str, f64)> =
        usual.parameters().enumerate().map(|(i, (p, v))| (p.name, if i == 0 { size } else { v })).collect();
    let mut costs = Vec::new();
    for seed in 0..SEEDS {
        let effects = vec![Setting::new(id, &names)?];
        let background = Background::Clean;
        costs.push(cost_of_leaving_out(&Scenario {
            effects,
            background,
            ..Scenario::campaign(4, 0.015, seed)?
        })?);
    }
    costs.sort_by(f64::total_cmp);
    Ok((costs[costs.len() / 2] + costs[(costs.len() - 1) / 2]) / 2.0)
}

/// Prints one line per effect: size and cost, over the usual range and at the usual sizes.
fn main() -> Result<(), host_sim::Error> {
    for entry in CATALOGUE {
        let parameter = &entry.parameters[0];
        let [low, high] = parameter.range;
        print!("{:18} {} {}:", entry.id, parameter.name, parameter.unit);
        for step in 0..SIZES {
            let size = low * (high / low).powf(f64::from(step) / f64::from(SIZES - 1));
            print!("  {size:.3} {:.1}", median_cost(entry.id, size)?);
        }
        print!("  usual:");
        for size in entry.moderate_and_strong {
            print!("  {size:.3} {:.1}", median_cost(entry.id, size)?);
        }
        println!();
    }
    Ok(())
}
