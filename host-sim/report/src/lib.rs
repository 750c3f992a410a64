//! Reports as HTML files: one file each, opened from disk, without a server or a network.
//!
//! Nothing here knows of simulations. A [`Page`] is a title and blocks from top to bottom: words, tables, figures, and at most one
//! viewer of runs, which is the only block that needs the scripts.
//!
//! | module | holds |
//! |---|---|
//! | [`page`] | the page and its blocks, as HTML |
//! | [`table`] | tables whose cells keep the exact number behind what they show |
//! | [`figure`] | scatter, lines and bars as SVG inside the page, whose points say on hover what they are and how to repeat them |
//! | [`mod@column`] | time series as base64 of f32 |
//! | `axis`, `series` | ticks and scales of figures; what is drawn between them |
//! | `escape` | text inside HTML and JSON inside scripts |
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
pub mod column;
mod escape;
pub mod figure;
pub mod page;
mod series;
pub mod table;

pub use figure::{Figure, Point, Scale, Series};
pub use page::{Block, Page};
pub use table::{Cell, Table};
