//! Checks of pages for users of a board against the board files and the project's claims.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Folders with pages and comments about things that have not been measured, in which a reader would look for a claim.
const FOLDERS: [&str; 14] = [
    "docs",
    "firmware/src",
    "link/joint-io/src",
    "link/session/src",
    "host-sim/src",
    "host-sim/sim/src",
    "host-sim/board/src",
    "host-sim/studies/src",
    "xtask/src",
    "xtask/image/src",
    "bench/src",
    "robots",
    "scenes",
    "dynamics-core/src",
];

/// The checklist names the claiming files, so its own text is not a claim.
const CHECKLIST: &str = "docs/hardware-checklist.md";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

fn text(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Markdown and Rust files under a folder, as paths relative to the project's folder.
fn files(folder: &Path, found: &mut Vec<String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md" || extension == "rs") {
            found.push(path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned());
        }
    }
}

/// True if a text states that something is unmeasured. The statement may be broken across lines, and each comment line has its marker.
fn says_so(text: &str) -> bool {
    let words =
        text.lines().map(|line| line.trim_start().trim_start_matches(['/', '!', '#'])).collect::<Vec<_>>().join(" ");
    let words = words.split_whitespace().collect::<Vec<_>>().join(" ");
    ["on silicon", "no silicon", "with silicon", "on a board is still to be measured"]
        .iter()
        .any(|claim| words.contains(claim))
}

#[test]
fn every_file_that_says_it_was_not_on_silicon_is_in_the_checklist() {
    let mut all = Vec::new();
    FOLDERS.iter().for_each(|folder| files(&root().join(folder), &mut all));
    let claiming: BTreeSet<_> = all.into_iter().filter(|file| file != CHECKLIST && says_so(&text(file))).collect();
    assert!(claiming.contains("docs/performance.md"), "{claiming:?}");
    let checklist = text(CHECKLIST);
    let missing: Vec<_> = claiming.iter().filter(|file| !checklist.contains(&format!("`{file}`"))).collect();
    assert!(missing.is_empty(), "{CHECKLIST} names none of {missing:?}");
}

#[test]
fn every_file_that_the_checklist_names_is_there() {
    let checklist = text(CHECKLIST);
    let named: Vec<_> =
        checklist.split('`').skip(1).step_by(2).filter(|word| word.contains('/') && !word.contains(' ')).collect();
    assert!(named.len() > 10, "{named:?}");
    for file in named {
        assert!(root().join(file).exists(), "{CHECKLIST} names {file}");
    }
}

#[test]
fn every_row_of_the_checklist_has_five_cells_and_a_state() {
    let rows: Vec<_> = text(CHECKLIST).lines().filter(|line| line.starts_with("| [")).map(str::to_owned).collect();
    assert!(rows.len() > 30, "{}", rows.len());
    for row in rows {
        let cells: Vec<_> = row.trim_matches('|').split(" | ").map(str::trim).collect();
        assert_eq!(cells.len(), 5, "{row}");
        assert!(cells.iter().all(|cell| !cell.is_empty()), "{row}");
        let open = cells[0] == "[ ]";
        assert_eq!(open, cells[4] == "open", "{row}");
        assert!(open || cells[0] == "[x]", "{row}");
    }
}

/// The pins that a text names, such as `PA2` and `PB10`.
fn pins(text: &str) -> BTreeSet<String> {
    let words = text.split(|character: char| !character.is_ascii_alphanumeric());
    let is_pin = |word: &&str| {
        let number = word.strip_prefix('P').and_then(|rest| rest.strip_prefix(['A', 'B', 'C', 'D']));
        number.is_some_and(|number| number.parse::<u8>().is_ok_and(|number| number < 16))
    };
    words.filter(is_pin).map(str::to_owned).collect()
}

