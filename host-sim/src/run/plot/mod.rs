//! Plots as SVG.
//!
//! | module | holds |
//! |---|---|
//! | `chart` | curves in panels above one another |
//! | `scatter` | points of several kinds, both axes logarithmic |
//! | `log_chart` | curves and the points that are to lie on them, both axes logarithmic |
//! | `figures` | what a run shows: one chart per quantity, one panel per joint |
//! | `page` | the sheet that charts and scatters are drawn on |

mod chart;
mod figures;
mod log_chart;
mod page;
mod scatter;

pub use chart::{Chart, Line, Mark, Panel, Pen, Pieces, write_chart};
pub use figures::{write_all, write_power};
pub(crate) use log_chart::{LogChart, LogCurve, write_log_chart};
pub use scatter::{Scatter, ScatterPanel, Spot, write_scatter};

use std::error::Error;

/// Something went wrong in drawing.
pub type PlotError = Box<dyn Error + Send + Sync>;
