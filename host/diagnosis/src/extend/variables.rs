//! An operator with extensions as a list of numbers that a search can move, each in steps of about 1.
//!
//! What is positive is moved by its logarithm, or mirrored at 0 where it may be 0. Fixed are what no derivative is of
//! (dead band, references), the valve beside a muscle that is modelled from its pressure, and what is only a
//! scaling of other parameters.

use model_core::ExtensionParameters;
use model_core::dead_zone::DeadZoneParameters;
use model_core::envelope::EnvelopeParameters;
use model_core::extension::ValveLagForm;
use model_core::play::PlayParameters;

use super::Extension;
use identification::{DEAD_ZONES, Density, HostParameters, PLAYS};

/// What steps are measured by.
#[derive(Clone, Copy, Debug)]
pub struct Units {
    /// Highest less lowest output. Output unit.
    pub stroke: f64,
    /// Unit: s.
    pub duration_s: f64,
    /// Whether the valve is part of what is fitted.
    pub with_valve: bool,
    /// Whether the extensions are.
    pub with_extensions: bool,
}

/// A step of a delay. Unit: s.
const DELAY_STEP_S: f64 = 0.01;
/// A step of a share of the contraction, or of an amplitude as a share of the stroke.
const SHARE_STEP: f64 = 0.02;
/// Steps of what goes slowly, see [`super::slow`]: of an offset, as a share of its size, and of the logarithm of a travel. To move an
/// offset by its size or a travel by a third costs as much as the first error of all rows.
const SLOWLY: f64 = 0.025;
const TRAVEL_STEP: f64 = 0.01;
/// What rises does so by this share of the mean at least: in the board's numbers, which hold sums, less would be lost.
const FLATTEST: f64 = 1e-3;
/// The largest exponent of a rate.
const LARGEST_EXPONENT: f64 = 4.0;

/// The variables of a model.
pub fn of(model: &Extension, units: &Units) -> Vec<f64> {
    let mut all = Vec::new();
    visit(&mut model.clone(), units, &mut |variable| {
        all.push(variable);
        variable
    });
    all
}

/// The model with these variables.
pub fn with(model: &Extension, units: &Units, variables: &[f64]) -> Extension {
    let mut model = model.clone();
    let mut variables = variables.iter();
    visit(&mut model, units, &mut |before| variables.next().copied().unwrap_or(before));
    model
}

/// Hands every variable to `change`, and takes what that answers.
fn visit(model: &mut Extension, units: &Units, change: &mut impl FnMut(f64) -> f64) {
    visit_operator(&mut model.parameters, &mut model.density, units, change);
    if units.with_extensions {
        visit_extensions(&mut model.extensions, units, change);
        if let Some(jump) = &mut model.jump {
            scaled(&mut jump.height, SHARE_STEP * units.stroke, change);
        }
    }
}

fn logarithm(value: &mut f64, change: &mut impl FnMut(f64) -> f64) {
    if *value != 0.0 {
        *value = value.signum() * change(value.abs().ln()).exp();
    }
}

fn scaled(value: &mut f64, step: f64, change: &mut impl FnMut(f64) -> f64) {
    *value = change(*value / step) * step;
}

fn mirrored(value: &mut f64, step: f64, change: &mut impl FnMut(f64) -> f64) {
    *value = change(*value / step).abs() * step;
}

/// A profile's step is its largest value.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(1e-9, |largest, value| largest.max(value.abs()))
}

