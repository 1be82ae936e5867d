//! The one look of all plots: lines over two axes, drawn as SVG.
//!
//! # Design
//! Colours are those of Okabe and Ito, which people with any common colour vision tell apart; in
//! print and for those who see no colours the lines differ in width and dashes. Each colour has a
//! second value for dark backgrounds, which [`colour_style`] turns into style rules.
//!
//! The lines lie in a drawing of their own inside the axes: its view box is what a page's script
//! changes to zoom (`plot.js`), and it cuts off what is outside. The ends of both axes stand in the
//! drawing's `data-` attributes. The script reads values under the pointer, and those of an
//! exported file, from the points that are drawn.
//!
//! Without a script the picture is whole, on paper too: so a plot is a drawing, and no canvas of a
//! plotting library.

use std::fmt::Write as _;

use maud::{Markup, html};

use super::axis::Axis;
pub use super::axis::Scale;
use super::simplify::{Place, simplify};

/// Width of the drawing: small, so that its text stays readable when a phone scales it. Unit:
/// pixels.
const WIDTH: f64 = 640.0;
/// What is left free of lines at the left, the top, the right and the bottom. Unit: pixels.
const FREE: (f64, f64, f64, f64) = (92.0, 10.0, 20.0, 66.0);
/// Largest deviation of a simplified line, small enough to be looked at closely. Unit: pixels.
const TOLERANCE: f64 = 0.05;
/// Most numbers at the horizontal axis.
const TICKS: usize = 7;
const FONT: &str = "sans-serif";
const FONT_SIZE: f64 = 18.0;
/// What half the height of a letter is. Unit: pixels.
const HALF_LETTER: f64 = 6.0;
/// Height of title and legend above a plot of a sheet. Unit: pixels.
const HEAD: f64 = 52.0;
/// What an entry of a sheet's legend needs beside its letters, and about what a letter needs. Unit:
/// pixels.
const KEY_WIDTH: f64 = 60.0;
const KEY_LETTER: f64 = 8.0;

/// What a line stands for, and so how it looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// What happened: a thick blue line.
    Measured,
    /// What was computed or wanted: a thin dashed vermilion line.
    Model,
    /// A difference, or a line of its own: a thin green one.
    Error,
    /// Axes, text, and lines that others are read against.
    Ink,
    /// The lines behind.
    Grid,
}

impl Style {
    const ALL: [Self; 5] = [Self::Measured, Self::Model, Self::Error, Self::Ink, Self::Grid];

    /// Colour on a light background, and on a dark one.
    fn colours(self) -> (&'static str, &'static str) {
        match self {
            Self::Measured => ("#0072B2", "#56B4E9"),
            Self::Model => ("#D55E00", "#F0A03C"),
            Self::Error => ("#008060", "#3CC89B"),
            Self::Ink => ("#333333", "#D2D2D2"),
            Self::Grid => ("#DDDDDD", "#404040"),
        }
    }

    /// The colour on a light background.
    pub fn hex(self) -> &'static str {
        self.colours().0
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

/// How high a plot is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Height {
    /// For a plot by itself.
    #[default]
    Whole,
    /// For one of several that stand over each other.
    Low,
}

impl Height {
    /// Of the drawing. Unit: pixels.
    fn pixels(self) -> f64 {
        match self {
            Self::Whole => 400.0,
            Self::Low => 250.0,
        }
    }

    /// Where the lines lie: left, top, width, height. Unit: pixels.
    fn area(self) -> (f64, f64, f64, f64) {
        let (left, top, right, bottom) = FREE;
        (left, top, WIDTH - left - right, self.pixels() - top - bottom)
    }

    /// Most numbers at the vertical axis.
    fn ticks(self) -> usize {
        match self {
            Self::Whole => 6,
            Self::Low => 4,
        }
    }
}

