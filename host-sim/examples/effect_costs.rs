//! What leaving each effect out costs: the experiment behind `moderate_and_strong` of the lists.
//!
//! `cargo run --release -p host-sim --example effect_costs [ID...]`

use host_sim::effects::{Entry, every};
use host_sim::{Background, Scenario, Setting, cost_of_leaving_out};

const SEEDS: u64 = 8;
const SIZES: i32 = 6;
const HALVINGS: i32 = 6;

/// Median cost over the seeds, points of VAF on held-out sections.
fn median_cost(entry: &Entry, size: f64) -> Result<f64, host_sim::Error> {
    let effect = Setting::usual(entry.id, false)?.resized(size);
    let mut costs = Vec::new();
    for seed in 0..SEEDS {
        let mut scenario = Scenario::campaign(4, 0.015, seed)?;
        scenario.background = Background::Clean;
        scenario.conceal(vec![effect.clone()]);
        costs.push(cost_of_leaving_out(&scenario)?);
    }
    costs.sort_by(f64::total_cmp);
    Ok((costs[costs.len() / 2] + costs[(costs.len() - 1) / 2]) / 2.0)
}

/// The size, between a cheap and a dear one, whose median cost is nearest to `points`, and that cost.
fn size_for(entry: &Entry, mut sizes: [f64; 2], points: f64) -> Result<(f64, f64), host_sim::Error> {
    let mut best = (sizes[1], median_cost(entry, sizes[1])?);
    for _ in 0..HALVINGS {
        let middle = (sizes[0] * sizes[1]).sqrt();
        let cost = median_cost(entry, middle)?;
        if (cost - points).abs() < (best.1 - points).abs() {
            best = (middle, cost);
        }
        sizes[usize::from(cost > points)] = middle;
    }
    Ok(best)
}

/// Prints one line per effect: size and cost over the usual range, at the usual sizes, and the sizes for 5 and
/// 10 points.
fn main() -> Result<(), host_sim::Error> {
    let wanted: Vec<String> = std::env::args().skip(1).collect();
    for entry in every().filter(|entry| wanted.is_empty() || wanted.iter().any(|id| id == entry.id)) {
        let parameter = &entry.parameters[0];
        let [low, high] = parameter.range;
        print!("{:22} {} {}:", entry.id, parameter.name, parameter.unit);
        let mut swept = Vec::new();
        for step in 0..SIZES {
            let size = low * (high / low).powf(f64::from(step) / f64::from(SIZES - 1));
            swept.push((size, median_cost(entry, size)?));
        }
        swept.iter().for_each(|(size, cost)| print!("  {size:.4} {cost:.1}"));
        print!("  usual:");
        for size in entry.moderate_and_strong {
            print!("  {size:.4} {:.1}", median_cost(entry, size)?);
        }
        swept.sort_by(|a, b| a.1.total_cmp(&b.1));
        print!("  for 5 and 10:");
        for points in [5.0, 10.0] {
            // the neighbours in cost, so that an uneven curve does not lead astray
            let above = swept.iter().position(|(_, cost)| *cost > points).unwrap_or(swept.len() - 1).max(1);
            let (size, cost) = size_for(entry, [swept[above - 1].0, swept[above].0], points)?;
            print!("  {size:.4} {cost:.1}");
        }
        println!();
    }
    Ok(())
}
