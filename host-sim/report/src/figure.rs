//! Figures as inline SVG: points, lines, steps and bars. [`sheet`] draws several in one SVG file.

mod sheet;

pub use crate::axis::Scale;
pub use crate::series::{Point, Series};
pub use sheet::sheet;

use crate::axis::Axis;
use crate::escape::html;
use crate::series::{Kind, LINE, MARGIN, SIZE};
use std::fmt::Write as _;

/// A figure. Its colours follow the page, dark or light. Its points show their names on hover; those with a command can also be reached by keyboard.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    caption: String,
    labels: (String, String),
    scales: (Scale, Scale),
    series: Vec<Series>,
}

/// Number of series colours in the style sheet, and of line styles for each: solid, dashed, dotted.
const COLOURS: usize = 6;
const DASHES: usize = 3;

/// CSS classes of a series: its colour, and its line style.
fn class(pen: usize) -> String {
    let dashes = pen / COLOURS % DASHES;
    let dashed = if dashes > 0 { format!(" d{dashes}") } else { String::new() };
    format!("c{}{dashed}", pen % COLOURS)
}

impl Figure {
    /// Creates a figure without series, with two linear axes.
    #[must_use]
    pub fn new(caption: impl Into<String>, abscissa: impl Into<String>, ordinate: impl Into<String>) -> Self {
        Self {
            caption: caption.into(),
            labels: (abscissa.into(), ordinate.into()),
            scales: (Scale::Linear, Scale::Linear),
            series: Vec::new(),
        }
    }

    /// Returns the figure with these scales of abscissa and ordinate.
    #[must_use]
    pub fn scaled(self, abscissa: Scale, ordinate: Scale) -> Self {
        Self { scales: (abscissa, ordinate), ..self }
    }

    /// Returns the figure with one more series, in a style that differs from the previous ones.
    #[must_use]
    pub fn with(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    pub(crate) fn write(&self, out: &mut String) {
        let caption = html(&self.caption);
        let _ = write!(out, "<figure><figcaption>{caption}</figcaption>");
        if self.series.len() > 1 {
            out.push_str("<p class=\"legend\">");
            for (pen, series) in self.series.iter().enumerate() {
                let _ =
                    write!(out, "<span class=\"{}{}\">{}</span>", class(pen), series.kind.class(), html(&series.name));
            }
            out.push_str("</p>");
        }
        let x = self.abscissa();
        let lines = x.ticks().iter().map(|(_, text)| x.lines(text).len()).max().unwrap_or(1);
        let height = SIZE.1 + LINE * (lines - 1) as f64;
        let _ = write!(
            out,
            "<div class=\"drawing\"><svg viewBox=\"0 0 {} {height}\" role=\"group\" aria-label=\"{caption}\">",
            SIZE.0
        );
        self.draw(out, &x, height);
        out.push_str("</svg></div>");
        self.write_list(out);
        out.push_str("</figure>\n");
    }

    fn abscissa(&self) -> Axis<'_> {
        let all = self.series.iter().flat_map(|series| &series.points);
        Axis::new(&self.scales.0, all.map(|p| p.at.0), false, (MARGIN.0, SIZE.0 - MARGIN.1))
    }

    fn draw(&self, out: &mut String, x: &Axis<'_>, height: f64) {
        let all = || self.series.iter().flat_map(|series| &series.points);
        let bars = self.series.iter().filter(|series| series.kind == Kind::Bars).count();
        let (left, right, top, bottom) = MARGIN;
        let y = Axis::new(&self.scales.1, all().map(|p| p.at.1), bars > 0, (SIZE.1 - bottom, top));
        let foot = SIZE.1 - bottom;
        for (at, text) in x.ticks() {
            let Some(px) = x.pixel(at) else { continue };
            let _ = write!(out, "<path class=\"grid\" d=\"M{px:.1} {top}V{foot}\"/>");
            let _ = write!(out, "<text y=\"{}\" text-anchor=\"middle\">", foot + 18.0);
            for (line, part) in x.lines(&text).iter().enumerate() {
                let down = if line == 0 { 0.0 } else { LINE };
                let _ = write!(out, "<tspan x=\"{px:.1}\" dy=\"{down}\">{}</tspan>", html(part));
            }
            out.push_str("</text>");
        }
        for (at, text) in y.ticks() {
            let Some(py) = y.pixel(at) else { continue };
            let _ = write!(out, "<path class=\"grid\" d=\"M{left} {py:.1}H{}\"/>", SIZE.0 - right);
            let _ = write!(
                out,
                "<text x=\"{}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 8.0,
                py + 4.0,
                html(&text)
            );
        }
        let middle = (0.5 * (left + SIZE.0 - right), 0.5 * (top + foot));
        let _ = write!(
            out,
            "<text class=\"axis\" x=\"{}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            middle.0,
            height - 14.0,
            html(&self.labels.0)
        );
        let _ = write!(
            out,
            "<text class=\"axis\" transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            middle.1,
            html(&self.labels.1)
        );
        let gap = self.gap(x);
        let mut bar = 0;
        for (pen, series) in self.series.iter().enumerate() {
            let _ = write!(out, "<g class=\"{}{}\">", class(pen), series.kind.class());
            match series.kind {
                Kind::Points => series.draw_points(out, x, &y),
                Kind::Line | Kind::Limit | Kind::Median | Kind::Quantile => series.draw_line(out, x, &y),
                Kind::Steps => {
                    series.draw_steps(out, x, &y);
                    series.draw_points(out, x, &y);
                }
                Kind::Bars => {
                    let width = 0.8 * gap / bars as f64;
                    let off = -0.4 * gap + bar as f64 * width;
                    series.draw_bars(out, x, &y, off, width);
                    bar += 1;
                }
            }
            out.push_str("</g>");
        }
    }

