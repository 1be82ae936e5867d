//! What the ELF file of an image tells without being run: where its functions and handlers are, how
//! large it is, and whether it can panic.

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use object::elf::{SHF_ALLOC, SHT_NOBITS};
use object::read::elf::{ElfFile32, SectionHeader};
use object::{LittleEndian, Object, ObjectSection, ObjectSymbol, SymbolKind};

/// Where the board's RAM begins; below is flash.
const RAM: u64 = 0x2000_0000;

/// The bit of a function's address that says Thumb, which every function here is.
const THUMB: u64 = 1;

/// Parts of the names of functions that end a program. All of them lead to the panic handler, the
/// second; the others tell more: panics as such, and failed indices, slices, unwraps and
/// expectations.
const PANICS: [&str; 3] = ["panic", "rust_begin_unwind", "_fail"];

/// A function of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Function {
    /// As in the source, with its path.
    pub name: String,
    /// Where its first instruction stands.
    pub address: u64,
    /// How many instructions it has, constants behind the last one counted with them.
    pub instructions: usize,
    /// Its length; 0 where the ELF file does not say. Unit: byte.
    pub bytes: u64,
}

/// An image.
#[derive(Debug)]
pub struct Image {
    /// Its ELF file.
    pub path: PathBuf,
    /// All its functions.
    pub functions: Vec<Function>,
    /// Where its handlers of exceptions begin.
    pub handlers: Vec<u64>,
    /// Where constants stand between its instructions.
    pub constants: Vec<Range<u64>>,
    /// What it occupies of the flash. Unit: byte.
    pub flash: u64,
    /// What its variables occupy of the RAM, without the stack. Unit: byte.
    pub ram: u64,
}

impl Image {
    /// Reads an ELF file.
    ///
    /// # Errors
    /// It cannot be read, or is no image for the board.
    pub fn read(path: &Path) -> Result<Self> {
        let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        Self::parse(path, &bytes).with_context(|| format!("{} is no image for the board", path.display()))
    }

    fn parse(path: &Path, bytes: &[u8]) -> Result<Self> {
        let elf = ElfFile32::<LittleEndian>::parse(bytes)?;
        let vectors = elf.section_by_name(".vector_table").context("it has no vector table")?;
        let (mut flash, mut ram) = (0, 0);
        for section in elf.sections() {
            let header = section.elf_section_header();
            if header.sh_flags(LittleEndian) & SHF_ALLOC == 0 {
                continue;
            }
            // Initial values of variables are in both. What stands before the vectors, the starter,
            // is no part of the image.
            if header.sh_type(LittleEndian) != SHT_NOBITS && section.address() >= vectors.address() {
                flash += section.size();
            }
            if section.address() >= RAM {
                ram += section.size();
            }
        }
        Ok(Self {
            path: path.to_owned(),
            functions: elf
                .symbols()
                .filter(|symbol| symbol.kind() == SymbolKind::Text)
                .map(|symbol| function(&elf, &symbol))
                .collect(),
            handlers: handlers(vectors.data()?),
            constants: constants(
                elf.symbols().filter_map(|symbol| Some((symbol.address(), symbol.name().ok()?))).collect(),
            ),
            flash,
            ram,
        })
    }

    /// A function by its full name.
    ///
    /// # Errors
    /// There is none, or there are more than one.
    pub fn function(&self, name: &str) -> Result<&Function> {
        let mut found = self.functions.iter().filter(|function| function.name == name);
        match (found.next(), found.next()) {
            (Some(function), None) => Ok(function),
            (None, _) => bail!("{} has no function {name}", self.path.display()),
            (Some(_), Some(_)) => bail!("{} has more than one function {name}", self.path.display()),
        }
    }

    /// The names of its functions that end the program, in order. None: the image cannot panic,
    /// since the linker leaves out what nothing refers to.
    pub fn panics(&self) -> Vec<&str> {
        let names = self.functions.iter().map(|function| function.name.as_str());
        let mut panics: Vec<_> = names.filter(|name| is_panic(name)).collect();
        panics.sort_unstable();
        panics
    }
}

/// Whether a function of this name ends the program.
pub fn is_panic(name: &str) -> bool {
    PANICS.iter().any(|part| name.contains(part))
}

fn function<'data>(elf: &ElfFile32<'data, LittleEndian>, symbol: &impl ObjectSymbol<'data>) -> Function {
    let name = symbol.name_bytes().map(String::from_utf8_lossy).unwrap_or_default();
    // The alternate form leaves out the hash that tells copies apart.
    Function {
        name: format!("{:#}", rustc_demangle::demangle(&name)),
        address: symbol.address() & !THUMB,
        instructions: instructions(code(elf, symbol).unwrap_or_default()),
        bytes: symbol.size(),
    }
}

