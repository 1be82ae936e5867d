//! The program `mgpi`, as its library has it.

use std::process::ExitCode;

fn main() -> ExitCode {
    mgpi::main()
}
