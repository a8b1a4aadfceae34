//! A recording as it comes in: a row for each cycle, and as comments what no row can hold.
//!
//! Every row is in the file before the next message is waited for. Time runs on where the board's clock begins anew. Until it is
//! finished the recording lies beside its place, in `NAME.part`: that is what a computer that fails, or a full disk, leaves.

use super::cycle::CycleReport;
use crate::failure::Failure;
use crate::format::plural;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::time::Instant;

const COLUMNS: &str = "t_s,u_rad,q_rad_s,theta_rad,section,supervised,theta_ref_rad,excitation_rad,\
                       prediction_error_rad_s,settling,gain_drift,innovation_ratio";

/// An open recording.
pub struct Log {
    /// Where it goes when it is finished.
    path: PathBuf,
    /// Where it lies until then.
    part: PathBuf,
    file: BufWriter<File>,
    /// The last cycle, and when it came.
    last: Option<(CycleReport, Instant)>,
    /// What is added to the board's clock, µs.
    shift_us: i128,
    /// Rows written.
    pub rows: u64,
    /// Cycles that the board flew and that did not arrive.
    pub lost: u64,
}

impl Log {
    /// What was written, for people.
    pub fn counted(&self) -> String {
        let samples = plural(self.rows, "sample");
        match self.lost {
            0 => format!("{samples}, every cycle arrived"),
            lost => format!("{samples}, {} did not arrive", plural(lost, "cycle")),
        }
    }

    /// Refuses a place beside which lies what an earlier recording left.
    pub fn check(path: &Path) -> Result<(), Failure> {
        let (path, part) = places(path);
        if part == path || !part.exists() {
            return Ok(());
        }
        let part = part.display();
        let help = format!("look at it (pitchid show {part}), then rename or delete it");
        Err(Failure::new(format!("{part}: what a recording left that was cut off"), help))
    }

    /// Begins a recording.
    pub fn create(path: &Path, title: &str) -> Result<Self, Failure> {
        Self::check(path)?;
        let (path, part) = places(path);
        let file = File::create(&part).map_err(|error| Failure::unwritable(&part, &error))?;
        let mut log =
            Self { path, part, file: BufWriter::new(file), last: None, shift_us: 0, rows: 0, lost: 0 };
        log.line(&format!("# {title}\n{COLUMNS}"))?;
        Ok(log)
    }

    /// Writes one cycle.
    pub fn cycle(&mut self, report: &CycleReport) -> Result<(), Failure> {
        match self.last.replace((*report, Instant::now())) {
            None => self.shift_us = -i128::from(report.time_us),
            Some((last, _)) if report.time_us > last.time_us => {
                let lost = u64::from(report.tick.saturating_sub(last.tick)).saturating_sub(1);
                if lost > 0 {
                    self.lost += lost;
                    self.note(&format!("{} did not arrive", plural(lost, "cycle")))?;
                }
            }
            Some((last, then)) => {
                let passed = then.elapsed().as_micros().max(20_000) as i128;
                self.shift_us += i128::from(last.time_us) + passed - i128::from(report.time_us);
                self.note("the board's clock began anew; the time of the gap is this computer's")?;
            }
        }
        let t_s = (i128::from(report.time_us) + self.shift_us) as f64 / 1e6;
        let CycleReport { u_rad, section, supervised, theta_ref_rad, excitation_rad, error_rad_s, .. } =
            report;
        let Some([q, theta]) = report.sample else {
            return self.line(&format!("# {t_s} s: no usable sample; u_rad {u_rad}, section {section}"));
        };
        let [settling, drift, innovation] = report.figures;
        self.rows += 1;
        self.line(&format!(
            "{t_s},{u_rad},{q},{theta},{section},{},{theta_ref_rad},{excitation_rad},{error_rad_s},{settling},{drift},{innovation}",
            u8::from(*supervised)
        ))
    }

