//! What a recorded column moves: the load, the temperature.

use model_core::extension::{ScheduleParameters, Site};

use crate::effect::{Driver, Effect, Form, Parameter};
use crate::signals::Signals;
use crate::simulated::Simulated;
use recording::numbers::root_mean_square;

/// Effects that a column drives, on either side of the hysteresis; none without the column.
pub fn starts(signals: &Signals, driver: Driver, column: &Option<Vec<f64>>) -> Vec<Effect> {
    let Some(column) = column else { return Vec::new() };
    let strengths = Parameter::strengths(signals, root_mean_square(column), f64::NEG_INFINITY);
    vec![Effect::new(Form::Driven(driver), strengths), Effect::new(Form::Added(driver), [])]
}

/// The offset where the contraction is 0, and the gain over the contraction, of changes at these knots.
pub fn moved(knots: &[f64], changes: &[f64]) -> (f64, f64) {
    let mean_y = knots.iter().sum::<f64>() / knots.len() as f64;
    let mean = changes.iter().sum::<f64>() / knots.len() as f64;
    let (mut over, mut under) = (0.0, 0.0);
    for (y, change) in knots.iter().zip(changes) {
        over += (y - mean_y) * (change - mean);
        under += (y - mean_y).powi(2);
    }
    let gain = over / under.max(1e-12);
    (mean - gain * mean_y, gain)
}

/// The same of an extension of a model, if it has that.
pub fn written(
    model: &Simulated<'_>,
    schedule: &Option<ScheduleParameters<f64>>,
    site: Site,
) -> Option<(f64, f64)> {
    let offset = &schedule.as_ref()?.offset;
    Some(moved(&offset.knots, &model.changes(offset, site)))
}
