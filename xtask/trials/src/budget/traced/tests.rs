#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{BYTE, SERVE, Served, Step, TICK, TICKS_BEFORE, TraceFindings, TraceWatch};
use chip_image::Program;
use chip_image::cycles::steps::Event;

/// Eight instructions: `nop`, except `cpsid i` as the third and `cpsie i` as the sixth.
const HALVES: [u16; 8] = [0xbf00, 0xbf00, 0xb672, 0xbf00, 0xbf00, 0xb662, 0xbf00, 0xbf00];

fn watched(exceptions: &[(u16, u32)]) -> TraceFindings {
    let program = Program::from_halves(0, &HALVES);
    let mut watch = TraceWatch::new(&program);
    for (exception, priority) in [(BYTE, 0xd0), (TICK, 0xe0), (SERVE, 0xf0)] {
        watch.event(Event::Priority { exception, priority });
    }
    for (exception, address) in exceptions {
        watch.event(Event::Step(Step { address: *address, exception: *exception, ..Step::default() }));
    }
    watch.found
}

fn straight(exception: u16) -> Vec<(u16, u32)> {
    (0..8).map(|at| (exception, 2 * at)).collect()
}

#[test]
fn a_mask_counts_from_behind_the_instruction_that_sets_it_to_the_one_that_clears_it() {
    assert_eq!(watched(&straight(SERVE)).masked, 3);
}

#[test]
fn what_is_no_less_urgent_than_the_tick_and_what_is_no_interrupt_is_not_masked_time() {
    for exception in [TICK, BYTE, 0] {
        assert_eq!(watched(&straight(exception)).masked, 0, "{exception}");
    }
    // A byte in the middle of a masked stretch; the stretch continues after it.
    let mut steps = straight(SERVE);
    steps.splice(4..4, [(BYTE, 0), (BYTE, 2)]);
    assert_eq!(watched(&steps).masked, 3);
}

#[test]
fn a_tick_that_a_byte_interrupts_is_one_tick_without_the_bytes_cycles() {
    let mut whole = straight(TICK);
    whole.push((SERVE, 0));
    let mut cut = straight(TICK);
    cut.splice(4..4, [(BYTE, 12), (BYTE, 14)]);
    cut.push((SERVE, 0));
    let [whole, cut] = [whole, cut].map(|steps| watched(&steps));
    assert_eq!((whole.estimates.len(), cut.estimates.len()), (1, 1));
    assert_eq!((whole.estimates[0].instructions, cut.estimates[0].instructions), (8, 8));
    assert_eq!((cut.tick.times, cut.tick.most, cut.byte.total), (1, 8, 2));
}

#[test]
fn a_trace_that_lacks_a_tick_or_a_byte_is_refused() {
    let ticks = |count: u64| {
        let mut steps: Vec<_> = (0..count).flat_map(|_| [straight(TICK), vec![(SERVE, 0)]].concat()).collect();
        steps.extend([(SERVE, 2), (BYTE, 0)]);
        watched(&steps)
    };
    // Homing's ticks and the one with empty caches are left out, so one tick after them is enough.
    let needed = TICKS_BEFORE as u64 + 2;
    let found = ticks(needed);
    let all = found.byte.total + found.serve.total;
    assert_eq!(found.clone().sum_up(1, 3, needed).unwrap().link_byte, all.div_ceil(4));
    for (bytes, count, what) in [(1, needed + 1, "ticks"), (2, needed, "2 received bytes")] {
        let why = found.clone().sum_up(bytes, 3, count).unwrap_err().to_string();
        assert!(why.contains(what), "{why}");
    }
    let short = ticks(needed - 1);
    assert!(short.sum_up(1, 3, needed - 1).is_err(), "no tick is left over behind those that are left out");
}

#[test]
fn the_longest_of_a_handlers_runs_counts() {
    let mut served = Served::default();
    for address in [8, 10, 8, 10, 12, 8] {
        served.step(&Step { address, ..Step::default() });
    }
    assert_eq!((served.times, served.most, served.total), (3, 3, 6));
}
