//! Reader of ELF files.

use crate::decode::{self, Instruction};
use object::{
    Object as _, ObjectSection as _, ObjectSymbol as _, SectionFlags, SectionKind, SymbolKind, SymbolSection, elf,
};
use std::collections::BTreeMap;
use std::ops::Range;

/// Address range of static RAM. Code that does not run from flash is in it.
const SRAM: Range<u32> = 0x2000_0000..0x2002_0000;

/// Address range of the memory that is coupled to the core (RM0090, 2.3.1).
const COUPLED: Range<u32> = 0x1000_0000..0x1001_0000;

/// Name of the vector table's section, from the start-up code.
const VECTORS: &str = ".vector_table";

/// Reasons why a program cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file is not a program, or is broken.
    #[error("cannot be read as a program: {0}")]
    Unreadable(#[from] object::Error),
    /// The program is for another processor.
    #[error("a program for {0:?}; expected one for 32-bit Arm")]
    OtherProcessor(object::Architecture),
    /// The program has no code.
    #[error("a program without code; expected a linked one with a text section")]
    NoCode,
    /// No function begins at the given address.
    #[error("no function at {0:#x}")]
    NoFunction(u32),
    /// The program has no vector table, so its start is not known.
    #[error("no vector table: expected a section .vector_table")]
    NoVectors,
    /// There is no free RAM below the top of the stack.
    #[error("no room for a stack below {0:#x}: expected RAM without variables")]
    NoStack(u32),
}

/// A section in the chip's memory.
#[derive(Clone, Debug)]
pub(crate) struct Section {
    name: String,
    pub(crate) address: u32,
    /// Empty for zeroed variables.
    pub(crate) bytes: Vec<u8>,
    pub(crate) executable: bool,
}

impl Section {
    /// The contents as words, as the core reads them.
    pub(crate) fn words(&self) -> impl Iterator<Item = u32> {
        self.bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]))
    }

    pub(crate) fn end(&self) -> u32 {
        self.address.saturating_add(self.bytes.len() as u32)
    }

    pub(crate) fn contains(&self, address: u32) -> bool {
        (self.address..self.end()).contains(&address)
    }
}

/// A symbol's name and size.
pub(crate) type Named = (String, u32);

/// A linked program.
#[derive(Clone, Debug, Default)]
pub struct Program {
    /// Sections; those with code come first, because most queries concern them.
    pub(crate) sections: Vec<Section>,
    /// Addresses that the linker script names: symbols without a section.
    marks_of_linker: BTreeMap<String, u32>,
    /// All symbols, in the file's order.
    symbols: Vec<Named>,
    /// Functions by address.
    pub(crate) functions: BTreeMap<u32, Named>,
    /// Variables and constants with a symbol, by address.
    pub(crate) objects: BTreeMap<u32, Named>,
    /// Addresses at which data (`true`) or instructions begin: the mapping symbols `$d` and `$t`.
    pub(crate) marks: BTreeMap<u32, bool>,
    /// Words of the vector table: top of the stack, start address, handlers. Empty if there is no table.
    pub(crate) vectors: Vec<u32>,
    /// Address of the vector table.
    pub(crate) vectors_at: u32,
    /// Ranges in static RAM, by section: variables, zeroed or not, and code that is copied there.
    variables: Vec<Range<u32>>,
    flash_bytes: u64,
    ram_bytes: u64,
}

