//! The sheet under the panels: its title, its legend, its colours.

use super::PlotError;
use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, IntoDrawingArea, PathElement, RGBColor, SVGBackend, ShapeStyle, Text, WHITE};
use std::path::Path;

pub(super) const BLUE: RGBColor = RGBColor(0x1f, 0x4e, 0x9c);
pub(super) const ORANGE: RGBColor = RGBColor(0xf0, 0x8c, 0x1e);
pub(super) const GREEN: RGBColor = RGBColor(0x2e, 0x8b, 0x57);
pub(super) const GREY: RGBColor = RGBColor(0x8a, 0x8a, 0x8a);

pub(super) const WIDTH: u32 = 1000;
const PANEL: u32 = 240;
const TITLE: u32 = 40;
/// Width of a legend entry.
const LEGEND: i32 = 110;

/// Draw a file with a head and `count` panels. `panel` draws each; each is `taller` times as high as a panel of curves.
pub(super) fn on_page(
    path: &Path,
    title: &str,
    legend: &[(&str, ShapeStyle)],
    count: usize,
    taller: usize,
    panel: impl Fn(usize, &DrawingArea<SVGBackend<'_>, Shift>) -> Result<(), PlotError>,
) -> Result<(), PlotError> {
    let height = TITLE + PANEL * u32::try_from(count * taller)?;
    let area = SVGBackend::new(path, (WIDTH, height)).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, body) = area.split_vertically(TITLE);
    draw_head(&head, WIDTH, title, legend)?;
    for (index, area) in body.split_evenly((count, 1)).iter().enumerate() {
        panel(index, area)?;
    }
    area.present()?;
    Ok(())
}

/// Size of a sheet.
const SHEET: (u32, u32) = (1600, 900);

/// Draw a file that is wider than high, with a head and `count` cells in rows. `cell` draws each, and is told whether no other one stands
/// below it.
pub(super) fn on_sheet(
    path: &Path,
    title: &str,
    legend: &[(&str, ShapeStyle)],
    count: usize,
    cell: impl Fn(usize, &DrawingArea<SVGBackend<'_>, Shift>, bool) -> Result<(), PlotError>,
) -> Result<(), PlotError> {
    let columns = match count {
        0 | 1 => 1,
        2..=4 => 2,
        _ => 3,
    };
    let rows = count.div_ceil(columns).max(1);
    let area = SVGBackend::new(path, SHEET).into_drawing_area();
    area.fill(&WHITE)?;
    let (head, body) = area.split_vertically(TITLE);
    draw_head(&head, SHEET.0, title, legend)?;
    for (index, area) in body.split_evenly((rows, columns)).iter().take(count).enumerate() {
        cell(index, area, index + columns >= count)?;
    }
    area.present()?;
    Ok(())
}

/// Draw the title on the left and the legend on the right. The legend holds for all panels and covers no curve here.
fn draw_head(
    head: &DrawingArea<SVGBackend<'_>, Shift>,
    width: u32,
    title: &str,
    legend: &[(&str, ShapeStyle)],
) -> Result<(), PlotError> {
    head.draw(&Text::new(title.to_owned(), (12, 10), ("sans-serif", 22)))?;
    for (index, (name, style)) in legend.iter().rev().enumerate() {
        let x = i32::try_from(width)? - 20 - LEGEND * (1 + i32::try_from(index)?);
        head.draw(&PathElement::new([(x, 22), (x + 26, 22)], *style))?;
        head.draw(&Text::new((*name).to_owned(), (x + 34, 15), ("sans-serif", 15)))?;
    }
    Ok(())
}