fn visit_operator(
    parameters: &mut HostParameters,
    density: &mut Density,
    units: &Units,
    change: &mut impl FnMut(f64) -> f64,
) {
    // Of the other models the extensions alone are fitted.
    let HostParameters::Cascade(cascade) = parameters else { return };
    match &mut cascade.envelope {
        EnvelopeParameters::PiecewiseLinear(envelope) => {
            let least = FLATTEST * largest(&envelope.values) / envelope.values.len().max(1) as f64;
            let mut values = envelope.values.iter_mut();
            if let Some(first) = values.next() {
                let (mut before, mut sum) = (*first, *first);
                for value in values {
                    let mut rise = *value - before;
                    before = *value;
                    logarithm(&mut rise, change);
                    sum += rise.max(least);
                    *value = sum;
                }
            }
        }
        EnvelopeParameters::Tanh(tanh) => {
            logarithm(&mut tanh.c1, change);
            scaled(&mut tanh.c2, 1.0, change);
        }
        EnvelopeParameters::Identity => {}
    }
    visit_plays(&mut cascade.plays, density, change);
    visit_dead_zones(&mut cascade.dead_zones, units, change);
}

fn visit_plays(
    plays: &mut PlayParameters<f64, PLAYS>,
    density: &mut Density,
    change: &mut impl FnMut(f64) -> f64,
) {
    match density {
        Density::Exponential { rho, tau, alpha } => {
            logarithm(rho, change);
            let step = 1.0 / (*alpha * plays.thresholds.len().max(1) as f64);
            scaled(tau, step, change);
            logarithm(alpha, change);
            let count = plays.thresholds.len();
            if let Ok(next) = PlayParameters::exponential(count, plays.q, *rho, *tau, *alpha) {
                *plays = next;
            }
        }
        Density::Free { .. } => plays.weights.iter_mut().for_each(|weight| logarithm(weight, change)),
    }
}

/// By the slopes between the knots, from 0 outward, and the offset.
fn visit_dead_zones(
    zones: &mut DeadZoneParameters<f64, DEAD_ZONES>,
    units: &Units,
    change: &mut impl FnMut(f64) -> f64,
) {
    scaled(&mut zones.offset, SHARE_STEP * units.stroke, change);
    let home = zones.thresholds.iter().position(|&threshold| threshold == 0.0).unwrap_or(0);
    let Some(&first) = zones.weights.get(home) else { return };
    let mut slope = first;
    logarithm(&mut slope, change);
    zones.weights[home] = slope;
    let above: Vec<usize> = (home + 1..zones.weights.len()).collect();
    let below: Vec<usize> = (0..home).rev().collect();
    for places in [above, below] {
        let (mut old, mut new) = (first, slope);
        for place in places {
            old += zones.weights[place];
            let mut next = old;
            logarithm(&mut next, change);
            next = next.max(FLATTEST * units.stroke);
            zones.weights[place] = next - new;
            new = next;
        }
    }
}

