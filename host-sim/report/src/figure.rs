//! Figures as SVG inside the page: points, lines, steps and bars.

pub use crate::axis::Scale;

use crate::axis::Axis;
use crate::escape::html;
use std::fmt::Write as _;

/// A figure. Its colours are those of the page, dark or light; its points say what they are on hover, and those
/// with a command are reached by keyboard too.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    caption: String,
    labels: (String, String),
    scales: (Scale, Scale),
    series: Vec<Series>,
}

/// Points of one kind, with a name in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    name: String,
    kind: Kind,
    points: Vec<Point>,
}

/// How the points of a series are drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Points,
    Line,
    Limit,
    Steps,
    Bars,
}

/// A point, and what is said of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// Abscissa and ordinate.
    pub at: (f64, f64),
    /// Its name, in the list under the figure and on hover.
    pub name: Option<String>,
    /// Command that repeats it, on hover; a click copies it.
    pub command: Option<String>,
    /// Whether it has a ring around it.
    pub ringed: bool,
}

impl Point {
    /// A point without a name.
    #[must_use]
    pub fn at(x: f64, y: f64) -> Self {
        Self { at: (x, y), ..Self::default() }
    }

    /// The same point with a name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// The same point with the command that repeats it.
    #[must_use]
    pub fn told(self, command: impl Into<String>) -> Self {
        Self { command: Some(command.into()), ..self }
    }
}

impl Series {
    /// Points by themselves.
    #[must_use]
    pub fn points(name: impl Into<String>, points: Vec<Point>) -> Self {
        Self { name: name.into(), kind: Kind::Points, points }
    }

    /// A line through these points, which interrupts itself where one is not finite. Of many points those are kept that are seen: the
    /// lowest and the highest of each column of pixels.
    #[must_use]
    pub fn line(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let all: Vec<(f64, f64)> = points.into_iter().collect();
        let points = thinned(&all).into_iter().map(|(x, y)| Point::at(x, y)).collect();
        Self { name: name.into(), kind: Kind::Line, points }
    }

    /// A dashed line from one point to the other: a limit.
    #[must_use]
    pub fn limit(name: impl Into<String>, from: (f64, f64), to: (f64, f64)) -> Self {
        let points = [from, to].map(|(x, y)| Point::at(x, y)).into();
        Self { name: name.into(), kind: Kind::Limit, points }
    }

    /// A line that keeps its height until the next point, as a Pareto front does. The points keep their names.
    #[must_use]
    pub fn steps(name: impl Into<String>, mut points: Vec<Point>) -> Self {
        points.sort_by(|a, b| a.at.0.total_cmp(&b.at.0));
        Self { name: name.into(), kind: Kind::Steps, points }
    }

    /// Bars from zero, beside those of other series.
    #[must_use]
    pub fn bars(name: impl Into<String>, points: Vec<Point>) -> Self {
        Self { name: name.into(), kind: Kind::Bars, points }
    }

    /// A histogram of values: `bins` bars of equal width over their range, at the middle of each.
    #[must_use]
    pub fn histogram(name: impl Into<String>, values: &[f64], bins: usize) -> Self {
        let finite = || values.iter().copied().filter(|x| x.is_finite());
        let (low, high) = finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        let bins = bins.max(1);
        let width = if high > low { (high - low) / bins as f64 } else { 1.0 };
        let mut counts = vec![0_u32; bins];
        for x in finite() {
            counts[(((x - low) / width) as usize).min(bins - 1)] += 1;
        }
        let bar = |(k, count): (usize, &u32)| {
            let from = low + k as f64 * width;
            let name = format!("{from:.4} to {:.4}: {count}", from + width);
            Point::at(from + 0.5 * width, f64::from(*count)).named(name)
        };
        let points = if low <= high { counts.iter().enumerate().map(bar).collect() } else { Vec::new() };
        Self { name: name.into(), kind: Kind::Bars, points }
    }
}

/// The lowest and the highest of every so many neighbours, in their order, where there are more than two in a column of pixels.
fn thinned(all: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let chunk = all.len().div_ceil(SIZE.0 as usize);
    if chunk <= 2 {
        return all.to_vec();
    }
    let ends = |points: &[(f64, f64)]| {
        let finite = || (0..points.len()).filter(|k| points[*k].1.is_finite());
        let low = finite().min_by(|a, b| points[*a].1.total_cmp(&points[*b].1));
        let high = finite().max_by(|a, b| points[*a].1.total_cmp(&points[*b].1));
        let mut kept: Vec<usize> = low.into_iter().chain(high).collect();
        kept.sort_unstable();
        kept.dedup();
        // Nothing but gaps: a gap stays.
        if kept.is_empty() { vec![points[0]] } else { kept.into_iter().map(|k| points[k]).collect() }
    };
    all.chunks(chunk).flat_map(ends).collect()
}

