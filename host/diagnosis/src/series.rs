//! A first-order lag before a mass, both on the output: together of third order.
//!
//! y + R y' + A y'' + J y''' = (1 + lag d/dt)(y + damping y' + mass y''), so the fit stays linear in its weights: beside a mass the lag
//! has the jerk as its column, and the mass the rates of both. What is named, tuned and run is the one after the other.

use super::effect::{Effect, Form};
use super::fit::Fit;
use super::signals::{Signals, TENTS};

/// Halvings of the interval that the lag lies in.
const HALVINGS: usize = 40;
/// A jerk's weight is at most this share of the one from which on the motion would grow.
const STABLE: f64 = 0.95;

/// The two at a tent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Series {
    /// Of the lag. Unit: s.
    pub lag_s: f64,
    /// Beside the mass. Unit: s.
    pub damping_s: f64,
    /// Unit: s².
    pub mass_s2: f64,
}

impl Series {
    /// From the weights of jerk, acceleration and rate, none below 0.
    fn of([jerk, acceleration, rate]: [f64; 3]) -> Self {
        let jerk = jerk.min(STABLE * acceleration * rate);
        // -1/lag is a root of the polynomial: from 0 to the whole rate there is one.
        let over = |lag: f64| ((lag - rate) * lag + acceleration) * lag - jerk;
        let (mut low, mut high) = (0.0, rate);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if over(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        let lag_s = if jerk > 0.0 { high } else { 0.0 };
        let damping_s = rate - lag_s;
        Self { lag_s, damping_s, mass_s2: (acceleration - lag_s * damping_s).max(0.0) }
    }

    fn weights(&self) -> [f64; 3] {
        let Self { lag_s, damping_s, mass_s2 } = *self;
        [mass_s2 * lag_s, mass_s2 + lag_s * damping_s, damping_s + lag_s]
    }
}

/// The places of the first weights on the output of lag and mass, if one is before the other.
fn places(fit: &Fit, signals: &Signals) -> Option<[usize; 2]> {
    let places = fit.output_places(signals);
    let of = |form| fit.effects.iter().position(|effect| effect.form == form).map(|i| places[i].start);
    Some([of(Form::LagBefore)?, of(Form::OutputInertia)?])
}

/// Lag and mass at each tent, if one is before the other.
pub fn series(fit: &Fit, signals: &Signals) -> Option<[Series; TENTS]> {
    let [lag, mass] = places(fit, signals)?;
    let weight = |place: usize| fit.weights[place];
    Some(std::array::from_fn(|tent| {
        Series::of([weight(lag + tent), weight(mass + tent), weight(mass + TENTS + tent)])
    }))
}

/// Puts lag and mass, changed, back into the fit.
pub fn change(fit: &mut Fit, signals: &Signals, change: impl Fn(Series) -> Series) {
    let Some((all, [lag, mass])) = series(fit, signals).zip(places(fit, signals)) else { return };
    for (tent, series) in all.into_iter().enumerate() {
        let places = [lag + tent, mass + tent, mass + TENTS + tent];
        places
            .into_iter()
            .zip(change(series).weights())
            .for_each(|(place, weight)| fit.weights[place] = weight);
    }
}

/// The weights of an effect of a fit: those on the output, of lag and mass each its own.
pub fn weights(fit: &Fit, signals: &Signals, effect: usize) -> Vec<f64> {
    match (series(fit, signals), fit.effects[effect].form) {
        (Some(all), Form::LagBefore) => all.map(|series| series.lag_s).to_vec(),
        (Some(all), Form::OutputInertia) => {
            all.map(|series| series.mass_s2).into_iter().chain(all.map(|series| series.damping_s)).collect()
        }
        _ => fit.output_weights(signals, effect).to_vec(),
    }
}

/// Gives every lag on the output its place: before the mass, if there is one on the output too.
pub fn arrange(effects: &mut [Effect]) {
    let has_mass = has_mass(effects);
    effects.iter_mut().for_each(|effect| effect.form = arranged(effect.form, has_mass));
}

/// The starts of an effect beside others, each in its place.
pub fn beside(others: &[Effect], mut starts: Vec<Effect>) -> Vec<Effect> {
    let has_mass = has_mass(others);
    starts.iter_mut().for_each(|effect| effect.form = arranged(effect.form, has_mass));
    starts
}

fn has_mass(effects: &[Effect]) -> bool {
    effects.iter().any(|effect| effect.form == Form::OutputInertia)
}

fn arranged(form: Form, has_mass: bool) -> Form {
    match form {
        Form::OutputLag | Form::LagBefore if has_mass => Form::LagBefore,
        Form::OutputLag | Form::LagBefore => Form::OutputLag,
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_a_lag_before_a_mass_say_both() {
        for (lag_s, damping_s, mass_s2) in
            [(0.05, 0.02, 0.002), (0.003, 0.03, 0.001), (0.2, 0.01, 0.0005), (0.0, 0.02, 0.002)]
        {
            let series = Series { lag_s, damping_s, mass_s2 };
            let found = Series::of(series.weights());
            let near = |found: f64, wanted: f64| (found - wanted).abs() < 1e-9;
            assert!(near(found.lag_s, lag_s), "{found:?} for {series:?}");
            assert!(near(found.damping_s, damping_s) && near(found.mass_s2, mass_s2), "{found:?}");
        }
    }

    #[test]
    fn weights_whose_motion_would_grow_say_what_does_not() {
        let found = Series::of([1.0, 0.001, 0.05]);
        assert!(found.lag_s > 0.0 && found.damping_s >= 0.0 && found.mass_s2 > 0.0, "{found:?}");
        assert_eq!(Series::of([0.0; 3]).weights(), [0.0; 3]);
    }
}
