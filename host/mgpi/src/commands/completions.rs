//! `mgpi completions`: what a shell needs to complete the arguments of `mgpi`.

use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};

use super::CommandLine;
use crate::Error;
use crate::output::print;

/// Prints what a shell needs to complete this program's arguments.
#[derive(Args, Debug)]
pub struct Arguments {
    /// For which shell
    shell: Shell,
}

/// Prints.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let mut script = Vec::new();
    generate(arguments.shell, &mut CommandLine::command(), "mgpi", &mut script);
    Ok(print(&script)?)
}
