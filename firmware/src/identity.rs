//! Which board it is, and what its firmware was built from.

/// Which board it is; zeros where there is no such thing, as in an emulator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Identity {
    /// The processor's number of 96 bits, of which there are no two.
    pub unique_id: [u16; 6],
    /// Line and revision of the processor, as its register DBGMCU_IDCODE tells.
    pub processor: u32,
    /// Of the board, as its maker has written it.
    pub hardware_revision: u16,
}

/// The sources of the firmware.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Source {
    /// The git commit, two bytes a word, the first in the high half; zeros where it is not known.
    pub commit: [u16; 10],
    /// Whether they differed from it.
    pub is_modified: bool,
}

/// Those of this build, as `cargo xtask firmware` tells by the environment: 40 digits, with a `+`
/// behind them where they differ from the commit.
pub const SOURCE: Source = match option_env!("MGPI_SOURCE") {
    Some(text) => source(text),
    None => Source { commit: [0; 10], is_modified: false },
};

/// Reads 40 hexadecimal digits; any other character counts as 0.
const fn source(text: &str) -> Source {
    let (mut bytes, mut commit, mut place) = (text.as_bytes(), [0; 10], 0);
    while let [digit, rest @ ..] = bytes
        && place < 40
    {
        let value = match digit {
            b'0'..=b'9' => *digit - b'0',
            b'a'..=b'f' => *digit - b'a' + 10,
            _ => 0,
        };
        #[allow(clippy::indexing_slicing, reason = "place is below 40; at compile time only")]
        {
            commit[place / 4] = commit[place / 4] << 4 | value as u16;
        }
        place += 1;
        bytes = rest;
    }
    Source { commit, is_modified: matches!(bytes, [b'+', ..]) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_commit_is_read_with_its_first_digits_in_the_highest_bits() {
        let Source { commit, is_modified } = source("0123456789abcdef0123456789abcdef01234567");
        assert_eq!(commit[..4], [0x0123, 0x4567, 0x89ab, 0xcdef]);
        assert_eq!(commit[8..], [0x0123, 0x4567]);
        assert!(!is_modified);
        assert!(source("0123456789abcdef0123456789abcdef01234567+").is_modified);
    }
}
