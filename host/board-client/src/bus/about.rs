//! Which board it is, and what its firmware was built from.

use serde_json::{Value, json};
use wire::registers::Id;

use super::board::Board;
use super::client::BusError;

/// What a board says of itself for good.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct About {
    /// The processor's number of 96 bits, of which there are no two, in hexadecimal digits; empty
    /// in the emulator.
    pub unique_id: String,
    /// Line and revision of the processor: its register DBGMCU_IDCODE; 0 in the emulator.
    pub processor: u32,
    /// Of the board; 0 where its maker has written none.
    pub hardware_revision: u16,
    /// The git commit of the firmware's sources, with a `+` where they differed from it; empty
    /// where that was not known.
    pub source: String,
}

impl About {
    /// Asks the board; `None` of one whose firmware is older than these registers.
    ///
    /// # Errors
    /// No answer.
    pub fn read(board: &mut Board) -> Result<Option<Self>, BusError> {
        let block = match board.read(Id::UniqueId, Id::SourceModified) {
            Err(error) if error.exception().is_some() => return Ok(None),
            block => block?,
        };
        let digits = |id: Id| {
            let words = block.words(id).iter().take(id.register().length.into());
            let text: String = words.map(|word| format!("{word:04x}")).collect();
            if text.bytes().all(|digit| digit == b'0') { String::new() } else { text }
        };
        let mut source = digits(Id::SourceCommit);
        if block.whole(Id::SourceModified) == 1 {
            source.push('+');
        }
        Ok(Some(Self {
            unique_id: digits(Id::UniqueId),
            processor: block.whole(Id::Processor),
            hardware_revision: block.whole(Id::HardwareRevision) as u16,
            source,
        }))
    }

    /// For people: two lines.
    pub fn in_words(&self) -> [String; 2] {
        let Self { unique_id, processor, hardware_revision, source } = self;
        let said = |text: &str| if text.is_empty() { "not known".to_owned() } else { text.to_owned() };
        let processor = match processor {
            0 => "emulated".to_owned(),
            code => format!("{:#05x} revision {:#06x}", code & 0xFFF, code >> 16),
        };
        [
            format!(
                "hardware    number {}, revision {hardware_revision}, processor {processor}",
                said(unique_id)
            ),
            format!("sources     {}", said(source)),
        ]
    }

    /// For programs.
    pub fn to_json(&self) -> Value {
        let Self { unique_id, processor, hardware_revision, source } = self;
        json!({
            "unique_id": unique_id, "processor": processor, "hardware_revision": hardware_revision, "source": source,
        })
    }
}
