//! The compiled part of the Python package `mgpi`.
//!
//! # Design
//! | file | what it does |
//! |---|---|
//! | `recording` | recordings from files and arrays |
//! | `identify` | one model from one recording or several |
//! | `diagnose` | what a model gets wrong, and why |
//! | `model` | simulation, inverse, model files |
//! | `error` | our errors as exceptions that know the row and the column |
//! | `work` | long work that Ctrl-C ends, without Python's lock |
//!
//! What people type is in the files beside this folder (`mgpi/*.py`): names, defaults, tables.
//!
//! # Contract
//! Results are those of the command, bit for bit: both call the same functions. Arrays that come in
//! are copied once, into a table; arrays that go out are handed over.
//!
//! # Why in the workspace
//! The module asks for nothing but Python's stable interface (`abi3`), so that it is compiled
//! without Python's headers, and without Python; as a `cdylib` without tests it is linked with no
//! Python either. So one lock file, one set of lints and one build of the crates below serve it,
//! and `cargo test --workspace` asks nothing more of a machine.

mod diagnose;
mod error;
mod identify;
mod model;
mod recording;
mod work;

/// The module.
#[pyo3::pymodule]
mod _native {
    #[pymodule_export]
    use crate::diagnose::{Diagnosed, diagnose};
    #[pymodule_export]
    use crate::error::{DataError, DiagnosisError, IdentificationError, ModelError};
    #[pymodule_export]
    use crate::identify::{Identified, identify};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::recording::Recording;
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
