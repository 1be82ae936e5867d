//! `mgpi man`: the manual page, a section each command.

use std::io;

use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;

use super::CommandLine;
use crate::Error;
use crate::output::print;

/// Prints the manual page: `mgpi man > mgpi.1; man ./mgpi.1`.
#[derive(Args, Debug)]
pub struct Arguments {}

/// Prints.
///
/// # Errors
/// Standard output cannot be written.
pub fn run(Arguments {}: &Arguments) -> Result<(), Error> {
    let mut program = CommandLine::command().disable_help_subcommand(true);
    program.build();
    let mut page = Vec::new();
    // Writing to memory cannot fail.
    let _ = write_page(&program, &mut page);
    Ok(print(&page)?)
}

fn write_page(program: &Command, page: &mut dyn io::Write) -> io::Result<()> {
    let man = Man::new(program.clone());
    man.render_title(page)?;
    man.render_name_section(page)?;
    write_sections(program, page)?;
    man.render_version_section(page)
}

/// A section each command, and each of its own commands.
fn write_sections(program: &Command, page: &mut dyn io::Write) -> io::Result<()> {
    for command in program.get_subcommands().filter(|command| command.get_name() != "help") {
        let (mut part, man) = (Vec::new(), Man::new(command.clone()));
        man.render_synopsis_section(&mut part)?;
        man.render_description_section(&mut part)?;
        man.render_options_section(&mut part)?;
        let name = command.get_bin_name().unwrap_or_else(|| command.get_name());
        writeln!(page, ".SH \"{}\"", name.to_uppercase())?;
        // What is a section of a page of its own is a part of one here.
        page.write_all(String::from_utf8_lossy(&part).replace("\n.SH ", "\n.SS ").as_bytes())?;
        write_sections(command, page)?;
    }
    Ok(())
}
