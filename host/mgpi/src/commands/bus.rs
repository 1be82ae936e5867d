//! `mgpi bus`: how a board is reached.

use std::thread;
use std::time::Duration;

use clap::Args;
use wire::BusParameters;

use super::port::PortArguments;
use crate::Error;
use board_client::bus::about::About;
use board_client::bus::port::Parity;
use board_client::bus::reached::{Change, InWords, Reached, in_words, keep, take};
use board_client::bus::{Board, BoardError};

/// How long a board may take to listen by other parameters.
const SETTLING: Duration = Duration::from_millis(50);

/// Shows or changes how a board is reached: its number, rate, parity and turn-around.
///
/// A board keeps what it is told, and takes it at its next start, or by --take at once. One that
/// hears nobody for 10 s by its own rate and parity listens by 115200 bit/s without parity, under
/// its own number, and by its own again, 10 s each, until somebody speaks: a wrong rate loses no
/// board.
#[derive(Args, Debug)]
pub struct Arguments {
    /// The number that the board gets
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(1..=247))]
    set_number: Option<u8>,
    /// The rate that it gets, in bit/s
    #[arg(long, value_name = "BIT/S", value_parser = clap::value_parser!(u32).range(9_600..=1_000_000))]
    set_baud: Option<u32>,
    /// The parity that it gets
    #[arg(long)]
    set_parity: Option<Parity>,
    /// Least time from the end of a request to the answer, in us, for masters that let go of the
    /// line late
    #[arg(long, value_name = "US", value_parser = clap::value_parser!(u32).range(0..=50_000))]
    set_turnaround_us: Option<u32>,
    /// Let the board take what it keeps at once, and ask it again by that
    #[arg(long)]
    take: bool,
    #[command(flatten)]
    port: PortArguments,
}

/// Shows or changes.
///
/// # Errors
/// The board does not answer, does not take it, or is not heard by its new parameters.
pub fn run(arguments: &Arguments) -> Result<(), Error> {
    let Arguments { set_number, set_baud, set_parity, set_turnaround_us, take: takes, port } = arguments;
    let change = Change {
        unit: *set_number,
        baud: *set_baud,
        parity: set_parity.map(Into::into),
        turnaround_us: *set_turnaround_us,
    };
    let mut board = port.open()?;
    let before = reached(&mut board)?;
    let wanted = change.of(before.kept);
    if wanted != before.kept {
        keep(&mut board, &wanted).map_err(BoardError::from)?;
        say!("kept      {} -> {}", InWords(&before.kept), InWords(&wanted));
    }
    if *takes {
        let about = About::read(&mut board).map_err(BoardError::from)?;
        take(&mut board).map_err(BoardError::from)?;
        drop(board);
        thread::sleep(SETTLING);
        board = again(port, &wanted)?;
        if About::read(&mut board).map_err(BoardError::from)? != about {
            return Err(Error::Usage(format!(
                "another board than before answers by {}: two have the number {}",
                InWords(&wanted),
                wanted.unit
            )));
        }
    }
    let now = reached(&mut board)?;
    if now.kept != wanted {
        return Err(Error::Usage(format!("the board keeps {}, not what it was told", InWords(&now.kept))));
    }
    say!("keeps     {}", InWords(&now.kept));
    say!("listens   by {}", in_words(now.listens));
    Ok(())
}

fn reached(board: &mut Board) -> Result<Reached, Error> {
    Reached::read(board).map_err(BoardError::from)?.ok_or_else(|| {
        Error::Usage("the board's firmware keeps no number and no rate: flash one of this release".to_owned())
    })
}

/// The board by its new parameters.
fn again(port: &PortArguments, parameters: &BusParameters) -> Result<Board, Error> {
    port.open_by(parameters).map_err(|error| {
        Error::Usage(format!(
            "{error}\nthe board has taken {}, and is not heard by that; it keeps it. Behind 10 s it listens by 115200 bit/s \
             without parity too, 10 s in 20: mgpi bus --unit {} --port …",
            InWords(parameters),
            parameters.unit
        ))
    })
}
