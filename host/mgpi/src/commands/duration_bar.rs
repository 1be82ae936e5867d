//! The progress of a run whose length is known.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over so many seconds.
pub fn bar(duration_s: f64) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {eta} left");
    ProgressBar::new((1e3 * duration_s) as u64)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}
