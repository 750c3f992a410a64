//! What is in a linked program for the chip: functions and their bytes, what a function reaches, what it keeps on the stack.
//!
//! Read from the symbols and the Thumb instructions of an ELF file; nothing is run.
//!
//! | item | what |
//! |---|---|
//! | [`Program::function`] | bytes of one function, and its traffic to the stack for want of registers |
//! | [`Program::reached_from`] | the function, everything that it calls, and the tables that they refer to |
//! | [`Program::stack`] | how deep its stack can become |
#![forbid(unsafe_code)]

pub mod cycles;
mod instructions;
mod stack;

pub use stack::{Depth, EXCEPTION_FRAME, Stack};

use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionFlags, SymbolKind, elf};
use std::collections::BTreeMap;
use std::ops::Range;

/// Static RAM of the chip, where a kernel lies that does not run from flash.
pub const SRAM: Range<u64> = 0x2000_0000..0x2002_0000;

/// The section that holds the vector table, as the start-up code names it.
const VECTORS: &str = ".vector_table";

/// Why a program cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// Not the file of a program, or a broken one.
    #[error("cannot be read as a program: {0}")]
    Unreadable(#[from] object::Error),
    /// There is no function where one is asked for.
    #[error("no function at {0:#x}")]
    NoFunction(u64),
    /// Nothing says where the program starts.
    #[error("no vector table: expected a section .vector_table")]
    NoVectors,
    /// Nothing is free below where the stack begins.
    #[error("no room for a stack below {0:#x}: expected RAM without variables")]
    NoStack(u64),
}

/// What a function is on the chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Code {
    /// With the numbers that stand behind it.
    pub bytes: u64,
    /// Single registers stored on the stack.
    pub stores: usize,
    /// Single registers loaded from the stack.
    pub loads: usize,
}

/// A function, or a table of constants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its symbol; empty for a table without one.
    pub name: String,
    /// Where it begins.
    pub address: u64,
    /// How long it is.
    pub bytes: u64,
}

/// What a function reaches, itself included: each part once, by address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reached {
    /// Functions.
    pub functions: Vec<Part>,
    /// Constants that the functions refer to by their address, apart from those that stand behind a function and count as its own.
    pub tables: Vec<Part>,
    /// Calls through a register, whose goal is known only where its address stands in the calling function.
    pub indirect: usize,
}

impl Reached {
    /// Bytes of all parts. What lies in RAM lies in flash too, which it is copied from.
    #[must_use]
    pub fn flash_bytes(&self) -> u64 {
        self.functions.iter().chain(&self.tables).map(|part| part.bytes).sum()
    }

    /// Where the functions lie: the code that is executed between the first instruction and the return.
    #[must_use]
    pub fn ranges(&self) -> Vec<Range<u32>> {
        // The chip's addresses have 32 bits.
        self.functions.iter().map(|part| part.address as u32..(part.address + part.bytes) as u32).collect()
    }

    /// Bytes of the functions that run from static RAM.
    #[must_use]
    pub fn sram_bytes(&self) -> u64 {
        self.functions.iter().filter(|part| SRAM.contains(&part.address)).map(|part| part.bytes).sum()
    }
}

/// A section that lies in the chip's memory.
struct Memory<'a> {
    address: u64,
    bytes: &'a [u8],
    executable: bool,
}

impl Memory<'_> {
    /// Whole words, as the core reads them.
    fn words(&self) -> impl Iterator<Item = u64> {
        self.bytes.chunks_exact(4).map(|b| u64::from(u32::from_le_bytes([b[0], b[1], b[2], b[3]])))
    }

    fn contains(&self, address: u64) -> bool {
        (self.address..self.address + self.bytes.len() as u64).contains(&address)
    }
}

/// A linked program.
pub struct Program<'a> {
    memory: Vec<Memory<'a>>,
    /// Functions by address: name and size.
    functions: BTreeMap<u64, (String, u64)>,
    /// Variables and constants with a symbol.
    objects: BTreeMap<u64, (String, u64)>,
    /// Where data begins, `true`, and where code does: the mapping symbols `$d` and `$t`.
    marks: BTreeMap<u64, bool>,
    /// Words of the vector table: the stack's top, the start, the handlers; none where there is no such table.
    vectors: Vec<u64>,
    /// Where the vector table lies.
    vectors_at: u64,
    /// What lies in static RAM by section: variables, zeroed or not, and code that is copied there.
    variables: Vec<Range<u64>>,
}

