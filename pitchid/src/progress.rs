//! A sign of life on standard error while something takes long; nothing where that is not a terminal, or with `--quiet`.

use crate::output;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::time::Duration;
use sysid::progress::Step;

/// Where the number of parts is not known.
const UNKNOWN: &str = "{spinner} {elapsed:>4} {wide_msg}";
/// Where it is.
const KNOWN: &str = "{spinner} {elapsed:>4} {msg}: {pos} of {len}, about {eta} left {wide_bar}";

/// What is being done, how far it is, the time that has passed and that is left; removes itself when dropped.
pub struct Progress(ProgressBar);

impl Progress {
    /// Starts it.
    pub fn start(message: &str) -> Self {
        let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
        if output::is_quiet() {
            bar.set_draw_target(ProgressDrawTarget::hidden());
        }
        let progress = Self(bar);
        progress.draw_as(UNKNOWN);
        progress.0.set_message(message.to_owned());
        progress.0.enable_steady_tick(Duration::from_millis(120));
        progress
    }

    /// Says what is being done now.
    pub fn say(&self, step: Step<'_>) {
        let bar = &self.0;
        let all = step.done.map(|[_, all]| all as u64).filter(|all| *all > 1);
        if bar.message() != step.what || bar.length() != all {
            bar.set_message(step.what.to_owned());
            match all {
                Some(all) => bar.set_length(all),
                None => bar.unset_length(),
            }
            self.draw_as(if all.is_some() { KNOWN } else { UNKNOWN });
            // the time left is that of this work alone
            bar.reset_eta();
        }
        if let Some([done, _]) = step.done {
            bar.set_position(done as u64);
        }
    }

    /// A line above it, where there is something to say; not with `--quiet`.
    pub fn note(&self, text: Option<&str>) {
        if let Some(text) = text.filter(|_| !output::is_quiet()) {
            self.0.suspend(|| eprintln!("{text}"));
        }
    }

    fn draw_as(&self, template: &str) {
        if let Ok(style) = ProgressStyle::with_template(template) {
            self.0.set_style(style);
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
