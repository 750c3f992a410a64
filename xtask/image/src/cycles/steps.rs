//! Every instruction that an emulator executes, with the core's registers before it and the current exception.
//!
//! For a program that runs until it is stopped, the caller starts the emulator with [`arguments`] and passes its standard error to [`read`]. For a
//! program that ends, use [`run`]. The log is long: it suits a few hundred ticks, not more.

use crate::cycles::emulator::{Error, Line, one_instruction_a_block, start};
use std::io::{BufRead, BufReader};
use std::path::Path;

/// The emulator's name of the trace event for priorities, which is logged in addition to instructions.
const PRIORITIES: &str = "nvic_set_prio";

/// The emulator's name of the trace event for an interrupt that becomes pending.
const PENDING: &str = "nvic_set_pending";

/// An instruction about to be executed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Step {
    /// Address of the instruction.
    pub address: u32,
    /// Core registers before the instruction; 13 is the stack pointer.
    pub registers: [u32; 16],
    /// Exception being served; 0 outside of exceptions.
    pub exception: u16,
}

/// An event in the log.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// An instruction was executed.
    Step(Step),
    /// An exception received a priority, in the core's encoding: 0 is the most urgent, and the upper bits are used.
    Priority {
        /// Exception number; the first interrupt is 16.
        exception: u16,
        /// Priority number.
        priority: u8,
    },
    /// An exception became pending, before the next instruction in the log.
    Pending {
        /// Exception number.
        exception: u16,
    },
}

/// Detail of the log for each instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// The address only; registers and exception are zero. About 80 bytes per instruction.
    Addresses,
    /// A full [`Step`]: about 350 bytes per instruction.
    Registers,
}

/// Arguments for starting the emulator.
///
/// # Errors
/// The emulator cannot be started, or does not print its version.
pub fn arguments(detail: Detail) -> Result<Vec<&'static str>, Error> {
    let mut all = one_instruction_a_block()?.to_vec();
    let log = match detail {
        Detail::Addresses => "exec,nochain",
        Detail::Registers => "exec,cpu,nochain",
    };
    // Standard error itself is written one word at a time. Opened again as a file, it is written one line at a time, which is more than twice as
    // fast.
    all.extend(["-d", log, "-trace", PRIORITIES, "-trace", PENDING, "-D", "/dev/stderr"]);
    Ok(all)
}

/// Runs a program that ends, and calls back for each event in order.
///
/// # Errors
/// The emulator cannot be started, or the program fails.
pub fn run(elf: &Path, detail: Detail, on_event: impl FnMut(Event)) -> Result<(), Error> {
    let mut process = start(elf, &arguments(detail)?)?;
    let mut said = String::new();
    if let Some(log) = process.child().stderr.take() {
        said = read_saying(BufReader::with_capacity(1 << 16, log), on_event)?;
    }
    let status = process.child().wait().map_err(Error::Log)?;
    if status.success() { Ok(()) } else { Err(Error::GaveUp { status, said }) }
}

/// Reads the log to its end, and calls back for each event in order.
///
/// An instruction that the emulator restarts is reported once.
///
/// # Errors
/// The pipe breaks.
pub fn read(log: impl BufRead, on_event: impl FnMut(Event)) -> Result<(), Error> {
    read_saying(log, on_event).map(drop)
}

/// Same as [`read`]; returns the lines that are not part of the log.
pub(crate) fn read_saying(mut log: impl BufRead, mut on_event: impl FnMut(Event)) -> Result<String, Error> {
    let mut reader = Reader::default();
    let mut line = Vec::new();
    while log.read_until(b'\n', &mut line).map_err(Error::Log)? > 0 {
        reader.line(&line, &mut on_event);
        line.clear();
    }
    reader.flush(&mut on_event);
    Ok(reader.said)
}

/// Joins lines to steps, with a delay of one instruction, because an instruction may still be undone.
#[derive(Default)]
struct Reader {
    last: Option<Step>,
    /// Events to report after the last instruction.
    after: Vec<Event>,
    said: String,
}

impl Reader {
    fn line(&mut self, line: &[u8], on_event: &mut impl FnMut(Event)) {
        match Line::of(line) {
            Line::Executed(address) => {
                self.flush(on_event);
                self.last = Some(Step { address, ..Step::default() });
            }
            Line::Undone => {
                let text = String::from_utf8_lossy(line);
                self.last = self.last.filter(|last| !text.contains(&format!("{:08x}", last.address)));
            }
            Line::Other => self.other(&String::from_utf8_lossy(line)),
        }
    }

