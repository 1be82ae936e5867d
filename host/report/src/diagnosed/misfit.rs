//! The anatomy of the error, as pictures: where it is worst, what it goes with, its frequencies,
//! and the noise.

use maud::{Markup, html};

use super::view::View;
use super::with_unit;
use crate::bars::{Bar, bars};
use crate::page::explained;
use crate::plot::{Line, Plot, Point, Scale, Style};
use crate::table::{Row, table};
use diagnosis::anatomy::axis::{Axis, AxisMean};
use diagnosis::anatomy::spectrum::{Peak, Spectrum};
use diagnosis::anatomy::stretches::Stretch;
use recording::numbers::range;
use recording::numbers::significant;

/// Axes that are drawn, at most.
const MOST_AXES: usize = 6;
/// About what a letter of a drawing is wide. Unit: pixels.
const LETTER: i32 = 9;
/// Half the band that noise stays in, mostly. Unit: standard deviations.
const BAND: f64 = 2.0;

/// The section of the report.
pub fn section(view: &View<'_>) -> Markup {
    let anatomy = &view.diagnosis.anatomy;
    let over_time = OverTime::of(view);
    let over_axes: Vec<OverAxis<'_>> =
        anatomy.axes.iter().filter(|axis| axis.share > 0.0).take(MOST_AXES).map(OverAxis::of).collect();
    let frequencies = Frequencies::of(&anatomy.spectrum);
    let unit = view.unit();
    let memory = with_unit(anatomy.whiteness.memory_s, "s");
    let mut plots = vec![(
        over_time.plot(view),
        "The two thin lines are the band of the sensor's noise: an error within it cannot be bettered. Thick: where it is worst.",
    )];
    plots.extend(over_axes.iter().map(|over| {
        let words =
            "Mean error, with twice its standard error: what is beside 0 by more goes with this quantity.";
        (over.plot(view), words)
    }));
    plots.push((frequencies.plot(view, &anatomy.spectrum.peaks), &frequencies.words));
    html! {
        h2 { "What it gets wrong" }
        p { "The root mean square of the error is " (with_unit(anatomy.rms, &unit)) "; the sensor's own noise is "
            (with_unit(anatomy.noise.deviation, &unit)) ". "
            @if anatomy.whiteness.p_value < 0.05 {
                "Neighbouring errors are alike over about " (memory) ": this is no noise, something is at work."
            } @else {
                "Neighbouring errors have nothing to do with each other, as those of noise."
            }
        }
        (shares(&anatomy.axes))
        (explained(&plots))
        (stretches(&anatomy.stretches, view))
    }
}

/// What the error goes with, as bars.
fn shares(axes: &[AxisMean]) -> Markup {
    let (beyond, chance): (Vec<_>, Vec<_>) = axes.iter().partition(|axis| axis.share > 0.0);
    let rows: Vec<(&str, [f64; 1])> =
        beyond.iter().map(|axis| (axis.axis.quantity(), [100.0 * axis.share])).collect();
    let chance: Vec<&str> = chance.iter().map(|axis| axis.axis.quantity()).collect();
    let groups: Vec<Bar<'_>> =
        rows.iter().map(|(name, values)| Bar { name, values, is_chosen: false }).collect();
    html! {
        @if !groups.is_empty() {
            (bars("What the error goes with: share of its energy, beyond chance (%)", &[], &groups, None))
            p { "Quantities that go with each other (time and travel, say) share what they explain: these are hints, not causes." }
        }
        @if !chance.is_empty() { p { "It goes no more than by chance with: " (chance.join(", ")) "." } }
    }
}

/// The error over time, beside the noise, with its worst stretches.
struct OverTime {
    worst: Vec<f64>,
    ends_s: [f64; 2],
    band: [[f64; 2]; 2],
}

impl OverTime {
    fn of(view: &View<'_>) -> Self {
        let stretches = &view.diagnosis.anatomy.stretches;
        let is_worst = |t: f64| stretches.iter().any(|stretch| (stretch.from_s..=stretch.to_s).contains(&t));
        let rows = view.time_s.iter().zip(&view.residual);
        let half = BAND * view.diagnosis.anatomy.noise.deviation;
        let ends =
            |values: &[f64]| values.iter().copied().filter(|value| value.is_finite()).collect::<Vec<_>>();
        let times = ends(&view.time_s);
        Self {
            worst: rows.map(|(&t, &error)| if is_worst(t) { error } else { f64::NAN }).collect(),
            ends_s: [times.first(), times.last()].map(|time| time.copied().unwrap_or(0.0)),
            band: [[half; 2], [-half; 2]],
        }
    }

    fn plot<'a>(&'a self, view: &'a View<'_>) -> Plot<'a> {
        let band = |name, y| Line { name, style: Style::Ink, x: &self.ends_s, y };
        let mut lines = vec![view.line("error", Style::Error, &view.residual)];
        if self.worst.iter().any(|error| error.is_finite()) {
            lines.push(view.line("worst", Style::Measured, &self.worst));
        }
        lines.extend([band("noise", &self.band[0][..]), band("", &self.band[1][..])]);
        view.errors_over_time("Error over time", lines)
    }
}

/// The mean error over an axis.
struct OverAxis<'a> {
    mean: &'a AxisMean,
    at: Vec<f64>,
    error: Vec<f64>,
    /// Up and down strokes of the uncertainty.
    bars: (Vec<f64>, Vec<f64>),
}

