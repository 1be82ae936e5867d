//! What the board learns of its muscle: the switch, and the result ([`model_core::adaptation`]).
//!
//! # Contract
//! Off at each start of the program, and for another model. A stop, a fault and other gains leave
//! what was learnt as it is. Nothing is learnt from a tick whose command a limit has changed, whose
//! samples were replaced, or whose pressure is further from the command than the protection calls
//! following.

use model_core::adaptation::{Adapted, Adapter, Change};
use wire::registers::Learning;

/// The switch, and what was learnt.
#[derive(Clone, Copy, Debug)]
pub struct Adaptation {
    learning: Learning,
    adapted: Adapted<f32>,
    /// Samples that were replaced, as they were counted in the tick before.
    bridged: u32,
}

/// What it tells of itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Told {
    /// The switch.
    pub learning: Learning,
    /// What was learnt. Unit: mm.
    pub change: Change<f32>,
    /// In so many steps.
    pub steps: u32,
}

impl Default for Adaptation {
    /// Off, and nothing was learnt.
    fn default() -> Self {
        Self { learning: Learning::Off, adapted: Adapted::default(), bridged: 0 }
    }
}

impl Adaptation {
    /// The switch.
    pub fn learning(&self) -> Learning {
        self.learning
    }

    /// Sets it.
    pub fn switch(&mut self, learning: Learning) {
        if learning == Learning::Off {
            *self = Self::default();
        }
        self.learning = learning;
    }

    /// What it tells of itself. Without a model nothing was learnt.
    pub fn told(&self, adapter: Option<Adapter<f32>>) -> Told {
        let Self { learning, adapted, .. } = self;
        let change = adapter.map(|adapter| adapter.in_mm(adapted.change())).unwrap_or_default();
        Told { learning: *learning, change, steps: adapted.steps() }
    }

    /// What a feed-forward is changed by; none where it is off.
    pub fn acting(&mut self) -> Option<&mut Adapted<f32>> {
        (self.learning != Learning::Off).then_some(&mut self.adapted)
    }

    /// What learns; none where nothing does. `bridged`: samples that were replaced so far. Answers
    /// whether none was replaced in this tick, too.
    pub fn learner(&mut self, bridged: u32) -> Option<(&mut Adapted<f32>, bool)> {
        if self.learning != Learning::On {
            return None;
        }
        let is_new = core::mem::replace(&mut self.bridged, bridged) == bridged;
        Some((&mut self.adapted, is_new))
    }
}
