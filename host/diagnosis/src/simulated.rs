//! A model that is simulated, as causes read their parameters from it: such a model is not misled by the noise of measured rates, and its
//! operator takes up less of what the effects do.
//!
//! An equivalent input becomes a change of contraction by the slope of the operator's loop, where it slides.

use model_core::ExtensionParameters;
use model_core::extension::profile::Profile;
use model_core::extension::{ProfileParameters, Site};

use super::extend::jump::Jump;
use super::turn::Loop;
use identification::HostParameters;

/// A simulated model.
pub struct Simulated<'a> {
    turn: Loop,
    /// What extends its operator.
    pub extensions: &'a ExtensionParameters<f64>,
    /// What the sensor's zero did.
    pub jump: Option<Jump>,
}

impl<'a> Simulated<'a> {
    /// Of an operator and its extensions; None where there is no loop to take a slope from.
    pub fn of(operator: &HostParameters, extensions: &'a ExtensionParameters<f64>) -> Option<Self> {
        Some(Self { turn: Loop::of_operator(operator)?, extensions, jump: None })
    }

    /// The same where the sensor's zero jumps.
    pub fn jumping(self, jump: Option<Jump>) -> Self {
        Self { jump, ..self }
    }

    /// The changes of the output at the knots of a profile that is taken off the input, or off the output.
    pub fn changes(&self, profile: &ProfileParameters<f64>, site: Site) -> Vec<f64> {
        let change = |(&knot, value): (&f64, &f64)| -value * self.per_input(site, knot);
        profile.knots.iter().zip(&profile.values).map(change).collect()
    }

    /// The strength at mid stroke of what comes late by a profile.
    pub fn late(&self, profile: &Option<ProfileParameters<f64>>, site: Site) -> Option<f64> {
        let profile = profile.as_ref()?;
        Some(at_middle(profile)? * self.per_input(site, middle(profile)))
    }

    /// Half the width of the operator's loop at its middle. Input unit.
    pub fn half_width(&self) -> f64 {
        self.turn.half_width(self.turn.middle())
    }

    /// What of an effect's strength shows in the contraction.
    fn per_input(&self, site: Site, at: f64) -> f64 {
        match site {
            Site::Pressure => self.turn.slope(at),
            Site::Contraction => 1.0,
        }
    }
}

/// The value of a profile at mid stroke.
pub fn at_middle(profile: &ProfileParameters<f64>) -> Option<f64> {
    Some(Profile::try_new(profile, "profile", "").ok()?.value(middle(profile)))
}

fn middle(profile: &ProfileParameters<f64>) -> f64 {
    let ends = profile.knots.first().zip(profile.knots.last());
    ends.map_or(0.0, |(first, last)| 0.5 * (first + last))
}
