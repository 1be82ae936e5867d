//! What the commands need beyond cargo, and how it is got. [`NEEDS`] is the whole policy: each need
//! is tested; when it is not met its cures are tried in turn, each announced before it runs; what
//! is left is a [`Missing`] error that says exactly what to install. Nothing is printed when
//! nothing is missing.
//!
//! Packages are installed by apt-get (by sudo when not root, since only system packages need it);
//! on a system without apt-get that cure does not apply.

use std::fmt;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};
use std::time::Duration;

use anyhow::Result;

use crate::board_compiler::{BoardCompiler, TARGET};
use crate::run;

const NEEDS: &[Need] = &[
    Need {
        name: "a compiler for the board (thumbv7em-none-eabihf)",
        is_met: || BoardCompiler::find().is_some(),
        cures: &[Cure::RustupTarget, Cure::Packages(&["rustc-web", "rust-web-src", "lld-19"])],
        by_hand: "rustup target add thumbv7em-none-eabihf\n\
                  or, without rustup: the distribution's Rust (1.88 or newer) with its sources as /usr/bin/rustc, \
                  and LLVM's linker ld.lld\n(Debian 12: apt-get install rustc-web rust-web-src lld-19)",
    },
    Need {
        name: "the emulator (qemu-system-arm)",
        is_met: || run::output("qemu-system-arm", &["--version"]).is_some(),
        cures: &[Cure::Packages(&["qemu-system-arm"])],
        by_hand: "QEMU 7.2 or newer for ARM systems: the package qemu-system-arm (Debian, Ubuntu, Fedora, Arch) \
                  or qemu (Homebrew)",
    },
];

/// What fuzzing needs beyond that.
const FUZZER: Need = Need {
    name: "the fuzzer (cargo-fuzz)",
    is_met: || run::output("cargo", &["fuzz", "--version"]).is_some(),
    cures: &[Cure::CargoInstall("cargo-fuzz")],
    by_hand: "cargo install --locked cargo-fuzz (it needs a C++ compiler)",
};

/// What the tests of the bus need: clients that others have written.
const BUS_CLIENTS: [Need; 2] = [
    Need {
        name: "a Modbus client (mbpoll)",
        is_met: || run::output("mbpoll", &["-V"]).is_some(),
        cures: &[Cure::Packages(&["mbpoll"])],
        by_hand: "mbpoll: the package of that name (Debian, Ubuntu), or https://github.com/epsilonrt/mbpoll",
    },
    Need {
        name: "a Python with pymodbus",
        is_met: || BUS_PYTHON.is_made(),
        cures: &[Cure::Python(&BUS_PYTHON), Cure::Packages(&["python3-venv"]), Cure::Python(&BUS_PYTHON)],
        by_hand: PYTHON_BY_HAND,
    },
];

/// What the tests of the chip need: the processor that their model is built around.
const CHIP_MODEL: Need = Need {
    name: "a Python with unicorn",
    is_met: || CHIP_PYTHON.is_made(),
    cures: &[Cure::Python(&CHIP_PYTHON), Cure::Packages(&["python3-venv"]), Cure::Python(&CHIP_PYTHON)],
    by_hand: PYTHON_BY_HAND,
};

/// What the tests of the network need: programs that others have written.
const NETWORK_CLIENTS: Need = Need {
    name: "a Python with eclipse-zenoh",
    is_met: || NETWORK_PYTHON.is_made(),
    cures: &[Cure::Python(&NETWORK_PYTHON), Cure::Packages(&["python3-venv"]), Cure::Python(&NETWORK_PYTHON)],
    by_hand: PYTHON_BY_HAND,
};

/// What the tests of models in C need, to run them on the board's processor too.
const BOARD_C: Need = Need {
    name: "a C compiler for the board (arm-none-eabi-gcc)",
    is_met: || run::output("arm-none-eabi-gcc", &["--version"]).is_some(),
    cures: &[Cure::Packages(&["gcc-arm-none-eabi", "libnewlib-arm-none-eabi"])],
    by_hand: "GCC and newlib for bare ARM: the packages gcc-arm-none-eabi and libnewlib-arm-none-eabi (Debian, Ubuntu)",
};

