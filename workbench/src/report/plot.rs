//! The one look of all plots: lines over two axes, drawn as SVG.
//!
//! Colours are those of Okabe and Ito, which people with any common colour vision tell apart; in print and for
//! those who see no colours the lines differ in width and dashes. Each colour has a second value for dark
//! backgrounds, which [`colour_style`] turns into style rules.

use maud::{Markup, PreEscaped, html};
use plotters::prelude::*;
use thiserror::Error;

use super::simplify::simplify;

/// Size of the drawing: small, so that its text stays readable when a phone scales it. Unit: pixels.
const SIZE: (u32, u32) = (640, 400);
/// Largest deviation of a simplified line. Unit: pixels.
const TOLERANCE: f64 = 0.3;
/// Share of an axis that is left free at either end.
const MARGIN: f64 = 0.04;
const FONT: &str = "sans-serif";
const FONT_SIZE: u32 = 18;
/// Height of title and legend above a plot of a sheet. Unit: pixels.
const HEAD: u32 = 52;
/// What an entry of a sheet's legend needs beside its letters, and about what a letter needs. Unit: pixels.
const KEY_WIDTH: u32 = 60;
const KEY_LETTER: u32 = 8;

/// A plot could not be drawn.
#[derive(Debug, Error)]
#[error("the plot \"{title}\" cannot be drawn: {reason}")]
pub struct DrawingError {
    title: String,
    reason: String,
}

impl DrawingError {
    /// That something cannot be drawn, and why.
    pub(super) fn new(title: &str, reason: impl std::fmt::Display) -> Self {
        Self { title: title.to_owned(), reason: reason.to_string() }
    }
}

/// What a line stands for, and so how it looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// What happened: a thick blue line.
    Measured,
    /// What was computed or wanted: a thin dashed vermilion line.
    Model,
    /// A difference, or a line of its own: a thin green one.
    Error,
    /// Axes and text.
    Ink,
    /// The lines behind.
    Grid,
}

impl Style {
    const ALL: [Self; 5] = [Self::Measured, Self::Model, Self::Error, Self::Ink, Self::Grid];

    /// Colour on a light background, and on a dark one.
    fn colours(self) -> (RGBColor, RGBColor) {
        match self {
            Self::Measured => (RGBColor(0, 114, 178), RGBColor(86, 180, 233)),
            Self::Model => (RGBColor(213, 94, 0), RGBColor(240, 160, 60)),
            Self::Error => (RGBColor(0, 128, 96), RGBColor(60, 200, 155)),
            Self::Ink => (RGBColor(51, 51, 51), RGBColor(210, 210, 210)),
            Self::Grid => (RGBColor(221, 221, 221), RGBColor(64, 64, 64)),
        }
    }

    fn light(self) -> RGBColor {
        self.colours().0
    }

    /// The colour on a light background, as SVG writes it.
    pub fn hex(self) -> String {
        hex(self.light())
    }

    /// Width of a line. Unit: pixels.
    fn width(self) -> u32 {
        match self {
            Self::Measured => 3,
            Self::Model => 2,
            Self::Error | Self::Ink | Self::Grid => 1,
        }
    }
}

/// A line of a plot.
pub struct Line<'a> {
    /// What it shows, for the legend.
    pub name: &'a str,
    /// How it looks.
    pub style: Style,
    /// Horizontal values.
    pub x: &'a [f64],
    /// Vertical values, as many; a NaN interrupts the line.
    pub y: &'a [f64],
}

impl Line<'_> {
    /// A stroke of the line's look and its name, for the legend.
    fn key(&self) -> Markup {
        html! {
            span {
                svg width="36" height="10" aria-hidden="true" {
                    line x1="0" x2="36" y1="5" y2="5" stroke=(self.style.hex())
                        stroke-width=(self.style.width()) {}
                }
                (self.name)
            }
        }
    }
}

/// A point with a name beside it.
pub struct Point<'a> {
    /// Its name.
    pub name: &'a str,
    /// Its place.
    pub at: (f64, f64),
    /// Where the name begins, from the point to the right and down. Unit: pixels.
    pub offset: (i32, i32),
}

