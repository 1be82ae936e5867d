//! Fewer points for the same picture.
//!
//! # Design
//! - A line over an axis that only rises, time above all, has in each column of pixels the first,
//!   the lowest, the highest and the last of its points, which draws the same picture (M4: Jugel
//!   and others, VLDB 2014).
//! - Any other line, a loop above all, is simplified by Douglas and Peucker's method (1973): a
//!   point stays if the line would otherwise miss it by more than a tolerance. Where that leaves
//!   too many points, evenly spaced stretches of the line are drawn, since a tolerance that the eye
//!   sees would change the loops' shape.
//!
//! # Limits
//! A line has about [`MOST_POINTS`] points, whatever its recording has. The time that a long loop
//! takes grows with its rows, since only `MOST_LOOKED_AT` of them are simplified.

/// A line has no more points, but for the ends of its pieces.
pub const MOST_POINTS: usize = 3000;
/// Points of a loop that are simplified, at most.
const MOST_LOOKED_AT: usize = 40 * MOST_POINTS;
/// Stretches of a line that is too long.
const STRETCHES: usize = 8;
/// The tolerance that is not to be seen yet. Unit: pixels.
const UNSEEN: f64 = 0.8;
/// By what the tolerance grows.
const GROWTH: f64 = 1.5;

/// A place in the drawing. Unit: pixels.
pub type Place = (f64, f64);

/// Simplifies a line to the pieces that are drawn; a place that is not a number interrupts it. Unit
/// of the tolerance: pixels.
pub fn simplify(line: &[Place], tolerance: f64) -> Vec<Vec<Place>> {
    let pieces = pieces(line);
    let count = length(&pieces);
    if count > MOST_POINTS && only_rises(&pieces) {
        return by_columns(&pieces);
    }
    let pieces = stretches(&pieces, MOST_LOOKED_AT);
    let mut tolerance = tolerance;
    loop {
        let kept: Vec<Vec<Place>> = pieces.iter().map(|piece| kept(piece, tolerance)).collect();
        if length(&kept) <= MOST_POINTS {
            return kept;
        }
        if tolerance > UNSEEN {
            let kept: Vec<&[Place]> = kept.iter().map(Vec::as_slice).collect();
            return stretches(&kept, MOST_POINTS).into_iter().map(<[Place]>::to_vec).collect();
        }
        tolerance *= GROWTH;
    }
}

fn pieces(line: &[Place]) -> Vec<&[Place]> {
    line.split(|(x, y)| x.is_nan() || y.is_nan()).filter(|piece| !piece.is_empty()).collect()
}

fn length(pieces: &[impl AsRef<[Place]>]) -> usize {
    pieces.iter().map(|piece| piece.as_ref().len()).sum()
}

fn only_rises(pieces: &[&[Place]]) -> bool {
    pieces.iter().copied().flatten().is_sorted_by(|one, next| one.0 <= next.0)
}

/// The points of each column of pixels that its picture needs. A gap within a column is not seen,
/// and closed.
fn by_columns(pieces: &[&[Place]]) -> Vec<Vec<Place>> {
    let column = |place: &Place| place.0.floor();
    let mut drawn: Vec<Vec<Place>> = Vec::new();
    for piece in pieces {
        let continues = drawn.last().and_then(|last| last.last()).map(column) == piece.first().map(column);
        if !continues {
            drawn.push(Vec::new());
        }
        for points in piece.chunk_by(|one, next| column(one) == column(next)) {
            let lowest = (0..points.len()).min_by(|&i, &j| points[i].1.total_cmp(&points[j].1));
            let highest = (0..points.len()).max_by(|&i, &j| points[i].1.total_cmp(&points[j].1));
            let mut needed: Vec<usize> =
                [Some(0), lowest, highest, points.len().checked_sub(1)].into_iter().flatten().collect();
            needed.sort_unstable();
            needed.dedup();
            if let Some(last) = drawn.last_mut() {
                last.extend(needed.into_iter().map(|i| points[i]));
            }
        }
    }
    drawn
}

/// The whole pieces if they have no more than `most` points, else about so many in evenly spaced
/// stretches.
fn stretches<'a>(pieces: &[&'a [Place]], most: usize) -> Vec<&'a [Place]> {
    let count = length(pieces);
    if count <= most {
        return pieces.to_vec();
    }
    let (every, long) = (count / STRETCHES, most / STRETCHES);
    let mut begin = 0;
    let mut drawn = Vec::new();
    for piece in pieces {
        for stretch in begin / every..=(begin + piece.len()) / every {
            let from = (stretch * every).clamp(begin, begin + piece.len()) - begin;
            let to = (stretch * every + long).clamp(begin, begin + piece.len()) - begin;
            drawn.push(&piece[from..to]);
        }
        begin += piece.len();
    }
    drawn.retain(|piece| !piece.is_empty());
    drawn
}