/// A line of a plot.
pub struct Line<'a> {
    /// What it shows, for the legend; empty where the axes say it.
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

    /// The line inside the axes, of the points that make a difference to the eye. Width and height:
    /// those of the area, in pixels.
    fn drawing(&self, (x, width): (&Axis, f64), (y, height): (&Axis, f64)) -> Markup {
        let place = |(&at_x, &at_y): (&f64, &f64)| (x.share(at_x) * width, (1.0 - y.share(at_y)) * height);
        let places: Vec<Place> = self.x.iter().zip(self.y).map(place).collect();
        html! {
            g data-name=(self.name) stroke=(self.style.hex()) stroke-width=(self.style.width()) fill="none" {
                @for piece in simplify(&places, TOLERANCE) { polyline points=(points(&piece)) {} }
            }
        }
    }
}

/// Places as SVG writes them.
fn points(places: &[Place]) -> String {
    let mut text = String::new();
    for (x, y) in places {
        // Writing to a string does not fail.
        let _ = write!(text, "{x:.2},{y:.2} ");
    }
    text.truncate(text.trim_end().len());
    text
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
    /// How values lie on both axes.
    pub scale: Scale,
    /// The lines, the first at the back. Those without a name are not in the legend.
    pub lines: Vec<Line<'a>>,
    /// Points with names, in front of the lines.
    pub points: Vec<Point<'a>>,
    /// Whose time the horizontal axis has: plots of the same clock are enlarged and pointed at
    /// together. Empty: nobody's.
    pub clock: String,
    /// How high it is.
    pub height: Height,
    /// Lowest and highest value that the vertical axis reaches at least, so that plots beside each
    /// other have one scale.
    pub reaches: Option<(f64, f64)>,
}

