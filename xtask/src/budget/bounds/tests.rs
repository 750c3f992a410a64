#![allow(clippy::unwrap_used, reason = "a test that fails should stop there")]

use super::{BadInput, Board, Budget, Fields, Late, around, verdict};
use crate::budget::row::{BudgetRow, Field};

const TARGETS: &str = "rustc = \"rustc 1.95.0\"\n[target]\nflash = 65536\nram_with_stack = 24576\nmasked = 100\n\
    share_scene = \"hard\"\nshare_rate_hz = 4000\nshare_clock_hz = 168000000\nshare_percent = 25\n";

fn row(scene: &str, numbers: &[(Field, u64)]) -> BudgetRow {
    BudgetRow { scene: scene.into(), board: "netduinoplus2".into(), numbers: numbers.iter().copied().collect() }
}

fn blessed(rows: &[BudgetRow]) -> Budget {
    let mut budget = Budget::parse(TARGETS).unwrap();
    budget.bless(rows, "rustc 1.95.0", true);
    budget
}

fn held(budget: &Budget, rows: &[BudgetRow]) -> Vec<String> {
    budget.hold(rows, "rustc 1.95.0", Fields::All)
}

#[test]
fn what_is_blessed_is_kept_and_reads_back() {
    let rows = [row("pick", &[(Field::Flash, 40_000), (Field::Instructions, 1322)]), row("easy", &[(Field::Ram, 0)])];
    let budget = blessed(&rows);
    assert_eq!(held(&budget, &rows), [""; 0]);
    assert_eq!(Budget::parse(&budget.print()).unwrap(), budget);
}

#[test]
fn a_number_that_leaves_its_range_either_way_is_reported_with_row_field_found_and_expected() {
    let budget = blessed(&[row("pick", &[(Field::Flash, 40_000)])]);
    for passes in [39_200, 40_000, 40_800] {
        assert_eq!(held(&budget, &[row("pick", &[(Field::Flash, passes)])]), [""; 0], "{passes}");
    }
    for fails in [39_199, 40_801, 28_000] {
        let expected = format!("pick on netduinoplus2: flash: {fails} bytes found, expected 39200 to 40800");
        assert_eq!(held(&budget, &[row("pick", &[(Field::Flash, fails)])]), [expected]);
    }
}

#[test]
fn another_compiler_may_be_ten_percent_off_and_no_more() {
    let budget = blessed(&[row("pick", &[(Field::Flash, 40_000)])]);
    let held = |flash| budget.hold(&[row("pick", &[(Field::Flash, flash)])], "rustc 1.96.0", Fields::All);
    assert_eq!((held(37_000).len(), held(43_900).len()), (0, 0));
    assert_eq!((held(36_000).len(), held(44_100).len()), (1, 1));
}

#[test]
fn ticks_that_were_alike_must_stay_alike() {
    assert_eq!((around(Field::Ram, 0), around(Field::Ram, 100)), ((0, 0), (98, 102)));
    let budget = blessed(&[row("pick", &[(Field::InstructionsSpread, 0), (Field::Instructions, 1_353)])]);
    let one = |field, value| held(&budget, &[row("pick", &[(Field::InstructionsSpread, 0), (field, value)])]).len();
    assert_eq!([1_352, 1_353, 1_354].map(|value| one(Field::Instructions, value)), [1, 0, 1]);
    let spread = row("pick", &[(Field::InstructionsSpread, 1), (Field::Instructions, 1_353)]);
    assert_eq!(held(&budget, &[spread]).len(), 1);
}

#[test]
fn rows_and_fields_that_are_missing_or_new_are_reported() {
    let budget = blessed(&[row("pick", &[(Field::Flash, 1)]), row("gone", &[(Field::Flash, 1)])]);
    let now = [row("pick", &[(Field::Ram, 5)]), row("new", &[])];
    assert_eq!(
        held(&budget, &now),
        [
            "pick on netduinoplus2: flash: nothing found, expected 0 to 2",
            "pick on netduinoplus2: ram: 5 found, expected a range in the file",
            "new on netduinoplus2: found a firmware, expected a [[row]] of it",
            "gone on netduinoplus2: found no such firmware, expected one",
        ]
    );
    let some = budget.hold(&[row("pick", &[])], "rustc 1.95.0", Fields::Measured);
    assert_eq!(some, [""; 0], "the cheap part does not measure everything");
}