fn kept(points: &[Place], tolerance: f64) -> Vec<Place> {
    let Some(last) = points.len().checked_sub(1) else { return Vec::new() };
    let mut keep = vec![false; points.len()];
    (keep[0], keep[last]) = (true, true);
    let mut spans = vec![(0, last)];
    while let Some((first, last)) = spans.pop() {
        let missed = (first + 1..last)
            .map(|i| (distance(points[i], points[first], points[last]), i))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((distance, i)) = missed
            && distance > tolerance
        {
            keep[i] = true;
            spans.extend([(first, i), (i, last)]);
        }
    }
    points.iter().zip(&keep).filter(|(_, keep)| **keep).map(|(point, _)| *point).collect()
}

/// Distance of a point from the segment between two others.
fn distance(point: Place, start: Place, end: Place) -> f64 {
    let (dx, dy) = (end.0 - start.0, end.1 - start.1);
    let square = dx * dx + dy * dy;
    let along = (point.0 - start.0) * dx + (point.1 - start.1) * dy;
    let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    (point.0 - start.0 - share * dx).hypot(point.1 - start.1 - share * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line over pixels 0 to 500, with noise.
    fn noisy(count: usize) -> Vec<Place> {
        let x = |i: usize| 500.0 * i as f64 / count as f64;
        (0..count).map(|i| (x(i), (i * 7919 % 401) as f64)).collect()
    }

    /// Circles, one after the other, each a little larger than the one before.
    fn circles(count: usize) -> Vec<Place> {
        let place = |i: usize| {
            let (angle, radius) = ((i as f64).to_radians(), 100.0 + i as f64 / 1e4 + (i % 7) as f64);
            (radius * angle.cos(), radius * angle.sin())
        };
        (0..360 * count).map(place).collect()
    }

    #[test]
    fn a_straight_line_keeps_its_ends_only() {
        let line: Vec<Place> = (0..1000).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect();
        assert_eq!(simplify(&line, 0.3), [[line[0], line[999]]]);
    }

    #[test]
    fn a_single_outlier_survives_in_a_short_line_and_in_a_long_one() {
        for count in [1000, 100_000] {
            let mut line: Vec<Place> = (0..count).map(|i| (500.0 * i as f64 / count as f64, 0.0)).collect();
            line[count / 2].1 = 50.0;
            assert!(simplify(&line, 0.3).concat().contains(&line[count / 2]), "{count}");
        }
    }

    #[test]
    fn a_closed_loop_stays_open_in_the_middle() {
        let circle: Vec<Place> = (0..=720)
            .map(|i| f64::from(i).to_radians())
            .map(|a| (100.0 * a.cos(), 100.0 * a.sin()))
            .collect();
        let kept = simplify(&circle, 0.3).concat();
        assert!(kept.len() < circle.len() / 4);
        assert!(kept.iter().any(|point| point.1 < -99.0) && kept.iter().any(|point| point.1 > 99.0));
    }

    #[test]
    fn a_line_over_time_keeps_the_lowest_and_highest_of_each_column() {
        let kept = simplify(&noisy(1_000_000), 0.05).concat();
        assert!(kept.len() <= 4 * 501, "{}", kept.len());
        for column in 0..500 {
            let column: Vec<f64> = kept
                .iter()
                .filter(|place| place.0.floor() == f64::from(column))
                .map(|place| place.1)
                .collect();
            assert!(column.contains(&0.0) && column.contains(&400.0));
        }
    }

    #[test]
    fn a_gap_is_drawn_where_it_is_wider_than_a_pixel() {
        let mut line = noisy(100_000);
        line[30_050..30_055].fill((f64::NAN, f64::NAN));
        assert_eq!(simplify(&line, 0.05).len(), 1);
        line[30_050..31_000].fill((f64::NAN, f64::NAN));
        assert_eq!(simplify(&line, 0.05).len(), 2);
    }

    #[test]
    fn loops_without_end_are_drawn_in_stretches_that_keep_their_shape() {
        let drawn = simplify(&circles(3000), 0.05);
        let count = length(&drawn);
        assert!(count <= MOST_POINTS && count > MOST_POINTS / 2, "{count} points");
        assert!(drawn.len() <= 2 * STRETCHES, "{} pieces", drawn.len());
        let steps = drawn.iter().flat_map(|piece| piece.windows(2));
        let longest =
            steps.map(|pair| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1)).fold(0.0, f64::max);
        assert!(longest < 60.0, "a step of {longest} pixels");
    }
}
