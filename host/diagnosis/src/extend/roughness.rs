//! How unevenly an operator rises: the logarithms of the ratios of neighbouring slopes, of envelope and dead zones. And how
//! unevenly what resists motion does so, and creep over the decades.
//!
//! What effects make of the input reaches beyond where the rows are: a mass that swings drives the operators to where the
//! recording hardly goes. What rows do not teach there is as around it, rather than whatever slope fits the few that do.

use model_core::ExtensionParameters;
use model_core::dead_zone::DeadZoneParameters;
use model_core::envelope::EnvelopeParameters;
use model_core::extension::{ProfileParameters, Site};

use super::Extension;
use crate::carrier::LEAST_SLOPE;
use crate::turn::Loop;
use identification::{DEAD_ZONES, HostParameters};

/// The least slope, so that there is a logarithm. Any unit.
const LEAST: f64 = 1e-9;

/// What the unevenness of a creep counts beside that of a profile: it is less sure to be even, and its slowest element stands for all
/// that is slower still.
const CREEP: f64 = 0.1;

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

/// What values of a mass and its damper before the hysteresis are even beside, at the knots of their profiles: the root of the slope of the
/// loop over its mean. As a pressure a force is the larger the less the pressure pulls, and that is all of the slope where the stiffness is
/// the same at every contraction, and none of it where the pull is: a muscle lies between. Empty without a mass.
pub fn ease(model: &Extension) -> Vec<f64> {
    let Extension { parameters, extensions: ExtensionParameters { inertia: Some(mass), .. }, .. } = model
    else {
        return Vec::new();
    };
    let Some(turn) = Loop::of_operator(parameters) else { return Vec::new() };
    let (low, high) = parameters.input();
    let stroke = mass.knots.last().zip(mass.knots.first()).map_or(1.0, |(last, first)| last - first);
    let mean = (stroke / (high - low)).max(LEAST);
    mass.knots.iter().map(|&knot| (turn.slope(knot) / mean).max(LEAST_SLOPE).sqrt()).collect()
}

/// How unevenly what resists fast motion does so: differences of neighbouring values of the profiles of masses with their dampers and of
/// widths, over their mean. A viscosity alone shows at any speed, and rows teach it well. And how unevenly a creep goes on over the
/// decades: its elements are so near each other that rows hardly tell which of them a part belongs to.
pub fn unevenness(extensions: &ExtensionParameters<f64>, ease: &[f64]) -> Vec<f64> {
    let ExtensionParameters {
        viscous_lag,
        inertia,
        rate_dependent_width,
        rate_dependent_thresholds,
        sites,
        ..
    } = extensions;
    let width = rate_dependent_width.as_ref().map(|width| &width.width);
    // By the rate of the input they have no profile.
    let by_contraction = rate_dependent_thresholds.as_ref().filter(|all| all.pressure.is_none());
    let thresholds = by_contraction.map(|thresholds| &thresholds.gain);
    let damper = viscous_lag.as_ref().filter(|_| inertia.is_some());
    let eased = |profile: &ProfileParameters<f64>, site: Site| -> Vec<f64> {
        let eases = profile.values.iter().zip(ease).map(|(value, ease)| value * ease);
        if site == Site::Pressure { eases.collect() } else { profile.values.to_vec() }
    };
    let [damper, mass] = [(damper, sites.viscous_lag), (inertia.as_ref(), sites.inertia)]
        .map(|(profile, site)| profile.map(|profile| eased(profile, site)));
    let [width, thresholds] =
        [width, thresholds].map(|profile| profile.map(|profile| profile.values.to_vec()));
    let profiles = [damper, mass, width, thresholds].into_iter().flatten();
    let of_creep = extensions.creep.iter().flat_map(|creep| differences(&creep.fractions));
    let of_creep = of_creep.map(|uneven| CREEP * uneven);
    profiles.flat_map(|values| differences(&values)).chain(of_creep).collect()
}

/// Of neighbouring values, over their mean.
fn differences(values: &[f64]) -> Vec<f64> {
    let mean = (values.iter().sum::<f64>() / values.len().max(1) as f64).max(LEAST);
    values.windows(2).map(|pair| (pair[1] - pair[0]) / mean).collect()
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
    use model_core::extension::{CreepParameters, ProfileParameters};

    use super::*;
    use crate::extend::tests::model;

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
    fn a_constant_mass_is_even_and_one_that_grows_is_as_uneven_as_its_values_differ() {
        let profile = |values: [f64; 3]| ProfileParameters {
            knots: [0.0, 50.0, 100.0].into_iter().collect(),
            values: values.into_iter().collect(),
        };
        let both = ExtensionParameters {
            viscous_lag: Some(profile([0.1, 0.1, 0.1])),
            inertia: Some(profile([1.0, 2.0, 6.0])),
            ..ExtensionParameters::default()
        };
        let uneven = unevenness(&both, &[1.0; 3]);
        let expected = [0.0, 0.0, 1.0 / 3.0, 4.0 / 3.0];
        assert_eq!(uneven.len(), expected.len());
        assert!(uneven.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-12), "{uneven:?}");
    }

    #[test]
    fn a_mass_before_the_hysteresis_is_even_beside_how_much_the_muscle_gives_way() {
        let mut mass = ExtensionParameters {
            inertia: Some(ProfileParameters {
                knots: [0.0, 50.0, 100.0].into_iter().collect(),
                values: [2.0, 1.0, 4.0].into_iter().collect(),
            }),
            ..ExtensionParameters::default()
        };
        let ease = [0.5, 1.0, 0.25];
        assert_eq!(unevenness(&mass, &ease), [0.0; 2]);
        mass.sites.inertia = Site::Contraction;
        assert!(unevenness(&mass, &ease).iter().all(|uneven| uneven.abs() > 0.1));
    }

    #[test]
    fn what_a_mass_is_even_beside_falls_as_the_loop_gets_flat() {
        let knots = [0.0, 50.0, 100.0].into_iter().collect();
        let mass = ProfileParameters { knots, values: [1e-3; 3].into_iter().collect() };
        let mut model = model();
        assert_eq!(ease(&model).len(), model.extensions.inertia.as_ref().map_or(0, |mass| mass.knots.len()));
        model.extensions.inertia = Some(mass);
        let ease = ease(&model);
        assert_eq!(ease.len(), 3);
        assert!(ease.is_sorted_by(|steep, flat| steep > flat), "{ease:?}");
    }

    #[test]
    fn a_creep_that_is_the_same_in_every_decade_is_even_and_one_element_alone_is_not() {
        let creep = |fractions: [f64; 4]| ExtensionParameters {
            creep: Some(CreepParameters {
                time_constants_s: [0.1, 0.3, 1.0, 3.0].into_iter().collect(),
                fractions: fractions.into_iter().collect(),
            }),
            ..ExtensionParameters::default()
        };
        assert_eq!(unevenness(&creep([0.02; 4]), &[]), [0.0; 3]);
        let alone = unevenness(&creep([0.0, 0.04, 0.0, 0.0]), &[]);
        assert_eq!(alone, [4.0 * CREEP, -4.0 * CREEP, 0.0]);
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
