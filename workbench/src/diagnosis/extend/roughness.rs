//! How unevenly an operator rises: the logarithms of the ratios of neighbouring slopes, of envelope and dead zones.
//!
//! What effects make of the input reaches beyond where the rows are: a mass that swings drives the operators to where the
//! recording hardly goes. What rows do not teach there is as around it, rather than whatever slope fits the few that do.

use model_core::dead_zone::DeadZoneParameters;
use model_core::envelope::EnvelopeParameters;

use crate::identification::{DEAD_ZONES, HostParameters};

/// The least slope, so that there is a logarithm. Any unit.
const LEAST: f64 = 1e-9;

/// Of a cascade; nothing of the other models.
pub fn roughness(parameters: &HostParameters) -> Vec<f64> {
    let HostParameters::Cascade(cascade) = parameters else { return Vec::new() };
    let mut all = Vec::new();
    if let EnvelopeParameters::PiecewiseLinear(envelope) = &cascade.envelope {
        let knots = envelope.inputs.windows(2).zip(envelope.values.windows(2));
        let slopes = knots.map(|(inputs, values)| (values[1] - values[0]) / (inputs[1] - inputs[0]));
        all.extend(ratios(slopes));
    }
    all.extend(of_dead_zones(&cascade.dead_zones));
    all
}

/// From 0 outward, to either side.
fn of_dead_zones(zones: &DeadZoneParameters<f64, DEAD_ZONES>) -> Vec<f64> {
    let home = zones.thresholds.iter().position(|&threshold| threshold == 0.0).unwrap_or(0);
    let Some((below, above)) = zones.weights.split_at_checked(home) else { return Vec::new() };
    let Some((first, above)) = above.split_first() else { return Vec::new() };
    let slope = |sum: &mut f64, weight: &f64| {
        *sum += weight;
        Some(*sum)
    };
    let upward = std::iter::once(first).chain(above).scan(0.0, slope);
    let downward = std::iter::once(first).chain(below.iter().rev()).scan(0.0, slope);
    ratios(upward).chain(ratios(downward)).collect()
}

fn ratios(slopes: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    let logarithms: Vec<f64> = slopes.map(|slope| slope.max(LEAST).ln()).collect();
    (1..logarithms.len()).map(move |i| logarithms[i] - logarithms[i - 1])
}

#[cfg(test)]
mod tests {
    use model_core::envelope::{PiecewiseLinearParameters, TanhParameters};

    use super::*;
    use crate::diagnosis::extend::tests::model;

    #[test]
    fn one_slope_is_smooth_and_a_slope_that_doubles_and_halves_is_rough_twice() {
        let zones = |weights: [f64; 4]| DeadZoneParameters {
            thresholds: [-0.2, 0.0, 0.3, 0.6].into_iter().collect(),
            weights: weights.into_iter().collect(),
            offset: 1.0,
        };
        assert!(of_dead_zones(&zones([0.0, 5.0, 0.0, 0.0])).iter().all(|rough| rough.abs() < 1e-12));
        let rough = of_dead_zones(&zones([5.0, 5.0, 5.0, -5.0]));
        let two = 2.0_f64.ln();
        let expected = [two, -two, two];
        assert_eq!(rough.len(), expected.len());
        assert!(rough.iter().zip(expected).all(|(rough, two)| (rough - two).abs() < 1e-12), "{rough:?}");
    }

    #[test]
    fn an_envelope_of_knots_is_as_rough_as_its_slopes_differ_and_a_tanh_is_not() {
        let HostParameters::Cascade(mut cascade) = model().parameters else { panic!("a cascade") };
        let zones = of_dead_zones(&cascade.dead_zones).len();
        // Slopes of 1, 2 and 2.
        let (inputs, values) = ([0.0, 1.0, 3.0, 4.0], [0.0, 1.0, 5.0, 7.0]);
        let knots = PiecewiseLinearParameters {
            inputs: inputs.into_iter().collect(),
            values: values.into_iter().collect(),
        };
        cascade.envelope = EnvelopeParameters::PiecewiseLinear(knots);
        let rough = roughness(&HostParameters::Cascade(cascade.clone()));
        assert_eq!(rough.len(), 2 + zones);
        assert!((rough[0] - 2.0_f64.ln()).abs() < 1e-12 && rough[1].abs() < 1e-12, "{rough:?}");
        cascade.envelope = EnvelopeParameters::Tanh(TanhParameters { c0: 1.0, c1: 0.5, c2: -1.0, c3: 1.0 });
        assert_eq!(roughness(&HostParameters::Cascade(cascade)).len(), zones);
    }
}