impl Program {
    /// Reads a program from the bytes of its ELF file.
    ///
    /// # Errors
    /// The file is not an ELF file for Arm, is broken, or has no code.
    pub fn parse(bytes: &[u8]) -> Result<Self, ImageError> {
        let file = object::File::parse(bytes)?;
        if file.architecture() != object::Architecture::Arm {
            return Err(ImageError::OtherProcessor(file.architecture()));
        }
        let mut program = Self::default();
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
            if sh_flags & u64::from(elf::SHF_ALLOC) != 0 && section.size() > 0 {
                program.section(&section, sh_flags)?;
            }
        }
        if !program.sections.iter().any(|section| section.executable) {
            return Err(ImageError::NoCode);
        }
        program.sections.sort_by_key(|section| !section.executable);
        for symbol in file.symbols() {
            program.symbol(&symbol);
        }
        Ok(program)
    }

    fn section(&mut self, section: &object::Section<'_, '_>, flags: u64) -> Result<(), ImageError> {
        let has = |flag: u32| flags & u64::from(flag) != 0;
        // Addresses of the chip have 32 bits.
        let address = section.address() as u32;
        let (name, bytes) = (section.name()?.to_owned(), section.data()?.to_vec());
        let part = Section { name, address, bytes, executable: has(elf::SHF_EXECINSTR) };
        if part.name == VECTORS {
            (self.vectors, self.vectors_at) = (part.words().collect(), address);
        }
        // Zeroed variables have an address, but no bytes in the file.
        if SRAM.contains(&address) || COUPLED.contains(&address) {
            self.variables.push(address..address.saturating_add(section.size() as u32));
        }
        let zeroed = matches!(section.kind(), SectionKind::UninitializedData);
        // Initial values of variables are in flash, and are copied to RAM.
        self.flash_bytes += if zeroed { 0 } else { section.size() };
        self.ram_bytes += if zeroed || has(elf::SHF_WRITE) { section.size() } else { 0 };
        self.sections.push(part);
        Ok(())
    }

    fn symbol(&mut self, symbol: &object::Symbol<'_, '_>) {
        let Ok(name) = symbol.name() else { return };
        let (address, named) = (symbol.address() as u32, (name.to_owned(), symbol.size() as u32));
        self.symbols.push(named.clone());
        if symbol.section() == SymbolSection::Absolute {
            self.marks_of_linker.insert(name.to_owned(), address);
        }
        match symbol.kind() {
            _ if name.starts_with("$d") => drop(self.marks.insert(address & !1, true)),
            _ if name.starts_with("$t") => drop(self.marks.insert(address & !1, false)),
            SymbolKind::Text if symbol.size() > 0 => drop(self.functions.insert(address & !1, named)),
            SymbolKind::Data if symbol.size() > 0 => drop(self.objects.insert(address, named)),
            _ => {}
        }
    }

    /// Creates a program of these instruction halves, starting at an address.
    #[must_use]
    pub fn from_halves(address: u32, halves: &[u16]) -> Self {
        let bytes = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        let code = Section { name: ".text".to_owned(), address, bytes, executable: true };
        Self { sections: vec![code], ..Self::default() }
    }

    /// Names and sizes of all symbols, in the order of the file.
    pub fn symbols(&self) -> impl Iterator<Item = (&str, u32)> {
        self.symbols.iter().map(|(name, size)| (name.as_str(), *size))
    }

    /// Bytes of the section with this name in the file; `None` if there is no such section.
    #[must_use]
    pub fn section_bytes(&self, name: &str) -> Option<u64> {
        self.sections.iter().find(|section| section.name == name).map(|section| section.bytes.len() as u64)
    }

    /// Bytes of code, constants, and initial values of variables.
    #[must_use]
    pub const fn flash_bytes(&self) -> u64 {
        self.flash_bytes
    }

    /// Bytes of variables, without the stack, and without code that runs from RAM.
    #[must_use]
    pub const fn ram_bytes(&self) -> u64 {
        self.ram_bytes
    }

    /// Start address of an exception's handler: 1 is reset, 16 the first interrupt. `None` if it has no handler.
    #[must_use]
    pub fn handler(&self, exception: usize) -> Option<u32> {
        self.vectors.get(exception).filter(|at| **at != 0).map(|at| at & !1)
    }

    /// Addresses that stand in for the memory that is coupled to the core, from `_coupled_start` to `_coupled_end`. Empty if the program has no such
    /// symbols.
    #[must_use]
    pub fn stand_in_for_coupled(&self) -> Range<u32> {
        let at = |name: &str| self.marks_of_linker.get(name).copied().unwrap_or_default();
        at("_coupled_start")..at("_coupled_end")
    }

    /// Initial stack pointer, from which the stack grows down: the first word of the vector table.
    #[must_use]
    pub fn stack_top(&self) -> Option<u32> {
        self.vectors.first().copied()
    }

    /// RAM free for the stack: from its top down to the nearest variables, or to the beginning of RAM if the variables are above the stack.
    ///
    /// # Errors
    /// The program has no vector table, or there is no free RAM below the top of the stack.
    pub fn stack_room(&self) -> Result<Range<u32>, ImageError> {
        let top = self.stack_top().ok_or(ImageError::NoVectors)?;
        room_below(top, &self.variables).ok_or(ImageError::NoStack(top))
    }

    /// Decodes the instruction at an address; `None` if there is no code, or no valid instruction.
    #[must_use]
    pub fn decode(&self, address: u32) -> Option<Instruction> {
        decode::decode(address, self.half(address)?, self.half(address.wrapping_add(2)))
    }

    /// The instructions in a range, in order; data and invalid instructions are left out.
    pub(crate) fn instructions(&self, range: Range<u32>) -> impl Iterator<Item = Instruction> {
        let mut at = range.start;
        std::iter::from_fn(move || {
            while at < range.end {
                let here = at;
                let first = if self.is_data(here) { None } else { self.half(here) };
                at += first.map_or(2, decode::width);
                if let Some(found) = first.and_then(|_| self.decode(here)) {
                    return Some(found);
                }
            }
            None
        })
    }

    /// True if the linker's mapping symbols mark an address as data, not instructions.
    pub(crate) fn is_data(&self, address: u32) -> bool {
        self.marks.range(..=address).next_back().is_some_and(|(_, data)| *data)
    }

    /// The half word at an address; `None` outside all sections.
    fn half(&self, address: u32) -> Option<u16> {
        self.sections.iter().find_map(|section| {
            let at = address.checked_sub(section.address)? as usize;
            Some(u16::from_le_bytes([*section.bytes.get(at)?, *section.bytes.get(at + 1)?]))
        })
    }

    /// The word at an address; `None` outside all sections.
    pub(crate) fn word(&self, address: u32) -> Option<u32> {
        let [low, high] = [self.half(address)?, self.half(address.wrapping_add(2))?].map(u32::from);
        Some(high << 16 | low)
    }
}

