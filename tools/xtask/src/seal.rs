//! The checksum of the production image, put into its ELF file: `firmware`'s `image.rs` holds the
//! image against it in each start.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use crc::{CRC_32_ISO_HDLC, Crc};
use object::elf::PT_LOAD;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol};

/// Where the checksum stands.
const CHECK: &str = ".image_check";
/// Where the flash begins and ends, by cortex-m-rt's linker script and memory.x.
const FLASH: [&str; 2] = ["__vector_table", "_flash_end"];
/// Ranges that the image has room for: begin and bytes of each, then the CRC-32 over all of them.
const RANGES: usize = 4;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Puts it in.
///
/// # Errors
/// The file is not the production image, or has more ranges.
pub fn seal(elf: &Path) -> Result<()> {
    let mut bytes = fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))?;
    let (place, words) = sealed(&bytes).with_context(|| format!("{} cannot be sealed", elf.display()))?;
    let check: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes[place..place + check.len()].copy_from_slice(&check);
    Ok(fs::write(elf, bytes)?)
}

/// Where the checksum stands in the file, and its words.
fn sealed(bytes: &[u8]) -> Result<(usize, Vec<u32>)> {
    let file = ElfFile32::<Endianness>::parse(bytes)?;
    let address = |name: &str| -> Result<u32> {
        let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
        Ok(symbol.with_context(|| format!("no symbol {name}"))?.address() as u32)
    };
    let flash = address(FLASH[0])?..address(FLASH[1])?;
    let check = file.section_by_name(CHECK).with_context(|| format!("no section {CHECK}"))?;
    let (place, size) = check.file_range().context("the checksum is not in the file")?;
    ensure!(size as usize == 4 * (2 * RANGES + 1), "{size} bytes for the checksum");
    let endian = file.endian();
    let (mut words, mut digest) = (Vec::new(), CRC.digest());
    // Each section at the place that it is loaded from.
    for header in file.elf_program_headers() {
        let (at, offset, length) = (header.p_paddr(endian), header.p_offset(endian), header.p_filesz(endian));
        if header.p_type(endian) != PT_LOAD || !flash.contains(&at) {
            continue;
        }
        let mut within: Vec<_> = file
            .sections()
            .filter(|section| section.name() != Ok(CHECK))
            .filter_map(|section| section.file_range())
            .filter(|(from, size)| *size > 0 && (offset..offset + length).contains(&(*from as u32)))
            .collect();
        within.sort_unstable();
        for (from, size) in within {
            words.extend([at + (from as u32 - offset), size as u32]);
            digest.update(&bytes[from as usize..(from + size) as usize]);
        }
    }
    ensure!(words.len() <= 2 * RANGES, "{} ranges, there is room for {RANGES}", words.len() / 2);
    while words.len() < 2 * RANGES {
        words.extend([flash.start, 0]);
    }
    words.push(digest.finalize());
    Ok((place as usize, words))
}
