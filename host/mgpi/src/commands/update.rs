//! `mgpi update`: a new image to a board.

use std::cell::RefCell;
use std::path::PathBuf;

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::port::PortArguments;
use crate::Error;
use board_client::stop::Stop;
use board_client::update::{Package, Step, restart, send, watch};

/// Brings new firmware to a board, and waits until it has shown that it runs. Broken off, or
/// without power, the board keeps the firmware that it has; the same command goes on.
///
/// The valve must not be driven, and nothing else may ask the board meanwhile. What the board
/// stores (model, limits, calibration, number) stays. A package is made and signed by `cargo xtask
/// image`; the board takes it only if the key is that which its own firmware was built with.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The package, from `cargo xtask image`
    #[arg(value_name = "IMAGE")]
    package: PathBuf,
    /// Also take a release that is older than the one that runs; if it does not know the layout of
    /// what the board stores, the board begins with that of a new one
    #[arg(long)]
    older: bool,
    #[command(flatten)]
    port: PortArguments,
}

/// Updates.
///
/// # Errors
/// The file is no package, or the board does not take it.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { package: file, older, port } = arguments;
    let package = Package::read(file)?;
    let stop = Stop::on_signals();
    let mut board = port.open()?;
    let style = ProgressStyle::with_template("{msg} {wide_bar} {bytes} of {total_bytes}, {eta} left");
    let bar = ProgressBar::new(0).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    let begun = RefCell::new(false);
    let sent = send(&mut board, &package, *older, &stop, &|step| match step {
        Step::Writing(done, all) => {
            if !begun.replace(true) {
                bar.set_message("writing");
                if done > 0 {
                    say!("goes on behind {done} bytes that are there");
                }
            }
            bar.set_length(all as u64);
            bar.set_position(done as u64);
        }
        Step::Looking => bar.set_message("looking"),
    });
    bar.finish_and_clear();
    let place = sent?;
    say!("the image is written and complete, and its signature fits the board's key; the board restarts");
    restart(&mut board)?;
    say!("on trial: it has to run for 10 s");
    watch(&mut board, place)?;
    say!("the board runs with it, in the place {place:?}, and keeps it");
    Ok(())
}
