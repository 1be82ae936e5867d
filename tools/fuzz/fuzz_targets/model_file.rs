//! A model file that says anything: what is read is written, and read again as the same.
#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use recording::model_file::ModelFile;
use wire::{DEAD_ZONES, PLAYS};

fuzz_target!(|text: &str| {
    let file = Path::new("model.toml");
    let Ok(model) = ModelFile::parse(file, text) else { return };
    let written = model.to_toml();
    let again = ModelFile::parse(file, &written).expect("what was written is read");
    assert_eq!(again.to_toml(), written);
    // The board may refuse it, for its size.
    let _ = model.parameters.convert::<f32, PLAYS, DEAD_ZONES>();
});