/// A plot: lines over two axes.
#[derive(Default)]
pub struct Plot<'a> {
    /// What it shows, which is also its name for those who do not see it.
    pub title: String,
    /// Name and unit of the horizontal axis.
    pub x: String,
    /// Name and unit of the vertical axis.
    pub y: String,
    /// The lines, the first at the back. Those without a name are not in the legend.
    pub lines: Vec<Line<'a>>,
    /// Points with names, in front of the lines.
    pub points: Vec<Point<'a>>,
}

/// A range of values along an axis.
type Span = (f64, f64);

impl Plot<'_> {
    /// The plot with its title and legend, as a figure of a page.
    ///
    /// # Errors
    /// The drawing library refuses.
    pub fn figure(&self) -> Result<Markup, DrawingError> {
        let drawing = self.drawing()?;
        Ok(html! {
            figure {
                figcaption {
                    (self.title)
                    @if self.has_legend() {
                        div.legend { @for line in self.named() { (line.key()) } }
                    }
                }
                svg role="img" viewBox=(format!("0 0 {} {}", SIZE.0, SIZE.1)) xmlns="http://www.w3.org/2000/svg" {
                    title { (self.title) ": " (self.y) " over " (self.x) }
                    (PreEscaped(drawing))
                }
            }
        })
    }

    fn named(&self) -> impl Iterator<Item = &Line<'_>> {
        self.lines.iter().filter(|line| !line.name.is_empty())
    }

    fn has_legend(&self) -> bool {
        self.named().count() > 1
    }

    /// The content of the drawing: the library's own element has neither a role nor a name.
    fn drawing(&self) -> Result<String, DrawingError> {
        let svg = self.svg().map_err(|error| DrawingError::new(&self.title, error))?;
        let drawing = svg.split_once('>').map_or("", |(_, content)| content);
        Ok(drawing.trim_end().trim_end_matches("</svg>").to_owned())
    }

    /// The plot below its title and legend, as a part of a sheet.
    fn panel(&self) -> Result<Markup, DrawingError> {
        let ink = Style::Ink.hex();
        let middle = SIZE.0 / 2;
        let keys: Vec<_> = if self.has_legend() { self.named().collect() } else { Vec::new() };
        let mut places = Vec::new();
        let mut end = 0;
        for line in &keys {
            places.push(end);
            end += KEY_WIDTH + KEY_LETTER * line.name.chars().count() as u32;
        }
        let start = middle.saturating_sub(end / 2);
        Ok(html! {
            g font-family=(FONT) font-size="16" fill=(ink) {
                text x=(middle) y="20" text-anchor="middle" font-weight="600" { (self.title) }
                @for (line, place) in keys.iter().zip(&places) {
                    g transform=(format!("translate({},42)", start + place)) {
                        line x1="0" x2="30" y1="-5" y2="-5" stroke=(line.style.hex())
                            stroke-width=(line.style.width()) {}
                        text x="36" { (line.name) }
                    }
                }
            }
            g transform=(format!("translate(0,{HEAD})")) stroke-linejoin="round" { (PreEscaped(self.drawing()?)) }
        })
    }

    fn svg(&self) -> Result<String, Box<dyn std::error::Error + '_>> {
        let mut svg = String::new();
        {
            let area = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
            let (x_span, y_span) = (self.span(|line| line.x), self.span(|line| line.y));
            let text = (FONT, FONT_SIZE).into_font().color(&Style::Ink.light());
            let mut chart = ChartBuilder::on(&area)
                .margin(10)
                .margin_right(20)
                .x_label_area_size(52)
                .y_label_area_size(76)
                .build_cartesian_2d(x_span.0..x_span.1, y_span.0..y_span.1)?;
            chart
                .configure_mesh()
                .axis_style(Style::Ink.light())
                .bold_line_style(Style::Grid.light())
                .max_light_lines(0)
                .x_labels(7)
                .y_labels(6)
                .label_style(text.clone())
                .axis_desc_style(text)
                .x_label_formatter(&|value| label(*value, x_span))
                .y_label_formatter(&|value| label(*value, y_span))
                .x_desc(&self.x)
                .y_desc(&self.y)
                .draw()?;
            for line in &self.lines {
                let stroke = line.style.light().stroke_width(line.style.width());
                for piece in visible(line, x_span, y_span) {
                    chart.draw_series(LineSeries::new(piece, stroke))?;
                }
            }
            for point in &self.points {
                let dot = Circle::new((0, 0), 4, Style::Ink.light().filled());
                let name = Text::new(
                    point.name.to_owned(),
                    point.offset,
                    (FONT, FONT_SIZE).into_font().color(&Style::Ink.light()),
                );
                chart.draw_series([EmptyElement::at(point.at) + dot + name])?;
            }
            area.present()?;
        }
        Ok(svg)
    }

    /// The values of all lines along an axis, and a margin.
    fn span(&self, axis: impl for<'a> Fn(&'a Line<'a>) -> &'a [f64]) -> Span {
        let values = self.lines.iter().flat_map(|line| axis(line).iter().copied());
        let (min, max) = values
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), value| (min.min(value), max.max(value)));
        let margin = if max > min { MARGIN * (max - min) } else { 1.0 };
        (min - margin, max + margin)
    }
}

