//! Figures as one SVG file, for a page that can show a picture but holds no HTML.

use super::{COLOURS, Figure, Kind, SIZE, class};
use crate::escape::html;
use std::fmt::Write as _;

/// Height above a drawing, for caption and legend, pixels.
const HEAD: f64 = 56.0;
/// Margin around each panel, pixels.
const GAP: f64 = 12.0;

/// Style of the parts of a drawing. The text is larger than on a report page, because a sheet is usually shown at half its size.
const STYLE: &str = "svg{font-family:Helvetica,Arial,sans-serif}.ground{fill:var(--panel)}\
    text{fill:var(--muted);font-size:17px}text.axis,text.title{fill:var(--ink);font-size:19px}text.title{font-weight:650}\
    .grid{stroke:var(--grid);fill:none}.line{stroke:var(--pen);stroke-width:2.4;fill:none}circle{fill:var(--pen);stroke:var(--pen);stroke-width:3}";

/// Draws figures as one SVG file, `columns` in a row, each with its caption and its legend. The file has its own style, light and dark, and loads nothing.
#[must_use]
pub fn sheet(title: &str, columns: usize, figures: &[Figure]) -> String {
    let columns = columns.clamp(1, figures.len().max(1));
    let panel = (SIZE.0 + 2.0 * GAP, HEAD + SIZE.1 + 2.0 * GAP);
    let (width, height) = (panel.0 * columns as f64, panel.1 * figures.len().div_ceil(columns) as f64);
    // The colours of a report page, without those for printing.
    let colours = include_str!("../../assets/report.css").split("@media print").next().unwrap_or_default();
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-labelledby=\"title\">\n\
         <title id=\"title\">{}</title>\n<style>\n{colours}{STYLE}",
        html(title)
    );
    for colour in 0..COLOURS {
        let _ = write!(out, ".c{colour}{{--pen:var(--c{colour})}}");
    }
    let _ = write!(out, "\n</style>\n<rect class=\"ground\" width=\"{width}\" height=\"{height}\" rx=\"8\"/>\n");
    for (number, figure) in figures.iter().enumerate() {
        let (row, column) = (number / columns, number % columns);
        let at = (panel.0 * column as f64 + GAP, panel.1 * row as f64 + GAP);
        let _ = write!(out, "<g transform=\"translate({} {})\">", at.0, at.1);
        figure.write_panel(&mut out);
        out.push_str("</g>\n");
    }
    out + "</svg>\n"
}

impl Figure {
    /// Writes caption, legend and drawing, within the size of a drawing and `HEAD` above it.
    fn write_panel(&self, out: &mut String) {
        let _ = write!(out, "<text class=\"title\" x=\"8\" y=\"20\">{}</text>", html(&self.caption));
        let mut x = 8.0;
        for (pen, series) in self.series.iter().enumerate() {
            let dashes = if series.kind == Kind::Limit { " stroke-dasharray=\"7 5\"" } else { "" };
            let _ = match series.kind {
                Kind::Points => {
                    write!(out, "<g class=\"{}\"><circle cx=\"{}\" cy=\"42\" r=\"5\"/></g>", class(pen), x + 12.0)
                }
                _ => write!(out, "<g class=\"{}\"><path class=\"line\"{dashes} d=\"M{x} 42h24\"/></g>", class(pen)),
            };
            let _ = write!(out, "<text x=\"{}\" y=\"48\">{}</text>", x + 30.0, html(&series.name));
            x += 52.0 + 9.2 * series.name.chars().count() as f64;
        }
        let _ = write!(out, "<g transform=\"translate(0 {HEAD})\">");
        self.draw(out, &self.abscissa(), SIZE.1);
        out.push_str("</g>");
    }
}

#[cfg(test)]
mod tests {
    use super::{GAP, HEAD, SIZE, sheet};
    use crate::{Figure, Point, Scale, Series};

    fn figure(caption: &str) -> Figure {
        Figure::new(caption, "joints", "ms")
            .scaled(Scale::Log, Scale::Log)
            .with(Series::points("one <run>", vec![Point::at(1.0, 3.0), Point::at(6.0, 20.0)]))
            .with(Series::limit("linear", (1.0, 3.0), (6.0, 18.0)))
    }

    /// Values of an attribute in every element with this beginning.
    fn values(svg: &str, element: &str, name: &str) -> Vec<f64> {
        let attribute = |rest: &str| rest.split_once(&format!(" {name}=\""))?.1.split('"').next()?.parse().ok();
        svg.split(element).skip(1).filter_map(attribute).collect()
    }

    #[test]
    fn every_panel_lies_inside_the_sheet_and_every_point_inside_its_panel() {
        let svg = sheet("growth", 2, &[figure("a"), figure("b"), figure("c")]);
        let size = (2.0 * (SIZE.0 + 2.0 * GAP), 2.0 * (HEAD + SIZE.1 + 2.0 * GAP));
        assert!(svg.contains(&format!("viewBox=\"0 0 {} {}\"", size.0, size.1)), "{svg}");
        let corners: Vec<(f64, f64)> = svg
            .split("<g transform=\"translate(")
            .filter_map(|rest| rest.split_once(')')?.0.split_once(' '))
            .filter_map(|(x, y)| Some((x.parse().ok()?, y.parse().ok()?)))
            .filter(|corner: &(f64, f64)| *corner != (0.0, HEAD))
            .collect();
        assert_eq!(corners.len(), 3);
        for (x, y) in corners {
            assert!(x >= 0.0 && y >= 0.0 && x + SIZE.0 <= size.0 && y + HEAD + SIZE.1 <= size.1, "{x} {y}");
        }
        let (x, y) = (values(&svg, "<circle", "cx"), values(&svg, "<circle", "cy"));
        assert_eq!((x.len(), y.len()), (9, 9), "two points and a key for each");
        assert!(x.iter().all(|x| (0.0..=SIZE.0).contains(x)) && y.iter().all(|y| (0.0..=SIZE.1).contains(y)));
    }

    #[test]
    fn a_sheet_needs_no_page_and_escapes_its_texts() {
        let svg = sheet("a & b", 2, &[figure("c < d")]);
        assert!(svg.contains("a &amp; b") && svg.contains("c &lt; d") && svg.contains("one &lt;run&gt;"), "{svg}");
        assert!(svg.contains("prefers-color-scheme: dark") && !svg.contains("@media print"));
        assert!(!svg.contains("href") && !svg.contains("url("));
    }
}
