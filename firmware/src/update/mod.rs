//! A new image over the bus.
//!
//! # Design
//! The flash has two places for an image ([`Place`]), and before them a starter that is never
//! written over the bus. The image that runs writes the other place, block by block; it looks at
//! what stands there (board, release, checksum, signature), and says in a [`log`] that it is to be
//! tried. The starter tries it at the next start, at most three times; the image says in the log
//! that it is there to stay, once it has shown that it runs (`trial`). Else the former image runs
//! again.
//!
//! ```text
//! begin ─▶ blocks, in order ─▶ take ─▶ restart ─▶ trial ─▶ for good
//! ForGood(A)                   Try(B)             Tried     ForGood(B)      what the log gets
//! ```
//!
//! # Contract
//! * Each step is one word of the log. Whatever a loss of power leaves, the image that the log
//!   names last for good is whole: its place is never erased while the log names it.
//! * An image on trial writes neither the other place nor the stored parameters: the former image,
//!   should it run again, finds what it can read.
//! * Nothing is done while the valve is driven. An erasure stops the processor for up to 2 s, and
//!   the look at an image 0.2 s.
//!
//! # Limits
//! How far the blocks have come is forgotten with power: what begins behind a loss of it begins
//! again.

pub mod log;
mod signature;
mod trial;

use wire::image::{Head, Place, SIGNATURE_BYTES};
use wire::registers::{Exception, UpdateResult, UpdateTrial};

use log::{Entry, Log};
pub use trial::look;

/// Words of the log that are left for the trial of the last image that is taken.
const RESERVED: usize = 8;

/// The flash has not done what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failure;

/// Both places, and the log.
pub trait Images {
    /// Where the image that asks stands.
    fn running(&self) -> Place;

    /// What stands in a place.
    fn read(&self, place: Place) -> &[u8];

    /// The words of the log.
    fn log(&self) -> &[u32];

    /// Erases the sector of this number of the place that does not run.
    ///
    /// # Errors
    /// It is not blank behind that.
    fn erase(&mut self, sector: usize) -> Result<(), Failure>;

    /// Programs whole words of the place that does not run, from an offset on.
    ///
    /// # Errors
    /// The flash refuses.
    fn program(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure>;

    /// Programs the word of the log with this number.
    ///
    /// # Errors
    /// The flash refuses.
    fn program_log(&mut self, index: usize, word: u32) -> Result<(), Failure>;

    /// Computes the checksum of what is shown.
    fn checksum(&self, show: impl FnOnce(&mut dyn FnMut(&[u8]))) -> u32;

    /// Does work that takes long while nothing else runs, as an erasure does: it would keep the
    /// other tasks from checking in.
    fn alone<R>(&self, work: impl FnOnce(&Self) -> R) -> R;

    /// Starts again.
    fn restart(&mut self);

    /// Writes a step, behind the others.
    ///
    /// # Errors
    /// The log is full, or the flash does not keep it.
    fn append(&mut self, entry: Entry) -> Result<(), Failure> {
        let index = Log::of(self.log()).used;
        let left = self.log().len().saturating_sub(index);
        if left == 0 || left <= RESERVED && matches!(entry, Entry::Try(_)) {
            return Err(Failure);
        }
        self.program_log(index, entry.word())?;
        if self.log().get(index) == Some(&entry.word()) { Ok(()) } else { Err(Failure) }
    }

    /// Whether the image that runs is on trial.
    fn is_on_trial(&self) -> bool {
        Log::of(self.log()).trial.is_some_and(|trial| trial.place == self.running())
    }
}

/// The images of a board that takes none; no value of it exists.
#[derive(Debug)]
pub enum NoImages {}

impl Images for NoImages {
    fn running(&self) -> Place {
        match *self {}
    }

    fn read(&self, _: Place) -> &[u8] {
        match *self {}
    }

    fn log(&self) -> &[u32] {
        match *self {}
    }

    fn erase(&mut self, _: usize) -> Result<(), Failure> {
        match *self {}
    }

    fn program(&mut self, _: u32, _: &[u8]) -> Result<(), Failure> {
        match *self {}
    }

    fn program_log(&mut self, _: usize, _: u32) -> Result<(), Failure> {
        match *self {}
    }

    fn checksum(&self, _: impl FnOnce(&mut dyn FnMut(&[u8]))) -> u32 {
        match *self {}
    }

    fn alone<R>(&self, _: impl FnOnce(&Self) -> R) -> R {
        match *self {}
    }

    fn restart(&mut self) {
        match *self {}
    }
}

/// How far an update has come, since the start.
#[derive(Debug)]
pub struct Update {
    /// Bytes written since begin; `None` before that.
    next: Option<u32>,
    /// Where the window stands.
    pub offset: u32,
    /// Of the last take.
    pub result: UpdateResult,
    /// To start again, behind the answer.
    pub restarts: bool,
    /// Whether there is a trial to be looked after; `None` until the first look.
    is_on_trial: Option<bool>,
}

impl Update {
    /// None has begun.
    pub const fn new() -> Self {
        Self { next: None, offset: 0, result: UpdateResult::None, restarts: false, is_on_trial: None }
    }

    /// Bytes written since begin.
    pub fn written(&self) -> u32 {
        self.next.unwrap_or(0)
    }

