//! What a board keeps in its flash, and has at hand while it runs.

use core::sync::atomic::{AtomicBool, Ordering};

use firmware::store::{BoardState, LoadError, ParameterStore, SaveError, Set};
use firmware::update::Images;
use firmware::watchdog::{CheckIns, Task};

use super::flash::Flash;
use super::tick::moment_us;

/// More than the longest frame of any port takes: on the bus 256 bytes of 11 bits, at the lowest
/// rate of 9,600 bit/s 294 ms; 44 ms on the link. Unit: µs.
const LONGEST_FRAME_US: u32 = 300_000;

/// A set of parameters, and where it is stored.
pub struct Stored<P, const PORTS: usize> {
    store: ParameterStore<Flash, P>,
    parameters: P,
    is_taken: bool,
    /// Whether the ports are sending.
    sending: [&'static AtomicBool; PORTS],
    check_ins: &'static CheckIns,
}

impl<P: Set, const PORTS: usize> Stored<P, PORTS> {
    /// What is stored, or the set of a new board and why.
    // Not inlined: `init` would need the stack all the time.
    #[inline(never)]
    pub fn load(
        flash: Flash,
        sending: [&'static AtomicBool; PORTS],
        check_ins: &'static CheckIns,
    ) -> (Self, Option<LoadError>) {
        let mut store = ParameterStore::new(flash);
        let (parameters, failure) = match store.load() {
            Ok(parameters) => (parameters, None),
            Err(error) => {
                defmt::error!("stored parameters: {}", defmt::Debug2Format(&error));
                (P::NEW, Some(error))
            }
        };
        (Self { store, parameters, is_taken: false, sending, check_ins }, failure)
    }

    /// The set.
    pub fn parameters(&self) -> &P {
        &self.parameters
    }

    /// The flash.
    pub fn flash_mut(&mut self) -> &mut Flash {
        self.store.flash_mut()
    }

    /// Whether nobody has asked this before: whichever task comes first behind `init`, which has
    /// not the stack for it, takes the set.
    pub fn is_to_be_taken(&mut self) -> bool {
        !core::mem::replace(&mut self.is_taken, true)
    }

    /// Stores another set.
    ///
    /// # Errors
    /// As of [`Self::save`].
    pub fn keep(&mut self, state: impl BoardState, parameters: P) -> Result<(), SaveError> {
        self.parameters = parameters;
        self.save(state)
    }

    /// Stores the set; one that is there already, in the present layout, is not written again. What
    /// is being sent leaves before: a flash that is erased stops the processor, with the bus's
    /// driver on.
    ///
    /// # Errors
    /// It cannot be stored, which does not keep it from being used.
    #[inline(never)]
    pub fn save(&mut self, state: impl BoardState) -> Result<(), SaveError> {
        if self.store.flash().is_on_trial() {
            return Err(SaveError::OnTrial);
        }
        let begin = moment_us();
        while self.sending.iter().any(|is_sending| is_sending.load(Ordering::Acquire))
            && moment_us().wrapping_sub(begin) < LONGEST_FRAME_US
        {
            // The next byte wakes, or the tick.
            cortex_m::asm::wfi();
            // A wait that ends is no task that stands still, nor is the supervisor below it.
            self.check_ins.check_in(Task::Link);
            self.check_ins.check_in(Task::Supervisor);
        }
        self.store.save(state, &self.parameters).inspect_err(|error| {
            defmt::error!("parameters are not stored: {}", defmt::Debug2Format(error));
        })
    }
}