/// What an ELF file holds of a function.
fn code<'data>(
    elf: &ElfFile32<'data, LittleEndian>,
    symbol: &impl ObjectSymbol<'data>,
) -> Option<&'data [u8]> {
    let section = elf.section_by_index(symbol.section_index()?).ok()?;
    section.data_range(symbol.address() & !THUMB, symbol.size()).ok()?
}

/// From each mark of constants (`$d`) to the next mark of instructions (`$t`).
fn constants(mut symbols: Vec<(u64, &str)>) -> Vec<Range<u64>> {
    let is = |name: &str, mark| name == mark || name.starts_with(&format!("{mark}."));
    symbols.retain(|(_, name)| is(name, "$d") || is(name, "$t"));
    symbols.sort_unstable();
    let end = |next: Option<&(u64, &str)>| next.map_or(u64::MAX, |(address, _)| *address);
    let marks = symbols.iter().enumerate().filter(|(_, (_, name))| is(name, "$d"));
    marks.map(|(place, (start, _))| *start..end(symbols.get(place + 1))).collect()
}

/// The number of Thumb instructions: one or two halfwords each, as the first one says.
fn instructions(code: &[u8]) -> usize {
    let mut halfwords = code.chunks_exact(2);
    let mut count = 0;
    while let Some(first) = halfwords.next() {
        if first[1] >= 0xE8 {
            halfwords.next();
        }
        count += 1;
    }
    count
}

/// The addresses in a vector table but for its first two words: the stack's beginning, and where a
/// reset goes.
fn handlers(table: &[u8]) -> Vec<u64> {
    let words =
        table.chunks_exact(4).map(|word| u64::from(u32::from_le_bytes([word[0], word[1], word[2], word[3]])));
    let mut handlers: Vec<_> = words.skip(2).filter(|&word| word != 0).map(|word| word & !THUMB).collect();
    handlers.sort_unstable();
    handlers.dedup();
    handlers
}

#[cfg(test)]
mod tests {
    use super::{Function, Image, constants, handlers, instructions};

    fn panics(names: &[&str]) -> Vec<String> {
        let function =
            |name: &&str| Function { name: (*name).to_owned(), address: 0, instructions: 0, bytes: 0 };
        let image = Image {
            path: "image".into(),
            functions: names.iter().map(function).collect(),
            handlers: Vec::new(),
            constants: Vec::new(),
            flash: 0,
            ram: 0,
        };
        image.panics().into_iter().map(str::to_owned).collect()
    }

    #[test]
    fn instructions_of_one_and_of_two_halfwords_are_told_apart() {
        // push {r7, lr}; mov.w r0, #-1; pop {r7, pc}.
        assert_eq!(instructions(&[0x80, 0xB5, 0x4F, 0xF0, 0xFF, 0x30, 0x80, 0xBD]), 3);
    }

    #[test]
    fn constants_last_from_their_mark_to_that_of_instructions() {
        let symbols = vec![(0x20, "$t.1"), (0x10, "$d"), (0x10, "main"), (0x0, "$t"), (0x30, "$d.2")];
        assert_eq!(constants(symbols), [0x10..0x20, 0x30..u64::MAX]);
    }

    #[test]
    fn every_kind_of_panic_is_known_by_its_name() {
        let names = [
            "__rustc::rust_begin_unwind",
            "core::option::expect_failed",
            "core::option::unwrap_failed",
            "core::panicking::panic_bounds_check",
            "core::panicking::panic_const::panic_const_div_by_zero",
            "core::result::unwrap_failed",
            "core::slice::copy_from_slice_impl::len_mismatch_fail",
            "core::slice::index::slice_end_index_len_fail",
            "law_and_tick::panicked",
        ];
        assert_eq!(panics(&names), names);
    }

    #[test]
    fn other_functions_are_no_panics() {
        assert!(
            panics(&["main", "HardFault_", "firmware::law::controller_act", "libm::math::tanhf::tanhf"])
                .is_empty()
        );
    }

    #[test]
    fn a_vector_table_has_each_handler_once_without_stack_reset_and_gaps() {
        let table = [0x2000_C000_u32, 0x0800_C189, 0x0800_0205, 0, 0x0800_0301, 0x0800_0205];
        let bytes: Vec<u8> = table.iter().flat_map(|word| word.to_le_bytes()).collect();
        assert_eq!(handlers(&bytes), [0x0800_0204, 0x0800_0300]);
    }
}
