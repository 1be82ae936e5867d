//! Fewer points for the same picture: Douglas and Peucker's line simplification (1973).
//!
//! A point stays if the simplified line would otherwise miss it by more than a tolerance, so that loops,
//! corners and single outliers look as they do with all points.

/// No line of a plot has more points; the tolerance grows until it is so.
const MOST_POINTS: usize = 3000;

/// Simplifies a line. Coordinates and tolerance: pixels.
pub fn simplify(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    let mut tolerance = tolerance;
    loop {
        let kept = kept(points, tolerance);
        if kept.len() <= MOST_POINTS {
            return kept;
        }
        tolerance *= 1.5;
    }
}

fn kept(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
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
fn distance(point: (f64, f64), start: (f64, f64), end: (f64, f64)) -> f64 {
    let (dx, dy) = (end.0 - start.0, end.1 - start.1);
    let square = dx * dx + dy * dy;
    let along = (point.0 - start.0) * dx + (point.1 - start.1) * dy;
    let share = if square > 0.0 { (along / square).clamp(0.0, 1.0) } else { 0.0 };
    (point.0 - start.0 - share * dx).hypot(point.1 - start.1 - share * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_line_keeps_its_ends_only() {
        let line: Vec<(f64, f64)> = (0..1000).map(|i| (f64::from(i), 2.0 * f64::from(i))).collect();
        assert_eq!(simplify(&line, 0.3), [line[0], line[999]]);
    }

    #[test]
    fn a_single_outlier_survives() {
        let mut line: Vec<(f64, f64)> = (0..1000).map(|i| (f64::from(i), 0.0)).collect();
        line[400].1 = 50.0;
        assert!(simplify(&line, 0.3).contains(&(400.0, 50.0)));
    }

    #[test]
    fn a_closed_loop_stays_open_in_the_middle() {
        let circle: Vec<(f64, f64)> = (0..=720)
            .map(|i| f64::from(i).to_radians())
            .map(|a| (100.0 * a.cos(), 100.0 * a.sin()))
            .collect();
        let kept = simplify(&circle, 0.3);
        assert!(kept.len() < circle.len() / 4);
        assert!(kept.iter().any(|point| point.1 < -99.0) && kept.iter().any(|point| point.1 > 99.0));
    }

    #[test]
    fn noise_is_cut_to_the_largest_number_of_points() {
        let noise: Vec<(f64, f64)> =
            (0..20_000).map(|i| (f64::from(i) / 30.0, f64::from(i * 7919 % 401))).collect();
        assert!(simplify(&noise, 0.3).len() <= MOST_POINTS);
    }
}
