//! Estimates compared with cycles computed by hand, one rule at a time.

use chip_image::Program;
use chip_image::cycles::timing::{FLASH_WAIT_STATES, INSTRUCTION_LINES, LIKELY, Prefetched, Reading};
use chip_image::cycles::{Estimate, Estimator, Memory, Placement, Range};

const SRAM: u32 = 0x2000_0000;
const FLASH: u32 = 0x0800_0000;

const NOP: u16 = 0xbf00;
const ADDS_R0_R0_R1: u16 = 0x1840;
const LDR_R5_R4: u16 = 0x6865;
const LDR_R6_R5: u16 = 0x682e;
const STR_R5_R4: u16 = 0x6065;
const STR_R5_R4_R1: u16 = 0x5065;
/// A wide instruction of one cycle: add.w r8, r1, r2, lsl #2.
const ADD_WIDE: [u16; 2] = [0xeb01, 0x0882];
const VADD_S0_S1_S2: [u16; 2] = [0xee30, 0x0a81];
/// vadd.f32 s3, s0, s2
const VADD_S3_S0_S2: [u16; 2] = [0xee70, 0x1a01];
/// vadd.f32 s3, s4, s5
const VADD_S3_S4_S5: [u16; 2] = [0xee72, 0x1a22];
/// vmla.f32 s0, s4, s5
const VMLA_S0_S4_S5: [u16; 2] = [0xee02, 0x0a22];
const VDIV_S0_S1_S2: [u16; 2] = [0xee80, 0x0a81];

/// Runs instructions in sequence, starting with a core at rest and all of them cached.
fn straight(halves: &[u16]) -> Estimate {
    // The instructions that follow let the float unit finish and clear the pipeline.
    let with_rest = [halves, &[NOP; 32]].concat();
    let program = Program::from_halves(SRAM, &with_rest);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::Flash));
    run(&program, &mut estimator, SRAM, with_rest.len());
    estimator.finish();
    run(&program, &mut estimator, SRAM, halves.len());
    estimator.finish()
}

fn run(program: &Program, estimator: &mut Estimator<'_>, start: u32, halves: usize) {
    let mut at = start;
    while at < start + 2 * halves as u32 {
        estimator.execute(at);
        at += program.decode(at).map_or(2, |instruction| instruction.width);
    }
}

fn likely(halves: &[u16]) -> u64 {
    straight(halves).cycles.likely
}

fn together(parts: &[&[u16]]) -> Vec<u16> {
    parts.concat()
}

#[test]
fn integers_take_a_cycle_each() {
    assert_eq!(straight(&[ADDS_R0_R0_R1; 4]).cycles, Range { low: 4, likely: 4, high: 4 });
    assert_eq!(likely(&[0x4348, 0x4348]), 2, "muls");
    assert_eq!(straight(&[0xfb91, 0xf0f2]).cycles, Range { low: 2, likely: 7, high: 12 }, "sdiv");
}

#[test]
fn loads_are_pipelined_behind_loads() {
    assert_eq!(likely(&[LDR_R5_R4]), 2);
    // Arm's own example: three loads, four cycles.
    assert_eq!(likely(&[LDR_R5_R4, LDR_R5_R4, LDR_R5_R4]), 4);
    assert_eq!(likely(&[LDR_R5_R4, NOP, LDR_R5_R4]), 5);
    assert_eq!(likely(&[LDR_R5_R4, LDR_R6_R5]), 4, "the second waits for its address");
    assert_eq!(likely(&[LDR_R5_R4, STR_R5_R4]), 3);
    let behind_store = straight(&[STR_R5_R4, LDR_R5_R4]).cycles;
    assert_eq!(behind_store, Range { low: 2, likely: 3, high: 3 }, "in the low reading only, behind a store");
    // push {r4, r5, r7, lr}; pop {r4-r7}
    assert_eq!(straight(&[0xb5b0, 0xbcf0]).cycles, Range { low: 9, likely: 10, high: 10 });
    assert_eq!(likely(&[STR_R5_R4_R1]), 2);
    assert_eq!(likely(&[0xb5b0]), 5, "push of four");
    // adds r5, r0, r1; ldr r6, [r5]: an address from a sum waits one cycle.
    assert_eq!(likely(&[0x1845, LDR_R6_R5]), 4);
}

