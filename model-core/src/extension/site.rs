//! Where an effect acts: before the hysteresis, on the pressure, or behind it, on the contraction.
//!
//! Both are found in muscles and models of them. Before it an effect goes through the loop like the
//! pressure; behind it the loop does not know of it. What a profile multiplies is then in units of
//! the contraction: what has to be added to the contraction for the operator's output.

/// A side of the hysteresis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Site {
    /// Before it: an equivalent input.
    Pressure,
    /// Behind it: on the output.
    Contraction,
}

/// The sides of the effects that can be on either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[allow(missing_docs, reason = "the fields are the effects by name")]
pub struct Sites {
    pub load: Site,
    pub temperature: Site,
    pub warm_up: Site,
    pub viscous_lag: Site,
    pub inertia: Site,
    pub creep: Site,
}

impl Default for Sites {
    /// Forces before the hysteresis, creep behind it.
    fn default() -> Self {
        Self {
            load: Site::Pressure,
            temperature: Site::Pressure,
            warm_up: Site::Pressure,
            viscous_lag: Site::Pressure,
            inertia: Site::Pressure,
            creep: Site::Contraction,
        }
    }
}