/// What the tests of the board's front ends need.
const CIRCUITS: Need = Need {
    name: "a simulator of circuits (ngspice)",
    is_met: || run::output("ngspice", &["--version"]).is_some(),
    cures: &[Cure::Packages(&["ngspice"])],
    by_hand: "ngspice 39 or newer: the package of that name (Debian, Ubuntu, Fedora, Arch, Homebrew)",
};

/// What the Python package needs: what builds its wheel, and what its tests hold it against.
const PYTHON_PACKAGE: Need = Need {
    name: "a Python with maturin",
    is_met: || PACKAGE_PYTHON.is_made(),
    cures: &[Cure::Python(&PACKAGE_PYTHON), Cure::Packages(&["python3-venv"]), Cure::Python(&PACKAGE_PYTHON)],
    by_hand: PYTHON_BY_HAND,
};

const PYTHON_BY_HAND: &str =
    "Python 3.10 or newer with its module venv (Debian, Ubuntu: apt-get install python3-venv)";

/// The Python of the tests of the bus.
pub const BUS_PYTHON: Python =
    Python { directory: "bus-clients", requirements: "host-tests/bus/requirements.txt" };

/// The Python of the tests of the chip.
pub const CHIP_PYTHON: Python =
    Python { directory: "chip-model", requirements: "host-tests/chip/requirements.txt" };

/// The Python of the tests of the network.
pub const NETWORK_PYTHON: Python =
    Python { directory: "network-clients", requirements: "host-tests/network/requirements.txt" };

/// The Python that builds and tests the package.
pub const PACKAGE_PYTHON: Python =
    Python { directory: "python-package", requirements: "host/python/requirements.txt" };

/// A Python with packages of its own, in the target directory.
pub struct Python {
    directory: &'static str,
    /// The file that names the packages.
    requirements: &'static str,
}

impl Python {
    /// The program.
    pub fn program(&self) -> PathBuf {
        run::target_dir().join(self.directory).join("bin/python")
    }

    /// The list of packages that it was made of.
    fn made_of(&self) -> PathBuf {
        self.program().with_file_name("requirements.txt")
    }

    fn wanted(&self) -> PathBuf {
        run::root().join(self.requirements)
    }

    fn is_made(&self) -> bool {
        fs::read(self.made_of()).is_ok_and(|made| fs::read(self.wanted()).is_ok_and(|wanted| wanted == made))
    }

    fn make(&self) -> bool {
        let directory = run::target_dir().join(self.directory);
        let mut pip = Command::new(self.program());
        pip.args(["-m", "pip", "install", "-q", "-r"]).arg(self.wanted());
        announced(Command::new("python3").args(["-m", "venv"]).arg(directory), PYTHON_LIMIT)
            && announced(&mut pip, PYTHON_LIMIT)
            && fs::copy(self.wanted(), self.made_of()).is_ok()
    }
}

/// Something the commands cannot do without.
struct Need {
    name: &'static str,
    is_met: fn() -> bool,
    cures: &'static [Cure],
    /// What the user is told when no cure helped.
    by_hand: &'static str,
}

/// A way to meet a need.
enum Cure {
    /// rustup installs the target's precompiled `core`.
    RustupTarget,
    /// cargo installs this program, in the user's directory.
    CargoInstall(&'static str),
    /// A Python environment is made, with its packages.
    Python(&'static Python),
    /// apt-get installs these packages.
    Packages(&'static [&'static str]),
}

/// How long rustup may take for a download of some 30 MB before the next cure is tried.
const RUSTUP_LIMIT: Duration = Duration::from_secs(180);
/// How long cargo may take for the compilation of a program.
const CARGO_LIMIT: Duration = Duration::from_secs(600);
/// How long pip may take for packages of some MB.
const PYTHON_LIMIT: Duration = Duration::from_secs(300);
/// How long apt-get may take for some 300 MB.
const APT_LIMIT: Duration = Duration::from_secs(1200);

/// The needs that no cure could meet.
#[derive(Debug)]
pub struct Missing(Vec<String>);

impl fmt::Display for Missing {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "please install by hand, then run the command again:")?;
        self.0.iter().try_for_each(|need| write!(formatter, "\n{need}"))
    }
}

