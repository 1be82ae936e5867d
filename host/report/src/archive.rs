//! Report of `mgpi batch`: an archive of recordings, muscle by muscle, from month to month.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use maud::{Markup, html};
use recording::day::Day;
use recording::numbers::legible;

use super::page::page;
use super::plot::{Height, Line, Plot, Style};
use super::table::{Row, table};

/// What was found in a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// Its file.
    pub file: String,
    /// The muscle that it is of.
    pub muscle: String,
    /// When it was made, if that is known.
    pub day: Option<Day>,
    /// What was found, or why nothing was.
    pub result: Result<Figures, String>,
}

/// Errors are root mean squares of simulated models.
#[derive(Clone, Debug, PartialEq)]
pub struct Figures {
    /// The output's unit.
    pub unit: String,
    /// Unit: as said.
    pub stroke: f64,
    /// In a word.
    pub verdict: String,
    /// What acts beside hysteresis; empty if nothing does.
    pub causes: String,
    /// Of the plain model. Unit: as said.
    pub plain_rmse: f64,
    /// Of the model that is written. Unit: as said.
    pub written_rmse: f64,
}

impl Figures {
    /// Unit: percent of stroke.
    fn percent(&self, rmse: f64) -> f64 {
        100.0 * rmse / self.stroke
    }

    fn causes(&self) -> String {
        if self.causes.is_empty() {
            self.verdict.clone()
        } else {
            format!("{}: {}", self.verdict, self.causes)
        }
    }
}

/// The report as an HTML file; `folder`: of the archive.
pub fn to_html(folder: &Path, found: &[Found]) -> String {
    let mut muscles: BTreeMap<&str, Vec<&Found>> = BTreeMap::new();
    for one in found {
        muscles.entry(&one.muscle).or_default().push(one);
    }
    for recordings in muscles.values_mut() {
        recordings.sort_by_key(|one| one.day);
    }
    let refused = found.iter().filter(|one| one.result.is_err()).count();
    let body = html! {
        p { (found.len()) " recordings of " (muscles.len()) " muscles, " (refused) " of them refused. A muscle is a folder; the day is the \
            date in a file's name, else that of its last change." }
        (overview(&muscles))
        @for (muscle, recordings) in &muscles { (history(muscle, recordings)) }
    };
    let source = format!("Recordings of {}", folder.display());
    page(&format!("Muscles of {}", folder.display()), &body, &source)
}

/// A row a muscle.
fn overview(muscles: &BTreeMap<&str, Vec<&Found>>) -> Markup {
    let headings = [
        "muscle",
        "recordings",
        "from",
        "to",
        "stroke, first",
        "stroke, last",
        "change (%)",
        "error, last (% of stroke)",
        "causes seen",
    ];
    let row = |(muscle, recordings): (&&str, &Vec<&Found>)| -> Row {
        let good: Vec<(Option<Day>, &Figures)> =
            recordings.iter().filter_map(|one| Some((one.day, one.result.as_ref().ok()?))).collect();
        let (first, last) = (good.first(), good.last());
        let day = |one: Option<&(Option<Day>, &Figures)>| {
            one.and_then(|(day, _)| *day).map_or_else(String::new, |day| day.to_string())
        };
        let stroke = |one: Option<&(Option<Day>, &Figures)>| {
            one.map_or_else(String::new, |(_, f)| format!("{} {}", legible(f.stroke, 3), f.unit))
        };
        let change = match (first, last) {
            (Some((_, first)), Some((_, last))) if first.unit == last.unit && good.len() > 1 => {
                format!("{:+.1}", 100.0 * (last.stroke / first.stroke - 1.0))
            }
            _ => String::new(),
        };
        let error = last.map_or_else(String::new, |(_, f)| legible(f.percent(f.written_rmse), 2));
        let causes: BTreeSet<&str> =
            good.iter().flat_map(|(_, f)| f.causes.split(" + ")).filter(|cause| !cause.is_empty()).collect();
        let causes = causes.into_iter().collect::<Vec<_>>().join(", ");
        vec![
            name(muscle),
            recordings.len().to_string(),
            day(first),
            day(last),
            stroke(first),
            stroke(last),
            change,
            error,
            if causes.is_empty() { "none".to_owned() } else { causes },
        ]
        .into()
    };
    let rows: Vec<Row> = muscles.iter().map(row).collect();
    html! { h2 { "All muscles" } (table(&headings.map(str::to_owned), &rows)) }
}

