//! Everything reachable from a function.

use crate::elf::{ImageError, Named, Program};
use std::collections::BTreeMap;
use std::ops::Range;

/// A function, or a table of constants.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Part {
    /// Symbol; empty for a table without one.
    pub name: String,
    /// Start address.
    pub address: u32,
    /// Length, bytes.
    pub bytes: u32,
}

/// Parts reachable from a function, including itself: each part once, by address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reached {
    /// All reachable functions.
    pub functions: Vec<Part>,
    /// Constants that the functions refer to by address. Literals after a function's code count as part of the function instead.
    pub tables: Vec<Part>,
    /// Number of calls through a register. Their target is known only if its address is a number in the calling function.
    pub indirect: usize,
}

impl Reached {
    /// Bytes of all parts in flash. Parts in RAM count too, because they are copied from flash.
    #[must_use]
    pub fn flash_bytes(&self) -> u64 {
        self.functions.iter().chain(&self.tables).map(|part| u64::from(part.bytes)).sum()
    }

    /// Ranges of the functions: the code executed between the first instruction and the return.
    #[must_use]
    pub fn ranges(&self) -> Vec<Range<u32>> {
        self.functions.iter().map(|part| part.address..part.address + part.bytes).collect()
    }
}

impl Program {
    /// Finds everything that the function at an address reaches, including itself.
    ///
    /// The search follows calls and jumps out of a function, and addresses that a function contains as numbers: of functions (the linker's veneers
    /// from flash to RAM) and of constants. A table without a symbol ends where the next known object begins.
    ///
    /// # Errors
    /// No function begins there, or one of the called functions is not known.
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

    /// The constants that contain an address: in a section without code, or in a data symbol.
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