    /// Whether the image that runs is there to stay.
    pub fn trial(&self, images: &impl Images) -> UpdateTrial {
        match Log::of(images.log()).trial {
            None => UpdateTrial::ForGood,
            Some(trial) if trial.place == images.running() => UpdateTrial::OnTrial,
            Some(_) if self.result == UpdateResult::Taken => UpdateTrial::Waits,
            Some(_) => UpdateTrial::RolledBack,
        }
    }

    /// What stands in the other place is not tried any more, and is written afresh.
    ///
    /// # Errors
    /// The image that runs is on trial itself: the other is the one that is known to run. The flash
    /// has not kept it.
    pub fn begin(&mut self, images: &mut impl Images) -> Result<(), Exception> {
        let (log, running) = (Log::of(images.log()), images.running());
        if images.is_on_trial() {
            return Err(Exception::DeviceBusy);
        }
        if log.trial.is_some() || log.for_good != running {
            images.append(Entry::ForGood(running)).map_err(|Failure| Exception::DeviceFailure)?;
        }
        (self.next, self.result) = (Some(0), UpdateResult::None);
        Ok(())
    }

    /// Writes a block, and makes sure that it stands there; one that came before does nothing.
    ///
    /// # Errors
    /// It is not the next one, or not within the place; the flash has not kept it.
    pub fn write(&mut self, images: &mut impl Images, offset: u32, bytes: &[u8]) -> Result<(), Exception> {
        let next = self.next.filter(|_| self.result != UpdateResult::Taken).ok_or(Exception::DeviceBusy)?;
        let place = images.running().other();
        let end = offset.checked_add(bytes.len() as u32).ok_or(Exception::IllegalValue)?;
        let range = offset as usize..end as usize;
        if !offset.is_multiple_of(4) || !bytes.len().is_multiple_of(4) || end > place.bytes() {
            return Err(Exception::IllegalValue);
        }
        let stands = |images: &_| Images::read(images, place).get(range.clone()) == Some(bytes);
        if offset != next {
            return if end <= next && stands(images) { Ok(()) } else { Err(Exception::IllegalValue) };
        }
        let mut begin = 0;
        for (sector, sector_end) in place.sectors().into_iter().enumerate() {
            if (offset..end).contains(&begin) {
                empty(images, sector, begin as usize..sector_end as usize)?;
            }
            begin = sector_end;
        }
        images.program(offset, bytes).map_err(|Failure| Exception::DeviceFailure)?;
        if !stands(images) {
            return Err(Exception::DeviceFailure);
        }
        self.next = Some(end);
        Ok(())
    }

    /// Looks at what was written; if it is an image for this board, says that it is to be tried.
    /// `revision`: of the board; `takes_older`: whether its release may be older than that of the
    /// image that runs.
    ///
    /// # Errors
    /// It is not; the result says why.
    pub fn take(
        &mut self,
        images: &mut impl Images,
        revision: u16,
        takes_older: bool,
    ) -> Result<(), Exception> {
        let written = self.next.ok_or(Exception::DeviceBusy)?;
        let looked = images.alone(|images| judge(images, written, revision, takes_older));
        let done = looked.and_then(|()| {
            let entry = Entry::Try(images.running().other());
            images.append(entry).map_err(|Failure| UpdateResult::NotStored)
        });
        self.result = done.err().unwrap_or(UpdateResult::Taken);
        done.map_err(|_| Exception::IllegalValue)
    }
}

impl Default for Update {
    fn default() -> Self {
        Self::new()
    }
}

/// Erases a sector, unless it is blank.
fn empty(images: &mut impl Images, sector: usize, range: core::ops::Range<usize>) -> Result<(), Exception> {
    let place = images.running().other();
    let is_blank = images.read(place).get(range).is_some_and(|bytes| bytes.iter().all(|byte| *byte == 0xFF));
    if is_blank { Ok(()) } else { images.erase(sector).map_err(|Failure| Exception::DeviceFailure) }
}

/// Whether the image that stands in the other place is one for this board.
fn judge(images: &impl Images, written: u32, revision: u16, takes_older: bool) -> Result<(), UpdateResult> {
    let own = Head::of(images.read(images.running())).ok_or(UpdateResult::OtherBoard)?;
    let place = images.running().other();
    let memory = images.read(place);
    let head = Head::of(memory).ok_or(UpdateResult::NotWhole)?;
    let [first, last] = head.linked.revisions;
    if head.linked.kind != own.linked.kind || !(first..=last).contains(&revision) {
        return Err(UpdateResult::OtherBoard);
    }
    let [begin, length] = head.place;
    if begin != place.begin() {
        return Err(UpdateResult::OtherPlace);
    }
    let split = memory.split_at_checked(length as usize);
    let (image, behind) = split.ok_or(UpdateResult::NotWhole)?;
    let signature = behind.first_chunk::<SIGNATURE_BYTES>().ok_or(UpdateResult::NotWhole)?;
    if written as usize != image.len() + SIGNATURE_BYTES || !is_whole(images, &head, place) {
        return Err(UpdateResult::NotWhole);
    }
    if head.linked.release < own.linked.release && !takes_older {
        return Err(UpdateResult::Older);
    }
    if signature::is_signed(image, signature) { Ok(()) } else { Err(UpdateResult::Signature) }
}

/// Whether the checksum of the image in a place fits.
pub fn is_whole(images: &impl Images, head: &Head, place: Place) -> bool {
    let mut is_within = false;
    let sum = images.checksum(|show| {
        is_within = head.for_each(images.read(place), place.begin(), show).is_some();
    });
    is_within && sum == head.checksum
}