fn visit_extensions(
    extensions: &mut ExtensionParameters<f64>,
    units: &Units,
    change: &mut impl FnMut(f64) -> f64,
) {
    if let (Some(lag), true) = (&mut extensions.valve_lag, units.with_valve) {
        logarithm(&mut lag.time_constant_s, change);
        match &mut lag.form {
            ValveLagForm::FirstOrder => {}
            ValveLagForm::SecondOrder { damping_ratio } => logarithm(damping_ratio, change),
            ValveLagForm::Orifice { supply, outside } => {
                let mut above = *supply - *outside;
                logarithm(&mut above, change);
                *supply = *outside + above;
            }
        }
    }
    if let (Some(saturation), true) = (&mut extensions.supply_saturation, units.with_valve) {
        logarithm(&mut saturation.supply, change);
    }
    if let Some(delay) = &mut extensions.transport_delay {
        mirrored(&mut delay.delay_s, DELAY_STEP_S, change);
    }
    let offsets = [
        extensions.load.as_mut().map(|load| (&mut load.offset, 1.0)),
        extensions.temperature.as_mut().map(|temperature| (&mut temperature.offset, SLOWLY)),
        extensions.warm_up.as_mut().map(|warm_up| (&mut warm_up.offset, SLOWLY)),
    ];
    for (offset, step) in offsets.into_iter().flatten() {
        let step = step * largest(&offset.values);
        offset.values.iter_mut().for_each(|value| scaled(value, step, change));
    }
    if let Some(warm_up) = &mut extensions.warm_up {
        let mut logarithm = warm_up.travel.ln();
        scaled(&mut logarithm, TRAVEL_STEP, change);
        warm_up.travel = logarithm.exp();
    }
    for profile in [&mut extensions.viscous_lag, &mut extensions.inertia].into_iter().flatten() {
        let step = largest(&profile.values);
        profile.values.iter_mut().for_each(|value| mirrored(value, step, change));
    }
    if let Some(width) = &mut extensions.rate_dependent_width {
        logarithm(&mut width.radius, change);
        logarithm(&mut width.exponent, change);
        width.exponent = width.exponent.min(LARGEST_EXPONENT);
        let step = largest(&width.width.values);
        width.width.values.iter_mut().for_each(|value| mirrored(value, step, change));
    }
    if let Some(thresholds) = &mut extensions.rate_dependent_thresholds {
        logarithm(&mut thresholds.exponent, change);
        thresholds.exponent = thresholds.exponent.min(LARGEST_EXPONENT);
        match &mut thresholds.pressure {
            // The other gain is the inverse's, and worked out from this one.
            Some(pressure) => {
                logarithm(&mut pressure.gain, change);
                logarithm(&mut thresholds.filter_s, change);
            }
            None => {
                let step = largest(&thresholds.gain.values);
                thresholds.gain.values.iter_mut().for_each(|value| mirrored(value, step, change));
            }
        }
    }
    if let Some(creep) = &mut extensions.creep {
        creep.fractions.iter_mut().for_each(|fraction| mirrored(fraction, SHARE_STEP, change));
    }
    if let Some(drift) = &mut extensions.drift {
        scaled(&mut drift.rate_per_s, SHARE_STEP * units.stroke / units.duration_s, change);
    }
    if let Some(tone) = &mut extensions.periodic_disturbance {
        mirrored(&mut tone.amplitude, SHARE_STEP * units.stroke, change);
        scaled(&mut tone.frequency_hz, 1.0 / (std::f64::consts::TAU * units.duration_s), change);
        scaled(&mut tone.phase_rad, 1.0, change);
        tone.phase_rad %= std::f64::consts::TAU;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extend::tests::model;

    const UNITS: Units = Units { stroke: 100.0, duration_s: 50.0, with_valve: true, with_extensions: true };

    #[test]
    fn a_model_with_its_own_variables_is_itself() {
        let model = model();
        let again = with(&model, &UNITS, &of(&model, &UNITS));
        let (before, after) = (of(&model, &UNITS), of(&again, &UNITS));
        assert!(
            before.iter().zip(&after).all(|(one, other)| (one - other).abs() < 1e-9),
            "{before:?} {after:?}"
        );
        assert_eq!(model.extensions.drift, again.extensions.drift);
    }

    #[test]
    fn every_variable_moves_the_model() {
        let model = model();
        let variables = of(&model, &UNITS);
        for variable in 0..variables.len() {
            let mut moved = variables.clone();
            moved[variable] += 0.1;
            let moved = with(&model, &UNITS, &moved);
            let differs = moved.parameters != model.parameters || moved.extensions != model.extensions;
            assert!(differs, "{variable}");
        }
    }

    #[test]
    fn no_variable_leads_to_an_operator_that_the_board_refuses() {
        let model = model();
        let variables = of(&Extension { extensions: Default::default(), ..model.clone() }, &UNITS);
        for variable in 0..variables.len() {
            let mut moved = variables.clone();
            moved[variable] -= 30.0;
            let moved = with(&model, &UNITS, &moved);
            let on_the_board =
                moved.parameters.convert::<f32, PLAYS, DEAD_ZONES>().expect("within its numbers");
            let checked = model_core::Model::try_new(&on_the_board);
            assert!(checked.is_ok(), "{variable}: {:?}", checked.err());
        }
    }

    #[test]
    fn the_valve_beside_a_muscle_stays_as_it_was_found() {
        let beside = Units { with_valve: false, ..UNITS };
        assert_eq!(of(&model(), &beside).len() + 1, of(&model(), &UNITS).len());
    }
}