#[test]
fn float_results_are_a_cycle_late_but_for_an_addend() {
    assert_eq!(likely(&together(&[&VADD_S0_S1_S2, &VADD_S3_S4_S5])), 2);
    assert_eq!(likely(&together(&[&VADD_S0_S1_S2, &VADD_S3_S0_S2])), 3);
    assert_eq!(likely(&together(&[&VADD_S0_S1_S2, &[NOP], &VADD_S3_S0_S2])), 3, "something between hides it");
    // The multiply-add takes 3, and the next instruction waits for the unit; its addend is ready in time.
    let after = together(&[&VADD_S0_S1_S2, &VMLA_S0_S4_S5, &VADD_S3_S4_S5]);
    assert_eq!(likely(&after), 1 + 3 + 1);
    assert_eq!(likely(&together(&[&VMLA_S0_S4_S5, &VMLA_S0_S4_S5, &VADD_S3_S4_S5])), 3 + 3 + 1);
    assert_eq!(likely(&together(&[&VMLA_S0_S4_S5, &VADD_S3_S0_S2])), 3 + 1 + 1, "its result is a cycle late");
}

#[test]
fn integers_go_on_beside_a_division_in_all_but_the_high_reading() {
    let divide = straight(&together(&[&VDIV_S0_S1_S2, &[NOP; 5], &VADD_S3_S4_S5]));
    assert_eq!(divide.cycles, Range { low: 14 + 1, likely: 14 + 1, high: 14 + 5 + 1 });
    assert_eq!(divide.stalls.unit, 14 - 1 - 5);
    assert_eq!(likely(&together(&[&VDIV_S0_S1_S2, &VADD_S3_S0_S2])), 14 + 1 + 1);
}

#[test]
fn float_loads_are_pipelined_in_the_low_reading_only() {
    // vldr s1, [r0, #4]; vldr s1, [r0, #4]; vstr s1, [sp, #8]
    let cycles = straight(&[0xedd0, 0x0a01, 0xedd0, 0x0a01, 0xedcd, 0x0a02]).cycles;
    assert_eq!(cycles, Range { low: 4, likely: 6, high: 6 });
    // vldr d1, [r0]
    assert_eq!(straight(&[0xed90, 0x1b00]).cycles, Range { low: 3, likely: 3, high: 3 });
    assert_eq!(likely(&together(&[&[0xedd0, 0x0a01], &[LDR_R5_R4]])), 4, "nothing is pipelined behind vldr");
    assert_eq!(likely(&together(&[&[LDR_R5_R4], &[0xedd0, 0x0a01]])), 4, "nor vldr behind a load");
    assert_eq!(likely(&[0xed2d, 0x8b08]), 9, "vpush of eight singles");
}

#[test]
fn transfers_take_the_core_a_cycle_and_the_float_unit_two() {
    // vmov s0, r1; vmov r1, s0; vmov s2, s3, r0, r1
    let (to_float, to_core, pair_to_float) = ([0xee00, 0x1a10], [0xee10, 0x1a10], [0xec41, 0x0a11]);
    for one in [to_float, to_core, pair_to_float] {
        assert_eq!(straight(&one).cycles, Range { low: 1, likely: 1, high: 2 });
        let twice = straight(&[one, one].concat()).cycles;
        assert_eq!(twice, Range { low: 2, likely: 3, high: 4 }, "the second waits for the unit");
        assert_eq!(likely(&together(&[&one, &VADD_S3_S4_S5])), 3, "so does a sum of other registers");
        assert_eq!(likely(&together(&[&one, &[NOP], &VADD_S3_S4_S5])), 3, "beside something of the core");
    }
    // vmov r0, r1, d1
    let pair_to_core = [0xec51, 0x0b11];
    assert_eq!(straight(&pair_to_core).cycles, Range { low: 1, likely: 2, high: 2 });
    assert_eq!(likely(&together(&[&pair_to_core, &VADD_S3_S4_S5])), 3);
    assert_eq!(likely(&together(&[&to_core, &[ADDS_R0_R0_R1]])), 3, "its result is ready with the unit");
    assert_eq!(likely(&together(&[&to_core, &[NOP, ADDS_R0_R0_R1]])), 3);
}

