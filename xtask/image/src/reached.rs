//! Everything that a function reaches.

use crate::elf::{ImageError, Named, Program, SRAM};
use std::collections::BTreeMap;
use std::ops::Range;

/// A function, or a table of constants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Its symbol; empty for a table without one.
    pub name: String,
    /// Where it begins.
    pub address: u32,
    /// How long it is.
    pub bytes: u32,
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
        self.functions.iter().chain(&self.tables).map(|part| u64::from(part.bytes)).sum()
    }

    /// Where the functions lie: the code that is executed between the first instruction and the return.
    #[must_use]
    pub fn ranges(&self) -> Vec<Range<u32>> {
        self.functions.iter().map(|part| part.address..part.address + part.bytes).collect()
    }

    /// Bytes of the functions that run from static RAM.
    #[must_use]
    pub fn sram_bytes(&self) -> u64 {
        let in_ram = self.functions.iter().filter(|part| SRAM.contains(&part.address));
        in_ram.map(|part| u64::from(part.bytes)).sum()
    }
}

impl Program {
    /// The function at an address, and everything that it reaches.
    ///
    /// Followed are calls and jumps out of a function, and addresses that a function holds as numbers: of functions (the linker's steps
    /// from flash to RAM) and of constants. A table without a symbol ends where the next thing begins that the program knows of.
    ///
    /// # Errors
    /// No function begins there, or one of those that are called is not known.
    pub fn reached_from(&self, address: u32) -> Result<Reached, ImageError> {
        let mut reached = Reached::default();
        let (mut functions, mut tables) = (BTreeMap::new(), BTreeMap::new());
        let mut open = vec![address & !1];
        while let Some(start) = open.pop() {
            let start = self.containing(start).ok_or(ImageError::NoFunction(start))?;
            if functions.contains_key(&start) {
                continue;
            }
            let range = self.range(start)?;
            functions.insert(start, part(&self.functions, start, range.len() as u32));
            let found = self.references(range);
            reached.indirect += found.indirect;
            open.extend(found.jumps);
            for value in found.numbers {
                if let Some(function) = self.function_at(value) {
                    open.push(function);
                } else if let Some(table) = self.table(value) {
                    tables.insert(table.address, table);
                }
            }
        }
        reached.functions = functions.into_values().collect();
        reached.tables = tables.into_values().collect();
        Ok(reached)
    }

    /// The constants that an address lies in: in a section that holds no code, or in a symbol for data.
    fn table(&self, address: u32) -> Option<Part> {
        if let Some((start, (_, size))) = self.objects.range(..=address).next_back()
            && address - start < *size
        {
            return Some(part(&self.objects, *start, *size));
        }
        let section = self.sections.iter().find(|section| section.contains(address) && !section.executable)?;
        let next =
            self.objects.range(address + 1..).next().map_or(section.end(), |(next, _)| (*next).min(section.end()));
        Some(Part { name: String::new(), address, bytes: next - address })
    }
}

fn part(symbols: &BTreeMap<u32, Named>, address: u32, bytes: u32) -> Part {
    let name = symbols.get(&address).map(|(name, _)| name.clone()).unwrap_or_default();
    Part { name, address, bytes }
}