    /// Smallest distance between two neighbouring bars on the abscissa, pixels.
    fn gap(&self, x: &Axis<'_>) -> f64 {
        let bars = self.series.iter().filter(|series| series.kind == Kind::Bars);
        let mut at: Vec<f64> = bars.flat_map(|series| &series.points).filter_map(|p| x.pixel(p.at.0)).collect();
        at.sort_by(f64::total_cmp);
        at.dedup_by(|a, b| (*a - *b).abs() < 0.01);
        let least = at.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.5 * (SIZE.0 - MARGIN.0 - MARGIN.1) }
    }

    /// Writes the named points as a list, for readers who cannot see the picture.
    fn write_list(&self, out: &mut String) {
        let named = |series: &Series| series.points.iter().any(|p| p.name.is_some()) && series.kind != Kind::Bars;
        for series in self.series.iter().filter(|series| named(series)) {
            let _ = write!(out, "<details><summary>{}, point by point</summary><ul>", html(&series.name));
            for point in series.points.iter().filter(|point| point.name.is_some()) {
                let command = point.command.as_ref().map_or(String::new(), |c| format!("<br><code>{}</code>", html(c)));
                let _ = write!(out, "<li>{}{command}</li>", html(&point.words(&self.labels)));
            }
            out.push_str("</ul></details>");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Figure, Point, Scale, Series};

    fn drawn(figure: &Figure) -> String {
        let mut out = String::new();
        figure.write(&mut out);
        out
    }

    #[test]
    fn a_point_says_its_name_and_its_command_to_pointer_keyboard_and_reader() {
        let point = Point::at(1.0, 2.0).named("best <one>").told("newtau choose trade a.toml --scalar f32");
        let out = drawn(&Figure::new("cost", "cycles", "error").with(Series::steps("front", vec![point])));
        assert!(out.contains("data-command=\"newtau choose trade a.toml --scalar f32\""), "{out}");
        assert!(out.contains("<title>best &lt;one&gt;\nnewtau choose trade a.toml --scalar f32</title>"), "{out}");
        assert!(
            out.contains("tabindex=\"0\"") && out.contains("<li>best &lt;one&gt;: cycles 1.0000e0, error 2.0000e0<br>")
        );
    }

    #[test]
    fn what_has_no_place_on_an_axis_is_left_out() {
        let points = vec![Point::at(0.0, 1.0), Point::at(10.0, f64::NAN), Point::at(10.0, 1.0)];
        let figure = Figure::new("a", "x", "y").scaled(Scale::Log, Scale::Log).with(Series::points("p", points));
        assert_eq!(drawn(&figure).matches("<circle").count(), 1);
        let gap = Figure::new("a", "x", "y").with(Series::line("l", [(0.0, 0.0), (1.0, f64::NAN), (2.0, 1.0)]));
        assert_eq!(drawn(&gap).matches("class=\"line\" d=\"M").count(), 1);
        assert_eq!(drawn(&gap).split("class=\"line\"").nth(1).unwrap().matches('M').count(), 2);
    }

    #[test]
    fn no_two_lines_look_alike() {
        let line = |k: usize| Series::line(format!("l{k}"), [(0.0, 0.0), (1.0, 1.0)]);
        let out = drawn(&(0..12).map(line).fold(Figure::new("a", "x", "y"), Figure::with));
        let classes = out.split("<g class=\"").skip(1).filter_map(|rest| Some(rest.split_once('"')?.0));
        assert_eq!(classes.collect::<std::collections::BTreeSet<&str>>().len(), 12);
        assert!(out.contains("<span class=\"c1 d1\">l7</span>"), "{out}");
        let dots =
            drawn(&Figure::new("a", "x", "y").with(line(0)).with(Series::points("p", vec![Point::at(0.5, 0.5)])));
        assert!(dots.contains("<span class=\"c1 dots\">p</span>"), "{dots}");
    }

    #[test]
    fn a_point_without_a_command_is_no_stop_of_the_keyboard_and_a_limit_is_dashed() {
        let bars = Series::steps("all", vec![Point::at(0.0, 3.0).named("0 to 1: 3 runs")]);
        let out = drawn(&Figure::new("a", "x", "y").with(bars).with(Series::limit("limit", (0.5, 0.0), (0.5, 3.0))));
        assert!(!out.contains("tabindex") && out.contains("<title>0 to 1: 3 runs</title>"), "{out}");
        assert_eq!(out.matches("stroke-dasharray").count(), 1);
    }

    #[test]
    fn bars_of_two_series_stand_beside_each_other() {
        let bars = |name: &str| Series::bars(name, vec![Point::at(0.0, 1.0), Point::at(1.0, -1.0)]);
        let names = Scale::Names(vec!["waist".to_owned(), "elbow".to_owned()]);
        let out = drawn(&Figure::new("work", "", "J").scaled(names, Scale::Linear).with(bars("a")).with(bars("b")));
        assert_eq!(out.matches("<rect").count(), 4);
        assert!(out.contains(">waist</tspan></text>"));
    }
}
