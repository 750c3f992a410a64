//! A trade-off as a page: the choices on the Pareto front are named, and every point has the command that measures it again.

use super::choice::TermSet;
use super::{Trade, TradePoint};
use report::{Block, Cell, Figure, Page, Scale, Series, Table};
use robot_compiler::names::{self, Named as _};

impl Trade {
    /// Creates the page.
    #[must_use]
    pub fn page(&self) -> Page {
        let varied = self.varied();
        let mut head = self.head(&varied);
        head.extend(["front", "command"].map(str::to_owned));
        let mut table = Table::new("Choices that nothing beats", &head);
        for point in self.front() {
            let mut row: Vec<Cell> = Self::row(point, &varied).into_iter().map(Cell::from).collect();
            row.extend([super::report::front_name(point).into(), point.command.clone().into()]);
            table.row(row);
        }
        let lines = self.table();
        let below = lines.rsplit_once('\u{2518}').map_or(lines.as_str(), |(_, below)| below).trim();
        let torque = self.figure(
            "Cost and torque error",
            "torque error / % of the limit",
            &|p| p.torque_of_limit.map(|x| 100.0 * x),
            |p| p.on_torque_front,
        );
        let tracking =
            self.figure("Cost and tracking error", "tracking error / rad", &|p| p.tracking, |p| p.on_tracking_front);
        Page {
            title: format!("trade: {}", self.scene),
            lead: vec![format!(
                "{}: {} choices measured; {} that nothing beats in cost and error.",
                self.robot,
                self.points.len(),
                self.front().count()
            )],
            blocks: vec![
                Block::Figure(torque),
                Block::Figure(tracking),
                Block::Table(table),
                Block::List(below.lines().map(|line| line.split_whitespace().collect::<Vec<_>>().join(" ")).collect()),
            ],
        }
    }

    fn figure(
        &self,
        caption: &str,
        ordinate: &str,
        error: &dyn Fn(&TradePoint) -> Option<f64>,
        on_front: fn(&TradePoint) -> bool,
    ) -> Figure {
        let point = |p: &TradePoint| {
            let made = report::Point::at(p.cost.cycles, error(p)?).named(self.name_of(p)).told(p.command.clone());
            Some(report::Point { ringed: p.choice == self.own, ..made })
        };
        let mut figure =
            Figure::new(caption, "cycles of the controller, estimate", ordinate).scaled(Scale::Log, Scale::Log);
        for &(.., set) in TermSet::NAMES {
            let of_set: Vec<report::Point> =
                self.points.iter().filter(|p| p.choice.terms == set).filter_map(point).collect();
            if of_set.is_empty() {
                continue;
            }
            figure = figure.with(Series::points(format!("terms {}", names::name(set)), of_set));
        }
        figure.with(Series::steps("front", self.points.iter().filter(|p| on_front(p)).filter_map(point).collect()))
    }
}
