//! Long work without Python's lock, that Ctrl-C and an exception of the caller's callback end.
//!
//! The work goes on a thread of its own and tells how far it is; the thread that called waits, asks
//! Python for signals, and calls the callback. To end it the work's next word about its progress
//! unwinds its threads: nothing of it is kept, and nothing has to ask whether it is to stop.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use pyo3::prelude::*;

/// How often signals are looked for. A person does not notice a fiftieth of a second.
const LOOK: Duration = Duration::from_millis(20);

/// What unwinds a work that is to end.
struct Stopped;

/// How far a work is: the share, and what is being done.
type Told = (f64, String);

/// Works, and calls `callback(share, what)` now and then.
///
/// # Errors
/// What the callback raises, or a signal: `KeyboardInterrupt`.
pub fn interruptible<T: Send>(
    py: Python<'_>,
    callback: Option<&Py<PyAny>>,
    work: impl FnOnce(&(dyn Fn(f64, &str) + Sync)) -> T + Send,
) -> PyResult<T> {
    let told: Mutex<Told> = Mutex::default();
    let is_stopped = AtomicBool::new(false);
    let tell = |share: f64, what: &str| {
        // What is dropped while it unwinds tells too.
        if is_stopped.load(Ordering::Relaxed) && !thread::panicking() {
            resume_unwind(Box::new(Stopped));
        }
        *told.lock().unwrap_or_else(PoisonError::into_inner) = (share, what.to_owned());
    };
    py.detach(|| {
        let waiting = thread::current();
        thread::scope(|scope| {
            let worker = scope.spawn(|| {
                let result = catch_unwind(AssertUnwindSafe(|| work(&tell)));
                waiting.unpark();
                result
            });
            let mut last = Told::default();
            let mut raised = None;
            while !worker.is_finished() {
                thread::park_timeout(LOOK);
                if raised.is_none()
                    && let Err(error) = look(callback, &told, &mut last)
                {
                    is_stopped.store(true, Ordering::Relaxed);
                    raised = Some(error);
                }
            }
            match (raised, worker.join().unwrap_or_else(Err)) {
                (Some(error), _) => Err(error),
                (None, Ok(result)) => Ok(result),
                (None, Err(panic)) => resume_unwind(panic),
            }
        })
    })
}

/// Looks for signals, and tells the callback what is new.
fn look(callback: Option<&Py<PyAny>>, told: &Mutex<Told>, last: &mut Told) -> PyResult<()> {
    Python::attach(|py| {
        py.check_signals()?;
        let now = told.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if let Some(callback) = callback
            && now != *last
        {
            callback.call1(py, (now.0, now.1.as_str()))?;
            *last = now;
        }
        Ok(())
    })
}
