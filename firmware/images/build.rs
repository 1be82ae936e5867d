//! Lets the linker find the board's memory layout, `memory.x` at the root of the workspace.

fn main() {
    println!("cargo:rustc-link-search={}/../..", env!("CARGO_MANIFEST_DIR"));
    println!("cargo:rerun-if-changed=../../memory.x");
}