/// Size of the drawing, and its margins: left, right, top, bottom.
const SIZE: (f64, f64) = (760.0, 400.0);
const MARGIN: (f64, f64, f64, f64) = (78.0, 18.0, 14.0, 62.0);
/// Colours of series that the style sheet has.
const COLOURS: usize = 6;

impl Figure {
    /// A figure without series; both axes linear.
    #[must_use]
    pub fn new(caption: impl Into<String>, abscissa: impl Into<String>, ordinate: impl Into<String>) -> Self {
        Self {
            caption: caption.into(),
            labels: (abscissa.into(), ordinate.into()),
            scales: (Scale::Linear, Scale::Linear),
            series: Vec::new(),
        }
    }

    /// The same figure with these scales of abscissa and ordinate.
    #[must_use]
    pub fn scaled(self, abscissa: Scale, ordinate: Scale) -> Self {
        Self { scales: (abscissa, ordinate), ..self }
    }

    /// The same figure with one more series.
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
            for (index, series) in self.series.iter().enumerate() {
                let _ = write!(out, "<span class=\"c{}\">{}</span>", index % COLOURS, html(&series.name));
            }
            out.push_str("</p>");
        }
        let _ = write!(out, "<svg viewBox=\"0 0 {} {}\" role=\"group\" aria-label=\"{caption}\">", SIZE.0, SIZE.1);
        self.draw(out);
        out.push_str("</svg>");
        self.write_list(out);
        out.push_str("</figure>\n");
    }

    fn draw(&self, out: &mut String) {
        let all = || self.series.iter().flat_map(|series| &series.points);
        let bars = self.series.iter().filter(|series| series.kind == Kind::Bars).count();
        let (left, right, top, bottom) = MARGIN;
        let x = Axis::new(&self.scales.0, all().map(|p| p.at.0), false, (left, SIZE.0 - right));
        let y = Axis::new(&self.scales.1, all().map(|p| p.at.1), bars > 0, (SIZE.1 - bottom, top));
        let foot = SIZE.1 - bottom;
        for (at, text) in x.ticks() {
            let Some(px) = x.pixel(at) else { continue };
            let _ = write!(out, "<path class=\"grid\" d=\"M{px:.1} {top}V{foot}\"/>");
            let _ =
                write!(out, "<text x=\"{px:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>", foot + 18.0, html(&text));
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
            SIZE.1 - 14.0,
            html(&self.labels.0)
        );
        let _ = write!(
            out,
            "<text class=\"axis\" transform=\"translate(16 {}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            middle.1,
            html(&self.labels.1)
        );
        let gap = self.gap(&x);
        let mut bar = 0;
        for (index, series) in self.series.iter().enumerate() {
            let _ = write!(out, "<g class=\"c{}\">", index % COLOURS);
            match series.kind {
                Kind::Points => series.draw_points(out, &x, &y),
                Kind::Line | Kind::Limit => series.draw_line(out, &x, &y),
                Kind::Steps => {
                    series.draw_steps(out, &x, &y);
                    series.draw_points(out, &x, &y);
                }
                Kind::Bars => {
                    let width = 0.8 * gap / bars as f64;
                    let off = -0.4 * gap + bar as f64 * width;
                    series.draw_bars(out, &x, &y, off, width);
                    bar += 1;
                }
            }
            out.push_str("</g>");
        }
    }

    /// Least distance of two neighbours on the abscissa among bars, pixels.
    fn gap(&self, x: &Axis<'_>) -> f64 {
        let bars = self.series.iter().filter(|series| series.kind == Kind::Bars);
        let mut at: Vec<f64> = bars.flat_map(|series| &series.points).filter_map(|p| x.pixel(p.at.0)).collect();
        at.sort_by(f64::total_cmp);
        at.dedup_by(|a, b| (*a - *b).abs() < 0.01);
        let least = at.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.5 * (SIZE.0 - MARGIN.0 - MARGIN.1) }
    }

    /// The points with a name as a list, for whoever does not see the picture.
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

impl Point {
    fn words(&self, labels: &(String, String)) -> String {
        let name = self.name.as_ref().map_or(String::new(), |name| format!("{name}: "));
        format!("{name}{} {:.4e}, {} {:.4e}", labels.0, self.at.0, labels.1, self.at.1)
    }

    /// Opening tag of the point's group, and what it says on hover.
    fn open(&self, out: &mut String) {
        let said = [self.name.as_deref(), self.command.as_deref()].into_iter().flatten().collect::<Vec<_>>().join("\n");
        if said.is_empty() {
            out.push_str("<g>");
            return;
        }
        let command = self.command.as_ref().map_or(String::new(), |c| format!(" data-command=\"{}\"", html(c)));
        let class = if self.name.is_some() { "point named" } else { "point" };
        // What can be pressed is a stop of the keyboard; names alone stand in the list under the figure, or in a table.
        let stop = if self.command.is_some() { " tabindex=\"0\"" } else { "" };
        let _ = write!(
            out,
            "<g class=\"{class}\"{stop} role=\"img\" aria-label=\"{0}\"{command}><title>{0}</title>",
            html(&said)
        );
    }
}

