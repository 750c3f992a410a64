//! Functions in the chip's program: their bytes, and what they keep on the stack for want of registers.

use anyhow::{Context as _, Result};
use object::{Object as _, ObjectSection as _, ObjectSymbol as _, SymbolKind};

/// What a function is on the chip.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Code {
    /// With the numbers that stand behind it.
    pub(crate) bytes: u64,
    /// Single registers stored on the stack.
    pub(crate) stores: usize,
    /// Single registers loaded from the stack.
    pub(crate) loads: usize,
}

/// A linked program.
pub(crate) struct Program<'a> {
    file: object::File<'a>,
}

impl<'a> Program<'a> {
    pub(crate) fn parse(bytes: &'a [u8]) -> Result<Self> {
        Ok(Self { file: object::File::parse(bytes)? })
    }

    /// The function at an address; its lowest bit, which says Thumb, is ignored.
    pub(crate) fn function(&self, address: u64) -> Result<Code> {
        let start = address & !1;
        let symbol = self
            .file
            .symbols()
            .find(|s| s.kind() == SymbolKind::Text && s.address() & !1 == start && s.size() > 0)
            .with_context(|| format!("no function at {start:#x}"))?;
        let section = symbol.section_index().context("a function without a section")?;
        let section = self.file.section_by_index(section)?;
        let bytes = section
            .data_range(start, symbol.size())?
            .with_context(|| format!("the function at {start:#x} leaves its section"))?;
        let (stores, loads) = stack_traffic(bytes, |offset| self.is_data(start + offset, start));
        Ok(Code { bytes: symbol.size(), stores, loads })
    }

    /// Whether an address lies in numbers rather than instructions: the mapping symbols `$t` and `$d` tell.
    fn is_data(&self, address: u64, start: u64) -> bool {
        let marks = self.file.symbols().filter_map(|symbol| {
            let name = symbol.name().ok()?;
            let at = symbol.address() & !1;
            let (is_data, is_mark) = (name.starts_with("$d"), name.starts_with("$d") || name.starts_with("$t"));
            (is_mark && at >= start && at <= address).then_some((at, is_data))
        });
        marks.max_by_key(|(at, _)| *at).is_some_and(|(_, is_data)| is_data)
    }
}

/// Single registers that VSTR and VLDR (Thumb encodings T1 and T2) move to and from the stack pointer's frame.
///
/// What is saved on entry goes by VPUSH, and is not counted; inputs and results have pointers of their own.
fn stack_traffic(code: &[u8], is_data: impl Fn(u64) -> bool) -> (usize, usize) {
    let (mut stores, mut loads) = (0, 0);
    let half = |at: usize| code.get(at..at + 2).map_or(0, |b| u16::from_le_bytes([b[0], b[1]]));
    let mut at = 0;
    while at + 2 <= code.len() {
        if at % 4 == 0 && is_data(at as u64) {
            at += 4;
            continue;
        }
        let (first, second) = (half(at), half(at + 2));
        // 11101, 11110 and 11111 begin an instruction of two halves.
        if first < 0xe800 {
            at += 2;
            continue;
        }
        at += 4;
        // 1110 1101 UD0L 1101 | Vd 101z imm8: the stack pointer is register 13; z: two singles at once.
        let registers = match second & 0x0f00 {
            0x0a00 => 1,
            0x0b00 => 2,
            _ => continue,
        };
        match first & 0xff3f {
            0xed0d => stores += registers,
            0xed1d => loads += registers,
            _ => {}
        }
    }
    (stores, loads)
}

#[cfg(test)]
mod tests {
    use super::stack_traffic;

    /// As the assembler gives them.
    const CODE: [u16; 12] = [
        0xb510, // push {r4, lr}
        0xed8d, 0x0a01, // vstr s0, [sp, #4]
        0xeddd, 0x7a02, // vldr s15, [sp, #8]
        0xed9d, 0x1b04, // vldr d1, [sp, #16]
        0xed91, 0x0a01, // vldr s0, [r1, #4]
        0xbd10, // pop {r4, pc}
        0xeddd, 0x7a02, // a number that looks like an instruction
    ];

    #[test]
    fn loads_and_stores_of_the_frame_are_counted_and_nothing_else() {
        let bytes: Vec<u8> = CODE.iter().flat_map(|half| half.to_le_bytes()).collect();
        assert_eq!(stack_traffic(&bytes, |at| at >= 20), (1, 3));
        assert_eq!(stack_traffic(&bytes, |_| false), (1, 4));
    }
}
