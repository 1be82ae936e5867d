//! The side of the hysteresis that resists motion.
//!
//! The search tells the two sides of a viscous lag apart with the measured rate in it, by which the contraction explains a part
//! of itself: a force looks like a lag of the output there. Running free they differ: a lag of the output goes on to where the
//! plays are held when the input turns, and a force stops short of it.

use model_core::extension::Site;

use super::Extension;
use super::task::Task;
use crate::carrier::LEAST_SLOPE;
use crate::turn::Loop;

/// The model, refined, with its viscous lag on the nearer side; that of a mass is on the mass's. `found` where it has none, or does
/// not run with it on the other one.
pub fn nearer(task: &Task<'_>, found: Extension) -> Option<Extension> {
    let other = on_the_other_side(&found).and_then(|other| task.refined(other));
    match other {
        Some((other, _)) if task.rms(&other)? < task.rms(&found)? => Some(other),
        _ => Some(found),
    }
}

/// The same lag from the other side, about.
fn on_the_other_side(found: &Extension) -> Option<Extension> {
    if found.extensions.inertia.is_some() {
        return None;
    }
    let mut other = found.clone();
    let viscosity = other.extensions.viscous_lag.as_mut()?;
    let turn = Loop::of_operator(&found.parameters)?;
    let (low, high) = found.parameters.input();
    let mean = (viscosity.knots.last()? - viscosity.knots.first()?) / (high - low);
    let site = &mut other.extensions.sites.viscous_lag;
    for (&knot, value) in viscosity.knots.iter().zip(&mut viscosity.values) {
        let slope = turn.slope(knot).max(LEAST_SLOPE * mean);
        *value *= match *site {
            Site::Pressure => slope,
            Site::Contraction => slope.recip(),
        };
    }
    *site = match *site {
        Site::Pressure => Site::Contraction,
        Site::Contraction => Site::Pressure,
    };
    Some(other)
}

#[cfg(test)]
mod tests {
    use model_core::ExtensionParameters;
    use model_core::extension::ProfileParameters;

    use super::*;
    use crate::extend::tests::{model, recorded};

    /// A muscle with nothing but a lag of 0.15 s, about, on a side.
    fn lagging(site: Site, viscosity: f64) -> Extension {
        let mut extensions = ExtensionParameters {
            viscous_lag: Some(ProfileParameters {
                knots: [0.0, 50.0].into_iter().collect(),
                values: [viscosity, viscosity].into_iter().collect(),
            }),
            ..ExtensionParameters::default()
        };
        extensions.sites.viscous_lag = site;
        Extension { extensions, ..model() }
    }

    #[test]
    fn a_lag_is_brought_to_the_side_that_it_is_on() {
        for (truth, wrong) in [
            (lagging(Site::Pressure, 0.01), lagging(Site::Contraction, 0.15)),
            (lagging(Site::Contraction, 0.15), lagging(Site::Pressure, 0.01)),
        ] {
            let columns = recorded(&truth);
            let rows: Vec<usize> = (0..columns.time_s.len()).collect();
            let task = Task { reached: 0.1, ..Task::alone(&columns, &rows) };
            let (found, _) = task.refined(wrong).expect("it runs");
            let near = nearer(&task, found).expect("it runs");
            assert_eq!(near.extensions.sites, truth.extensions.sites);
            let (kept, _) = task.refined(truth.clone()).expect("it runs");
            assert_eq!(nearer(&task, kept).expect("it runs").extensions.sites, truth.extensions.sites);
        }
    }

    #[test]
    fn the_damping_of_a_mass_stays_on_its_side() {
        let mut found = lagging(Site::Contraction, 0.15);
        found.extensions.inertia = Some(ProfileParameters::constant(0.001));
        assert!(on_the_other_side(&found).is_none());
    }
}