impl Series {
    fn draw_points(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>) {
        for point in &self.points {
            let (Some(px), Some(py)) = (x.pixel(point.at.0), y.pixel(point.at.1)) else { continue };
            point.open(out);
            if point.ringed {
                let _ = write!(out, "<circle class=\"ring\" cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"9\"/>");
            }
            let r = if point.name.is_some() { 5.0 } else { 3.5 };
            let _ = write!(out, "<circle cx=\"{px:.1}\" cy=\"{py:.1}\" r=\"{r}\"/></g>");
        }
    }

    fn draw_line(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>) {
        let mut path = String::new();
        let mut pen = 'M';
        for point in &self.points {
            let (Some(px), Some(py)) = (x.pixel(point.at.0), y.pixel(point.at.1)) else {
                pen = 'M';
                continue;
            };
            let _ = write!(path, "{pen}{px:.1} {py:.1}");
            pen = 'L';
        }
        let dashes = if self.kind == Kind::Limit { " stroke-dasharray=\"7 5\"" } else { "" };
        let _ = write!(out, "<path class=\"line\"{dashes} d=\"{path}\"/>");
    }

    fn draw_steps(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>) {
        let mut path = String::new();
        let placed = self.points.iter().filter_map(|p| Some((x.pixel(p.at.0)?, y.pixel(p.at.1)?)));
        for (index, (px, py)) in placed.enumerate() {
            let _ = if index == 0 { write!(path, "M{px:.1} {py:.1}") } else { write!(path, "H{px:.1}V{py:.1}") };
        }
        let _ = write!(out, "<path class=\"line\" d=\"{path}\"/>");
    }

    fn draw_bars(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>, off: f64, width: f64) {
        // A logarithmic axis has no zero: its bars stand on its foot.
        let zero = y.pixel(0.0).unwrap_or(SIZE.1 - MARGIN.3);
        for point in &self.points {
            let (Some(px), Some(py)) = (x.pixel(point.at.0), y.pixel(point.at.1)) else { continue };
            point.open(out);
            let (top, height) = (py.min(zero), (py - zero).abs());
            let _ = write!(
                out,
                "<rect x=\"{:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/></g>",
                px + off
            );
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
        let point = Point::at(1.0, 2.0).named("best <one>").told("host-sim trade a.toml --scalar f32");
        let out = drawn(&Figure::new("cost", "cycles", "error").with(Series::steps("front", vec![point])));
        assert!(out.contains("data-command=\"host-sim trade a.toml --scalar f32\""), "{out}");
        assert!(out.contains("<title>best &lt;one&gt;\nhost-sim trade a.toml --scalar f32</title>"), "{out}");
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
    fn a_point_without_a_command_is_no_stop_of_the_keyboard_and_a_limit_is_dashed() {
        let bars = Series::steps("all", vec![Point::at(0.0, 3.0).named("0 to 1: 3 runs")]);
        let out = drawn(&Figure::new("a", "x", "y").with(bars).with(Series::limit("limit", (0.5, 0.0), (0.5, 3.0))));
        assert!(!out.contains("tabindex") && out.contains("<title>0 to 1: 3 runs</title>"), "{out}");
        assert_eq!(out.matches("stroke-dasharray").count(), 1);
    }

    #[test]
    fn a_long_line_keeps_its_peaks() {
        let all = (0..50_000).map(|k| (f64::from(k), if k == 31_415 { 7.0 } else { 0.0 }));
        let line = Series::line("l", all);
        assert!(line.points.len() <= 1520 && line.points.iter().any(|p| p.at == (31_415.0, 7.0)));
        assert!(line.points.is_sorted_by(|a, b| a.at.0 <= b.at.0));
    }

    #[test]
    fn every_value_is_in_one_bar_of_a_histogram() {
        let series = Series::histogram("all", &[0.0, 0.1, 0.9, 1.0, f64::NAN], 2);
        let counts: Vec<f64> = series.points.iter().map(|p| p.at.1).collect();
        assert_eq!(counts, [2.0, 2.0]);
        assert!(Series::histogram("none", &[], 3).points.is_empty());
    }

    #[test]
    fn bars_of_two_series_stand_beside_each_other() {
        let bars = |name: &str| Series::bars(name, vec![Point::at(0.0, 1.0), Point::at(1.0, -1.0)]);
        let names = Scale::Names(vec!["waist".to_owned(), "elbow".to_owned()]);
        let out = drawn(&Figure::new("work", "", "J").scaled(names, Scale::Linear).with(bars("a")).with(bars("b")));
        assert_eq!(out.matches("<rect").count(), 4);
        assert!(out.contains(">waist</text>"));
    }
}