impl<'a> Program<'a> {
    /// A program from the bytes of its ELF file.
    ///
    /// # Errors
    /// Not an ELF file, or a broken one.
    pub fn parse(bytes: &'a [u8]) -> Result<Self, ImageError> {
        let file = object::File::parse(bytes)?;
        let mut memory = Vec::new();
        let (mut vectors, mut vectors_at, mut variables) = (Vec::new(), 0, Vec::new());
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags } = section.flags() else { continue };
            let has = |flag: u32| sh_flags & u64::from(flag) != 0;
            if has(elf::SHF_ALLOC) && section.size() > 0 {
                let executable = has(elf::SHF_EXECINSTR);
                let part = Memory { address: section.address(), bytes: section.data()?, executable };
                if section.name()? == VECTORS {
                    (vectors, vectors_at) = (part.words().collect(), part.address);
                }
                memory.push(part);
                // Zeroed variables have no bytes in the file, and an address all the same.
                if SRAM.contains(&section.address()) {
                    variables.push(section.address()..section.address() + section.size());
                }
            }
        }
        let (functions, objects, marks) = (BTreeMap::new(), BTreeMap::new(), BTreeMap::new());
        let mut program = Self { memory, functions, objects, marks, vectors, vectors_at, variables };
        for symbol in file.symbols() {
            let Ok(name) = symbol.name() else { continue };
            let (address, value) = (symbol.address() & !1, (name.to_owned(), symbol.size()));
            match symbol.kind() {
                _ if name.starts_with("$d") => drop(program.marks.insert(address, true)),
                _ if name.starts_with("$t") => drop(program.marks.insert(address, false)),
                SymbolKind::Text if symbol.size() > 0 => drop(program.functions.insert(address, value)),
                SymbolKind::Data if symbol.size() > 0 => drop(program.objects.insert(symbol.address(), value)),
                _ => {}
            }
        }
        Ok(program)
    }

    /// Where the function of this name begins, if there is one.
    #[must_use]
    pub fn address_of(&self, name: &str) -> Option<u64> {
        self.functions.iter().find(|(_, (known, _))| known == name).map(|(address, _)| *address)
    }

    /// Where the function that serves an exception begins: 1 is reset, 16 the first interrupt. None where nothing does.
    #[must_use]
    pub fn handler(&self, exception: usize) -> Option<u64> {
        self.vectors.get(exception).filter(|at| **at != 0).map(|at| at & !1)
    }

    /// RAM that the stack may fill, from where it begins down to what lies below it: variables, or the beginning of RAM where the
    /// variables lie above the stack.
    ///
    /// # Errors
    /// No vector table, whose first word says where the stack begins; or no room below that.
    pub fn stack_room(&self) -> Result<Range<u64>, ImageError> {
        let top = *self.vectors.first().ok_or(ImageError::NoVectors)?;
        room_below(top, &self.variables).ok_or(ImageError::NoStack(top))
    }

    /// The function at an address; its lowest bit, which says Thumb, is ignored.
    ///
    /// # Errors
    /// No function begins there.
    pub fn function(&self, address: u64) -> Result<Code, ImageError> {
        let start = address & !1;
        let bytes = self.code(start)?;
        let (stores, loads) = instructions::stack_traffic(bytes, |offset| self.is_data(start + offset, start));
        Ok(Code { bytes: bytes.len() as u64, stores, loads })
    }

    /// The function at an address, and everything that it reaches.
    ///
    /// Followed are calls and jumps out of a function, and addresses that a function holds as numbers: of functions (the linker's steps
    /// from flash to RAM) and of constants. A table without a symbol ends where the next thing begins that the program knows of.
    ///
    /// # Errors
    /// No function begins there, or one of those that are called is not known.
    pub fn reached_from(&self, address: u64) -> Result<Reached, ImageError> {
        let mut reached = Reached::default();
        let (mut functions, mut tables) = (BTreeMap::new(), BTreeMap::new());
        let mut open = vec![address & !1];
        while let Some(start) = open.pop() {
            let start = self.containing(start).ok_or(ImageError::NoFunction(start))?;
            if functions.contains_key(&start) {
                continue;
            }
            let bytes = self.code(start)?;
            functions.insert(start, self.part(&self.functions, start, bytes.len() as u64));
            let found = instructions::references(bytes, start, |address| self.is_data(address, start));
            reached.indirect += found.indirect;
            open.extend(found.jumps);
            for value in found.numbers {
                if value & 1 == 1 && self.functions.contains_key(&(value & !1)) {
                    open.push(value & !1);
                } else if let Some(table) = self.table(value) {
                    tables.insert(table.address, table);
                }
            }
        }
        reached.functions = functions.into_values().collect();
        reached.tables = tables.into_values().collect();
        Ok(reached)
    }

    fn part(&self, symbols: &BTreeMap<u64, (String, u64)>, address: u64, bytes: u64) -> Part {
        let name = symbols.get(&address).map(|(name, _)| name.clone()).unwrap_or_default();
        Part { name, address, bytes }
    }

    /// The beginning of the function that an address lies in.
    fn containing(&self, address: u64) -> Option<u64> {
        let (start, (_, size)) = self.functions.range(..=address).next_back()?;
        (address < start + size).then_some(*start)
    }

    /// The bytes of the function that begins here.
    fn code(&self, start: u64) -> Result<&'a [u8], ImageError> {
        let none = || ImageError::NoFunction(start);
        let (_, size) = self.functions.get(&start).ok_or_else(none)?;
        let memory = self.memory.iter().find(|memory| memory.contains(start)).ok_or_else(none)?;
        let from = (start - memory.address) as usize;
        memory.bytes.get(from..from + *size as usize).ok_or_else(none)
    }

    /// The constants that an address lies in: in a section that holds no code, or in a symbol for data.
    fn table(&self, address: u64) -> Option<Part> {
        if let Some((start, (_, size))) = self.objects.range(..=address).next_back()
            && address < start + size
        {
            return Some(self.part(&self.objects, *start, *size));
        }
        let memory = self.memory.iter().find(|memory| memory.contains(address) && !memory.executable)?;
        let end = memory.address + memory.bytes.len() as u64;
        let next = self.objects.range(address + 1..).next().map_or(end, |(next, _)| (*next).min(end));
        Some(Part { name: String::new(), address, bytes: next - address })
    }

    /// Whether an address in the function that begins at `start` lies in numbers rather than instructions.
    fn is_data(&self, address: u64, start: u64) -> bool {
        self.marks.range(start..=address).next_back().is_some_and(|(_, data)| *data)
    }
}

/// From the top down to the nearest variables; none where these reach the top.
fn room_below(top: u64, variables: &[Range<u64>]) -> Option<Range<u64>> {
    let below = variables.iter().filter(|range| range.start < top).map(|range| range.end);
    let bottom = below.fold(SRAM.start, u64::max);
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
    }
}
