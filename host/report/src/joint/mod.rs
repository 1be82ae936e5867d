//! Reports of a joint of two muscles.

pub mod identified;
#[cfg(feature = "runs")]
pub mod tracked;

use super::plot::{Line, Plot, Style};

fn degrees(radians: &[f64]) -> Vec<f64> {
    radians.iter().map(|radian| radian.to_degrees()).collect()
}

fn plot<'a>(title: &str, x: &str, y: &str, lines: Vec<Line<'a>>) -> Plot<'a> {
    Plot { title: title.to_owned(), x: x.to_owned(), y: y.to_owned(), lines, ..Plot::default() }
}

/// Over the time of a recording or a run, which all plots of a page have in common.
fn over_time<'a>(title: &str, y: &str, time_s: &'a [f64], lines: &[(&'a str, Style, &'a [f64])]) -> Plot<'a> {
    let lines = lines.iter().map(|&(name, style, y)| Line { name, style, x: time_s, y }).collect();
    Plot { clock: "joint".to_owned(), ..plot(title, "time (s)", y, lines) }
}
