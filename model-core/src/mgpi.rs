//! The modified generalized Prandtl-Ishlinskii model (MGPI), equation (16): envelope, plays, dead
//! zones.
//!
//! The envelope is the paper's tanh or a piecewise-linear one. Forward and inverse are those of the
//! [`crate::cascade`].
//!
//! # Accuracy
//! Round trip of Tables 1 and 2 over triangles from 0 to 6 bar: below 1e-12 bar in `f64`, 5e-5 bar
//! in `f32` (`cargo test -p model-core round_trip`).

use crate::cascade::{Cascade, CascadeParameters, InverseCascade};
use crate::envelope::AnyEnvelope;

/// Raw parameters of an MGPI model.
pub type MgpiParameters<T, const N: usize, const M: usize> = CascadeParameters<T, N, M>;
/// An MGPI model.
pub type Mgpi<T, const N: usize, const M: usize> = Cascade<T, AnyEnvelope<T>, N, M>;
/// Its inverse.
pub type InverseMgpi<T, const N: usize, const M: usize> = InverseCascade<T, AnyEnvelope<T>, N, M>;
