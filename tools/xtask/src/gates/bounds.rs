//! The bounds of the figures, and their file.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result};
use serde::Deserialize;

/// What is written above the bounds.
const HEADER: &str = "\
# Bounds of `cargo xtask gates`. A figure below its `lower` or above its `upper` fails: what has become better without
# anybody's knowing is as suspect as what has become worse.
#
# `cargo xtask gates --bless` measures, and writes `compiler`, `lower` and `upper` anew: the figure less and more
# `tolerance_percent`, rounded outwards. It keeps `tolerance_percent` and every `goal`, which are decided, not
# measured: a figure above its `goal` is a goal missed, which every run says.
";

/// A measured figure.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// What it is of, with its unit.
    pub name: String,
    /// Its value.
    pub value: u64,
    /// Where it comes from; nothing where that is plain.
    pub remark: String,
}

/// What a figure has to be.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bound {
    /// The least allowed.
    pub lower: u64,
    /// The most allowed.
    pub upper: u64,
    /// The goal.
    pub goal: Option<u64>,
}

/// The file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Bounds {
    /// The compiler that the bounds were measured with.
    pub compiler: String,
    /// How far from the measured figure the blessed bounds are.
    pub tolerance_percent: f64,
    /// By the figure's name.
    pub figures: BTreeMap<String, Bound>,
}

impl Bounds {
    /// Reads the file.
    ///
    /// # Errors
    /// It cannot be read, or is no file of bounds.
    pub fn read(path: &Path) -> Result<Self> {
        let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        toml::from_str(&text).with_context(|| format!("in {}", path.display()))
    }

    /// Bounds around measured figures, with this file's tolerance and goals.
    pub fn blessed(&self, compiler: &str, figures: &[Figure]) -> Self {
        let around = |figure: &Figure| {
            let value = figure.value as f64;
            let slack = value * self.tolerance_percent / 100.0;
            Bound {
                lower: (value - slack).floor() as u64,
                upper: (value + slack).ceil() as u64,
                goal: self.figures.get(&figure.name).and_then(|bound| bound.goal),
            }
        };
        Self {
            compiler: compiler.to_owned(),
            tolerance_percent: self.tolerance_percent,
            figures: figures.iter().map(|figure| (figure.name.clone(), around(figure))).collect(),
        }
    }

    /// Writes the file, the figures in the order of `figures`.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&self, path: &Path, figures: &[Figure]) -> Result<()> {
        let mut text = format!(
            "{HEADER}compiler = {:?}\ntolerance_percent = {:?}\n\n[figures]\n",
            self.compiler, self.tolerance_percent
        );
        for (name, Bound { lower, upper, goal }) in
            figures.iter().filter_map(|figure| self.figures.get_key_value(&figure.name))
        {
            let goal = goal.map_or_else(String::new, |goal| format!(", goal = {goal}"));
            // Writing to a string cannot fail.
            let _ = writeln!(text, "{name:?} = {{ lower = {lower}, upper = {upper}{goal} }}");
        }
        let beside = path.with_extension("toml.new");
        fs::write(&beside, text)
            .and_then(|()| fs::rename(&beside, path))
            .with_context(|| format!("cannot write {}", path.display()))
    }

    /// The goals that the figures miss, a line each.
    pub fn missed(&self, figures: &[Figure]) -> Vec<String> {
        let missed = |Figure { name, value, .. }: &Figure| {
            let goal = self.figures.get(name)?.goal?;
            (*value > goal).then(|| format!("{name}: {value}, at most {goal}"))
        };
        figures.iter().filter_map(missed).collect()
    }

    /// What is wrong with the figures, a line each.
    pub fn violations(&self, figures: &[Figure]) -> Vec<String> {
        let outside = figures.iter().filter_map(|figure| {
            let Figure { name, value, .. } = figure;
            let Some(Bound { lower, upper, .. }) = self.figures.get(name) else {
                return Some(format!("{name}: {value} has no bounds"));
            };
            let is_inside = (lower..=upper).contains(&value);
            (!is_inside).then(|| format!("{name}: {value} is not within {lower} to {upper}"))
        });
        let unmeasured =
            self.figures.keys().filter(|name| figures.iter().all(|figure| figure.name != **name));
        outside.chain(unmeasured.map(|name| format!("{name}: has bounds but is not measured"))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::{Bound, Bounds, Figure};

    fn figure(name: &str, value: u64) -> Figure {
        Figure { name: name.to_owned(), value, remark: String::new() }
    }

    fn bounds(tolerance_percent: f64, figures: &[(&str, Bound)]) -> Bounds {
        Bounds {
            compiler: "rustc".to_owned(),
            tolerance_percent,
            figures: figures.iter().map(|(name, bound)| ((*name).to_owned(), *bound)).collect(),
        }
    }

    #[test]
    fn a_figure_outside_either_bound_is_named_with_both() {
        let bounds = bounds(1.0, &[("a", Bound { lower: 90, upper: 100, goal: None })]);
        assert!(bounds.violations(&[figure("a", 90)]).is_empty());
        assert!(bounds.violations(&[figure("a", 100)]).is_empty());
        assert_eq!(bounds.violations(&[figure("a", 89)]), ["a: 89 is not within 90 to 100"]);
        assert_eq!(bounds.violations(&[figure("a", 101)]), ["a: 101 is not within 90 to 100"]);
    }

    #[test]
    fn a_missed_goal_is_said_whatever_is_blessed() {
        let old = bounds(1.0, &[("a", Bound { lower: 90, upper: 100, goal: Some(100) })]);
        let figures = [figure("a", 120)];
        let blessed = old.blessed("another rustc", &figures);
        assert_eq!(blessed.figures["a"], Bound { lower: 118, upper: 122, goal: Some(100) });
        assert!(blessed.violations(&figures).is_empty());
        assert_eq!(blessed.missed(&figures), ["a: 120, at most 100"]);
        assert!(blessed.missed(&[figure("a", 100)]).is_empty());
    }

    #[test]
    fn figures_and_bounds_without_the_other_are_violations() {
        let bounds = bounds(1.0, &[("a", Bound { lower: 0, upper: 1, goal: None })]);
        let violations = bounds.violations(&[figure("b", 1)]);
        assert_eq!(violations, ["b: 1 has no bounds", "a: has bounds but is not measured"]);
    }

    #[test]
    fn what_is_written_is_read_again() {
        let directory = tempfile::tempdir().expect("a directory");
        let path = directory.path().join("gates.toml");
        let figures = [figure("b, \"quoted\"", 12), figure("a", 200)];
        let blessed =
            bounds(2.0, &[("a", Bound { lower: 0, upper: 1, goal: Some(250) })]).blessed("rustc 1", &figures);
        blessed.write(&path, &figures).expect("written");
        assert_eq!(Bounds::read(&path).expect("read"), blessed);
    }
}
