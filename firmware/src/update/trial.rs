//! The trial of a new image, by itself.
//!
//! It stays once it has ticked for [`TRIAL_TICKS`], has found itself and the memory whole, and has
//! answered on the bus: then whoever sends the next image can reach it. One that nobody has
//! reached within [`PATIENCE_TICKS`] starts again, so that the former image runs again behind
//! three of them, should the new one be deaf.

use wire::Fault;

use super::log::Entry;
use super::{Images, Update};
use crate::node::Node;

/// Unit: tick, 1 ms.
pub const TRIAL_TICKS: u32 = 10_000;
/// A host that has sent an image asks for it within seconds. Unit: tick.
pub const PATIENCE_TICKS: u32 = 60_000;
/// What says that the image or the memory is damaged; nothing but power-off ends them.
const DAMAGES: [Fault; 2] = [Fault::ImageDamaged, Fault::MemoryDamaged];

/// Looks after the trial, if there is one. `is_reached`: whether a request for this board has come.
#[inline(never)]
pub fn look(update: &mut Update, is_reached: bool, node: &mut impl Node) {
    let ask = || node.images().is_some_and(|images| images.is_on_trial());
    if !*update.is_on_trial.get_or_insert_with(ask) {
        return;
    }
    let (ticks, is_driven, is_sound) = node.control(|control| {
        let counters = control.faults.counters();
        let count = |fault: Fault| counters.get(usize::from(fault.code()) - 1).copied().unwrap_or(0);
        (control.ticks(), control.state().is_driven(), DAMAGES.iter().all(|fault| count(*fault) == 0))
    });
    if is_driven || ticks < TRIAL_TICKS {
        return;
    }
    if is_reached && is_sound {
        update.is_on_trial = Some(false);
        let parameters = node.parameters().clone();
        let stays = |images: &mut _| Images::append(images, Entry::ForGood(Images::running(images)));
        if node.images().map(stays) == Some(Ok(())) {
            // What was changed in the trial, and in the layout of this image. Should it not be
            // kept, it is in use, as after a start.
            let _ = node.keep(parameters);
        }
    } else if ticks >= PATIENCE_TICKS {
        node.images().into_iter().for_each(|images| images.restart());
    }
}
