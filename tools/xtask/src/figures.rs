//! The figures of the documentation, redrawn by the report's plots:
//! `host/report/examples/figures.rs`.

use anyhow::Result;

use crate::run;

/// Draws them into `docs/figures`, or only compares.
///
/// # Errors
/// When they cannot be drawn, or differ from those that are there.
pub fn figures(check: bool) -> Result<()> {
    let directory = run::root().join("docs/figures");
    let mut draw = run::cargo(&["run", "--quiet", "--example", "figures", "--"]);
    draw.arg(directory).args(check.then_some("--check"));
    run::succeed(&mut draw)
}