#[test]
fn the_fewest_instructions_leave_room_for_another_compiler_and_for_unlike_ticks() {
    let fewest =
        |numbers: &[(Field, u64)]| blessed(&[row("pick", numbers)]).fewest_instructions("pick", Board::Netduinoplus2);
    // 10 % less.
    assert_eq!(fewest(&[(Field::Instructions, 1_000), (Field::InstructionsSpread, 0)]), Some(900));
    assert_eq!(fewest(&[(Field::Instructions, 1_000), (Field::InstructionsSpread, 500)]), Some(400));
    assert_eq!(fewest(&[(Field::Instructions, 1_000)]), None);
    let budget = blessed(&[row("pick", &[(Field::Instructions, 1_000)])]);
    assert_eq!(budget.range("pick", Board::Netduinoplus2, Field::Instructions), Some((1_000, 1_000)));
    assert_eq!(budget.range("pick", Board::F405Can, Field::Instructions), None);
}

#[test]
fn a_board_may_have_a_target_of_its_own_which_is_kept() {
    let own = format!("{TARGETS}[target.ram_with_stack_of]\nnetduinoplus2 = 100\n");
    let mut budget = Budget::parse(&own).unwrap();
    let mut row = row("pick", &[(Field::Ram, 60), (Field::StackBound, 41)]);
    budget.bless(std::slice::from_ref(&row), "rustc 1.95.0", true);
    assert_eq!(Budget::parse(&budget.print()).unwrap(), budget);
    let expected = "pick on netduinoplus2: ram with stack: 101 bytes found, expected at most 100: a target";
    assert_eq!(held(&budget, std::slice::from_ref(&row)), [expected]);
    // Other boards have the common limit.
    row.board = "odrive-v3".into();
    budget.bless(std::slice::from_ref(&row), "rustc 1.95.0", true);
    assert_eq!(held(&budget, &[row]), [""; 0]);
}

#[test]
fn no_blessing_moves_a_target() {
    let rows = [row(
        "hard",
        &[
            (Field::Flash, 65_537),
            (Field::Ram, 20_000),
            (Field::StackBound, 4_577),
            (Field::Masked, 101),
            (Field::CyclesEstimate, 10_501),
        ],
    )];
    let told = held(&blessed(&rows), &rows);
    assert_eq!(told.len(), 4, "{told:?}");
    assert_eq!(
        told[3],
        "hard on netduinoplus2: cycles_estimate: 10501 cycles, estimated, found, expected at most 10500: a target"
    );
    let within = [row("hard", &[(Field::Flash, 65_536), (Field::Masked, 100), (Field::CyclesEstimate, 10_500)])];
    assert_eq!(held(&blessed(&within), &within), [""; 0]);
}

#[test]
fn a_tick_that_is_later_than_the_mask_is_reported_and_so_is_a_flood_that_met_none() {
    let budget = Budget::parse(TARGETS).unwrap();
    let late = |most| Late { ticks: 1, delayed: 1, most, bytes_to_chip: 1, bytes_from_chip: 1 };
    assert_eq!((budget.hold_late(&late(100)).len(), budget.hold_late(&late(1)).len()), (0, 0));
    assert_eq!((budget.hold_late(&late(101)).len(), budget.hold_late(&late(0)).len()), (1, 1));
}

#[test]
fn a_file_that_cannot_be_is_refused_with_row_and_field() {
    let row = |line: &str| format!("{TARGETS}[[row]]\nscene = \"a\"\nboard = \"b\"\n{line}\n");
    let why = |text: &str| format!("{:#}", Budget::parse(text).unwrap_err());
    assert!(why(&row("flsh = [1, 2]")).starts_with("firmware/budget.toml: a on b: field \"flsh\" is not known"));
    let expected = "firmware/budget.toml: a on b: flash: found [2, 1]; expected the lesser number first";
    assert_eq!(why(&row("flash = [2, 1]")), expected);
    assert!(why(&row("flash = 5")).contains("firmware/budget.toml"));
    assert!(why(&TARGETS.replace("masked", "maskd")).contains("maskd"));
}

#[test]
fn the_verdict_is_an_error_of_its_own_kind_when_anything_is_broken() {
    assert!(verdict(1, &[]).is_ok());
    let why = verdict(1, &["a: b".into()]).unwrap_err();
    assert!(why.downcast_ref::<BadInput>().is_some() && why.to_string().contains("a: b"));
}