/// Plots side by side, two in a row, as a picture of its own on white ground.
///
/// # Errors
/// A plot cannot be drawn.
pub fn sheet(title: &str, plots: &[Plot<'_>]) -> Result<String, DrawingError> {
    let panels = plots.iter().map(Plot::panel).collect::<Result<Vec<_>, _>>()?;
    let height = HEAD + SIZE.1;
    let (columns, rows) = (plots.len().clamp(1, 2), plots.len().div_ceil(2));
    let (width, all) = (SIZE.0 * columns as u32, height * rows as u32);
    let picture = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {all}")) role="img" {
            title { (title) }
            style { (PreEscaped(dashes())) }
            rect width=(width) height=(all) fill="#fff" {}
            @for (i, panel) in panels.iter().enumerate() {
                g transform=(format!("translate({},{})", SIZE.0 * (i % 2) as u32, height * (i / 2) as u32)) { (panel) }
            }
        }
    };
    Ok(picture.into_string() + "\n")
}

/// The pieces of a line, of the points that make a difference to the eye.
fn visible(line: &Line<'_>, x_span: Span, y_span: Span) -> Vec<Vec<(f64, f64)>> {
    let scale = |span: Span, pixels: u32| f64::from(pixels) / (span.1 - span.0);
    let (x_scale, y_scale) = (scale(x_span, SIZE.0), scale(y_span, SIZE.1));
    let pixels: Vec<_> = line.x.iter().zip(line.y).map(|(x, y)| (x * x_scale, y * y_scale)).collect();
    pixels
        .split(|(_, y)| y.is_nan())
        .map(|piece| {
            simplify(piece, TOLERANCE).into_iter().map(|(x, y)| (x / x_scale, y / y_scale)).collect()
        })
        .collect()
}

/// A number at an axis, with as many decimals as the axis needs.
fn label(value: f64, span: Span) -> String {
    let decimals = (1.0 - ((span.1 - span.0) / 2.0).log10().floor()).clamp(0.0, 9.0) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn hex(colour: RGBColor) -> String {
    format!("#{:02X}{:02X}{:02X}", colour.0, colour.1, colour.2)
}

/// The style rule that dashes the model's lines.
fn dashes() -> String {
    format!("[stroke=\"{}\"]{{stroke-dasharray:7 3}}\n", Style::Model.hex())
}

/// Style rules of the plots: dashes for the model, and the colours for dark backgrounds.
pub fn colour_style() -> String {
    let mut rules = dashes();
    rules += "@media screen and (prefers-color-scheme: dark) {\n";
    for style in Style::ALL {
        let (light, dark) = style.colours();
        for property in ["stroke", "fill"] {
            let (light, dark) = (hex(light), hex(dark));
            rules += &format!("[{property}=\"{light}\"]{{{property}:{dark}}}\n");
        }
    }
    rules + "}\n"
}
