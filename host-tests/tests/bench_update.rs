//! `mgpi update` against the board's own code, with images in memory; the board's flash, its
//! starter and cuts of power are tested in the model of its chip.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use board_client::update::Package;
use firmware::FIRMWARE_VERSION;
use fleet::line::Way;
use host_tests::desk_commands::DeskBench as Bench;
use packing::{new_key, read_key, small};
use wire::image::{BoardKind, Linked, Place};

/// The head of the image that runs.
const RUNNING: Linked = Linked {
    kind: BoardKind::Regulator.number(),
    revisions: [0, 9],
    release: FIRMWARE_VERSION,
    wire: wire::VERSION,
    layout: firmware::store::LAYOUT,
    is_modified: false,
    commit: [0; 10],
};
/// The key that the firmware is built with where nobody says another.
const KEY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/keys/tests-only.key");
/// What the images do does not matter: nothing runs them.
const CODE: [u8; 2] = [0xFE, 0xE7];

fn write_package(bench: &Bench, name: &str, linked: &Linked, key: &Path) {
    let (key, _) = read_key(key).unwrap();
    let images = Place::BOTH.map(|place| small(place, linked, &key, &CODE).unwrap());
    std::fs::write(bench.directory().join(name), Package { images }.to_bytes()).unwrap();
}

#[test]
fn a_board_is_updated_and_updated_again_into_the_former_place() {
    let bench = Bench::with_images(RUNNING, |_, bytes| bytes);
    write_package(&bench, "new.image", &RUNNING, Path::new(KEY));
    for place in ["B", "A"] {
        let said = bench.succeeds("update new.image");
        assert!(said.contains(&format!("runs with it, in the place {place}, and keeps it")), "{said}");
        assert_eq!(bench.status()["image"], serde_json::json!({"place": place, "trial": 0}));
    }
}

#[test]
fn what_does_not_fit_is_refused_in_words_before_it_is_sent_or_behind() {
    let bench = Bench::with_images(RUNNING, |_, bytes| bytes);
    let forger = bench.directory().join("forger.key");
    new_key(&forger).unwrap();
    let older = Linked { release: [0, 0, 9], ..RUNNING };
    write_package(&bench, "older", &older, Path::new(KEY));
    write_package(&bench, "coil", &Linked { kind: BoardKind::Coil.number(), ..RUNNING }, Path::new(KEY));
    write_package(&bench, "revision", &Linked { revisions: [7, 9], ..RUNNING }, Path::new(KEY));
    write_package(&bench, "forged", &RUNNING, &forger);
    std::fs::write(bench.directory().join("text"), "no image").unwrap();
    for (file, message) in [
        ("older", "release 0.0.9, the board has 0.1.0: --older takes it"),
        ("coil", "for boards of kind 2, this one is of kind 1"),
        ("revision", "for boards of revision 7 to 9, this one is of revision 3"),
        ("forged", "it is not signed by the key"),
        ("text", "does not begin with MGPI-IMG"),
        ("missing", "missing: No such file"),
    ] {
        let said = bench.refuses(&format!("update {file}"));
        assert!(said.contains(message), "{file}: {said}");
    }
    let said = bench.succeeds("update older --older");
    assert!(said.contains("in the place B"), "{said}");
}

#[test]
fn a_board_that_takes_no_images_says_so() {
    let bench = Bench::new();
    write_package(&bench, "new.image", &RUNNING, Path::new(KEY));
    let said = bench.refuses("update new.image");
    assert!(said.contains("takes no images over the bus: it is emulated"), "{said}");
}

#[test]
fn a_transfer_that_breaks_off_goes_on_where_it_was() {
    // The first frames of a block's length are heard, then the cable is off for a time.
    let heard = Arc::new(AtomicUsize::new(0));
    let count = heard.clone();
    let bench = Bench::with_images(RUNNING, move |way, bytes| {
        let is_block = way == Way::ToBoard && bytes.len() > 100;
        let number = if is_block { count.fetch_add(1, Ordering::Relaxed) } else { 0 };
        if (4..1000).contains(&number) { Vec::new() } else { bytes }
    });
    write_package(&bench, "new.image", &RUNNING, Path::new(KEY));
    let said = bench.refuses("update new.image");
    assert!(said.contains("no answer"), "{said}");
    heard.store(1000, Ordering::Relaxed);
    let said = bench.succeeds("update new.image");
    assert!(said.contains("goes on behind") && said.contains("keeps it"), "{said}");
}
