//! Comparison of the decoder of `chip-image` with an independent disassembler: GNU objdump.

use crate::process::which;
use anyhow::{Context as _, Result, bail};
use chip_image::{Class, Program};
use std::path::Path;
use std::process::Command;

const OBJDUMP: &str = "arm-none-eabi-objdump";

/// Compares width, class, words, literal and jump target of every instruction of a program. Returns the number of
/// instructions, or `None` without objdump.
pub(super) fn compare(elf: &Path, program: &Program) -> Result<Option<usize>> {
    if which(OBJDUMP).is_none() {
        return Ok(None);
    }
    let output = Command::new(OBJDUMP).arg("-d").arg(elf).output().context(OBJDUMP)?;
    if !output.status.success() {
        bail!("{OBJDUMP} failed: {}", String::from_utf8_lossy(&output.stderr));
    }
    let text = String::from_utf8_lossy(&output.stdout);
    let lines: Vec<Listed<'_>> = text.lines().filter_map(Listed::of).collect();
    let mut wrong = Vec::new();
    for line in &lines {
        let expected = line.expected().with_context(|| format!("no class for {:?}", line.text));
        let found = program.decode(line.address).map(|i| (i.width, i.class, i.words, i.literal.or(i.jumps_to())));
        match expected {
            Ok(expected) if found == Some(expected) => {}
            Ok(expected) => wrong.push(format!("{:x} {}: {found:?}, expected {expected:?}", line.address, line.text)),
            Err(why) => wrong.push(format!("{:x}: {why:#}", line.address)),
        }
    }
    if !wrong.is_empty() || lines.is_empty() {
        wrong.truncate(20);
        bail!("{} instructions compared; the first differences:\n{}", lines.len(), wrong.join("\n"));
    }
    Ok(Some(lines.len()))
}

/// An instruction as objdump lists it.
#[derive(Clone, Copy, Debug)]
struct Listed<'a> {
    address: u32,
    width: u32,
    mnemonic: &'a str,
    operands: &'a str,
    text: &'a str,
}

impl<'a> Listed<'a> {
    /// ` 80003be:<tab>eddf dafd <tab>vldr<tab>s27, [pc, #1012]<tab>@ 80007b4 <...>`; `None` for other lines.
    fn of(line: &'a str) -> Option<Self> {
        let (address, rest) = line.split_once(":\t")?;
        let address = u32::from_str_radix(address.trim(), 16).ok()?;
        let (halves, text) = rest.split_once('\t')?;
        let (mnemonic, operands) = text.split_once('\t').unwrap_or((text, ""));
        let mnemonic = mnemonic.trim();
        let is_data = mnemonic.starts_with('.') || mnemonic.starts_with("udf") || mnemonic.starts_with('@');
        let width = 2 * halves.split_whitespace().count() as u32;
        (!is_data).then_some(Self { address, width, mnemonic, operands, text })
    }

    fn expected(&self) -> Option<(u32, Class, u32, Option<u32>)> {
        let class = self.class()?;
        let first = self.operands.split(',').next().unwrap_or_default();
        let words = match class {
            Class::LoadMultiple | Class::StoreMultiple if !self.operands.contains('{') => 2,
            Class::LoadMultiple | Class::StoreMultiple | Class::FloatLoadMultiple | Class::FloatStoreMultiple => {
                self.listed_words()?
            }
            Class::FloatLoad | Class::FloatStore if first.starts_with('d') => 2,
            _ if class.is_memory() => 1,
            _ => 0,
        };
        let loads = matches!(class, Class::Load | Class::LoadMultiple | Class::FloatLoad);
        let literal = (loads && self.operands.contains("[pc")).then(|| self.commented()).flatten();
        // The operand may be `800ffbc <function>`, after a register in CBZ and CBNZ. A jump through a register has no number here.
        let goal = || u32::from_str_radix(self.operands.split(", ").last()?.split(' ').next()?, 16).ok();
        let goal = (class == Class::Branch).then(goal).flatten();
        Some((self.width, class, words, literal.or(goal)))
    }

    /// `@ 80007b4 <...>` or `@ (80007b4 <...>)`
    fn commented(&self) -> Option<u32> {
        let (_, comment) = self.operands.split_once('@')?;
        let hex = comment.trim_start_matches([' ', '(']).split(|c: char| !c.is_ascii_hexdigit()).next()?;
        u32::from_str_radix(hex, 16).ok()
    }

    /// Number of words in a register list: `{r4, r5, pc}`, `{d8-d11}`, `{s16}`.
    fn listed_words(&self) -> Option<u32> {
        let list = self.operands.split_once('{')?.1.split_once('}')?.0;
        let number = |name: &str| name.get(1..)?.parse::<u32>().ok();
        let mut registers = 0;
        for part in list.split(',').map(str::trim) {
            registers += match part.split_once('-') {
                Some((from, to)) => number(to)? + 1 - number(from)?,
                None => 1,
            };
        }
        Some(if list.starts_with('d') { 2 * registers } else { registers })
    }