impl std::error::Error for Missing {}

/// Meets every need, and returns the compiler for the board.
///
/// # Errors
/// [`Missing`], naming all the needs that could not be met.
pub fn ensure() -> Result<BoardCompiler> {
    let missing: Vec<String> = NEEDS.iter().filter_map(|need| need.meet().err()).collect();
    match BoardCompiler::find() {
        Some(compiler) if missing.is_empty() => Ok(compiler),
        _ => Err(Missing(missing).into()),
    }
}

/// Installs the fuzzer if it is missing.
///
/// # Errors
/// [`Missing`].
pub fn ensure_fuzzer() -> Result<()> {
    FUZZER.meet().map_err(|missing| Missing(vec![missing]).into())
}

/// Makes the Python that builds and tests the package.
///
/// # Errors
/// [`Missing`].
pub fn ensure_python_package() -> Result<()> {
    PYTHON_PACKAGE.meet().map_err(|missing| Missing(vec![missing]).into())
}

/// Installs what some tests need and is missing: what cannot be had is said, and its tests are
/// skipped.
pub fn offer_test_tools() {
    let of_bus = BUS_CLIENTS.iter().map(|need| ("bus", need));
    let others = [
        ("chip", &CHIP_MODEL),
        ("network", &NETWORK_CLIENTS),
        ("C sources", &BOARD_C),
        ("circuits", &CIRCUITS),
    ];
    for (tests, need) in of_bus.chain(others) {
        if let Err(missing) = need.meet() {
            println!("setup: the tests of the {tests} are skipped without\n{missing}");
        }
    }
}

impl Need {
    fn meet(&self) -> Result<(), String> {
        if (self.is_met)() {
            return Ok(());
        }
        println!("setup: {} is missing", self.name);
        if self.cures.iter().any(|cure| cure.apply() && (self.is_met)()) {
            return Ok(());
        }
        Err(format!("- {}:\n    {}", self.name, self.by_hand.replace('\n', "\n    ")))
    }
}

impl Cure {
    /// Whether it could be done.
    fn apply(&self) -> bool {
        match self {
            Self::RustupTarget => {
                run::output("rustup", &["--version"]).is_some()
                    && announced(Command::new("rustup").args(["target", "add", TARGET]), RUSTUP_LIMIT)
            }
            Self::CargoInstall(program) => {
                announced(Command::new("cargo").args(["install", "--locked", program]), CARGO_LIMIT)
            }
            Self::Python(python) => python.make(),
            Self::Packages(packages) => {
                let install = [&["install", "-y", "--no-install-recommends"], *packages].concat();
                run::output("apt-get", &["--version"]).is_some() && {
                    // Fails when the lists of packages are missing, as on a bare image, or out of
                    // date.
                    announced(&mut apt_get(&install), APT_LIMIT)
                        || announced(&mut apt_get(&["update"]), APT_LIMIT)
                            && announced(&mut apt_get(&install), APT_LIMIT)
                }
            }
        }
    }
}

fn apt_get(arguments: &[&str]) -> Command {
    let is_root = run::output("id", &["-u"]).as_deref() == Some("0");
    let mut command = Command::new(if is_root { "env" } else { "sudo" });
    command.args(["DEBIAN_FRONTEND=noninteractive", "apt-get", "-qq"]).args(arguments).stdout(Stdio::null());
    command
}

/// Says what will run, and runs it.
fn announced(command: &mut Command, limit: Duration) -> bool {
    let words: Vec<_> = std::iter::once(command.get_program())
        .chain(command.get_args())
        .map(|word| word.to_string_lossy())
        .collect();
    println!("setup: running `{}` (at most {} s)", words.join(" "), limit.as_secs());
    run::succeeds_within(command, limit)
}
