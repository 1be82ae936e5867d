//! The way of an image to the board: begin, blocks in order, take, restart, trial.
//!
//! Broken off anywhere, the image that runs stays. A board that has kept its power since goes on
//! where it was, if the image is the same.

use std::time::{Duration, Instant};

use thiserror::Error;
use wire::State;
use wire::image::{HEAD_OFFSET, HEAD_WORDS, Head, Place};
use wire::registers::{
    Id, UPLOAD_REGISTERS, UpdateOrder, UpdateResult, UpdateTrial, Value, bytes_of, pack_bytes,
};

use super::Package;
use crate::bus::about::About;
use crate::bus::client::BusError;
use crate::bus::{Board, BoardError};
use crate::stop::Stop;

/// Bytes of a block.
const BLOCK: usize = 2 * UPLOAD_REGISTERS as usize;
/// How long a board may take that erases a sector or looks at an image: 2.6 s and 1.6 s, by the
/// processor's data sheet and its internal oscillator.
const LONG: Duration = Duration::from_secs(5);
/// How often what takes long is asked for.
const TRIES: usize = 3;
/// Without a board that is on trial: a start takes some tenths of a second, and the watchdog's
/// longest is 8 s.
const SILENCE: Duration = Duration::from_secs(45);
/// By the board's own clock, which may be a simulated one: twice its trial. Unit: tick.
const TRIAL_TICKS: u32 = 20_000;
/// From question to question while a board is on trial.
const LOOK: Duration = Duration::from_millis(250);

/// Why a board has not the new image.
#[derive(Debug, Error)]
#[allow(missing_docs, reason = "the messages say what the variants and their fields are")]
pub enum UpdateError {
    #[error(transparent)]
    Board(#[from] BoardError),
    #[error("the board takes no images over the bus: {}", if *.emulated { "it is emulated" } else { "its firmware is older than that; flash it by a debugger once" })]
    NotHere { emulated: bool },
    #[error(
        "the board has just begun with another image, and has not shown yet that it runs: wait a minute, then mgpi status"
    )]
    OnTrial,
    #[error("the image is for boards of kind {image}, this one is of kind {board} (1 regulator, 2 coil)")]
    Kind { image: u16, board: u16 },
    #[error("the image is for boards of revision {first} to {last}, this one is of revision {board}")]
    Revision { first: u16, last: u16, board: u16 },
    #[error("the image is of release {image}, the board has {board}: --older takes it nevertheless")]
    Older { image: String, board: String },
    #[error("the board does not take the image: {0}; the one that it has runs on")]
    Refused(&'static str),
    #[error(
        "the board has begun with the new image, which has not shown that it runs: the one before runs again"
    )]
    RolledBack,
    #[error("the board has run with the new image for {} s by its own clock, and has not shown that it runs: see mgpi status", TRIAL_TICKS / 1000)]
    NoSign,
    #[error("the board has said nothing of the new image for {} s: see mgpi status", SILENCE.as_secs())]
    Silent,
    #[error("interrupted; the image that runs stays, and the same mgpi update goes on")]
    Stopped,
}

impl From<BusError> for UpdateError {
    fn from(error: BusError) -> Self {
        Self::Board(error.into())
    }
}

/// What a board says of its images.
struct Here {
    place: Place,
    trial: UpdateTrial,
    kind: u16,
    next: usize,
}

/// What is done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// So many bytes of so many are written.
    Writing(usize, usize),
    /// The board looks at the image.
    Looking,
}