/// The rows of the first table of a text.
fn first_table(text: &str) -> String {
    let lines = text.lines().skip_while(|line| !line.starts_with('|')).take_while(|line| line.starts_with('|'));
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn the_wiring_tables_have_the_pins_of_the_board_files() {
    let page = text("docs/flash.md");
    for (board, file) in
        [("odrive-v3", "odrive_v3"), ("f405-can", "f405_can"), ("f405-pwm", "f405_pwm"), ("g474-fdcan", "g474_fdcan")]
    {
        let source = text(&format!("firmware/src/boards/{file}.rs"));
        let head: String =
            source.lines().filter_map(|line| line.strip_prefix("//! ")).map(|line| format!("{line}\n")).collect();
        let section = page.split(&format!("### `{board}`")).nth(1).unwrap_or_else(|| panic!("no section for {board}"));
        let (ours, theirs) = (pins(&first_table(section)), pins(&first_table(&head)));
        assert!(theirs.len() > 3, "{theirs:?}");
        assert_eq!(ours, theirs, "docs/flash.md against firmware/src/boards/{file}.rs");
    }
}

#[test]
fn claims_are_found_across_broken_lines_and_comments() {
    assert!(says_so("//! compiled; **not yet run on\n//! silicon**."));
    assert!(says_so("Nothing has been measured on silicon."));
    assert!(!says_so("measured in the emulator"));
}

/// Pages of prose: the README and the hand-written pages of `docs`, without the decision records.
fn prose() -> Vec<String> {
    let mut pages = Vec::new();
    files(&root().join("docs"), &mut pages);
    pages.retain(|page| !page.starts_with("docs/measured/") && !page.starts_with("docs/decisions/"));
    pages.push("README.md".to_owned());
    pages
}

#[test]
fn what_commands_write_stands_in_its_folder_alone() {
    for page in prose().iter().filter(|page| *page != "README.md") {
        assert!(!text(page).contains("<!-- measured: "), "{page}");
    }
}

#[test]
fn every_page_has_the_protocol_s_version() {
    let source = text("link/src/lib.rs");
    let version =
        source.split("pub const PROTOCOL_VERSION: u8 = ").nth(1).and_then(|rest| rest.split(';').next()).unwrap();
    let mut found = 0;
    for page in prose() {
        let lower = text(&page).to_lowercase();
        for number in
            lower.split("protocol version ").skip(1).filter_map(|rest| rest.split(|c: char| !c.is_ascii_digit()).next())
        {
            assert!(
                number.is_empty() || number == version,
                "{page}: protocol version {number}, link/src/lib.rs has {version}"
            );
            found += usize::from(!number.is_empty());
        }
    }
    assert!(found >= 2, "{found}");
}

/// Rows of the table between the markers of `budget`; each maps column titles to cells.
fn budget_rows(page: &str) -> Vec<BTreeMap<String, String>> {
    let text = text(page);
    let block = text.split("<!-- measured: budget -->").nth(1).unwrap_or_else(|| panic!("{page}"));
    let table = first_table(block);
    let cells = |line: &str| line.trim_matches('|').split('|').map(|cell| cell.trim().to_owned()).collect::<Vec<_>>();
    let head = cells(table.lines().next().unwrap());
    table.lines().skip(2).map(|line| head.iter().cloned().zip(cells(line)).collect()).collect()
}

#[test]
fn the_readme_s_rows_of_the_budget_are_those_that_were_measured() {
    let measured = budget_rows("docs/measured/budget.md");
    let shown = budget_rows("README.md");
    assert_eq!(shown.len(), 3);
    for row in shown {
        let same = |other: &BTreeMap<_, _>| row.iter().all(|(column, cell)| other.get(column) == Some(cell));
        assert!(measured.iter().any(same), "docs/measured/budget.md has no row {row:?}");
    }
}

/// Numbers of a text that have a thousands separator.
fn thousands(text: &str) -> BTreeSet<&str> {
    let words = text.split(|c: char| !(c.is_ascii_digit() || c == ',')).map(|word| word.trim_matches(','));
    words.filter(|word| word.contains(',') && word.split(',').skip(1).all(|group| group.len() == 3)).collect()
}

#[test]
fn no_page_of_prose_has_a_measured_count_of_instructions_or_cycles_typed_by_hand() {
    let measured: Vec<_> = ["budget", "cycles", "kernels"].map(|page| text(&format!("docs/measured/{page}.md"))).into();
    let counts: BTreeSet<&str> = measured
        .iter()
        .flat_map(|page| page.lines().filter(|line| line.starts_with('|')).flat_map(thousands))
        .collect();
    assert!(counts.len() > 100, "{counts:?}");
    for page in prose().iter().filter(|page| *page != "README.md") {
        let typed: Vec<_> = text(page)
            .lines()
            .filter(|line| line.contains("instruction") || line.contains("cycle"))
            .flat_map(thousands)
            .filter(|number| counts.contains(number))
            .map(str::to_owned)
            .collect();
        assert!(typed.is_empty(), "{page}: {typed:?} of docs/measured, which a command writes");
    }
}

#[test]
fn the_decision_table_leads_to_a_page_for_each_control_law() {
    let source = text("dynamics-core/src/control/law.rs");
    let laws = source.split("\nlaws! {").nth(1).and_then(|rest| rest.split("\nimpl ControlLaw").next()).unwrap();
    // A name contains no space; all other texts do.
    let laws: Vec<_> = laws.split('"').skip(1).step_by(2).filter(|word| !word.contains(' ')).collect();
    assert_eq!(laws.len(), 8, "{laws:?}");
    let page = text("docs/control/README.md");
    let missing: Vec<_> = laws.iter().filter(|law| !page.contains(&format!("[`{law}`]("))).collect();
    assert!(missing.is_empty(), "docs/control/README.md has no link for {missing:?}");
}

/// The anchor of a heading in links.
fn anchor(heading: &str) -> String {
    let kept = heading
        .to_lowercase()
        .chars()
        .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
        .collect::<String>();
    kept.trim().replace(' ', "-")
}

#[test]
fn every_link_of_a_page_leads_somewhere() {
    let mut pages: Vec<_> = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"].map(str::to_owned).into();
    ["docs", "robots", "scenes"].iter().for_each(|folder| files(&root().join(folder), &mut pages));
    let mut broken = Vec::new();
    for page in &pages {
        let here = root().join(page);
        let text = text(page);
        for link in text.split("](").skip(1).filter_map(|rest| rest.split([')', ' ']).next()) {
            let (path, heading) = link.split_once('#').unwrap_or((link, ""));
            let target = if path.is_empty() { here.clone() } else { here.parent().unwrap().join(path) };
            let found = link.contains("://")
                || target.exists()
                    && (heading.is_empty()
                        || std::fs::read_to_string(&target)
                            .unwrap()
                            .lines()
                            .any(|line| line.starts_with('#') && anchor(line.trim_start_matches('#')) == heading));
            if !found {
                broken.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}
