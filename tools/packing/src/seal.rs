//! What the production image is linked without, put into its ELF file: length, checked ranges and
//! checksum (`wire::image`), which the image looks at in each start; and the starter, so that one
//! file holds all that a debugger flashes.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use crc::{CRC_32_ISO_HDLC, Crc};
use object::elf::PT_LOAD;
use object::read::elf::{ElfFile32, ProgramHeader};
use object::{Endianness, Object, ObjectSection, ObjectSymbol};
use wire::image::{HEAD_OFFSET, HEAD_WORDS, Head, LINKED_WORDS, RANGES};

/// Where the head stands, and the room for the starter.
const HEAD: &str = ".image_head";
const STARTER: &str = ".starter";
/// Where the place of the image begins and ends, by cortex-m-rt's linker script and memory.x.
const PLACE: [&str; 2] = ["__vector_table", "_flash_end"];
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

type Elf<'data> = ElfFile32<'data, Endianness>;

/// A part of an image: its address, and where it stands in the file.
struct Part {
    address: u32,
    file: std::ops::Range<usize>,
}

/// Puts it in. The starter stands beside the image, in the file `starter`.
///
/// # Errors
/// The file is not the production image, has more ranges, or no starter is beside it.
pub fn seal(elf: &Path) -> Result<()> {
    let mut bytes = read(elf)?;
    if let Some(room) = room(&bytes)? {
        let starter = starter(&elf.with_file_name("starter"))?;
        ensure!(starter.len() <= room.len(), "the starter takes {} bytes of {}", starter.len(), room.len());
        bytes[room.start..room.start + starter.len()].copy_from_slice(&starter);
    }
    let (place, words) = sealed(&bytes).with_context(|| format!("{} cannot be sealed", elf.display()))?;
    let put_in: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    bytes[place..place + put_in.len()].copy_from_slice(&put_in);
    // The linker's file may be another name's too: a new one takes its place.
    let beside = elf.with_extension("sealed");
    fs::write(&beside, bytes)?;
    fs::set_permissions(&beside, fs::metadata(elf)?.permissions())?;
    Ok(fs::rename(beside, elf)?)
}

/// The image in a file as it stands in the flash, and the address that it begins with; what lies
/// between its parts is blank.
///
/// # Errors
/// The file is not an image.
pub fn flat(elf: &Path) -> Result<(u32, Vec<u8>)> {
    let bytes = read(elf)?;
    flattened(&bytes).with_context(|| format!("{} is no image", elf.display()))
}

fn flattened(bytes: &[u8]) -> Result<(u32, Vec<u8>)> {
    let file = Elf::parse(bytes)?;
    let begin = place(&file)?.start;
    let mut image = Vec::new();
    for Part { address, file } in parts(&file)? {
        let from = (address - begin) as usize;
        image.resize(image.len().max(from + file.len()), 0xFF);
        image[from..from + file.len()].copy_from_slice(&bytes[file]);
    }
    image.resize(image.len().next_multiple_of(4), 0xFF);
    Ok((begin, image))
}

fn read(elf: &Path) -> Result<Vec<u8>> {
    fs::read(elf).with_context(|| format!("cannot read {}", elf.display()))
}

/// Where there is room for the starter in an image's file.
fn room(bytes: &[u8]) -> Result<Option<std::ops::Range<usize>>> {
    let file = Elf::parse(bytes)?;
    let section = file.section_by_name(STARTER).and_then(|section| section.file_range());
    Ok(section.map(|(from, size)| from as usize..(from + size) as usize))
}

/// The starter as it stands in the flash.
fn starter(elf: &Path) -> Result<Vec<u8>> {
    let (begin, bytes) = flat(elf)?;
    ensure!(begin == 0x0800_0000, "{} begins at {begin:#010x}", elf.display());
    Ok(bytes)
}

/// Addresses of the place that the image is linked for.
fn place(file: &Elf<'_>) -> Result<std::ops::Range<u32>> {
    let address = |name: &str| -> Result<u32> {
        let symbol = file.symbols().find(|symbol| symbol.name() == Ok(name));
        Ok(symbol.with_context(|| format!("no symbol {name}"))?.address() as u32)
    };
    Ok(address(PLACE[0])?..address(PLACE[1])?)
}

/// Each section that is loaded into the place, at the address that it is loaded from.
fn parts(file: &Elf<'_>) -> Result<Vec<Part>> {
    let (place, endian) = (place(file)?, file.endian());
    let mut parts = Vec::new();
    for header in file.elf_program_headers() {
        let (at, offset, length) = (header.p_paddr(endian), header.p_offset(endian), header.p_filesz(endian));
        if header.p_type(endian) != PT_LOAD || !place.contains(&at) {
            continue;
        }
        parts.extend(
            file.sections()
                .filter_map(|section| section.file_range())
                .filter(|(from, size)| *size > 0 && (offset..offset + length).contains(&(*from as u32)))
                .map(|(from, size)| Part {
                    address: at + (from as u32 - offset),
                    file: from as usize..(from + size) as usize,
                }),
        );
    }
    parts.sort_unstable_by_key(|part| part.address);
    Ok(parts)
}

/// Where the words that are put in stand in the file, and those.
fn sealed(bytes: &[u8]) -> Result<(usize, Vec<u32>)> {
    let file = Elf::parse(bytes)?;
    let head = file.section_by_name(HEAD).with_context(|| format!("no section {HEAD}"))?;
    let (at, size) = head.file_range().context("the head is not in the file")?;
    ensure!(size as usize == 4 * HEAD_WORDS, "{size} bytes for the head");
    let (begin, image) = flattened(bytes)?;
    let mut found = parts(&file)?;
    found.retain(|part| part.file.start != at as usize);
    ensure!(found.len() <= RANGES, "{} ranges, there is room for {RANGES}", found.len());
    let mut ranges = [[begin, 0]; RANGES];
    for (range, part) in ranges.iter_mut().zip(&found) {
        *range = [part.address, part.file.len() as u32];
    }
    let words = Head::sealed([begin, image.len() as u32], ranges);
    let mut memory = image;
    put(&mut memory, LINKED_WORDS, &words);
    let sum = checksum(&memory, begin)?;
    Ok((at as usize + 4 * LINKED_WORDS, [&words[..], &[sum]].concat()))
}

/// The checksum of an image by the ranges in its head.
///
/// # Errors
/// It has no head, or a range beyond its end.
pub fn checksum(image: &[u8], begin: u32) -> Result<u32> {
    let Some(head) = Head::of(image) else { bail!("the image has no head") };
    let mut digest = CRC.digest();
    let shown = head.for_each(image, begin, |bytes| digest.update(bytes));
    shown.context("a range is not within the image")?;
    Ok(digest.finalize())
}

/// Puts words into the head of an image, from the one of this number on.
pub fn put(image: &mut [u8], first: usize, words: &[u32]) {
    for (index, word) in words.iter().enumerate() {
        let at = HEAD_OFFSET + 4 * (first + index);
        image[at..at + 4].copy_from_slice(&word.to_le_bytes());
    }
}