/// Sends the image for the place that does not run, and has it taken; answers the place.
///
/// # Errors
/// The board does not answer, or refuses: the image that runs stays.
pub fn send(
    board: &mut Board,
    package: &Package,
    takes_older: bool,
    stop: &Stop,
    told: &dyn Fn(Step),
) -> Result<Place, UpdateError> {
    let here = here(board)?;
    if here.trial == UpdateTrial::OnTrial {
        return Err(UpdateError::OnTrial);
    }
    let place = here.place.other();
    let image = package.image(place);
    fits(board, &here, image, takes_older)?;
    let mut done = begin(board, &here, image)?;
    while let Some(block) = image.get(done..).filter(|left| !left.is_empty()) {
        if stop.is_requested() {
            return Err(UpdateError::Stopped);
        }
        told(Step::Writing(done, image.len()));
        let block = &block[..BLOCK.min(block.len())];
        let erases = (0..4).any(|sector| {
            let begin = if sector == 0 { 0 } else { place.sectors()[sector - 1] as usize };
            (done..done + block.len()).contains(&begin)
        });
        let words: Vec<u16> = Value::U32(done as u32).words().chain(pack_bytes(block)).collect();
        if erases {
            patiently(board, |board, patience| board.write_once(Id::UpdateOffset, &words, patience))?;
        } else {
            board.write(Id::UpdateOffset, &words)?;
        }
        done += block.len();
    }
    told(Step::Looking);
    let order = [UpdateOrder::Take.number(), takes_older.into()];
    match patiently(board, |board, patience| board.write_once(Id::UpdateOrder, &order, patience)) {
        Err(error) if error.exception().is_some() => {
            let number = board.read(Id::UpdateResult, Id::UpdateResult)?.whole(Id::UpdateResult);
            Err(refused(UpdateResult::of_number(number as u16).unwrap_or(UpdateResult::None)))
        }
        done => Ok(done.map(|()| place)?),
    }
}

/// Has the board start again.
///
/// # Errors
/// It does not answer, or refuses.
pub fn restart(board: &mut Board) -> Result<(), UpdateError> {
    match board.write_once(Id::UpdateOrder, &[UpdateOrder::Restart.number()], 1) {
        // Whether it was heard is seen by what runs.
        Err(error) if error.is_lost() => Ok(()),
        done => Ok(done?),
    }
}

/// Waits until the image in a place stays: as long as the board says that it is on trial, by the
/// board's own ticks.
///
/// # Errors
/// It does not.
pub fn watch(board: &mut Board, place: Place) -> Result<(), UpdateError> {
    let mut last_seen = Instant::now();
    loop {
        std::thread::sleep(LOOK);
        let seen = match progress(board) {
            Ok(seen) => Some(seen),
            // It starts.
            Err(UpdateError::Board(BoardError::Bus(error))) if error.is_lost() => None,
            Err(error) => return Err(error),
        };
        match next(seen, place, last_seen.elapsed()) {
            Next::Seen => last_seen = Instant::now(),
            Next::Wait => {}
            Next::End(outcome) => return outcome,
        }
    }
}

/// What the board that is watched says: its place, what becomes of the trial, its ticks since the
/// start.
type Seen = (Place, UpdateTrial, u32);

fn progress(board: &mut Board) -> Result<Seen, UpdateError> {
    let Here { place, trial, .. } = here(board)?;
    Ok((place, trial, board.read(Id::Ticks, Id::Ticks)?.whole(Id::Ticks)))
}

/// What to do behind a look.
#[derive(Debug)]
enum Next {
    /// Go on: the board is on trial.
    Seen,
    /// Go on: it says nothing, or nothing of this image.
    Wait,
    End(Result<(), UpdateError>),
}

/// `silent_for`: since the board was last seen on trial, or the beginning.
fn next(seen: Option<Seen>, place: Place, silent_for: Duration) -> Next {
    match seen {
        Some((now, UpdateTrial::ForGood, _)) if now == place => Next::End(Ok(())),
        Some((_, UpdateTrial::RolledBack, _)) => Next::End(Err(UpdateError::RolledBack)),
        Some((_, UpdateTrial::OnTrial, ticks)) if ticks > TRIAL_TICKS => Next::End(Err(UpdateError::NoSign)),
        Some((_, UpdateTrial::OnTrial, _)) => Next::Seen,
        _ if silent_for > SILENCE => Next::End(Err(UpdateError::Silent)),
        _ => Next::Wait,
    }
}

fn here(board: &mut Board) -> Result<Here, UpdateError> {
    let block = match board.read(Id::UpdateOrder, Id::UpdateNext) {
        Err(error) if error.exception().is_some() => return Err(UpdateError::NotHere { emulated: false }),
        block => block?,
    };
    let number = block.whole(Id::UpdatePlace);
    let place = Place::BOTH.into_iter().find(|place| u32::from(place.number()) == number);
    Ok(Here {
        place: place.ok_or(UpdateError::NotHere { emulated: true })?,
        trial: UpdateTrial::of_number(block.whole(Id::UpdateTrial) as u16).unwrap_or(UpdateTrial::ForGood),
        kind: block.whole(Id::UpdateKind) as u16,
        next: block.whole(Id::UpdateNext) as usize,
    })
}

