//! How steeply a hysteresis model answers its input, everywhere on its loop.
//!
//! A model of plays is, at every instant, a slope times the rate of its input, and the slope lies
//! between that of a muscle that has just turned round, whose plays stand still, and that of one
//! that is driven on, whose plays all move. So a loop that has its margins on both holds them
//! between. The slopes are taken on the major loop, by steps of the model itself: any model of the
//! family has them.

use model_core::Hysteresis;
use recording::model::HostModel;

/// Places on each branch of the loop.
pub(crate) const PLACES: usize = 8;
/// Speeds at which a driven muscle is looked at.
pub(crate) const SWEEPS: usize = 3;
/// What a driven slope is taken over, as a share of the input's range: wider than a knot.
pub(crate) const DRIVEN: f64 = 0.02;
/// What a turned slope is taken over: less than any play is wide.
const TURNED: f64 = 1e-4;

/// The slopes at a place of the loop. Unit: output unit/input unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// Where. Output unit.
    pub contraction: f64,
    /// Just after the input has turned round.
    pub turned: f64,
    /// While it goes on.
    pub driven: f64,
    /// The lag that it has while it goes on at each of several speeds, where its width depends on the
    /// rate; 0 where it does not. Unit: s.
    pub sliding_s: [f64; SWEEPS],
}

/// The slopes on both branches of the major loop, between its ends.
pub fn slopes(model: &HostModel) -> Vec<Slope> {
    let (low, high) = (model.input_range().min(), model.input_range().max());
    let range = high - low;
    let mut state = model.rest_state();
    // Inputs within the range are finite: no step is refused.
    let mut all = Vec::new();
    for is_rising in [true, false] {
        for place in 0..PLACES {
            let share = (place as f64 + 0.5) / PLACES as f64;
            let way = if is_rising { share } else { 1.0 - share };
            let (x, ahead) = (low + way * range, if is_rising { DRIVEN } else { -DRIVEN } * range);
            let before = model.step(&mut state, x - 0.5 * ahead).unwrap_or_default();
            let contraction = model.step(&mut state, x).unwrap_or_default();
            let mut turned = state.clone();
            let back = TURNED * range * ahead.signum();
            let turned = contraction - model.step(&mut turned, x - back).unwrap_or_default();
            let after = model.step(&mut state, x + 0.5 * ahead).unwrap_or_default();
            all.push(Slope {
                contraction,
                turned: turned / back,
                driven: (after - before) / ahead,
                sliding_s: [0.0; SWEEPS],
            });
        }
        let end = if is_rising { high } else { low };
        model.step(&mut state, end).unwrap_or_default();
    }
    // Where the model is all but level, both are what rounding leaves of 0.
    let steepest = all.iter().fold(0.0_f64, |most, slope| most.max(slope.driven));
    let least = 1e-3 * steepest;
    for slope in &mut all {
        slope.driven = slope.driven.max(least);
        slope.turned = slope.turned.clamp(least, slope.driven);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use model_core::paper;
    use recording::model::HostParameters;

    #[test]
    fn the_paper_s_muscle_is_two_times_as_stiff_where_it_has_turned_and_steepest_in_its_middle() {
        let parameters = HostParameters::Cascade(paper::mgpi().expect("valid").convert().expect("fits"));
        let slopes = slopes(&HostModel::try_new(&parameters).expect("valid"));
        // q over q and all plays, Table 1: 0.2959 of 0.2959 + 0.1827 sum exp(-5.4999 0.08 i).
        let plays: f64 = (1..=10).map(|i| 0.1827 * (-5.4999 * 0.08 * f64::from(i)).exp()).sum();
        let share = 0.2959 / (0.2959 + plays);
        let middle = slopes[4];
        assert!((middle.turned / middle.driven / share - 1.0).abs() < 0.1, "{middle:?}, {share}");
        let steepest = slopes.iter().map(|slope| slope.driven).fold(0.0, f64::max);
        assert!((35.0..55.0).contains(&steepest), "{steepest} mm/bar");
        assert!(slopes.iter().all(|slope| slope.turned > 0.0 && slope.turned <= slope.driven));
    }
}
