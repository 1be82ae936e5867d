//! Two places for images and their log in memory, and a starter that does as the board's: for the
//! host's side of an update. The board's own is tested in the model of its chip.

use firmware::update::log::{Entry, Log};
use firmware::update::{Failure, Images};
use wire::image::{HEAD_OFFSET, Linked, Place};

/// The images of a board.
#[derive(Debug)]
pub struct RamImages {
    places: [Vec<u8>; 2],
    log: Vec<u32>,
    running: Place,
    /// Whether the board is to restart.
    pub restarts: bool,
}

impl RamImages {
    /// An image with this head runs in A, nothing stands in B.
    pub fn new(linked: &Linked) -> Self {
        let mut places = Place::BOTH.map(|place| vec![0xFF; place.bytes() as usize]);
        for (index, word) in linked.words().iter().enumerate() {
            places[0][HEAD_OFFSET + 4 * index..][..4].copy_from_slice(&word.to_le_bytes());
        }
        Self { places, log: vec![!0; 64], running: Place::A, restarts: false }
    }

    /// What the starter does.
    pub fn start(&mut self) {
        let log = Log::of(&self.log);
        self.restarts = false;
        self.running = log.to_try().unwrap_or(log.for_good);
        if log.to_try().is_some() {
            self.log[log.used] = Entry::Tried.word();
        }
    }

    fn other(&mut self) -> &mut Vec<u8> {
        &mut self.places[usize::from(self.running == Place::A)]
    }
}

impl Images for RamImages {
    fn running(&self) -> Place {
        self.running
    }

    fn read(&self, place: Place) -> &[u8] {
        &self.places[usize::from(place == Place::B)]
    }

    fn log(&self) -> &[u32] {
        &self.log
    }

    fn erase(&mut self, sector: usize) -> Result<(), Failure> {
        let ends = self.running.other().sectors();
        let begin = sector.checked_sub(1).map_or(0, |before| ends[before]);
        self.other()[begin as usize..ends[sector] as usize].fill(0xFF);
        Ok(())
    }

    fn program(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Failure> {
        let cells = &mut self.other()[offset as usize..][..bytes.len()];
        cells.iter_mut().zip(bytes).for_each(|(cell, byte)| *cell &= byte);
        Ok(())
    }

    fn program_log(&mut self, index: usize, word: u32) -> Result<(), Failure> {
        self.log[index] &= word;
        Ok(())
    }

    fn checksum(&self, show: impl FnOnce(&mut dyn FnMut(&[u8]))) -> u32 {
        let crc = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
        let mut digest = crc.digest();
        show(&mut |bytes| digest.update(bytes));
        digest.finalize()
    }

    fn alone<R>(&self, work: impl FnOnce(&Self) -> R) -> R {
        work(self)
    }

    fn restart(&mut self) {
        self.restarts = true;
    }
}