/// A muscle from recording to recording.
fn history(muscle: &str, recordings: &[&Found]) -> Markup {
    let dated: Vec<(f64, &Figures)> =
        recordings.iter().filter_map(|one| Some((one.day?.years(), one.result.as_ref().ok()?))).collect();
    let unit = dated.first().map_or("", |(_, figures)| &figures.unit);
    // Of another quantity there is no one line.
    let is_one = dated.iter().all(|(_, figures)| figures.unit == unit);
    let years: Vec<f64> = dated.iter().map(|(year, _)| *year).collect();
    let spread = years.first().zip(years.last()).is_some_and(|(first, last)| last > first);
    let of = |value: fn(&Figures) -> f64| -> Vec<f64> { dated.iter().map(|(_, f)| value(f)).collect() };
    let stroke = of(|figures| figures.stroke);
    let (plain, written) = (
        of(|figures| figures.percent(figures.plain_rmse)),
        of(|figures| figures.percent(figures.written_rmse)),
    );
    let plot = |title: &str, y: String, lines: Vec<Line<'_>>| {
        let plot = Plot {
            title: format!("{title} of {}", name(muscle)),
            x: "year".to_owned(),
            y,
            lines,
            height: Height::Low,
            clock: format!("years of {muscle}"),
            ..Plot::default()
        };
        html! { div { (plot.figure()) } }
    };
    let x = &years[..];
    let headings =
        ["recording", "day", "stroke", "verdict", "plain model (% of stroke)", "written model (% of stroke)"];
    let rows: Vec<Row> = recordings.iter().map(|one| Row::from(cells(one))).collect();
    html! {
        h2 { (name(muscle)) }
        @if spread && is_one {
            div.plots {
                (plot("Stroke", format!("stroke ({unit})"), vec![Line { name: "", style: Style::Measured, x, y: &stroke }]))
                (plot("Error", "RMSE (% of stroke)".to_owned(), vec![
                    Line { name: "plain model", style: Style::Model, x, y: &plain },
                    Line { name: "written model", style: Style::Measured, x, y: &written },
                ]))
            }
        }
        (table(&headings.map(str::to_owned), &rows))
    }
}

/// The muscle of the archive's own folder has no other name.
fn name(muscle: &str) -> String {
    if muscle.is_empty() { "(the folder itself)".to_owned() } else { muscle.to_owned() }
}

fn cells(one: &Found) -> Vec<String> {
    let day = one.day.map_or_else(String::new, |day| day.to_string());
    match &one.result {
        Ok(figures) => vec![
            one.file.clone(),
            day,
            format!("{} {}", legible(figures.stroke, 3), figures.unit),
            figures.causes(),
            legible(figures.percent(figures.plain_rmse), 2),
            legible(figures.percent(figures.written_rmse), 2),
        ],
        Err(error) => {
            vec![
                one.file.clone(),
                day,
                String::new(),
                format!("refused: {error}"),
                String::new(),
                String::new(),
            ]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(muscle: &str, day: &str, stroke: f64, causes: &str) -> Found {
        Found {
            file: format!("{muscle}/{day}.csv"),
            muscle: muscle.to_owned(),
            day: Day::in_name(Path::new(day)),
            result: Ok(Figures {
                unit: "mm".to_owned(),
                stroke,
                verdict: if causes.is_empty() { "adequate" } else { "explained" }.to_owned(),
                causes: causes.to_owned(),
                plain_rmse: 1.0,
                written_rmse: 0.5,
            }),
        }
    }

    #[test]
    fn a_muscle_is_followed_from_its_first_day_to_its_last() {
        let broken =
            Found { result: Err("line 3: no number".to_owned()), ..found("left", "2026-02-01", 1.0, "") };
        let page = to_html(
            Path::new("archive"),
            &[
                found("left", "2026-03-01", 90.0, "creep"),
                broken,
                found("left", "2026-01-01", 100.0, ""),
                found("", "2026-01-05", 50.0, ""),
            ],
        );
        for wanted in [
            "4 recordings of 2 muscles, 1 of them refused",
            "data-label=\"change (%)\">-10.0<",
            "data-label=\"causes seen\">creep<",
            "Stroke of left",
            "explained: creep",
            "refused: line 3: no number",
            "(the folder itself)",
        ] {
            assert!(page.contains(wanted), "{wanted}");
        }
        // A single recording is no line.
        assert!(!page.contains("Stroke of (the folder itself)"));
    }
}