#[test]
fn it_is_a_range() {
    // A narrow instruction, IT, and the instruction it governs.
    assert_eq!(straight(&[NOP, 0xbf08, NOP]).cycles, Range { low: 2, likely: 2, high: 3 });
    assert_eq!(straight(&[0xeb01, 0x0882, 0xbf08, NOP]).cycles, Range { low: 2, likely: 3, high: 3 });
}

#[test]
fn a_branch_refills_the_pipeline_when_it_is_taken() {
    // b +0 to a narrow instruction; beq not taken; b to a wide one across two words.
    let program = Program::from_halves(SRAM, &[0xe7ff, NOP, 0xd0ff, NOP, 0xe7ff, ADD_WIDE[0], ADD_WIDE[1], NOP]);
    let cycles = |addresses: &[u32]| {
        let mut estimator = Estimator::new(&program, Memory::new(Placement::Sram));
        addresses.iter().for_each(|at| estimator.execute(SRAM + at));
        estimator.finish().cycles
    };
    // To 12, a narrow one; the system bus adds 0 to 2.
    assert_eq!(cycles(&[0, 14]), Range { low: 1 + 2 + 1, likely: 1 + 2 + 1 + 1, high: 1 + 3 + 2 + 1 });
    assert_eq!(cycles(&[4, 6]), Range { low: 2, likely: 2, high: 2 });
    assert_eq!(cycles(&[4, 10]).likely, 1 + 3 + 1 + 1, "two fetches");
}

#[test]
fn data_and_code_meet_on_the_bus_of_sram() {
    let program = Program::from_halves(SRAM, &[LDR_R5_R4, NOP, 0xb5b0]);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::ByAddress));
    run(&program, &mut estimator, SRAM, 3);
    let estimate = estimator.finish();
    assert_eq!(estimate.cycles, Range { low: 2 + 1 + 5, likely: 3 + 1 + 6, high: 3 + 1 + 9 });
    assert_eq!((estimate.stalls.bus, estimate.stalls.fetch), (2, 0));
}

#[test]
fn a_straight_line_of_16_kib_runs_at_the_pace_of_flash() {
    // 4,096 wide instructions, four per line: each line takes 6 cycles to read and 4 to execute.
    let halves = ADD_WIDE.repeat(4096);
    let program = Program::from_halves(FLASH, &halves);
    let (lines, a_line) = (1024, 1 + FLASH_WAIT_STATES);
    for repeated in [0, 1] {
        let mut estimator = Estimator::new(&program, Memory::new(Placement::Flash));
        for _ in 0..repeated {
            run(&program, &mut estimator, FLASH, halves.len());
            estimator.finish();
        }
        run(&program, &mut estimator, FLASH, halves.len());
        let estimate = estimator.finish();
        assert_eq!(estimate.instructions, 4096);
        // Each line needs one read, the last line also its own instructions; the cache of 64 lines does not help here.
        let expected = lines * a_line + 4;
        assert!(estimate.cycles.likely.abs_diff(expected) <= 2 * a_line, "{} for {expected}", estimate.cycles.likely);
        assert_eq!(estimate.cycles.likely, 4096 + estimate.stalls.fetch);
    }
    // Narrow instructions, eight per line: the prefetch is always in time, so the core waits only for the first line.
    let halves = [NOP; 8192];
    let program = Program::from_halves(FLASH, &halves);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::Flash));
    run(&program, &mut estimator, FLASH, halves.len());
    assert_eq!(estimator.finish().cycles.likely, 8192 + FLASH_WAIT_STATES);
}

