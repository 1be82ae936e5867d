//! A plant program that answers anything: a measurement is two finite numbers.
#![no_main]

use board_client::pil::plant::measurement;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|line: &[u8]| {
    if let Some(measured) = measurement(line) {
        assert!(measured.pressure_bar.is_finite() && measured.contraction_mm.is_finite());
    }
});
