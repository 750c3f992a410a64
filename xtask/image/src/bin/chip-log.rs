//! Decoder of the logs of the chip's programs. It is a separate program, because few tasks need the decoder and it takes longer to compile than all
//! other tasks. Its argument is the program; the log comes on standard input.

use anyhow::{Context as _, Result, bail};
use defmt_decoder::{DecodeError, Table};
use std::io::Read as _;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [elf] = arguments.as_slice() else { bail!("expected one argument: a program") };
    let program = std::fs::read(elf).with_context(|| format!("cannot read {elf}"))?;
    print(&Table::parse(&program)?.context("the program has no log strings: is it the firmware?")?)
}

fn print(table: &Table) -> Result<()> {
    let mut log = std::io::stdin().lock();
    let mut decoder = table.new_stream_decoder();
    let mut buffer = [0; 4096];
    loop {
        let count = log.read(&mut buffer)?;
        if count == 0 {
            return Ok(());
        }
        decoder.received(&buffer[..count]);
        loop {
            match decoder.decode() {
                Ok(frame) => println!("{}", frame.display(false)),
                Err(DecodeError::UnexpectedEof) => break,
                Err(DecodeError::Malformed) if table.encoding().can_recover() => {}
                Err(DecodeError::Malformed) => bail!("the log cannot be decoded"),
            }
        }
    }
}
