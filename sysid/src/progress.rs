//! What is being done, told to whoever waits.

use std::fmt;
use std::sync::atomic::{AtomicUsize, Ordering};

/// One piece of news: what is being done, and how much of it is done where that is known.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// In words.
    pub what: &'a str,
    /// How many of how many.
    pub done: Option<[usize; 2]>,
}

impl fmt::Display for Step<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.what)?;
        match self.done {
            Some([done, all]) => write!(f, ": {done} of {all}"),
            None => Ok(()),
        }
    }
}

impl<'a> From<&'a str> for Step<'a> {
    fn from(what: &'a str) -> Self {
        Self { what, done: None }
    }
}

/// Who hears of it.
pub type Progress<'a> = dyn Fn(Step<'_>) + Sync + 'a;

/// Counts the parts of a piece of work, whatever the thread.
pub struct Counted<'a> {
    progress: &'a Progress<'a>,
    what: &'a str,
    all: usize,
    done: AtomicUsize,
}

impl<'a> Counted<'a> {
    /// Says that `all` parts are to come.
    pub fn new(progress: &'a Progress<'a>, what: &'a str, all: usize) -> Self {
        progress(Step { what, done: Some([0, all]) });
        Self { progress, what, all, done: AtomicUsize::new(0) }
    }

    /// Says that one more is done.
    pub fn one(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.progress)(Step { what: self.what, done: Some([done, self.all]) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn parts_are_counted_whatever_the_thread() {
        let heard = Mutex::new(Vec::new());
        let progress = |step: Step<'_>| heard.lock().unwrap().push(step.to_string());
        let counted = Counted::new(&progress, "fitting", 2);
        std::thread::scope(|scope| {
            scope.spawn(|| counted.one());
            scope.spawn(|| counted.one());
        });
        let mut heard = heard.into_inner().unwrap();
        heard.sort();
        assert_eq!(heard, ["fitting: 0 of 2", "fitting: 1 of 2", "fitting: 2 of 2"]);
        assert_eq!(Step::from("reading").to_string(), "reading");
    }
}
