//! What a recording says of its regulators, and below which pressures nobody has been.

use recording::joint::columns::JointRecording;

use super::JointError;

/// The names of the pressures' columns.
const PRESSURES: [&str; 2] = ["pressure_a_bar", "pressure_b_bar"];
/// Share of the way to its command that a pressure goes in a row, at most: beyond it the rows are
/// too far apart to tell a time constant.
const LARGEST_SHARE: f64 = 0.98;

/// The time constant of a regulator, s: the pressure goes a share of the way to its command from
/// row to row.
pub(super) fn lag_s(recording: &JointRecording, muscle: usize) -> Result<f64, JointError> {
    let (time_s, scored) = (&recording.time_s, &recording.scored);
    let (command, pressure) = (&recording.commands_bar[muscle], &recording.pressures_bar[muscle]);
    let (mut gone, mut way) = (0.0, 0.0);
    for row in (1..time_s.len()).filter(|row| scored[*row]) {
        let ahead = command[row] - pressure[row - 1];
        gone += (pressure[row] - pressure[row - 1]) * ahead;
        way += ahead * ahead;
    }
    let share = gone / way;
    if share > 0.0 && share < 1.0 {
        let span_s = time_s[time_s.len() - 1] - time_s[0];
        let step_s = span_s / (time_s.len() - 1) as f64;
        Ok(-step_s / (-share.min(LARGEST_SHARE)).ln_1p())
    } else {
        Err(JointError::NotFollowing(PRESSURES[muscle]))
    }
}

/// A line over the angle that no recorded pressure is below: of those the one that is highest in
/// the middle of the angles. Its values at both ends of them.
pub(super) fn lowest(mut points: Vec<(f64, f64)>, (first, last): (f64, f64)) -> [f64; 2] {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut hull: Vec<(f64, f64)> = Vec::new();
    for point in points {
        while let [.., a, b] = hull[..] {
            if (b.0 - a.0) * (point.1 - a.1) > (b.1 - a.1) * (point.0 - a.0) {
                break;
            }
            hull.pop();
        }
        hull.push(point);
    }
    let middle = 0.5 * (first + last);
    let edge = hull.windows(2).find(|edge| edge[1].0 >= middle && edge[1].0 > edge[0].0);
    let at = |angle: f64| match edge {
        Some(&[a, b]) => a.1 + (b.1 - a.1) * (angle - a.0) / (b.0 - a.0),
        _ => hull.iter().map(|point| point.1).fold(f64::INFINITY, f64::min),
    };
    [at(first), at(last)]
}

/// The same above all recorded pressures, lowest in the middle.
pub(super) fn highest(points: Vec<(f64, f64)>, ends: (f64, f64)) -> [f64; 2] {
    lowest(points.into_iter().map(|(angle, bar)| (angle, -bar)).collect(), ends).map(|bar| -bar)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_point_is_below_the_line_and_two_are_on_it() {
        let points: Vec<(f64, f64)> =
            (0..200).map(|k| (f64::from(k) * 0.005 - 0.5, 2.0 + (f64::from(k) * 1.7).sin().abs())).collect();
        let [first, last] = lowest(points.clone(), (-0.5, 0.5));
        let above: Vec<f64> =
            points.iter().map(|(angle, bar)| bar - first - (last - first) * (angle + 0.5)).collect();
        assert!(above.iter().all(|above| *above > -1e-12));
        assert_eq!(above.iter().filter(|above| **above < 1e-9).count(), 2);
    }
}
