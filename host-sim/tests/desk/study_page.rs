//! Figures and tables of studies in a real browser.

use crate::browser::{Browser, FLAT};
use crate::report_page::write;
use report::{Block, Cell, Figure, Page, Point, Scale, Series, Table};

#[test]
fn a_point_of_a_study_hands_over_the_command_that_repeats_it() {
    let Some(mut browser) = Browser::start("study", FLAT) else { return };
    let point = Point::at(100.0, 1e-3).named("best").told("newtau choose trade a.toml --scalar f32");
    let figure = Figure::new("cost", "cycles", "error")
        .scaled(Scale::Log, Scale::Log)
        .with(Series::steps("front", vec![point, Point::at(1000.0, 1e-5)]));
    let page = Page { title: "study".to_owned(), lead: vec!["Fine.".to_owned()], blocks: vec![Block::Figure(figure)] };
    for width in [1280, 390] {
        browser.open(&write("study", &page.html()), width, 800);
        assert!(browser.beyond() <= 0.0);
        browser.value("document.querySelector('[data-command]').focus()");
        browser.press("Enter");
        browser.until(
            "document.querySelector('.note')?.textContent.includes('newtau choose trade a.toml --scalar f32') === true",
        );
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn the_text_of_a_figure_can_be_read_on_a_phone_and_the_page_does_not_scroll_sideways() {
    let Some(mut browser) = Browser::start("text", FLAT) else { return };
    let figure = Figure::new("cost", "cycles", "error").with(Series::line("l", [(0.0, 0.0), (1.0, 1.0)]));
    let page = Page { title: "study".to_owned(), lead: Vec::new(), blocks: vec![Block::Figure(figure)] };
    for width in [1280, 390] {
        browser.open(&write("text", &page.html()), width, 800);
        let wide = browser.beyond();
        let height = "Math.min(...[...document.querySelectorAll('figure text')].map((text) => \
                      parseFloat(getComputedStyle(text).fontSize) * Math.hypot(text.getScreenCTM().a, text.getScreenCTM().b)))";
        let height = browser.value(height).as_f64().unwrap();
        assert!(wide <= 0.0 && (9.0..20.0).contains(&height), "{width}: {wide} too wide, text of {height} pixels");
    }
    assert_eq!(browser.complaints(), [""; 0]);
}

#[test]
fn a_verdict_behind_sentences_is_in_sight_and_rows_keep_their_names_where_a_table_scrolls() {
    let Some(mut browser) = Browser::start("table", FLAT) else { return };
    let mut table = Table::new("cells", &["cell", "what is done", "expected", "found", "verdict"]);
    for k in 0..3 {
        let done =
            "every joint is given a mass of nothing at all, and held so for a minute in each of a thousand postures";
        let expected =
            "no torque beyond its limit, and no joint farther from its place than the resolution of its encoder";
        table.row(vec![
            format!("joint {k}").into(),
            done.into(),
            expected.into(),
            Cell::number("12.3 mrad", 0.0123),
            "pass".into(),
        ]);
    }
    let page = Page { title: "study".to_owned(), lead: Vec::new(), blocks: vec![Block::Table(table)] };
    let file = write("table", &page.html());
    browser.open(&file, 1280, 800);
    let room = "document.querySelector('.table').scrollWidth - document.querySelector('.table').clientWidth";
    assert!(browser.value(room).as_f64().unwrap() <= 0.0, "the verdict is in sight");
    browser.open(&file, 390, 800);
    let off = "(() => { const box = document.querySelector('.table'); box.scrollLeft = 100; \
               const left = (of) => of.getBoundingClientRect().left; \
               return box.scrollLeft > 50 ? Math.abs(left(box.querySelector('tbody th')) - left(box)) : 99; })()";
    assert!(browser.value(off).as_f64().unwrap() < 2.0, "names stay where the table scrolls");
    assert!(browser.beyond() <= 0.0);
    assert_eq!(browser.complaints(), [""; 0]);
}
