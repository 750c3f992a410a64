//! Series of a figure, and their drawing.

use crate::axis::Axis;
use crate::escape::html;
use std::fmt::Write as _;

/// Size of the drawing, and its margins (left, right, top, bottom), pixels.
pub(crate) const SIZE: (f64, f64) = (760.0, 400.0);
pub(crate) const MARGIN: (f64, f64, f64, f64) = (78.0, 18.0, 14.0, 62.0);
/// Distance between the lines of a label, pixels.
pub(crate) const LINE: f64 = 14.0;
/// Points of one kind, with a name in the legend.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    pub(crate) name: String,
    pub(crate) kind: Kind,
    pub(crate) points: Vec<Point>,
}

/// Style of a series' points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    Points,
    Line,
    Limit,
    Median,
    Quantile,
    Steps,
    Bars,
}

impl Kind {
    /// CSS class of series of this kind, if they look different from others.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Points => " dots",
            Self::Median => " median",
            Self::Quantile => " quantile",
            Self::Line | Self::Limit | Self::Steps | Self::Bars => "",
        }
    }
}

/// A point, and its texts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Point {
    /// Abscissa and ordinate.
    pub at: (f64, f64),
    /// Name, in the list under the figure and on hover.
    pub name: Option<String>,
    /// Command that reproduces the point, on hover; a click copies it.
    pub command: Option<String>,
    /// True if a ring is drawn around it.
    pub ringed: bool,
}

impl Point {
    /// Creates a point without a name.
    #[must_use]
    pub fn at(x: f64, y: f64) -> Self {
        Self { at: (x, y), ..Self::default() }
    }

    /// Returns the point with a name.
    #[must_use]
    pub fn named(self, name: impl Into<String>) -> Self {
        Self { name: Some(name.into()), ..self }
    }

    /// Returns the point with the command that reproduces it.
    #[must_use]
    pub fn told(self, command: impl Into<String>) -> Self {
        Self { command: Some(command.into()), ..self }
    }
}

impl Series {
    /// Creates a series of separate points.
    #[must_use]
    pub fn points(name: impl Into<String>, points: Vec<Point>) -> Self {
        Self { name: name.into(), kind: Kind::Points, points }
    }

    /// Creates a line through these points, with a gap at points that are not finite. If there are many points, only the visible ones are kept: the
    /// lowest and the highest in each column of pixels.
    #[must_use]
    pub fn line(name: impl Into<String>, points: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let all: Vec<(f64, f64)> = points.into_iter().collect();
        let points = thinned(&all).into_iter().map(|(x, y)| Point::at(x, y)).collect();
        Self { name: name.into(), kind: Kind::Line, points }
    }

    /// Creates a dashed line between two points, for a limit.
    #[must_use]
    pub fn limit(name: impl Into<String>, from: (f64, f64), to: (f64, f64)) -> Self {
        let points = [from, to].map(|(x, y)| Point::at(x, y)).into();
        Self { name: name.into(), kind: Kind::Limit, points }
    }

    /// Creates a solid vertical line at the median of a histogram, up to this height.
    #[must_use]
    pub fn median(name: impl Into<String>, at: f64, height: f64) -> Self {
        Self { name: name.into(), kind: Kind::Median, points: vec![Point::at(at, 0.0), Point::at(at, height)] }
    }

    /// Creates a dotted vertical line at another quantile of a histogram, up to this height.
    #[must_use]
    pub fn quantile(name: impl Into<String>, at: f64, height: f64) -> Self {
        Self { kind: Kind::Quantile, ..Self::median(name, at, height) }
    }

    /// Creates a line that keeps its height until the next point, such as a Pareto front. The points keep their names.
    #[must_use]
    pub fn steps(name: impl Into<String>, mut points: Vec<Point>) -> Self {
        points.sort_by(|a, b| a.at.0.total_cmp(&b.at.0));
        Self { name: name.into(), kind: Kind::Steps, points }
    }

    /// Creates bars from zero, next to the bars of other series.
    #[must_use]
    pub fn bars(name: impl Into<String>, points: Vec<Point>) -> Self {
        Self { name: name.into(), kind: Kind::Bars, points }
    }
}

/// Keeps the lowest and the highest point of each group of neighbours, in their order, if there are more than two points per column of pixels.
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
        // If all points are gaps, keep one gap.
        if kept.is_empty() { vec![points[0]] } else { kept.into_iter().map(|k| points[k]).collect() }
    };
    all.chunks(chunk).flat_map(ends).collect()
}

impl Point {
    pub(crate) fn words(&self, labels: &(String, String)) -> String {
        let name = self.name.as_ref().map_or(String::new(), |name| format!("{name}: "));
        format!("{name}{} {:.4e}, {} {:.4e}", labels.0, self.at.0, labels.1, self.at.1)
    }

    /// Writes the opening tag of the point's group, and its text on hover.
    fn open(&self, out: &mut String) {
        let said = [self.name.as_deref(), self.command.as_deref()].into_iter().flatten().collect::<Vec<_>>().join("\n");
        if said.is_empty() {
            out.push_str("<g>");
            return;
        }
        let command = self.command.as_ref().map_or(String::new(), |c| format!(" data-command=\"{}\"", html(c)));
        let class = if self.name.is_some() { "point named" } else { "point" };
        // Only points with a command can be focused by keyboard. Names alone are in the list under the figure, or in a table.
        let stop = if self.command.is_some() { " tabindex=\"0\"" } else { "" };
        let _ = write!(
            out,
            "<g class=\"{class}\"{stop} role=\"img\" aria-label=\"{0}\"{command}><title>{0}</title>",
            html(&said)
        );
    }
}

impl Series {
    pub(crate) fn draw_points(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>) {
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

    pub(crate) fn draw_line(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>) {
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

    pub(crate) fn draw_steps(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>) {
        let mut path = String::new();
        let placed = self.points.iter().filter_map(|p| Some((x.pixel(p.at.0)?, y.pixel(p.at.1)?)));
        for (index, (px, py)) in placed.enumerate() {
            let _ = if index == 0 { write!(path, "M{px:.1} {py:.1}") } else { write!(path, "H{px:.1}V{py:.1}") };
        }
        let _ = write!(out, "<path class=\"line\" d=\"{path}\"/>");
    }

    pub(crate) fn draw_bars(&self, out: &mut String, x: &Axis<'_>, y: &Axis<'_>, off: f64, width: f64) {
        // A logarithmic axis has no zero, so its bars start at the bottom of the axis.
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
    use super::Series;

    #[test]
    fn a_long_line_keeps_its_peaks() {
        let all = (0..50_000).map(|k| (f64::from(k), if k == 31_415 { 7.0 } else { 0.0 }));
        let line = Series::line("l", all);
        assert!(line.points.len() <= 1520 && line.points.iter().any(|p| p.at == (31_415.0, 7.0)));
        assert!(line.points.is_sorted_by(|a, b| a.at.0 <= b.at.0));
    }
}
