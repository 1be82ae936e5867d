//! What a test motion tells of a joint that is not what its model says.

use thiserror::Error;

/// Why a joint is not started.
#[derive(Clone, Debug, Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum JointFault {
    #[error(
        "the test motion of {asked_deg:.1} degrees turned the joint by {turned_deg:.1} degrees: it turns the wrong \
         way; the angle sensor counts backwards, or both channels are swapped"
    )]
    WrongWay { asked_deg: f64, turned_deg: f64 },
    #[error(
        "the test motion of {asked_deg:.1} degrees turned the joint by {turned_deg:.1} degrees only: is it blocked, \
         the angle sensor unplugged, or a muscle without air?"
    )]
    Still { asked_deg: f64, turned_deg: f64 },
    #[error(
        "pressure_a_bar follows command_b_bar, and pressure_b_bar command_a_bar: the two pressure sensors, or the \
         two regulators, are swapped"
    )]
    Crossed,
    #[error(
        "the joint turns by {turned_deg:.1} degrees where its model turns by {asked_deg:.1} degrees, and stands \
         {offset_deg:.1} degrees from it in the mean: the model is that of another joint, or of other muscles"
    )]
    Another { asked_deg: f64, turned_deg: f64, offset_deg: f64 },
}
