//! The unmodified production image in the emulator: closed loop on the rig beside the emulated
//! image, and faults injected at its converter, its link and its registers.
//!
//! Skipped, in so many words, where emulator or firmware are missing; `cargo xtask test` provides
//! both. `cargo test -p host-tests --test production -- --nocapture` prints the figures.

mod bench;
mod bus;
mod closed_loop;
mod faults;
mod store;

use std::path::PathBuf;
use std::process::Command;

use board_client::emulator::image;
use libtest_mimic::{Arguments, Failed, Trial};

fn main() {
    let missing = missing();
    if let Some(reason) = &missing {
        println!("the tests of the production image are skipped: {reason}");
    }
    let trial = |name: &str, test: fn() -> Result<(), Failed>| {
        Trial::test(name, test).with_ignored_flag(missing.is_some())
    };
    let trials = vec![
        trial(
            "the_production_image_tracks_the_rig_as_the_emulated_one_does",
            closed_loop::as_the_emulated_image,
        ),
        trial("every_fault_that_samples_can_show_vents_the_production_image", faults::of_samples),
        trial("faults_of_the_processor_vent_reset_and_are_kept_until_acknowledged", faults::of_the_processor),
        trial("the_production_image_takes_an_upload_on_its_bus_within_its_stack", bus::takes_an_upload),
        trial(
            "random_frames_are_met_with_exceptions_by_the_production_image",
            bus::meets_random_frames_with_exceptions,
        ),
        trial("the_production_image_starts_with_what_is_stored", store::starts_with_what_is_stored),
        trial("a_store_that_cannot_be_read_is_the_fault_of_its_kind", store::faults),
        trial("a_full_store_is_saved_into_before_a_task_is_missed", store::saves_in_time),
        trial(
            "a_configuration_that_cannot_be_stored_is_used_and_whoever_sent_it_is_told",
            store::of_a_flash_that_does_not_keep,
        ),
    ];
    libtest_mimic::run(&Arguments::from_args(), trials).exit()
}

/// What is missing for these tests.
fn missing() -> Option<String> {
    if Command::new("qemu-system-arm").arg("--version").output().is_err() {
        return Some("no qemu-system-arm; `cargo xtask setup` installs it".to_owned());
    }
    match image::find(None) {
        Err(error) => Some(error.to_string()),
        Ok(_) => (!production().is_file()).then(|| format!("no {}", production().display())),
    }
}

/// The image's ELF file, beside that of the emulated image.
fn production() -> PathBuf {
    image::find(None).map(|image| image.with_file_name("stm32f405")).unwrap_or_default()
}
