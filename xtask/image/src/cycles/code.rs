//! A linked program.

use crate::cycles::decode;
use crate::cycles::instruction::{Class, Instruction, Registers};
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SectionKind, SymbolKind};
use std::ops::Range;

/// A file that is no program for the chip.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Not an ELF file, or a broken one.
    #[error("no linked program: {0}")]
    NotAProgram(#[from] object::Error),
    /// For another processor.
    #[error("a program for {0:?}; expected one for 32-bit Arm")]
    OtherProcessor(object::Architecture),
    /// No code in it.
    #[error("a program without code; expected a linked one with a text section")]
    NoCode,
}

/// The code of a linked Thumb-2 program.
#[derive(Clone, Debug)]
pub struct Code {
    sections: Vec<(u32, Vec<u8>)>,
    /// Mapping symbols, sorted: from this address on, numbers (true) or instructions.
    marks: Vec<(u32, bool)>,
    functions: Vec<(String, u32, u32)>,
}

impl Code {
    /// Read a linked program.
    ///
    /// # Errors
    /// Not an ELF file for Arm, or one without code.
    pub fn parse(elf: &[u8]) -> Result<Self, Error> {
        let file = object::File::parse(elf)?;
        if file.architecture() != object::Architecture::Arm {
            return Err(Error::OtherProcessor(file.architecture()));
        }
        let mut sections = Vec::new();
        // Code that runs from RAM is in a section of data: any section that is loaded may hold instructions.
        for section in file.sections().filter(|s| matches!(s.kind(), SectionKind::Text | SectionKind::Data)) {
            sections.push((section.address() as u32, section.data()?.to_vec()));
        }
        if !file.sections().any(|section| section.kind() == SectionKind::Text && section.size() > 0) {
            return Err(Error::NoCode);
        }
        let mut marks = Vec::new();
        let mut functions = Vec::new();
        for symbol in file.symbols() {
            let (name, address) = (symbol.name().unwrap_or_default(), symbol.address() as u32);
            if name.starts_with("$d") || name.starts_with("$t") {
                marks.push((address & !1, name.starts_with("$d")));
            } else if symbol.kind() == SymbolKind::Text && symbol.size() > 0 {
                functions.push((name.to_owned(), address & !1, symbol.size() as u32));
            }
        }
        marks.sort_unstable();
        functions.sort_by_key(|(_, address, _)| *address);
        Ok(Self { sections, marks, functions })
    }

    /// Code without a file: its halves from an address on.
    #[must_use]
    pub fn from_halves(address: u32, halves: &[u16]) -> Self {
        let bytes = halves.iter().flat_map(|half| half.to_le_bytes()).collect();
        Self { sections: vec![(address, bytes)], marks: Vec::new(), functions: Vec::new() }
    }

    /// The instruction at an address; none where there is no code, or what stands there is no instruction of the core.
    #[must_use]
    pub fn decode(&self, address: u32) -> Option<Instruction> {
        let first = self.half(address)?;
        decode::decode(address, first, self.half(address.wrapping_add(2)))
    }

    /// The two half words at an address; none where there is no code.
    #[must_use]
    pub fn halves(&self, address: u32) -> Option<[u16; 2]> {
        Some([self.half(address)?, self.half(address.wrapping_add(2))?])
    }

    /// Whether an address lies in numbers rather than instructions, by the linker's mapping symbols.
    #[must_use]
    pub fn is_data(&self, address: u32) -> bool {
        let after = self.marks.partition_point(|(at, _)| *at <= address);
        after.checked_sub(1).and_then(|i| self.marks.get(i)).is_some_and(|(_, data)| *data)
    }

    /// The functions: linker's name, address, bytes; in the order of their addresses.
    pub fn functions(&self) -> impl Iterator<Item = (&str, u32, u32)> {
        self.functions.iter().map(|(name, address, size)| (name.as_str(), *address, *size))
    }

    /// The function that begins at an address and all that it calls with BL, directly or not: their addresses.
    #[must_use]
    pub fn reached_from(&self, start: u32) -> Vec<Range<u32>> {
        let mut found: Vec<Range<u32>> = Vec::new();
        let mut left = vec![start];
        while let Some(next) = left.pop() {
            let function = self.functions().find(|(_, address, _)| *address == next);
            let Some((_, address, size)) = function.filter(|_| found.iter().all(|range| range.start != next)) else {
                continue;
            };
            found.push(address..address.saturating_add(size));
            let mut at = address;
            while at < address.saturating_add(size) {
                let instruction = if self.is_data(at) { None } else { self.decode(at) };
                left.extend(instruction.and_then(|instruction| instruction.calls));
                at += instruction.map_or(2, |instruction| instruction.width);
            }
        }
        found
    }

    /// Where a function that calls another through a register goes on behind its first such call; the function is the first
    /// whose linker's name holds these letters.
    ///
    /// A program that counts calls one after another with the same few instructions has one such place.
    #[must_use]
    pub fn behind_call_in(&self, name: &str) -> Option<u32> {
        let (_, start, size) = self.functions().find(|(known, ..)| known.contains(name))?;
        let link = Registers::core(14);
        let mut at = start;
        while at < start.saturating_add(size) {
            let instruction = self.decode(at)?;
            at += instruction.width;
            if instruction.class == Class::Branch && instruction.writes.meets(link) && instruction.reads.count() == 1 {
                return Some(at);
            }
        }
        None
    }

    fn half(&self, address: u32) -> Option<u16> {
        self.sections.iter().find_map(|(start, bytes)| {
            let at = address.checked_sub(*start)? as usize;
            Some(u16::from_le_bytes([*bytes.get(at)?, *bytes.get(at + 1)?]))
        })
    }
}
