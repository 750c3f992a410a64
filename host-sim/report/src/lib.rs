//! Reports as HTML files. Each is a single file that opens from disk, without a server or a network.
//!
//! This package knows nothing about simulations. A [`Page`] is a title and blocks from top to bottom: text, tables, figures, and at most one viewer
//! of runs, which is the only block that needs scripts.
//!
//! A study writes its page in three steps:
//!
//! ```
//! use report::{Block, Figure, Page, Point, Series, Table};
//! let mut table = Table::new("Gains", &["frequency", "error"]);
//! table.row(vec!["40 rad/s".into(), report::Cell::number("1.2 mrad", 0.0012)]);
//! let point = Point::at(40.0, 0.0012).named("the scene's own").told("newtau run scenes/a.toml");
//! let figure = Figure::new("Error over frequency", "frequency / (rad/s)", "error / rad")
//!     .with(Series::points("all", vec![point]));
//! let page = Page {
//!     title: "sweep: puma560_pick".to_owned(),
//!     lead: vec!["40 rad/s has the least error.".to_owned()],
//!     blocks: vec![Block::Table(table), Block::Figure(figure)],
//! };
//! assert!(page.html().starts_with("<!doctype html>"));
//! ```
#![forbid(unsafe_code)]

mod axis;
#[cfg(test)]
mod colours;
pub mod column;
mod escape;
pub mod figure;
pub mod page;
mod series;
pub mod table;

pub use figure::{Figure, Point, Scale, Series, sheet};
pub use page::{Block, Page};
pub use table::{Cell, Table, Tone};
