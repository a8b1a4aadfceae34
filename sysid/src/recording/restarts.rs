//! A clock that starts again within a file: two recordings one after the other, or a counter that has run over.

use super::clock::{counted, median_step};
use super::missing::lines;
use super::table::Table;
use super::{Note, NoteKind};

/// Steps by which a clock that is set back by less may be a stray one.
const LEAST_STEPS: f64 = 10.0;
/// Rows that each run has at least, and how many runs a file has at most.
const LEAST_ROWS: usize = 30;
const MOST_RUNS: usize = 50;
/// Rows over which the clock goes on at its pace, before it starts again and after.
const FIRST_ROWS: usize = 10;
/// Pause that is put between two runs, s: how long it was is not known.
const PAUSE_S: f64 = 10.0;
/// Values of a counter, of 16 and of 32 bits, in the file's unit, milliseconds or microseconds.
const COUNTERS: [f64; 2] = [65_536.0, 4_294_967_296.0];

/// Puts each run behind the one before. A clock that runs backwards in any other way is left to be refused.
pub(super) fn put_behind(table: &mut Table, notes: &mut Vec<Note>) {
    let t = &table.t;
    let starts: Vec<usize> = (1..t.len()).filter(|&row| t[row] < t[row - 1]).collect();
    if starts.is_empty() || starts.len() >= MOST_RUNS {
        return;
    }
    let step = median_step(t, 1);
    let ends = starts.iter().skip(1).copied().chain([t.len()]);
    let is_run = |(&start, end): (&usize, usize)| {
        let falls = t[start - 1] - t[start] > LEAST_STEPS * step && end - start >= LEAST_ROWS;
        // a few stray stamps come from where the clock was and go back there
        let at_its_pace = |first: usize| t[first + FIRST_ROWS] - t[first] < 2.0 * FIRST_ROWS as f64 * step;
        falls && at_its_pace(start - 1 - FIRST_ROWS) && at_its_pace(start)
    };
    if step <= 0.0 || starts[0] < LEAST_ROWS || !starts.iter().zip(ends).all(is_run) {
        return;
    }
    let (mut wraps, mut runs) = (Vec::new(), Vec::new());
    let mut later = 0.0;
    for row in 1..table.t.len() {
        if starts.binary_search(&row).is_ok() {
            let back = table.t[row - 1] - later - table.t[row];
            let units = [table.time.factor, 1e-3, 1e-6];
            let mut run_over = units.iter().flat_map(|unit| COUNTERS.map(|count| count * unit));
            let counter = run_over.find(|count| (count - back - step).abs() <= 0.5 * step);
            later += counter.unwrap_or(back + PAUSE_S);
            if counter.is_some() { &mut wraps } else { &mut runs }.push(row);
        }
        table.t[row] += later;
    }
    let mut tell = |rows: &[usize], what: &str| {
        if !rows.is_empty() {
            let text = format!(
                "the clock starts again {} ({}): {what}",
                times(rows.len()),
                lines(&table.lines, rows)
            );
            notes.push(Note::new(NoteKind::Gap, text));
        }
    };
    tell(&wraps, "a counter of 16 or 32 bits that has run over, which was counted on");
    tell(
        &runs,
        &format!("runs of their own, each put {PAUSE_S} s behind the one before, whatever the pause was"),
    );
}

fn times(count: usize) -> String {
    if count == 1 { "once".into() } else { counted(count, "time") }
}

#[cfg(test)]
mod tests {
    use super::super::{ReadOptions, Recording, parse};

    fn read(clock: impl Fn(usize) -> f64) -> Result<Recording, crate::error::Error> {
        let row = |k: usize| format!("{:.3},{},{}\n", clock(k), (k / 7) % 2, (0.3 * k as f64).sin());
        let text = "t_s,u_V,q_rad_s\n".to_owned() + &(0..400).map(row).collect::<String>();
        parse("two.csv", text.as_bytes(), &ReadOptions::default())
    }

    #[test]
    fn two_runs_in_a_file_are_two_runs() {
        let two = read(|k| 0.02 * if k < 150 { k } else { k - 150 } as f64).unwrap();
        assert_eq!(two.segments, [0..150, 150..400]);
        assert!((two.t[150] - two.t[149] - 10.0).abs() < 1e-9);
        assert!(two.notes.iter().any(|note| note.text.contains("once (line 152)")), "{:?}", two.notes);
    }

    #[test]
    fn a_counter_that_has_run_over_goes_on() {
        let clock = |k: usize| (60.0 + 0.02 * k as f64) % 65.536;
        let one = read(clock).unwrap();
        assert_eq!(one.segments.len(), 1, "{:?}", one.notes);
    }

    #[test]
    fn what_is_no_run_is_refused() {
        assert!(read(|k| 0.02 * if k < 390 { k } else { k - 390 } as f64).is_err(), "ten rows");
        assert!(read(|k| 0.02 * k as f64 - if k < 200 { 0.0 } else { 0.07 }).is_err(), "set back a little");
        assert!(read(|k| if (50..53).contains(&k) { 0.1 } else { 0.02 * k as f64 }).is_err(), "strays");
    }
}