impl<'a> OverAxis<'a> {
    fn of(mean: &'a AxisMean) -> Self {
        let strokes = mean.bins.iter().flat_map(|bin| {
            let half = BAND * bin.standard_error;
            [(bin.at, bin.mean - half), (bin.at, bin.mean + half), (bin.at, f64::NAN)]
        });
        Self {
            mean,
            at: mean.bins.iter().map(|bin| bin.at).collect(),
            error: mean.bins.iter().map(|bin| bin.mean).collect(),
            bars: strokes.unzip(),
        }
    }

    fn plot(&self, view: &View<'_>) -> Plot<'_> {
        let AxisMean { axis, share, .. } = self.mean;
        Plot {
            title: format!("Error over the {axis}: {} % of its energy", significant(100.0 * share)),
            x: match axis {
                Axis::Time | Axis::SinceChange => format!("{axis} (s)"),
                Axis::Input => view.input_axis(),
                Axis::Output | Axis::Travel => format!("{axis} ({})", view.unit()),
                Axis::Load => "load (N)".to_owned(),
                Axis::Temperature => "temperature (°C)".to_owned(),
                Axis::Direction => "direction of the input: -1 falls, 0 held, 1 rises".to_owned(),
                Axis::Rate => format!("{axis} ({}/s)", view.input_unit()),
                Axis::Cycle => format!("{axis} (1)"),
            },
            y: view.error_axis(),
            lines: vec![
                Line { name: "", style: Style::Ink, x: &self.bars.0, y: &self.bars.1 },
                Line { name: "mean error", style: Style::Measured, x: &self.at, y: &self.error },
            ],
            ..Plot::default()
        }
    }
}

/// The error by frequency.
struct Frequencies {
    frequency_hz: Vec<f64>,
    density: Vec<f64>,
    /// The strongest peak's.
    name: String,
    words: String,
}

impl Frequencies {
    fn of(spectrum: &Spectrum) -> Self {
        let name = |peak: &Peak| format!("{} Hz", significant(peak.frequency_hz));
        let named = |peak: &Peak| {
            let whose = if peak.in_input { " (the input has it too)" } else { "" };
            name(peak) + whose
        };
        let peaks: Vec<String> = spectrum.peaks.iter().map(named).collect();
        Self {
            frequency_hz: spectrum.density.iter().map(|point| point.frequency_hz).collect(),
            density: spectrum.density.iter().map(|point| point.power.sqrt()).collect(),
            name: spectrum.peaks.first().map(name).unwrap_or_default(),
            words: match peaks.is_empty() {
                true => "Slow errors are on the left, fast ones on the right. No tone stands above its neighbours.".to_owned(),
                false => format!(
                    "Slow errors are on the left, fast ones on the right. Tones that stand above their neighbours: {}.",
                    peaks.join(", ")
                ),
            },
        }
    }

    fn plot(&self, view: &View<'_>, peaks: &[Peak]) -> Plot<'_> {
        let height = |peak: &Peak| {
            let points = self.frequency_hz.iter().zip(&self.density);
            let nearest = points.min_by(|one, other| {
                let away = |at: f64| (at / peak.frequency_hz).ln().abs();
                away(*one.0).total_cmp(&away(*other.0))
            });
            nearest.map_or(f64::NAN, |(_, density)| *density)
        };
        // On the side where there is room for it.
        let middle_hz = range(&self.frequency_hz);
        let middle_hz = (middle_hz.0 * middle_hz.1).sqrt();
        let left = -8 - LETTER * self.name.chars().count() as i32;
        let points = peaks.iter().take(1).map(|peak| Point {
            name: &self.name,
            at: (peak.frequency_hz, height(peak)),
            offset: (if peak.frequency_hz > middle_hz { left } else { 8 }, -8),
        });
        Plot {
            title: "Error by frequency".to_owned(),
            x: "frequency (Hz)".to_owned(),
            y: format!("density ({}/√Hz)", view.unit()),
            scale: Scale::Logarithm,
            lines: vec![Line { name: "", style: Style::Measured, x: &self.frequency_hz, y: &self.density }],
            points: points.collect(),
            ..Plot::default()
        }
    }
}

fn stretches(stretches: &[Stretch], view: &View<'_>) -> Markup {
    let (unit, input_unit) = (view.unit(), view.input_unit());
    let headings = [
        "from … to (s)".to_owned(),
        format!("error ({unit})"),
        "share of its energy (%)".to_owned(),
        format!("input from … to ({input_unit})"),
        "input at rest (% of the time)".to_owned(),
        format!("fastest rate of the input ({input_unit}/s)"),
    ];
    let row = |stretch: &Stretch| {
        vec![
            format!("{:.1} … {:.1}", stretch.from_s, stretch.to_s),
            significant(stretch.rms),
            format!("{:.0}", 100.0 * stretch.share),
            format!("{} … {}", significant(stretch.lowest_input), significant(stretch.highest_input)),
            format!("{:.0}", 100.0 * stretch.held_share),
            significant(stretch.fastest_rate),
        ]
        .into()
    };
    let rows: Vec<Row> = stretches.iter().map(row).collect();
    html! {
        @if stretches.is_empty() {
            p { "The error is about the same everywhere: there is no worst stretch." }
        } @else {
            h3 { "Where it is worst" }
            (table(&headings, &rows))
        }
    }
}
