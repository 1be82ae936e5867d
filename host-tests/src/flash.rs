//! A NOR flash of two sectors in memory, which can lose its power at any byte, wear out, and count
//! what is done to it.
//!
//! # The loss of power
//! Programming a byte and erasing a byte each take one unit of work; the power goes after a given
//! number of them. What is being done at that moment is left undone in one of the ways of [`Tear`];
//! from then on every access fails, until [`MockFlash::power_up`].
//!
//! Programming clears bits and never sets any, as in the STM32F405; whether a word is blank is not
//! asked.

use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash, check_erase, check_read, check_write,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What an interrupted operation leaves behind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tear {
    /// Some bits of the byte being programmed; a sector erased from its beginning up to some bits
    /// of a byte.
    Rising,
    /// Some bits of the byte being programmed; a sector erased from its end down to some bits of a
    /// byte.
    Falling,
    /// Some bits of the word being programmed; a sector of which each bit is erased or not, the
    /// likelier the later.
    Scattered,
    /// A word of any bits; a sector that is first programmed to zeros from its beginning, then
    /// erased likewise.
    Undefined,
}

impl Tear {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Rising, Self::Falling, Self::Scattered, Self::Undefined];
}

/// Bytes of a word.
const WORD: usize = 4;

/// Two sectors of `SECTOR` bytes.
#[derive(Clone, Debug)]
pub struct MockFlash<const SECTOR: usize> {
    bytes: Vec<u8>,
    /// Units of work until the power goes; `None`: it stays.
    left: Option<usize>,
    has_power: bool,
    tear: Tear,
    random: ChaCha8Rng,
    /// Units of work that were done.
    work: usize,
    /// A byte of which the programmed bits stay set.
    stuck: Option<usize>,
}

impl<const SECTOR: usize> MockFlash<SECTOR> {
    /// A blank flash with power.
    pub fn blank() -> Self {
        Self::with(&[])
    }

    /// A flash that begins with these bytes and is blank behind them.
    pub fn with(bytes: &[u8]) -> Self {
        let mut contents = vec![0xFF; 2 * SECTOR];
        contents[..bytes.len()].copy_from_slice(bytes);
        Self {
            bytes: contents,
            left: None,
            has_power: true,
            tear: Tear::Rising,
            random: ChaCha8Rng::seed_from_u64(0),
            work: 0,
            stuck: None,
        }
    }

    /// Lets the power go after so many units of work.
    pub fn cut_after(&mut self, units: usize, tear: Tear, seed: u64) {
        self.left = Some(units);
        self.tear = tear;
        self.random = ChaCha8Rng::seed_from_u64(seed);
    }

    /// Power that stays, from now on.
    pub fn power_up(&mut self) {
        self.left = None;
        self.has_power = true;
    }

    /// Wears a byte out: no bit of it can be programmed any more.
    pub fn wear_out(&mut self, address: usize) {
        self.stuck = Some(address);
    }

    /// Units of work since the flash was made.
    pub fn work(&self) -> usize {
        self.work
    }

    /// The contents.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Takes units of work from what is left.
    ///
    /// # Errors
    /// The power goes after the given number of them, which is less.
    fn spend(&mut self, units: usize) -> Result<(), usize> {
        let possible = self.left.map_or(units, |left| left.min(units));
        self.work += possible;
        self.left = self.left.map(|left| left - possible);
        self.has_power = possible == units;
        if self.has_power { Ok(()) } else { Err(possible) }
    }

    fn check_power(&self) -> Result<(), NorFlashErrorKind> {
        if self.has_power { Ok(()) } else { Err(NorFlashErrorKind::Other) }
    }

    fn program(&mut self, address: usize, bytes: impl IntoIterator<Item = u8>) {
        for (address, byte) in (address..).zip(bytes) {
            if self.stuck != Some(address) {
                self.bytes[address] &= byte;
            }
        }
    }

    fn tear_word(&mut self, address: usize, bytes: &[u8], done: usize) {
        let word = done / WORD * WORD;
        let (whole, torn) = match self.tear {
            Tear::Rising | Tear::Falling => (done, done..done + 1),
            Tear::Scattered | Tear::Undefined => (word, word..word + WORD),
        };
        self.program(address, bytes[..whole].iter().copied());
        if self.tear == Tear::Undefined {
            self.random.fill(&mut self.bytes[address + torn.start..address + torn.end]);
        } else {
            let spared: [u8; WORD] = self.random.random();
            self.program(address + whole, bytes[torn].iter().zip(spared).map(|(byte, spared)| byte | spared));
        }
    }

    fn tear_sector(&mut self, sector: usize, done: usize) {
        let some: u8 = self.random.random();
        let contents = &mut self.bytes[sector..sector + SECTOR];
        match self.tear {
            Tear::Rising => {
                contents[..done].fill(0xFF);
                contents[done] |= some;
            }
            Tear::Falling => {
                contents[SECTOR - done..].fill(0xFF);
                contents[SECTOR - done - 1] |= some;
            }
            Tear::Scattered => {
                let share = done as f64 / SECTOR as f64;
                for byte in contents {
                    let erased =
                        (0..8).fold(0, |bits, bit| bits | u8::from(self.random.random_bool(share)) << bit);
                    *byte |= erased;
                }
            }
            Tear::Undefined if done < SECTOR / 2 => contents[..2 * done].fill(0),
            Tear::Undefined => {
                let (erased, programmed) = contents.split_at_mut(2 * done - SECTOR);
                erased.fill(0xFF);
                programmed.fill(0);
            }
        }
    }
}

impl<const SECTOR: usize> ErrorType for MockFlash<SECTOR> {
    type Error = NorFlashErrorKind;
}

impl<const SECTOR: usize> ReadNorFlash for MockFlash<SECTOR> {
    const READ_SIZE: usize = WORD;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        self.check_power()?;
        check_read(self, offset, bytes.len())?;
        bytes.copy_from_slice(&self.bytes[offset as usize..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl<const SECTOR: usize> NorFlash for MockFlash<SECTOR> {
    const WRITE_SIZE: usize = WORD;
    const ERASE_SIZE: usize = SECTOR;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        check_erase(self, from, to)?;
        for sector in (from as usize..to as usize).step_by(SECTOR) {
            self.check_power()?;
            match self.spend(SECTOR) {
                Ok(()) => self.bytes[sector..sector + SECTOR].fill(0xFF),
                Err(done) => {
                    self.tear_sector(sector, done);
                    return Err(NorFlashErrorKind::Other);
                }
            }
        }
        Ok(())
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        self.check_power()?;
        check_write(self, offset, bytes.len())?;
        let address = offset as usize;
        match self.spend(bytes.len()) {
            Ok(()) => {
                self.program(address, bytes.iter().copied());
                Ok(())
            }
            Err(done) => {
                self.tear_word(address, bytes, done);
                Err(NorFlashErrorKind::Other)
            }
        }
    }
}
