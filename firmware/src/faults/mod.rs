//! Faults: [`wire::fault::table`] says what each is, [`log`] latches and counts them, [`black_box`]
//! keeps the first.
//!
//! | reaction | what happens | until |
//! |---|---|---|
//! | `Vent` | the valve is vented in the same tick, state `Fault`, the record is closed | acknowledged; a reset loop: power-on |
//! | `AsConfigured` | `Vent`, or feedback alone may track, as the protection says | acknowledged, or another configuration |
//! | `Count` | it is counted; the board goes on | - |

pub mod black_box;
pub mod log;
