//! The report in light and in dark, in a real browser.

use crate::browser::{Browser, WEBGL};
use crate::pages::WINDOWS;
use crate::report_page::{READY, run, scene, write};
use serde_json::json;
use sim::run::report::page;

/// Texts with too little contrast to their background, by the rule of WCAG 2 for small text (4.5).
const FAINT_TEXTS: &str = "(() => { \
    const light = (c) => { const [r, g, b] = c.map((x) => x / 255).map((x) => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4); \
        return 0.2126 * r + 0.7152 * g + 0.0722 * b; }; \
    const parts = (colour) => colour.match(/[\\d.]+/g).map(Number); \
    const ground = (of) => { for (; of; of = of.parentElement) { const c = parts(getComputedStyle(of).backgroundColor); \
        if (c.length < 4 || c[3] === 1) return c; } return [255, 255, 255]; }; \
    return [...document.querySelectorAll('body *')].filter((of) => of.checkVisibility() \
        && [...of.childNodes].some((node) => node.nodeType === 3 && node.textContent.trim())).flatMap((of) => { \
        const style = getComputedStyle(of); const ink = parts(of.closest('svg') ? style.fill : style.color); \
        const [a, b] = [light(ink.slice(0, 3)), light(ground(of.closest('svg') ?? of).slice(0, 3))]; \
        const contrast = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05); \
        return contrast < 4.5 ? [`${of.tagName} ${of.className} ${of.textContent.trim().slice(0, 30)}: ${contrast.toFixed(2)}`] : []; }); })()";

#[test]
fn a_report_can_be_read_in_light_and_in_dark() {
    let Some(mut browser) = Browser::start("dark", WEBGL) else { return };
    let scene = scene("puma560_collision.toml");
    let file = write("dark", &page(&run(&scene), &scene).unwrap().html());
    let mut grounds = Vec::new();
    for dark in [false, true] {
        browser.prefer_dark(dark);
        for (width, height) in WINDOWS {
            browser.open(&file, width, height);
            browser.until(READY);
            assert!(browser.beyond() <= 0.0, "{width}, dark: {dark}");
            assert_eq!(browser.value(FAINT_TEXTS), json!([]), "{width}, dark: {dark}");
        }
        grounds.push(browser.value("getComputedStyle(document.body).backgroundColor"));
    }
    assert_ne!(grounds[0], grounds[1]);
    assert_eq!(browser.complaints(), [""; 0]);
}