    fn class(&self) -> Option<Class> {
        let name = self.mnemonic.split('.').next().unwrap_or_default();
        // In an IT block a condition follows the mnemonic.
        let class = named(name).or_else(|| named(name.get(..name.len().checked_sub(2)?)?))?;
        let operands: Vec<&str> = self.operands.split(',').map(str::trim).collect();
        let is_core = |operand: &&str| {
            operand.starts_with(['r', 'l', 'p', 'i', 'f'])
                || operand.starts_with("sp")
                || operand.starts_with("sl")
                || operand.starts_with("sb")
        };
        Some(match class {
            Class::FloatMove if operands.iter().filter(|o| is_core(o)).count() == 2 => Class::FloatTransferPair,
            Class::FloatMove if operands.iter().any(is_core) => Class::FloatTransfer,
            Class::Integer if operands.first() == Some(&"pc") => Class::Branch,
            _ => class,
        })
    }
}

/// Class of a mnemonic without condition and width suffix.
fn named(name: &str) -> Option<Class> {
    const INTEGER: [&str; 35] = [
        "adc", "add", "addw", "adr", "and", "asr", "bfc", "bfi", "bic", "clz", "cmn", "cmp", "eor", "lsl", "lsr",
        "mov", "movt", "movw", "mvn", "neg", "orn", "orr", "rbit", "rev", "rev16", "ror", "rrx", "rsb", "sbc", "sbfx",
        "ssat", "sub", "subw", "ubfx", "usat",
    ];
    const INTEGER_MORE: [&str; 10] =
        ["sxtb", "sxth", "teq", "tst", "uxtb", "uxth", "uxtb16", "uxtab", "uxtah", "uadd8"];
    const FLAGS: [&str; 17] = [
        "adcs", "adds", "ands", "asrs", "bics", "eors", "lsls", "lsrs", "movs", "mvns", "negs", "orns", "orrs", "rsbs",
        "sbcs", "subs", "rors",
    ];
    Some(match name {
        _ if INTEGER.contains(&name) || INTEGER_MORE.contains(&name) || FLAGS.contains(&name) => Class::Integer,
        "mul" | "muls" | "mla" | "mls" | "umull" | "smull" | "umlal" | "smlal" | "umaal" | "smulbb" | "smmul" => {
            Class::Multiply
        }
        "sdiv" | "udiv" => Class::Divide,
        "ldr" | "ldrb" | "ldrh" | "ldrsb" | "ldrsh" | "ldrex" | "ldrexb" => Class::Load,
        "str" | "strb" | "strh" | "strex" | "strexb" => Class::Store,
        "ldmia" | "ldmdb" | "pop" | "ldrd" => Class::LoadMultiple,
        "stmia" | "stmdb" | "push" | "strd" => Class::StoreMultiple,
        "b" | "bl" | "bx" | "blx" | "cbz" | "cbnz" => Class::Branch,
        "tbb" | "tbh" => Class::TableBranch,
        "it" | "itt" | "ite" | "ittt" | "itte" | "itet" | "itee" => Class::IfThen,
        "itttt" | "ittte" | "ittet" | "ittee" | "itett" | "itete" | "iteet" | "iteee" => Class::IfThen,
        "vadd" | "vsub" | "vmul" | "vnmul" | "vabs" | "vneg" => Class::FloatArithmetic,
        "vmla" | "vmls" | "vnmla" | "vnmls" | "vfma" | "vfms" | "vfnma" | "vfnms" => Class::FloatMultiplyAdd,
        "vdiv" => Class::FloatDivide,
        "vsqrt" => Class::FloatSquareRoot,
        "vcvt" | "vcvtr" | "vcvtb" | "vcvtt" => Class::FloatConvert,
        "vmov" => Class::FloatMove,
        "vcmp" | "vcmpe" => Class::FloatCompare,
        "vmrs" | "vmsr" => Class::FloatStatus,
        "vldr" => Class::FloatLoad,
        "vstr" => Class::FloatStore,
        "vldmia" | "vldmdb" | "vpop" => Class::FloatLoadMultiple,
        "vstmia" | "vstmdb" | "vpush" => Class::FloatStoreMultiple,
        "dmb" | "dsb" | "isb" => Class::Barrier,
        "nop" | "bkpt" | "svc" | "wfi" | "wfe" | "sev" | "mrs" | "msr" | "cpsid" | "cpsie" => Class::System,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::Listed;
    use chip_image::Class;

    #[test]
    fn listed_instructions_are_read() {
        let listed = |line| Listed::of(line).and_then(|line| line.expected());
        let literal = " 80003be:\teddf dafd \tvldr\ts27, [pc, #1012]\t@ 80007b4 <kernel+0x404>";
        assert_eq!(listed(literal), Some((4, Class::FloatLoad, 1, Some(0x0800_07b4))));
        assert_eq!(listed(" 80111be:\tbdb0      \tpop\t{r4, r5, r7, pc}"), Some((2, Class::LoadMultiple, 4, None)));
        assert_eq!(listed(" 8000002:\ted2d 8b08 \tvpush\t{d8-d11}"), Some((4, Class::FloatStoreMultiple, 8, None)));
        assert_eq!(listed(" 8000002:\tbf18      \tmovne\tr0, r1"), Some((2, Class::Integer, 0, None)));
        assert_eq!(listed(" 80007b4:\t3f800000 \t.word\t0x3f800000"), None);
    }
}