#[test]
fn code_that_fits_the_cache_waits_once_and_a_line_more_does_not_fit() {
    let of_lines = |lines: usize| {
        let halves = ADD_WIDE.repeat(4 * lines);
        let program = Program::from_halves(FLASH, &halves);
        let mut estimator = Estimator::new(&program, Memory::new(Placement::Flash));
        [0; 3].map(|_| {
            run(&program, &mut estimator, FLASH, halves.len());
            // It is unknown if the last instruction branches back, so none of these counts as a branch.
            estimator.finish().stalls.fetch
        })
    };
    let fits = of_lines(INSTRUCTION_LINES);
    assert!(fits[0] > 0, "{fits:?}");
    assert_eq!(fits[1..], [0, 0]);
    let one_more = of_lines(INSTRUCTION_LINES + 1);
    assert!(one_more[2] > 64, "the least recently used line is always the next one: {one_more:?}");
}

#[test]
fn a_literal_waits_for_flash_once_a_line() {
    // vldr s0, [pc, #16], four times: the literals are in one line, the code in another.
    let mut halves = [0xed9f, 0x0a04].repeat(4);
    halves.extend([0; 16]);
    let program = Program::from_halves(FLASH, &halves);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::Flash));
    run(&program, &mut estimator, FLASH, 8);
    let first = estimator.finish();
    run(&program, &mut estimator, FLASH, 8);
    let again = estimator.finish();
    assert!(first.stalls.literal >= FLASH_WAIT_STATES, "{first:?}");
    assert_eq!(again.stalls.literal, 0);
    // If the code is in SRAM, so are the literals: no wait except for the bus, once for each.
    let mut estimator = Estimator::new(&program, Memory::new(Placement::Sram));
    run(&program, &mut estimator, FLASH, 8);
    let stalls = estimator.finish().stalls;
    assert_eq!((stalls.literal, stalls.bus), (0, 4));
}

/// ldr r5, [r4, #4]; nop; both again; ldrd r0, r1, [r4, #8]; pop of four.
const THROUGH_POINTERS: [u16; 7] = [LDR_R5_R4, NOP, LDR_R5_R4, NOP, 0xe9d4, 0x0102, 0xbcf0];

/// Runs these from SRAM, where code needs no waiting.
fn through(r4: u32, sp: u32) -> Estimate {
    let program = Program::from_halves(SRAM, &THROUGH_POINTERS);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::ByAddress));
    let mut registers = [0; 16];
    (registers[4], registers[13]) = (r4, sp);
    for at in [0, 2, 4, 6, 8, 12] {
        estimator.execute_with(SRAM + at, &registers);
    }
    estimator.finish()
}

#[test]
fn a_load_through_a_pointer_into_flash_waits_for_it_once_a_line() {
    let (sram, coupled) = (through(SRAM + 4096, SRAM), through(0x1000_0000, 0x1000_0000));
    assert_eq!((sram.stalls.literal, sram.stalls.bus), (0, 4), "each of the four loads meets the code on the bus");
    assert_eq!((coupled.stalls.literal, coupled.stalls.bus), (0, 0), "the coupled memory has a bus of its own");
    // The words at 16, 16, 20 and 24 are in one line.
    let flash = through(FLASH + 12, SRAM);
    assert_eq!((flash.stalls.literal, flash.stalls.bus), (FLASH_WAIT_STATES, 1));
    // The words at 28, 28, 32 and 36 need a second line; those from 40 to 52 a third.
    let three = through(FLASH + 24, FLASH + 40);
    assert_eq!(three.stalls.literal, 3 * FLASH_WAIT_STATES);
    assert_eq!(three.cycles.low, sram.cycles.low + 3 * FLASH_WAIT_STATES);
    // The pair at 12 and 16 begins in the line of the word at 8.
    let across = through(FLASH + 4, SRAM);
    assert_eq!(across.stalls.literal, 2 * FLASH_WAIT_STATES);
    // Without registers, all data count as SRAM.
    let program = Program::from_halves(SRAM, &THROUGH_POINTERS);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::ByAddress));
    run(&program, &mut estimator, SRAM, THROUGH_POINTERS.len());
    assert_eq!(estimator.finish().stalls, sram.stalls);
}