    fn other(&mut self, line: &str) {
        let mut known = false;
        for (number, value) in registers(line) {
            known = true;
            if let Some(register) = self.last.as_mut().and_then(|step| step.registers.get_mut(number)) {
                *register = value;
            }
        }
        if let Some(status) = line.strip_prefix("XPSR=").and_then(|rest| hex(rest.get(..8)?)) {
            known = true;
            if let Some(step) = &mut self.last {
                // The lowest nine bits of the program status are the exception number.
                step.exception = (status & 0x1ff) as u16;
            }
        }
        let event = event(line);
        if !known && event.is_none() {
            self.said += line;
        }
        self.after.extend(event);
    }

    fn flush(&mut self, on_event: &mut impl FnMut(Event)) {
        if let Some(step) = self.last.take() {
            on_event(Event::Step(step));
        }
        self.after.drain(..).for_each(on_event);
    }
}

fn hex(text: &str) -> Option<u32> {
    u32::from_str_radix(text, 16).ok()
}

/// `R00=00000000 R01=..`
fn registers(line: &str) -> impl Iterator<Item = (usize, u32)> + '_ {
    line.split_ascii_whitespace().filter_map(|part| {
        let (number, value) = part.strip_prefix('R')?.split_once('=')?;
        Some((number.parse().ok()?, hex(value)?))
    })
}

/// Parses lines such as `nvic_set_prio NVIC set irq 45 secure-bank 0 priority 224` and `nvic_set_pending NVIC set pending irq 45 secure-bank 0 ..`,
/// with or without a time before them.
fn event(line: &str) -> Option<Event> {
    let words: Vec<&str> = line.split_ascii_whitespace().collect();
    let behind =
        |word: &str| words.iter().position(|w| *w == word).and_then(|at| words.get(at + 1)?.parse::<u16>().ok());
    let exception = behind("irq")?;
    if line.contains(PRIORITIES) {
        Some(Event::Priority { exception, priority: u8::try_from(behind("priority")?).ok()? })
    } else {
        line.contains(PENDING).then_some(Event::Pending { exception })
    }
}

#[cfg(test)]
mod tests {
    use super::{Event, Step, read_saying};

    const LOG: &str = "\
Trace 0: 0x7ff824000100 [00800408/08000188/00000110/ff020201] Reset
R00=00000000 R01=00000001 R02=00000002 R03=00000003
R04=00000000 R05=00000000 R06=00000000 R07=00000000
R08=00000000 R09=00000000 R10=00000000 R11=00000000
R12=00000000 R13=20020000 R14=ffffffff R15=08000188
XPSR=41000000 -Z-- T priv-thread
nvic_set_prio NVIC set irq 45 secure-bank 0 priority 224
Trace 0: 0x7ff824000200 [00800408/0800018a/00000110/ff020201] Reset
R12=00000000 R13=2001fff8 R14=ffffffff R15=0800018a
XPSR=4100002d -Z-- T handler
cpu_io_recompile: rewound execution of TB to 0800018a
nvic_set_pending NVIC set pending irq 54 secure-bank 0 targets_secure 0 derived 0 (enabled: 1, prio 208)
Trace 0: 0x7ff824000200 [00800408/0800018a/00000110/ff020201] Reset
R12=00000000 R13=2001fff8 R14=ffffffff R15=0800018a
XPSR=4100002d -Z-- T handler
";

    #[test]
    fn each_instruction_comes_once_with_its_registers_and_exception_and_what_happened_between() {
        let mut events = Vec::new();
        let said = read_saying(LOG.as_bytes(), |event| events.push(event));
        assert!(said.is_ok_and(|said| said.is_empty()));
        let mut first =
            Step { address: 0x0800_0188, registers: [0, 1, 2, 3, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], exception: 0 };
        first.registers[13..].copy_from_slice(&[0x2002_0000, 0xffff_ffff, 0x0800_0188]);
        let mut second = Step { address: 0x0800_018a, exception: 45, ..Step::default() };
        second.registers[13..].copy_from_slice(&[0x2001_fff8, 0xffff_ffff, 0x0800_018a]);
        let expected = [
            Event::Step(first),
            Event::Priority { exception: 45, priority: 224 },
            Event::Pending { exception: 54 },
            Event::Step(second),
        ];
        assert_eq!(events, expected);
    }

    #[test]
    fn other_lines_are_no_events_and_are_kept() {
        let mut events = Vec::new();
        let lines = "qemu-system-arm: warning: irq\nR00=zz\nXPSR=4\n";
        let said = read_saying(lines.as_bytes(), |event| events.push(event));
        assert_eq!((said.ok().as_deref(), events), (Some(lines), vec![]));
    }
}
