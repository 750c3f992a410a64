//! Plots as SVG.
//!
//! | module | holds |
//! |---|---|
//! | `chart` | curves in panels above one another |
//! | `scatter` | points of several kinds, both axes logarithmic |
//! | `log_chart` | curves, and points that should lie on them, both axes logarithmic |
//! | `figures` | figures of a run: a sheet per quantity, a panel per joint, errors on top |
//! | `marks` | what the figures of a run show beside its curves |
//! | `page` | the sheet under charts and scatters |
//! | `ticks` | ticks of a logarithmic axis |

mod chart;
mod figures;
mod log_chart;
mod marks;
mod page;
mod scatter;
mod ticks;

pub use chart::{Chart, Layout, Line, Mark, MarkKind, Panel, Pen, Pieces, write_chart};
pub use figures::{write_all, write_power};
pub use log_chart::{LogChart, LogCurve, write_log_chart};
pub use marks::Marks;
pub use scatter::{Scatter, ScatterPanel, Spot, write_scatter};

use std::error::Error;

/// Error while drawing a plot.
pub type PlotError = Box<dyn Error + Send + Sync>;