#[test]
fn data_go_before_a_prefetch_that_has_not_begun_and_behind_one_that_has() {
    // The first line arrives in cycle 5. The flash is then free, and begins the prefetch of the next line in cycle 6.
    let stalls = |halves: &[u16]| {
        let program = Program::from_halves(FLASH, halves);
        let mut estimator = Estimator::new(&program, Memory::new(Placement::Flash));
        let registers = [FLASH + 4096; 16];
        (0..halves.len() as u32).for_each(|at| estimator.execute_with(FLASH + 2 * at, &registers));
        estimator.finish().stalls.literal
    };
    assert_eq!(stalls(&[LDR_R5_R4]), 1 + FLASH_WAIT_STATES);
    assert_eq!(stalls(&[NOP, LDR_R5_R4]), FLASH_WAIT_STATES, "both want to begin");
    assert_eq!(stalls(&[NOP, NOP, LDR_R5_R4]), 2 * FLASH_WAIT_STATES, "of the prefetch, 5 of 6 cycles are left");
}

#[test]
fn a_prefetched_line_is_cached_always_or_if_it_was_waited_for_or_never() {
    // 16 lines, run a second time. A branch comes before it, as from a loop's end to its start.
    let again = |halves: &[u16]| {
        let program = Program::from_halves(FLASH, halves);
        let reading = |prefetched| Reading { prefetched, ..LIKELY };
        let readings = [Prefetched::Kept, Prefetched::KeptIfWaitedFor, Prefetched::Dropped].map(reading);
        let mut estimator = Estimator::with_readings(&program, Memory::new(Placement::Flash), readings);
        run(&program, &mut estimator, FLASH, halves.len());
        estimator.finish();
        run(&program, &mut estimator, FLASH, halves.len());
        let cycles = estimator.finish().cycles;
        [cycles.low, cycles.likely, cycles.high]
    };
    // Narrow instructions: each line came in time. In the second run it comes in time too.
    let [kept, waited, dropped] = again(&[NOP; 128]);
    assert_eq!((kept, waited), (128, 128));
    assert!(dropped >= 128);
    // Wide ones, four per line: the core waited for each line. If dropped, it waits for each again: 6 cycles per line.
    let [kept, waited, dropped] = again(&ADD_WIDE.repeat(64));
    assert_eq!((kept, waited), (64, 64));
    assert!(dropped.abs_diff(15 * (1 + FLASH_WAIT_STATES) + 4) <= 1 + FLASH_WAIT_STATES, "{dropped}");
}

#[test]
fn a_range_holds_the_likely_cycles_even_where_a_line_that_is_kept_evicts_one_that_is_needed() {
    // A loop of 2 KiB: with least-recently-used replacement, each line is evicted before it is needed again.
    let halves = ADD_WIDE.repeat(512);
    let program = Program::from_halves(FLASH, &halves);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::Flash));
    for _ in 0..4 {
        run(&program, &mut estimator, FLASH, halves.len());
        let cycles = estimator.finish().cycles;
        assert!(cycles.low <= cycles.likely && cycles.likely <= cycles.high, "{cycles:?}");
    }
}

#[test]
fn a_store_does_not_wait_for_flash() {
    let program = Program::from_halves(SRAM, &[STR_R5_R4]);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::ByAddress));
    estimator.execute_with(SRAM, &[0; 16]);
    assert_eq!(estimator.finish().cycles, Range { low: 1, likely: 1, high: 1 });
}

#[test]
fn readings_are_in_order_and_what_is_not_known_is_said() {
    let program = Program::from_halves(SRAM, &[0xde00, NOP]);
    let mut estimator = Estimator::new(&program, Memory::new(Placement::ByAddress));
    run(&program, &mut estimator, SRAM, 2);
    let estimate = estimator.finish();
    assert_eq!((estimate.instructions, estimate.unknown, estimate.cycles.likely), (2, 1, 2));
    assert_eq!(estimator.finish(), Estimate::default(), "nothing since");
}
