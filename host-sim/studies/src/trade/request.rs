//! Requirements on a choice, and the cheapest choice that meets them.

use super::report::percent;
use super::{Trade, TradePoint};
use sim::run::numbers::engineering;
use std::fmt::Write as _;
use std::path::Path;
use std::str::FromStr;

/// A share, written as `20%` or `0.2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Percentage(pub f64);

impl FromStr for Percentage {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |number| (number, 0.01));
        let share = number.trim().parse::<f64>().ok().map(|number| number * unit);
        let share = share.filter(|share| *share > 0.0 && *share <= 1.0);
        share.map(Self).ok_or_else(|| format!("{text}: expected a share above 0 and at most 1, such as 20% or 0.2"))
    }
}

/// A share of the processor at a control rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Budget {
    /// Share of the processor.
    pub share: f64,
    /// Control rate, Hz.
    pub rate: f64,
}

impl FromStr for Budget {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("{text}: expected a share and a rate, such as 20%@4kHz or 0.2@1000Hz");
        let (share, rate) = text.split_once('@').ok_or_else(expected)?;
        let share: Percentage = share.parse().map_err(|_| expected())?;
        let (number, unit) = match (rate.strip_suffix("kHz"), rate.strip_suffix("Hz")) {
            (Some(number), _) => (number, 1e3),
            (None, Some(number)) => (number, 1.0),
            (None, None) => return Err(expected()),
        };
        let rate = number.trim().parse::<f64>().map_err(|_| expected())? * unit;
        if rate > 0.0 && rate.is_finite() { Ok(Self { share: share.0, rate }) } else { Err(expected()) }
    }
}

/// Requirements on a choice.
pub struct Request {
    /// Greatest torque error as a share of the limit.
    pub torque: Option<f64>,
    /// Greatest tracking error, rad or m.
    pub tracking: Option<f64>,
    /// Greatest share of the processor, for the whole interrupt.
    pub share: Option<f64>,
    /// Clock of the processor, Hz.
    pub clock: f64,
}

impl Request {
    /// Share of the processor for the whole interrupt of the mean tick.
    pub fn share_of(&self, point: &TradePoint) -> f64 {
        point.interrupt.cycles * point.choice.rate / self.clock
    }

    /// True if the mean tick's interrupt keeps the share and the longest one ends before the next is due.
    fn fits(&self, point: &TradePoint) -> bool {
        let longest = point.interrupt.cycles_max * point.choice.rate / self.clock;
        self.share.is_none_or(|share| self.share_of(point) <= share) && longest <= 1.0
    }

    fn accurate(&self, point: &TradePoint) -> bool {
        let keeps = |most: Option<f64>, found: Option<f64>| most.is_none_or(|most| found.is_some_and(|x| x <= most));
        point.tracking.is_some() && keeps(self.torque, point.torque_of_limit) && keeps(self.tracking, point.tracking)
    }

    /// The cheapest point that meets the requirements: points are sorted by cycles, the fewest first.
    pub fn cheapest<'a>(&self, trade: &'a Trade) -> Option<&'a TradePoint> {
        trade.points.iter().find(|point| self.accurate(point) && self.fits(point))
    }

    /// Description of the nearest alternatives: the cheapest accurate point, and the most accurate point that fits.
    pub fn nearest(&self, trade: &Trade) -> String {
        let mut text = String::new();
        match trade.points.iter().find(|point| self.accurate(point)) {
            Some(point) => {
                let _ = writeln!(text, "accurate enough, and cheapest of those: {}", self.line(point));
            }
            None => text += "no choice is accurate enough\n",
        }
        match most_accurate(trade.points.iter().filter(|point| self.fits(point))) {
            Some(point) => {
                let _ = write!(text, "within the budget, and most accurate of those: {}", self.line(point));
            }
            None => text += "no choice is within the budget",
        }
        text
    }

    fn line(&self, point: &TradePoint) -> String {
        let [scalar, trig, terms, friction, rotors, every, kernel, rate] = point.choice.cells();
        let torque = point.torque_of_limit.map_or("fault".to_owned(), percent);
        let tracking = point.tracking.map_or("fault".to_owned(), |x| engineering(x, "rad"));
        format!(
            "{scalar}, {trig} trig, terms {terms}, friction {friction}, rotors {rotors}, model every {every}, {kernel}: {} of the processor at {rate} Hz, \
             torque error {torque}, tracking error {tracking}",
            percent(self.share_of(point)),
        )
    }

    /// Description of the choice: its numbers, the accuracy given up for it, and how it was measured.
    pub fn explain(&self, trade: &Trade, chosen: &TradePoint, path: &Path) -> String {
        let mut text = format!("chosen              {}\n", self.line(chosen));
        // Compare with the most accurate point of all, to show the accuracy that was given up.
        if let Some(best) = most_accurate(trade.points.iter()) {
            let given_up = differences(best, chosen);
            let what =
                if given_up.is_empty() { "nothing: it is the most accurate of all".to_owned() } else { given_up };
            let _ = writeln!(text, "given up            {what}");
            let _ = writeln!(text, "most accurate       {}", self.line(best));
        }
        let TradePoint { cost, interrupt, .. } = chosen;
        let _ = writeln!(
            text,
            "controller          {:.0} instructions a tick, {} at most; {:.0} cycles (estimate), flash {}, RAM {}",
            cost.instructions, cost.instructions_max, cost.cycles, cost.flash, cost.ram
        );
        let _ = writeln!(
            text,
            "whole interrupt     {:.0} cycles a tick, {:.0} at most (estimate): the share of the processor is this one's",
            interrupt.cycles, interrupt.cycles_max
        );
        text += &trade.beside_drives(chosen);
        let _ = writeln!(text, "measured by         {}", chosen.command);
        let _ = writeln!(text, "scene               {}", path.display());
        text
    }
}

/// The point with the smallest torque error among those with a complete closed loop.
fn most_accurate<'a>(points: impl Iterator<Item = &'a TradePoint>) -> Option<&'a TradePoint> {
    let error = |point: &&TradePoint| point.torque_of_limit.unwrap_or(f64::INFINITY);
    points.filter(|point| point.tracking.is_some()).min_by(|a, b| error(a).total_cmp(&error(b)))
}

/// Differences between two points' choices.
fn differences(best: &TradePoint, chosen: &TradePoint) -> String {
    let (a, b) = (best.choice.cells(), chosen.choice.cells());
    let [scalar, trig, terms, friction, rotors, every, kernel, _] = core::array::from_fn(|i| (&a[i], &b[i]));
    let axes = [("scalar", scalar), ("trig", trig), ("terms", terms), ("model every", every), ("kernel", kernel)];
    let switches = [("friction", friction), ("rotors", rotors)];
    let axes = axes.iter().filter(|(_, (a, b))| a != b).map(|(what, (a, b))| format!("{what} {b} in place of {a}"));
    let switches = switches.iter().filter(|(_, (a, b))| a != b).map(|(what, (_, b))| format!("{what} {b}"));
    let all: Vec<String> = axes.chain(switches).collect();
    all.join("; ")
}
