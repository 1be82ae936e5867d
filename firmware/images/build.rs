//! Lets the linker find the board's memory layout, `memory.x` at the root of the workspace, and the
//! place of each image in the flash, a `place.x` each in `places`.

/// Images, and the folder of their place.
const PLACES: [(&str, &str); 8] = [
    ("bring_up", "bring_up"),
    ("emulated", "whole"),
    ("emulated_joint", "whole"),
    ("law_and_tick", "whole"),
    ("starter", "starter"),
    ("stm32f405", "a"),
    ("stm32f405_b", "b"),
    ("stm32f405_joint", "a"),
];

fn main() {
    println!("cargo:rustc-link-search={}/../..", env!("CARGO_MANIFEST_DIR"));
    println!("cargo:rerun-if-changed=../../memory.x");
    println!("cargo:rerun-if-changed=places");
    if std::env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    for (image, place) in PLACES {
        println!("cargo:rustc-link-arg-bin={image}=-L{}/places/{place}", env!("CARGO_MANIFEST_DIR"));
    }
}
