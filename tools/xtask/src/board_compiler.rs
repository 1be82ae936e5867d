//! The compiler for the board: which one the machine has, and how cargo is told to use it.
//!
//! Either rustup's compiler with the target installed, or the system's own compiler (Debian ships a
//! current one and its sources, without the target), which then compiles `core` itself.

use std::path::{Path, PathBuf};
use std::process::Command;

use crate::run;

/// The instruction set of the STM32F405: Cortex-M4 with a single-precision floating-point unit.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// The oldest minor version of Rust 1 that compiles the workspace (`rust-version` in Cargo.toml).
const OLDEST_MINOR: u32 = 88;

/// Where distributions install their compiler, whatever else is first on the path.
const SYSTEM_RUSTC: &str = "/usr/bin/rustc";

/// A compiler that can build the firmware.
pub enum BoardCompiler {
    /// The compiler that cargo uses anyway: the target is installed.
    Installed,
    /// The system's compiler, compiling `core` from its sources and linking by `linker`.
    System {
        /// rust-lld or ld.lld.
        linker: PathBuf,
    },
}

impl BoardCompiler {
    /// The first that is there, if any.
    pub fn find() -> Option<Self> {
        if target_is_installed() {
            Some(Self::Installed)
        } else if system_compiler_is_complete() {
            Some(Self::System { linker: linker()? })
        } else {
            None
        }
    }

    /// Its name and version.
    pub fn version(&self) -> String {
        let program = match self {
            Self::Installed => "rustc",
            Self::System { .. } => SYSTEM_RUSTC,
        };
        run::output(program, &["--version"]).unwrap_or_default()
    }

    /// Makes a cargo command compile by this compiler.
    pub fn apply(&self, cargo: &mut Command) {
        // These would replace the link arguments of .cargo/config.toml.
        cargo.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
        if let Self::System { linker } = self {
            cargo
                .arg("-Zbuild-std=core")
                // Compiling `core` is the one unstable feature used; this permits it on a stable
                // compiler.
                .env("RUSTC_BOOTSTRAP", "1")
                .env("RUSTC", SYSTEM_RUSTC)
                .env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", linker);
        }
    }
}

fn target_is_installed() -> bool {
    run::output("rustc", &["--print", "target-libdir", "--target", TARGET])
        .is_some_and(|directory| Path::new(&directory).is_dir())
}

fn system_compiler_is_complete() -> bool {
    let current =
        run::output(SYSTEM_RUSTC, &["--version"]).and_then(|version| minor(&version)) >= Some(OLDEST_MINOR);
    let sources = run::output(SYSTEM_RUSTC, &["--print", "sysroot"])
        .map(|sysroot| Path::new(&sysroot).join("lib/rustlib/src/rust/library/core/src/lib.rs"));
    current && sources.is_some_and(|file| file.is_file())
}

/// 96 of "rustc 1.96.0 (…)".
fn minor(version: &str) -> Option<u32> {
    version.split('.').nth(1)?.parse().ok()
}

/// rust-lld as rustup ships it with its compiler for the host, else LLVM's linker of the system.
fn linker() -> Option<PathBuf> {
    let of_rustup = run::output("rustc", &["--print", "target-libdir"])
        .map(|libraries| Path::new(&libraries).with_file_name("bin").join("rust-lld"))
        .filter(|path| path.is_file());
    let of_system =
        || ["ld.lld-19", "ld.lld"].into_iter().find(|name| run::output(name, &["--version"]).is_some());
    of_rustup.or_else(|| of_system().map(PathBuf::from))
}

#[cfg(test)]
mod tests {
    use super::minor;

    #[test]
    fn the_minor_version_is_the_second_number() {
        assert_eq!(minor("rustc 1.96.0 (ac68faa20 2026-05-25)"), Some(96));
        assert_eq!(minor("rustc 1.63"), Some(63));
        assert_eq!(minor("gcc"), None);
    }
}
