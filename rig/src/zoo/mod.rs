//! A zoo of plants: muscles, valves, sensors and experiments drawn independently by a seed.
//!
//! | part | kinds |
//! |---|---|
//! | [`law`] | braid, exponential formula, polynomial, stiffening spring |
//! | [`friction`] | Coulomb bristles, Maxwell slip, Bouc-Wen, LuGre, Prandtl-Ishlinskii |
//! | [`muscle`] | the balance of both with a weight, a spring or both; where the effects act is drawn too |
//! | [`valve`] | first order, second order, orifice flow into the chamber |
//! | [`excitation`] | triangles, stairs, multisine, random ramps, one speed, production cycles, a mix |
//! | [`clock`] | 20 to 1000 Hz, jitter, lost rows |
//! | [`family`] | a law with a friction; the split into development, validation and sealed families |
//! | [`exhibit`] | all of this by one seed, with what is hidden in it; its recording |
//! | [`visible`] | what a hidden effect changes, and whether the recording can show it |
//!
//! Everything follows from the seed: the same seed gives the same recording, bit for bit.

pub mod clock;
pub mod excitation;
pub mod exhibit;
pub mod family;
pub mod friction;
pub mod law;
pub mod muscle;
mod refit;
pub mod site;
pub mod valve;
pub mod visible;