/// The image is one for this board, which does not drive its valve.
fn fits(board: &mut Board, here: &Here, image: &[u8], takes_older: bool) -> Result<(), UpdateError> {
    // A package has images only.
    let Some(Head { linked, .. }) = Head::of(image) else { return Err(refused(UpdateResult::NotWhole)) };
    let revision = About::read(board)?.map_or(0, |about| about.hardware_revision);
    let ([first, last], release) = (linked.revisions, board.identity().release);
    let named = |[major, minor, patch]: [u16; 3]| format!("{major}.{minor}.{patch}");
    if linked.kind != here.kind {
        return Err(UpdateError::Kind { image: linked.kind, board: here.kind });
    }
    if !(first..=last).contains(&revision) {
        return Err(UpdateError::Revision { first, last, board: revision });
    }
    if linked.release < release && !takes_older {
        return Err(UpdateError::Older { image: named(linked.release), board: named(release) });
    }
    let (state, _): (State, _) = board.state()?;
    if state.is_driven() {
        let needed = "drives the valve: mgpi status --stop ends that";
        return Err(BoardError::State { state, needed }.into());
    }
    Ok(())
}

/// Goes on where an earlier transfer of the same image was, or begins; answers how many bytes are
/// there.
fn begin(board: &mut Board, here: &Here, image: &[u8]) -> Result<usize, UpdateError> {
    let head = HEAD_OFFSET..HEAD_OFFSET + 4 * HEAD_WORDS;
    if (head.end..=image.len()).contains(&here.next) {
        board.set(Id::UpdateOffset, HEAD_OFFSET as f64)?;
        let window = board.read(Id::UpdateWindow, Id::UpdateWindow)?;
        let stands: Vec<u8> = bytes_of(window.words(Id::UpdateWindow)).take(head.len()).collect();
        if stands == image[head] {
            return Ok(here.next);
        }
    }
    board.write(Id::UpdateOrder, &[UpdateOrder::Begin.number()])?;
    Ok(0)
}

/// Asks for what takes long, and does no harm if it is done twice.
fn patiently(
    board: &mut Board,
    ask: impl Fn(&mut Board, u32) -> Result<(), BusError>,
) -> Result<(), BusError> {
    let patience = LONG.div_duration_f64(board.limit()).ceil() as u32;
    for _ in 1..TRIES {
        match ask(board, patience) {
            Err(error) if error.is_lost() => {}
            done => return done,
        }
    }
    ask(board, patience)
}

fn refused(result: UpdateResult) -> UpdateError {
    UpdateError::Refused(match result {
        UpdateResult::None | UpdateResult::Taken => "it does not say why",
        UpdateResult::NotWhole => "what has arrived is not whole",
        UpdateResult::OtherBoard => "it is for a board of another kind or revision",
        UpdateResult::OtherPlace => "it is for the other place in the flash",
        UpdateResult::Older => "it is of an older release; --older takes it nevertheless",
        UpdateResult::Signature => {
            "it is not signed by the key that the board's firmware was built with: see docs/update.md"
        }
        UpdateResult::NotStored => {
            "the flash has not kept that it is to be tried; after a second failure flash the board by a debugger"
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_board_on_trial_is_waited_for_by_its_own_clock_and_a_silent_one_by_the_hosts() {
        let (at_once, long) = (Duration::ZERO, SILENCE + Duration::from_secs(1));
        let look = |trial, ticks, silent_for| next(Some((Place::B, trial, ticks)), Place::B, silent_for);
        // However slow it is beside the host.
        assert!(matches!(look(UpdateTrial::OnTrial, 9_000, Duration::from_secs(3600)), Next::Seen));
        assert!(matches!(
            look(UpdateTrial::OnTrial, TRIAL_TICKS + 1, at_once),
            Next::End(Err(UpdateError::NoSign))
        ));
        assert!(matches!(look(UpdateTrial::ForGood, 10_000, at_once), Next::End(Ok(()))));
        assert!(matches!(
            look(UpdateTrial::RolledBack, 10, at_once),
            Next::End(Err(UpdateError::RolledBack))
        ));
        // It has not restarted yet, or starts.
        for seen in [Some((Place::A, UpdateTrial::Waits, 50_000)), None] {
            assert!(matches!(next(seen, Place::B, at_once), Next::Wait));
            assert!(matches!(next(seen, Place::B, long), Next::End(Err(UpdateError::Silent))));
        }
    }
}
