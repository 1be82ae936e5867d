//! A jump of the sensor's zero within a recording.
//!
//! The muscle has none: what the board runs is the operator with the zero behind the jump.

use identification::HostParameters;

/// By how much the output is more from a time on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jump {
    /// When. Unit: s.
    pub time_s: f64,
    /// By how much. Output unit.
    pub height: f64,
}

impl Jump {
    /// What it adds to the output at a time. Output unit.
    pub fn at(self, time_s: f64) -> f64 {
        if time_s >= self.time_s { self.height } else { 0.0 }
    }

    /// The operator with the zero behind the jump.
    pub(super) fn behind(self, mut parameters: HostParameters) -> HostParameters {
        let offset = match &mut parameters {
            HostParameters::Cascade(cascade) => &mut cascade.dead_zones.offset,
            HostParameters::Agpi(agpi) => &mut agpi.offset,
            HostParameters::Egpi(egpi) => &mut egpi.agpi.offset,
        };
        *offset += self.height;
        parameters
    }
}
