//! Work beside the interpreter: others run meanwhile, and Ctrl-C ends it.

use pitchid::Failure;
use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;
use sysid::progress::{Progress, Step};

/// How often it is asked whether someone wants to stop.
const LISTENING: Duration = Duration::from_millis(50);

/// Unwinds work that nobody waits for.
struct Stopped;

/// Does `work` on a thread of its own. An exception of a signal handler (Ctrl-C) is raised at once; the work itself ends
/// with the next step that it reports.
pub fn beside<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce(&Progress<'_>) -> Result<T, Failure> + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = channel();
    let stop = Arc::new(AtomicBool::new(false));
    let stopped = Arc::clone(&stop);
    std::thread::spawn(move || {
        let progress = move |_: Step<'_>| {
            if stopped.load(Ordering::Relaxed) {
                resume_unwind(Box::new(Stopped));
            }
        };
        // nobody may be there to hear it
        let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&progress))));
    });
    loop {
        let heard;
        // a receiver belongs to one thread at a time
        (receiver, heard) = py.detach(move || {
            let heard = receiver.recv_timeout(LISTENING);
            (receiver, heard)
        });
        match heard {
            Ok(Ok(answer)) => return answer.map_err(|failure| crate::failure::raised(py, &failure)),
            Ok(Err(panic)) => resume_unwind(panic),
            Err(RecvTimeoutError::Disconnected) => unreachable!("the thread sends before it ends"),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| stop.store(true, Ordering::Relaxed))?;
            }
        }
    }
}
