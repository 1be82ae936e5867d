//! How large a plant and how long its recording is, beside those that the effects are sized for.

/// Factors on lengths, forces and times. The default is the rig's own size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    /// On lengths.
    pub length: f64,
    /// On forces.
    pub force: f64,
    /// On the times at which something happens once, and over which something moves steadily.
    pub duration: f64,
}

impl Default for Scale {
    fn default() -> Self {
        Self { length: 1.0, force: 1.0, duration: 1.0 }
    }
}
