//! What a static force law is.

/// Pull of a muscle whose force at [`FULL_BAR`] and no contraction is 1.
pub trait Pull: Send {
    /// Pull at a pressure (bar, 0 and more) and a contraction ratio; falls with the ratio.
    fn pull(&self, pressure_bar: f64, ratio: f64) -> f64;
}

/// Pressure at which a law's force at no contraction is 1, bar.
pub const FULL_BAR: f64 = 6.0;

/// The part of the pressure beyond the one that the tube takes, bar: a smooth hinge, 0 at 0 bar.
pub(super) fn beyond(threshold_bar: f64, width_bar: f64, pressure_bar: f64) -> f64 {
    let hinge = |above_bar: f64| 0.5 * (above_bar + above_bar.hypot(width_bar));
    hinge(pressure_bar - threshold_bar) - hinge(-threshold_bar)
}
