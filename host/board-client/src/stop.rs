//! A request to stop, which Ctrl-C makes and threads share.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Asks all that share it to stop.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// One that Ctrl-C requests, and what else asks a program to end.
    pub fn on_signals() -> Self {
        let stop = Self::default();
        let requested = stop.clone();
        // Fails where a handler is installed already; the program then ends by the signal itself.
        let _ = ctrlc::set_handler(move || requested.request());
        stop
    }

    /// Asks.
    pub fn request(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether somebody has asked.
    pub fn is_requested(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}
