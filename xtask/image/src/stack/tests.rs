#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{Graph, Node, Program, Taken};

fn graph(nodes: &[(u32, u64, &[u32])]) -> Graph {
    let node =
        |(at, frame, calls): &(u32, u64, &[u32])| (*at, Node { frame: *frame, calls: calls.iter().copied().collect() });
    Graph { nodes: nodes.iter().map(node).collect(), ..Graph::default() }
}

#[test]
fn the_deepest_way_counts_and_not_the_longest() {
    let mut graph = graph(&[(1, 8, &[2, 3]), (2, 16, &[4]), (3, 100, &[]), (4, 24, &[])]);
    assert_eq!([1, 2, 3, 4].map(|at| graph.depth(at)), [108, 40, 100, 24]);
    assert!(graph.nodes.keys().all(|at| !graph.reached(*at).contains(at)));
}

#[test]
fn a_circle_counts_each_of_its_functions_once_and_is_seen() {
    let mut graph = graph(&[(1, 8, &[2]), (2, 16, &[3]), (3, 32, &[2, 4]), (4, 64, &[4])]);
    assert_eq!(graph.depth(1), 8 + 16 + 32 + 64);
    assert_eq!(graph.depth(3), 16 + 32 + 64);
    let seen: Vec<u32> = graph.nodes.keys().copied().filter(|at| graph.reached(*at).contains(at)).collect();
    assert_eq!(seen, [2, 3, 4]);
}

#[test]
fn what_is_taken_off_the_stack_pointer_is_added_up_in_every_encoding() {
    let taken = |code: &[u16]| Program::from_halves(0, code).taken(0..2 * code.len() as u32);
    for (code, expected) in [
        (&[0xb5f0][..], 20),                      // push {r4, r5, r6, r7, lr}
        (&[0xe92d, 0x4ff0], 36),                  // push.w {r4-r11, lr}
        (&[0xf84d, 0xbd04], 4),                   // str r11, [sp, #-4]!
        (&[0xe96d, 0x4504], 16),                  // strd r4, r5, [sp, #-16]!
        (&[0xed2d, 0x8b10], 64),                  // vpush {d8-d15}
        (&[0xed6d, 0x8a01], 4),                   // vpush {s17}
        (&[0xb0a4], 144),                         // sub sp, #144
        (&[0xf5ad, 0x7d12], 584),                 // sub.w sp, sp, #584
        (&[0xf1ad, 0x0d08], 8),                   // sub.w sp, sp, #8
        (&[0xf2ad, 0x4d04], 1028),                // subw sp, sp, #1028
        (&[0xb5f0, 0xb0a4, 0xb024, 0xbdf0], 164), // push, sub, add, pop
    ] {
        assert_eq!(taken(code), Taken { bytes: expected, unknown: false }, "{code:x?}");
    }
    // add sp, #144; pop; sub.w r4, sp, #8; str r0, [sp, #4]; ldr r11, [sp], #4.
    let nothing = [0xb024, 0xbdf0, 0xf1ad, 0x0408, 0x9001, 0xf85d, 0xbb04];
    assert_eq!(taken(&nothing), Taken::default());
    // sub.w sp, sp, r0; mov sp, r4; msr msp, r0.
    for code in [&[0xebad, 0x0d00][..], &[0x46a5], &[0xf380, 0x8808]] {
        assert_eq!(taken(code), Taken { bytes: 0, unknown: true }, "{code:x?}");
    }
}

/// A start, a `main` that masks interrupts, a function that unmasks them, and the functions that it calls before (144 bytes) and after (36 bytes).
fn started(main: [u16; 6], opener: [u16; 8]) -> Program {
    let code: Vec<u16> = [
        &[0xf000, 0xf802, 0xe7fe, 0xbf00][..], // 0: bl 8; b .
        &main,                                 // 8: frame 8
        &opener,                               // 20: frame 24
        &[0xb0a4, 0xb024, 0x4770, 0xbf00],     // 36: sub sp, #144; add sp, #144; bx lr
        &[0xe92d, 0x4ff0, 0xe8bd, 0x8ff0],     // 44: push.w {r4-r11, lr}; pop.w
    ]
    .concat();
    let mut program = Program::from_halves(0, &code);
    for (at, size) in [(0, 8), (8, 12), (20, 16), (36, 8), (44, 8)] {
        program.functions.insert(at, (format!("at {at}"), size));
    }
    program.vectors = vec![0x2000_0400, 1, 0, 0, 45];
    program
}

/// push {r7, lr}; cpsid i; bl 20; b . and nop.
const MAIN: [u16; 6] = [0xb580, 0xb672, 0xf000, 0xf802, 0xe7fe, 0xbf00];
/// push {r4, lr}; sub sp, #16; bl 36; cpsie i; bl 44; b to the end.
const OPENER: [u16; 8] = [0xb510, 0xb084, 0xf000, 0xf804, 0xb662, 0xf000, 0xf805, 0xbd10];

#[test]
fn handlers_lie_on_what_the_start_has_left_when_interrupts_are_unmasked() {
    let bound = |main, opener| {
        let stack = started(main, opener).stack().unwrap();
        (stack.entries[0].bytes, stack.open, stack.bytes())
    };
    let handler = super::EXCEPTION_FRAME + 36;
    // Main uses 8 and the opener 24 bytes; the opener's calls use 144 before unmasking, 36 after.
    assert_eq!(bound(MAIN, OPENER), (176, 68, 68 + handler));
    // A jump from after to the call before: bl 36 runs again, now with interrupts.
    let mut again = OPENER;
    again[7] = 0xe7f9;
    assert_eq!(bound(MAIN, again), (176, 176, 176 + handler));
    // If nothing masks or nothing unmasks, the whole depth counts.
    let mut main = MAIN;
    main[1] = 0xbf00;
    assert_eq!(bound(main, OPENER), (176, 176, 176 + handler));
    let mut opener = OPENER;
    opener[4] = 0xbf00;
    assert_eq!(bound(MAIN, opener), (176, 176, 176 + handler));
}
