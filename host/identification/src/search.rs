//! The searches: many starts, screened on a thinned recording; the best go on to their ends on it,
//! and the best of these on all rows.

use std::borrow::Cow;

use rayon::prelude::*;

use super::data::Data;
use super::descent::{End, Limits, is_clearly_better, search};
use super::plan::{Plan, ROWS, SCREENING, best, better, levels};
use super::problem::Point;
use super::robust::{self, Robust};
use super::starts::{Start, starts};
use super::{CONVERGED, Loss, Options};
use crate::progress::{Part, Work};

/// Ends that are searched from on all rows, at most.
const POLISHED: usize = 4;
/// Ends that are searched from on a recording between the thinned one and all rows, at most.
const FINALISTS: usize = 12;
/// Sums of squares larger than the least by this share are not searched from: which of two that
/// differ by less is better, few rows may not tell.
const NEAR: f64 = 0.1;

/// The searches of an identification.
pub struct Searches<'a> {
    /// How they are made.
    pub options: &'a Options,
    /// What they are planned to be.
    pub plan: Plan,
    /// Who counts the evaluations.
    pub work: &'a Work<'a>,
}

impl Searches<'_> {
    /// Screens all starts, and brings the best to their ends on a thinned recording; the best end
    /// comes first.
    pub fn everywhere<const K: usize>(&self, data: &Data) -> Vec<End> {
        let Options { starts: count, seed, tolerance, .. } = *self.options;
        let (thinned, rows) = (&*data.thinned(ROWS), data.count());
        let screening = Limits { patience: SCREENING, tolerance: CONVERGED };
        let part = self.work.begin(self.plan.screening);
        let starts = starts(&data.coordinates, count, seed);
        let kinds: Vec<Start> = match thinned.where_kinds_agree() {
            Some(agreed) => {
                let screened = search_all::<K>(&agreed, &starts, screening, &part).into_iter();
                screened.take(better(count, rows)).map(|(end, _)| of_better_kind::<K>(thinned, end)).collect()
            }
            None => {
                let both: Vec<Start> =
                    starts.iter().flat_map(|start| [start.of_other_kind(), start.clone()]).collect();
                let screened = search_all::<K>(thinned, &both, screening, &part).into_iter();
                screened.take(better(2 * count, rows)).map(|(end, _)| end).collect()
            }
        };
        let screened = search_all::<K>(thinned, &kinds, screening, &part);
        drop(part);
        let best: Vec<Start> = screened.into_iter().take(best(count, rows)).map(|(end, _)| end).collect();
        let part = self.work.begin(self.plan.converging);
        let mut ends = search_all::<K>(thinned, &best, Limits::to_the_end(tolerance), &part);
        // The other kind of muscle, if none is of it.
        let (first, _) = &ends[0];
        if ends.iter().all(|(end, _)| end.preconditioned == first.preconditioned) {
            ends.push(search::<K>(thinned, &first.of_other_kind(), Limits::to_the_end(tolerance), &part));
        }
        sort(&mut ends);
        remove_repeated(&mut ends, thinned);
        ends
    }

    /// Searches from some starts to their ends on a thinned recording; the best end comes first.
    pub fn onwards<const K: usize>(&self, data: &Data, starts: &[Start]) -> Vec<End> {
        let part = self.work.begin(self.plan.freeing);
        search_all::<K>(&data.thinned(ROWS), starts, Limits::to_the_end(self.options.tolerance), &part)
    }

    /// Ends on a thinned recording, the one to be believed first.
    pub fn believed<const K: usize>(&self, data: &Data, ends: Vec<End>) -> Vec<End> {
        match self.options.loss {
            Loss::Squares => prefer_preconditioned(ends),
            Loss::Huber => {
                let fits = robust::of_both_kinds::<K>(
                    &data.thinned(ROWS),
                    &ends,
                    &self.work.begin(self.plan.robust),
                );
                fits.into_iter().map(|fit| fit.end).collect()
            }
        }
    }

    /// Goes on from ends on a thinned recording to those on all rows, by way of less thinned ones;
    /// the one to be believed comes first.
    pub fn on_all_rows<'a, const K: usize>(&self, data: &'a Data, ends: &[End]) -> Vec<Robust<'a>> {
        if self.options.loss == Loss::Huber {
            return robust::of_both_kinds::<K>(data, ends, &self.work.begin(self.plan.polishing));
        }
        let limits = Limits::to_the_end(self.options.tolerance);
        let mut starts: Vec<Start> = ends.iter().map(|(end, _)| end.clone()).collect();
        let part = self.work.begin(self.plan.levels);
        for rows in levels(data.count()) {
            let thinned = data.thinned(rows);
            let mut ends = search_all::<K>(&thinned, &starts, limits, &part);
            remove_repeated(&mut ends, &thinned);
            starts = ends.iter().take(near(&ends, POLISHED)).map(|(end, _)| end.clone()).collect();
        }
        drop(part);
        let ends = search_all::<K>(data, &starts, limits, &self.work.begin(self.plan.polishing));
        let plain = |end| Robust { data: Cow::Borrowed(data), end, outliers: Vec::new() };
        prefer_preconditioned(ends).into_iter().map(plain).collect()
    }
}

/// Keeps the first of ends in the same minimum, of ends that are in order: their sums of squares
/// differ by less than what one standard error of one parameter costs, a share of one over the
/// rows.
pub fn remove_repeated(ends: &mut Vec<End>, data: &Data) {
    let same = 1.0 / data.count() as f64;
    ends.dedup_by(|(one, reached), (other, before)| {
        one.preconditioned == other.preconditioned && reached.cost <= before.cost * (1.0 + same)
    });
}

/// How many of the first ends on the thinned recording go on to the next, of one with so many rows
/// that count.
pub fn finalists(ends: &[End], rows: usize) -> usize {
    near(ends, if levels(rows).next().is_some() { FINALISTS } else { POLISHED })
}

/// How many of the first ends are nearly as good as the best of all, at least one.
fn near(ends: &[End], most: usize) -> usize {
    let least = ends.iter().map(|(_, reached)| reached.cost).fold(f64::INFINITY, f64::min);
    let near = ends.iter().take_while(|(_, reached)| reached.cost <= least * (1.0 + NEAR)).count();
    near.clamp(1, most)
}

/// The same point for the kind of muscle that fits better there.
fn of_better_kind<const K: usize>(data: &Data, end: Start) -> Start {
    let other = Point::<K>::new(data, end.of_other_kind(), None);
    if other.cost < Point::<K>::new(data, end.clone(), None).cost { other.at } else { end }
}

/// The ends, best first. Muscles that are measured have mostly been moved before: that one is fresh
/// has to show, where the recording begins, in a clearly smaller error.
fn prefer_preconditioned(mut ends: Vec<End>) -> Vec<End> {
    if let Some(place) = ends.iter().position(|(start, _)| start.preconditioned)
        && !is_clearly_better(&ends[0], &ends[place])
    {
        ends[..=place].rotate_right(1);
    }
    ends
}

/// Searches from all starts, side by side. The best end comes first.
fn search_all<const K: usize>(data: &Data, starts: &[Start], limits: Limits, part: &Part<'_>) -> Vec<End> {
    let mut ends: Vec<End> = starts.par_iter().map(|start| search::<K>(data, start, limits, part)).collect();
    sort(&mut ends);
    ends
}

/// Stable: of equal ends the first start wins, whichever thread was faster.
fn sort(ends: &mut [End]) {
    ends.sort_by(|(_, one), (_, other)| one.cost.total_cmp(&other.cost));
}