impl Plot<'_> {
    /// The plot with its title and legend, as a figure of a page.
    pub fn figure(&self) -> Markup {
        let (x, y) = self.axes();
        let ends = |axis: &Axis| format!("{} {}", axis.ends().0, axis.ends().1);
        html! {
            figure {
                figcaption {
                    (self.title)
                    @if self.has_legend() {
                        div.legend { @for line in self.named() { (line.key()) } }
                    }
                }
                svg.plot role="img" tabindex="0" viewBox=(format!("0 0 {WIDTH} {}", self.height.pixels()))
                    xmlns="http://www.w3.org/2000/svg" data-x=(ends(&x)) data-y=(ends(&y))
                    data-x-name=(self.x) data-y-name=(self.y) data-clock=(self.clock)
                    data-ticks=(format!("{TICKS} {}", self.height.ticks()))
                    data-logarithm[self.scale == Scale::Logarithm] {
                    title { (self.title) ": " (self.y) " over " (self.x) }
                    (self.drawing())
                }
            }
        }
    }

    fn named(&self) -> impl Iterator<Item = &Line<'_>> {
        self.lines.iter().filter(|line| !line.name.is_empty())
    }

    fn has_legend(&self) -> bool {
        self.named().next().is_some()
    }

    /// Of all lines.
    fn axes(&self) -> (Axis, Axis) {
        let reaches = self.reaches.into_iter().flat_map(|(low, high)| [low, high]);
        let x = self.lines.iter().flat_map(|line| line.x).copied();
        let y = self.lines.iter().flat_map(|line| line.y).copied();
        (Axis::of(x, self.scale), Axis::of(y.chain(reaches), self.scale))
    }

    /// The plot below its title and legend, as a part of a sheet.
    fn panel(&self) -> Markup {
        let ink = Style::Ink.hex();
        let middle = WIDTH / 2.0;
        let keys: Vec<_> = if self.has_legend() { self.named().collect() } else { Vec::new() };
        let mut places = Vec::new();
        let mut end = 0.0;
        for line in &keys {
            places.push(end);
            end += KEY_WIDTH + KEY_LETTER * line.name.chars().count() as f64;
        }
        let start = (middle - end / 2.0).max(0.0);
        html! {
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
            g transform=(format!("translate(0,{HEAD})")) { (self.drawing()) }
        }
    }

    /// Axes and lines.
    fn drawing(&self) -> Markup {
        let (left, top, width, height) = self.height.area();
        let (right, bottom) = (left + width, top + height);
        let (x, y) = self.axes();
        let across = |share: f64| format!("{:.1}", left + share * width);
        let down = |share: f64, by: f64| format!("{:.1}", bottom - share * height + by);
        let turned = format!("rotate(-90 20 {})", top + height / 2.0);
        html! {
            g font-family=(FONT) font-size=(FONT_SIZE) fill=(Style::Ink.hex()) {
                g.x text-anchor="middle" data-grid=(Style::Grid.hex()) { @for (share, label) in x.ticks(TICKS) {
                    line x1=(across(share)) x2=(across(share)) y1=(top) y2=(bottom) stroke=(Style::Grid.hex()) {}
                    text x=(across(share)) y=(bottom + 22.0) { (label) }
                } }
                g.y text-anchor="end" { @for (share, label) in y.ticks(self.height.ticks()) {
                    line x1=(left) x2=(right) y1=(down(share, 0.0)) y2=(down(share, 0.0)) stroke=(Style::Grid.hex()) {}
                    text x=(left - 8.0) y=(down(share, HALF_LETTER)) { (label) }
                } }
                text x=(left + width / 2.0) y=(self.height.pixels() - 10.0) text-anchor="middle" { (self.x) }
                text x="20" y=(top + height / 2.0) text-anchor="middle" transform=(turned) { (self.y) }
                polyline points=(format!("{left},{top} {left},{bottom} {right},{bottom}")) fill="none"
                    stroke=(Style::Ink.hex()) {}
                svg.lines x=(left) y=(top) width=(width) height=(height) viewBox=(format!("0 0 {width} {height}"))
                    preserveAspectRatio="none" stroke-linejoin="round" {
                    @for line in &self.lines { (line.drawing((&x, width), (&y, height))) }
                }
                g.names { @for Point { name, at, offset } in &self.points {
                    @let (share_x, share_y) = (x.share(at.0), y.share(at.1));
                    circle cx=(across(share_x)) cy=(down(share_y, 0.0)) r="4" {}
                    text x=(format!("{:.1}", left + share_x * width + f64::from(offset.0)))
                        y=(down(share_y, f64::from(offset.1) + 2.0 * HALF_LETTER)) { (name) }
                } }
            }
        }
    }
}

/// Plots side by side, two in a row, as a picture of its own on white ground.
pub fn sheet(title: &str, plots: &[Plot<'_>]) -> String {
    let height = HEAD + Height::Whole.pixels();
    let (columns, rows) = (plots.len().clamp(1, 2), plots.len().div_ceil(2));
    let (width, all) = (WIDTH * columns as f64, height * rows as f64);
    let picture = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(format!("0 0 {width} {all}")) role="img" {
            title { (title) }
            style { (maud::PreEscaped(dashes())) }
            rect width=(width) height=(all) fill="#fff" {}
            @for (i, plot) in plots.iter().enumerate() {
                @let (x, y) = (WIDTH * (i % 2) as f64, height * (i / 2) as f64);
                g transform=(format!("translate({x},{y})")) { (plot.panel()) }
            }
        }
    };
    picture.into_string() + "\n"
}

/// The style rule that dashes the model's lines.
pub fn dashes() -> String {
    format!("[stroke=\"{}\"]{{stroke-dasharray:7 3}}\n", Style::Model.hex())
}

/// Style rules of the plots: dashes for the model, and the colours for dark backgrounds.
pub fn colour_style() -> String {
    let mut rules = dashes();
    rules += "@media screen and (prefers-color-scheme: dark) {\n";
    for style in Style::ALL {
        let (light, dark) = style.colours();
        for property in ["stroke", "fill"] {
            rules += &format!("[{property}=\"{light}\"]{{{property}:{dark}}}\n");
        }
    }
    rules + "}\n"
}
