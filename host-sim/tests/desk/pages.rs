//! Pages of studies in a real browser: they load, fit into their window, can be read there, and show the numbers of the files.

use crate::browser::{Browser, FLAT};
use crate::trade;
use report::{Block, Page};
use robot_compiler::scene::ScalarChoice;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Window sizes of a desktop, a tablet and a phone, pixels.
pub(crate) const WINDOWS: [(u32, u32); 3] = [(1280, 800), (820, 1180), (390, 844)];

/// Smallest size of letters in a figure, pixels.
const LETTERS_MIN: f64 = 8.0;

/// Labels of figures that are cut off, overlap another one, or are smaller than this.
const UNREADABLE: &str = "((least) => [...document.querySelectorAll('figure svg')].flatMap((svg) => { \
    const frame = svg.getBoundingClientRect(); const scale = frame.width / svg.viewBox.baseVal.width; \
    const labels = [...svg.querySelectorAll('text')].map((text) => [text.textContent, text.getBoundingClientRect(), text]); \
    return labels.flatMap(([name, box, text], place) => [ \
        ...(box.left < frame.left - 0.5 || box.right > frame.right + 0.5 || box.top < frame.top - 0.5 || box.bottom > frame.bottom + 0.5 ? [`${name} is cut off`] : []), \
        ...(parseFloat(getComputedStyle(text).fontSize) * scale < least ? [`${name} is too small`] : []), \
        ...labels.slice(0, place).filter(([, other]) => box.left < other.right && other.left < box.right \
            && box.top < other.bottom && other.top < box.bottom).map(([other]) => `${name} lies on ${other}`), \
    ]); }))";

/// Opens a page in a window. With all its lists open it fits into the window, and its figures can be read.
pub(crate) fn open(browser: &mut Browser, page: &Path, (width, height): (u32, u32)) {
    browser.open(page, width, height);
    browser.value("document.querySelectorAll('details').forEach((list) => { list.open = true; })");
    let beyond = browser.beyond();
    assert!(beyond <= 0.0, "{} reaches {beyond} pixels beyond {width}", page.display());
    assert_eq!(browser.value(&format!("{UNREADABLE}({LETTERS_MIN})")), json!([]), "{} at {width}", page.display());
}

/// Rows of the table with this caption: the text of each cell, and its exact number, if it has one.
pub(crate) fn rows(browser: &mut Browser, caption: &str) -> Vec<Vec<(String, Option<f64>)>> {
    let found = browser.value(&format!(
        "[...[...document.querySelectorAll('table')].find((table) => table.caption.textContent === {}).tBodies[0].rows].map((row) => \
         [...row.cells].map((cell) => [cell.textContent, cell.dataset.exact === undefined ? null : Number(cell.dataset.exact)]))",
        json!(caption)
    ));
    let cell = |cell: &Value| (cell[0].as_str().unwrap().to_owned(), cell[1].as_f64());
    let row = |row: &Value| row.as_array().unwrap().iter().map(cell).collect();
    found.as_array().unwrap().iter().map(row).collect()
}

/// Commands that the cells of a table copy, each reached with the keyboard.
pub(crate) fn handed_over(browser: &mut Browser, caption: &str) -> Vec<String> {
    let found = browser.value(&format!(
        "[...[...document.querySelectorAll('table')].find((table) => table.caption.textContent === {}) \
         .querySelectorAll('[data-command]')].map((cell) => {{ document.activeElement.blur(); cell.focus(); \
         return document.activeElement.dataset.command ?? null; }})",
        json!(caption)
    ));
    found.as_array().unwrap().iter().map(|command| command.as_str().unwrap().to_owned()).collect()
}

fn written(name: &str, page: &Page) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("page_{name}.html"));
    std::fs::write(&path, page.html()).unwrap();
    path
}

#[test]
fn what_reaches_beyond_its_window_is_seen_on_a_desk_and_on_a_phone() {
    let Some(mut browser) = Browser::start("wide", FLAT) else { return };
    let page = Page { title: "wide".to_owned(), lead: Vec::new(), blocks: Vec::new() };
    let path = written("wide", &page);
    let html = page.html().replace("<main>", "<main><div style=\"width: 1500px\">wide</div>");
    std::fs::write(&path, html).unwrap();
    for (width, height) in WINDOWS {
        browser.open(&path, width, height);
        let beyond = browser.beyond();
        assert!(beyond > 1500.0 - f64::from(width), "{beyond} at {width}");
    }
}

#[test]
fn words_without_a_blank_stay_inside() {
    let Some(mut browser) = Browser::start("words", FLAT) else { return };
    let long = || "what_a_heavier_payload_and_a_late_torque_do_to_tracking_of_every_joint".repeat(3);
    let page = Page {
        title: long(),
        lead: vec![long()],
        blocks: vec![
            Block::Heading(long()),
            Block::Words(long()),
            Block::List(vec![long()]),
            Block::Facts(vec![("name".to_owned(), long())]),
            Block::Terminal(long()),
            Block::Table(report::Table::new(long(), &[&long()])),
            Block::Figure(report::Figure::new(long(), "x", "y")),
        ],
    };
    for window in WINDOWS {
        open(&mut browser, &written("words", &page), window);
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_trade_shows_the_front_of_its_table_and_hands_over_the_command_of_a_point() {
    let Some(mut browser) = Browser::start("trade", FLAT) else { return };
    let folder = trade::folder("page");
    let scene = trade::shipped("scenes/planar2r_swing.toml");
    let (found, _) = trade::measured_where(&scene, &folder, true, |choice| choice.scalar == ScalarChoice::F32);
    found.write_csv(&folder.join("trade.csv")).unwrap();
    let table: Vec<csv::StringRecord> =
        csv::Reader::from_path(folder.join("trade.csv")).unwrap().records().map(Result::unwrap).collect();
    // Columns of the table: eight for the choice, then instructions and cycles; fronts and command are at the end.
    let front: Vec<_> = table.iter().filter(|row| [3, 2].iter().any(|at| &row[row.len() - at] == "true")).collect();
    assert!(front.len() > 1 && front.len() < table.len(), "{} of {}", front.len(), table.len());
    let page = written("trade", &found.page());
    for window in WINDOWS {
        open(&mut browser, &page, window);
        let shown = rows(&mut browser, "Choices that nothing beats");
        assert_eq!(shown.len(), front.len());
        for (shown, row) in shown.iter().zip(&front) {
            let texts: Vec<&str> = shown.iter().map(|(text, _)| text.as_str()).collect();
            let cycles = format!("{:.0}", row[10].parse::<f64>().unwrap());
            // Here terms and kernel vary; they are before instructions and cycles.
            assert_eq!(texts[..2], [&row[2], &row[6]]);
            assert_eq!((texts[3], *texts.last().unwrap()), (cycles.as_str(), &row[row.len() - 1]));
        }
        let command = browser.value("document.querySelector('[data-command]').dataset.command");
        let command = command.as_str().unwrap();
        assert!(table.iter().any(|row| &row[row.len() - 1] == command), "{command}");
        browser.value("document.querySelector('[data-command]').focus()");
        let said = browser.value("document.activeElement.querySelector('title').textContent");
        assert!(said.as_str().unwrap().ends_with(command), "{said}");
        browser.press("Enter");
        browser.until(&format!("document.querySelector('.note')?.textContent.includes({}) === true", json!(command)));
        assert!(browser.beyond() <= 0.0, "the note reaches beyond its window");
    }
    assert_eq!(browser.complaints(), [""; 0]);
    std::fs::remove_dir_all(&folder).unwrap();
}
