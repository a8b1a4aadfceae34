//! What is being done, told to whoever waits.

use std::sync::atomic::{AtomicUsize, Ordering};

/// One piece of news: what is being done, and how much of it is done where that is known.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    /// In words.
    pub what: &'a str,
    /// How many of how many.
    pub done: Option<[usize; 2]>,
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