/// Range from the top down to the nearest variables; `None` if these reach the top.
fn room_below(top: u32, variables: &[Range<u32>]) -> Option<Range<u32>> {
    let begin = if top > SRAM.start { SRAM.start } else { COUPLED.start };
    let below = variables.iter().filter(|range| range.start < top).map(|range| range.end);
    let bottom = below.fold(begin, u32::max);
    (bottom < top).then_some(bottom..top)
}

#[cfg(test)]
mod tests {
    use super::room_below;

    #[test]
    fn the_stack_has_what_is_free_below_it_wherever_the_variables_lie() {
        let below = [0x2000_0000..0x2000_0400, 0x2000_0400..0x2000_0500];
        assert_eq!(room_below(0x2002_0000, &below), Some(0x2000_0500..0x2002_0000));
        let above = [0x2000_4000..0x2000_4418, 0x2000_4418..0x2000_8000];
        assert_eq!(room_below(0x2000_4000, &above), Some(0x2000_0000..0x2000_4000));
        assert_eq!(room_below(0x2000_0450, &below), None, "variables reach beyond the top");
        let coupled = [0x1000_4000..0x1000_5000, 0x2000_0000..0x2000_0400];
        assert_eq!(room_below(0x1000_4000, &coupled), Some(0x1000_0000..0x1000_4000));
    }
}