    /// Writes a comment.
    pub fn note(&mut self, text: &str) -> Result<(), Failure> {
        let text = text.replace(['\n', '\r'], " ");
        self.line(&format!("# {text}"))
    }

    fn line(&mut self, text: &str) -> Result<(), Failure> {
        writeln!(self.file, "{text}").map_err(|error| self.unwritable(&error))
    }

    /// Hands what has been written to the system.
    pub fn flush(&mut self) -> Result<(), Failure> {
        self.file.flush().map_err(|error| self.unwritable(&error))
    }

    /// Ends the recording and moves it to its place; one without a cycle leaves nothing.
    pub fn finish(&mut self) -> Result<(), Failure> {
        self.flush()?;
        if self.part == self.path {
            return Ok(());
        }
        if self.last.is_none() {
            return std::fs::remove_file(&self.part).map_err(|error| self.unwritable(&error));
        }
        let moved = self.file.get_ref().sync_all().and_then(|()| std::fs::rename(&self.part, &self.path));
        moved.map_err(|error| self.unwritable(&error))
    }

    fn unwritable(&self, error: &std::io::Error) -> Failure {
        Failure::unwritable(&self.part, error)
    }
}

/// The place of a recording, and where it lies until it is finished: the same where the place is no plain file, as a device or a pipe.
fn places(path: &Path) -> (PathBuf, PathBuf) {
    // a link stays a link
    let path = path.canonicalize().unwrap_or_else(|_| path.to_owned());
    if path.metadata().is_ok_and(|present| !present.is_file()) {
        return (path.clone(), path);
    }
    let mut part = path.clone().into_os_string();
    part.push(".part");
    (path, part.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::board::Phase;

    fn report(tick: u32, time_us: u64) -> CycleReport {
        CycleReport {
            time_us,
            tick,
            section: "I",
            phase: Phase::Exciting,
            supervised: false,
            sample: Some([0.1, 0.2]),
            u_rad: 0.015,
            excitation_rad: 0.015,
            theta_ref_rad: 0.0,
            error_rad_s: 0.0,
            verdict: "converging",
            figures: [0.0; 3],
        }
    }

    fn written(reports: &[CycleReport]) -> (String, u64, u64) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.csv");
        let mut log = Log::create(&path, "a test").unwrap();
        reports.iter().for_each(|report| log.cycle(report).unwrap());
        log.finish().unwrap();
        (std::fs::read_to_string(&path).unwrap(), log.rows, log.lost)
    }

    #[test]
    fn time_starts_at_zero_and_lost_cycles_are_counted() {
        let (text, rows, lost) =
            written(&[report(7, 500_140_000), report(8, 500_160_000), report(12, 500_240_000)]);
        assert_eq!((rows, lost), (3, 3));
        let lines: Vec<&str> = text.lines().skip(2).collect();
        assert!(lines[0].starts_with("0,0.015,0.1,0.2,I,0,0,0.015,"), "{}", lines[0]);
        assert!(lines[1].starts_with("0.02,"));
        assert_eq!(lines[2], "# 3 cycles did not arrive");
        assert!(lines[3].starts_with("0.1,"));
    }

    #[test]
    fn time_runs_on_after_a_reset_of_the_board() {
        let (text, rows, lost) = written(&[report(900, 18_000_000), report(1, 20_000)]);
        assert_eq!((rows, lost), (2, 0));
        let t: f64 = text.lines().last().unwrap().split(',').next().unwrap().parse().unwrap();
        assert!((0.02..5.0).contains(&t), "{t}");
        assert!(text.contains("# the board's clock began anew"));
    }

    #[test]
    fn a_cycle_without_a_sample_is_kept_as_a_comment() {
        let (text, rows, _) = written(&[CycleReport { sample: None, ..report(1, 20_000) }]);
        assert_eq!(rows, 0);
        assert!(text.ends_with("# 0 s: no usable sample; u_rad 0.015, section I\n"), "{text}");
    }
}
