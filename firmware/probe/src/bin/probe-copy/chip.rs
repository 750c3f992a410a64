//! The program on the chip.
#![allow(unsafe_code, reason = "calls the functions under test by the names that the compiler calls")]

use core::hint::black_box;
use core::sync::atomic::{Ordering, compiler_fence};
use cortex_m_semihosting::{debug, hprintln};
use stm32f4xx_hal as _;

unsafe extern "C" {
    fn memcpy(to: *mut u8, from: *const u8, bytes: usize) -> *mut u8;
    fn memmove(to: *mut u8, from: *const u8, bytes: usize) -> *mut u8;
    fn __aeabi_memclr(to: *mut u8, bytes: usize);
    fn __aeabi_memclr4(to: *mut u8, bytes: usize);
}

/// Longest length: three rounds of the longest loop, and all shorter ones.
const LONGEST: usize = 200;
/// Bytes around source and destination.
const MARGIN: usize = 16;
const ROOM: usize = LONGEST + 2 * MARGIN;

#[repr(align(8))]
struct Block([u8; ROOM]);

/// Fills a block with bytes that differ from their neighbours. A loop with a fence in it is never compiled into a call of the functions under test.
fn fill(block: &mut Block, seed: u8) {
    for (place, byte) in block.0.iter_mut().enumerate() {
        *byte = filled(place, seed);
        compiler_fence(Ordering::SeqCst);
    }
}

/// True if each byte is the expected one for its place.
fn is(block: &Block, expected: impl Fn(usize) -> u8) -> bool {
    block.0.iter().enumerate().all(|(place, byte)| *byte == expected(place))
}

/// The byte that [`fill`] wrote to a place.
fn filled(place: usize, seed: u8) -> u8 {
    (place as u8).wrapping_mul(167).wrapping_add(seed) | 1
}

fn copies(to: usize, from: usize, bytes: usize) -> bool {
    let (mut source, mut block) = (Block([0; ROOM]), Block([0; ROOM]));
    fill(&mut source, 3);
    fill(&mut block, 90);
    let destination = &raw mut block.0[to];
    // SAFETY: both ranges are inside of their blocks.
    let returned = unsafe { memcpy(black_box(destination), black_box(&raw const source.0[from]), black_box(bytes)) };
    let inside = |place: usize| (to..to + bytes).contains(&place);
    returned == destination
        && is(&source, |place| filled(place, 3))
        && is(&block, |place| if inside(place) { filled(place - to + from, 3) } else { filled(place, 90) })
}

fn moves(to: usize, from: usize, bytes: usize) -> bool {
    let mut block = Block([0; ROOM]);
    fill(&mut block, 41);
    let start = &raw mut block.0;
    let start = start.cast::<u8>();
    // SAFETY: both ranges are inside of the block.
    let (destination, source) = unsafe { (start.add(to), start.add(from)) };
    // SAFETY: as above.
    let returned = unsafe { memmove(black_box(destination), black_box(source), black_box(bytes)) };
    let inside = |place: usize| (to..to + bytes).contains(&place);
    returned == destination && is(&block, |place| filled(if inside(place) { place - to + from } else { place }, 41))
}

fn clears(to: usize, bytes: usize, clear: unsafe extern "C" fn(*mut u8, usize)) -> bool {
    let mut block = Block([0; ROOM]);
    fill(&mut block, 7);
    // SAFETY: the range is inside of the block.
    unsafe { clear(black_box(&raw mut block.0[to]), black_box(bytes)) };
    let inside = |place: usize| (to..to + bytes).contains(&place);
    is(&block, |place| if inside(place) { 0 } else { filled(place, 7) })
}

/// Ends the emulator with a failure unless a call was right.
fn expect(function: &str, [to, from, bytes]: [usize; 3], did: bool) {
    if !did {
        hprintln!("{} of {} bytes from {} to {} is wrong", function, bytes, from, to);
        debug::exit(debug::EXIT_FAILURE);
    }
}

#[cortex_m_rt::entry]
fn main() -> ! {
    let mut calls = 0_u32;
    for bytes in 0..=LONGEST {
        for to in MARGIN..MARGIN + 4 {
            for from in MARGIN..MARGIN + 4 {
                expect("memcpy", [to, from, bytes], copies(to, from, bytes));
                calls += 1;
            }
            expect("__aeabi_memclr", [to, to, bytes], clears(to, bytes, __aeabi_memclr));
            calls += 1;
        }
        expect("__aeabi_memclr4", [MARGIN, MARGIN, bytes], clears(MARGIN, bytes, __aeabi_memclr4));
        calls += 1;
        // Distances from -16 to 16 bytes.
        for to in 0..=2 * MARGIN {
            expect("memmove", [to, MARGIN, bytes], moves(to, MARGIN, bytes));
            calls += 1;
        }
    }
    hprintln!("{} calls are right", calls);
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

#[panic_handler]
fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}
