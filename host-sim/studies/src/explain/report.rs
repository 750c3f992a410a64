//! Tables of an explanation.

use super::{Dropped, Error, Explanation, Fewest, OnChip, OperationCount, PartReport, Tracking};
use crate::trade::chip::{Cost, Load};
use crate::trade::report::mean_share;
use comfy_table::Table;
use robot_compiler::choose::LoopGain;
use sim::run::numbers::engineering;
use sim::table::table;

impl Explanation {
    /// The tables for the terminal.
    #[must_use]
    pub fn text(&self) -> String {
        let Self { scene, robot, law, level, operations: OperationCount { mul, add, sub }, .. } = self;
        let mut text = format!("{scene}: {robot}, {law}, kernel {level}: {mul} mul, {add} add, {sub} sub\n");
        if let Some(OnChip { controller, interrupt, rate }) = self.chip {
            let Cost { instructions, cycles, flash, ram, .. } = controller;
            text += &format!(
                "the chip's controller: {instructions:.0} instructions, {cycles:.0} cycles (estimate), {flash} bytes of flash, {ram} of RAM\n\
                 the whole interrupt:   {:.0} cycles (estimate): {} of 168 MHz at {rate} Hz\n",
                interrupt.cycles,
                mean_share(interrupt.cpu_share, interrupt.cpu_share_max)
            );
        }
        text += &format!("{}\n", self.cost_table());
        let torques = self.joint_table(None, |i, dropped| {
            let (unit, error) = (self.joints[i].torque_unit, &dropped.torque_error);
            format!("{} ({})", engineering(error.max[i], unit), engineering(error.rms[i], unit))
        });
        let most = |i: usize, tracking: &Tracking| match tracking.fault {
            Some(_) => "fault".to_owned(),
            None => engineering(tracking.max[i], self.joints[i].position_unit),
        };
        let baseline = |i: usize| most(i, &self.tracking);
        let tracking = self.joint_table(Some(&baseline), |i, dropped| most(i, &dropped.tracking));
        text += &format!("\nTorque left out without, on the reference motion: most (root mean square)\n{torques}\n");
        text += &format!("\nGreatest tracking error of the closed loop without, in the scene's world\n{tracking}\n");
        if !self.friction.is_empty() {
            text += &format!("\nTerms of friction beyond viscous and Coulomb friction\n{}\n", self.friction_table());
        }
        text + "\n" + &self.fewest_lines()
    }

    /// A row per term and joint with the term: its torque, the tracking error without it, and its cost.
    fn friction_table(&self) -> Table {
        let mut head = vec!["term", "joint", "torque: most (rms)", "tracking error", "without", "mul", "add", "sub"];
        if self.chip.is_some() {
            head.extend(["instructions", "cycles, est.", "flash"]);
        }
        let mut table = table(head, 2);
        for PartReport { term, joints, operations: OperationCount { mul, add, sub }, chip, torque, tracking } in
            &self.friction
        {
            for (i, joint) in self.joints.iter().enumerate().filter(|(_, joint)| joints.contains(&joint.name)) {
                let most = |error: f64| engineering(error, joint.position_unit);
                let [max, rms] = [torque.max[i], torque.rms[i]].map(|x| engineering(x, joint.torque_unit));
                let without = tracking.fault.as_ref().map_or_else(|| most(tracking.max[i]), |_| "fault".to_owned());
                // The cost is the total for all joints with the term, shown in the row of the first.
                let first = joints.first() == Some(&joint.name);
                let of_term = [mul, add, sub].map(i64::to_string).into_iter();
                let on_chip = chip.iter().flat_map(|chip| {
                    [format!("{:.0}", chip.instructions), format!("{:.0}", chip.cycles), chip.flash.to_string()]
                });
                let cost = of_term.chain(on_chip).map(|cell| if first { cell } else { String::new() });
                let cells = [(*term).to_owned(), joint.name.clone(), format!("{max} ({rms})")].into_iter();
                let cells = cells.chain([most(self.tracking.max[i]), without]);
                table.add_row(cells.chain(cost).collect::<Vec<_>>());
            }
        }
        table
    }

    fn cost_table(&self) -> Table {
        let mut head = vec!["term", "is", "because of", "mul", "add", "sub"];
        if self.chip.is_some() {
            head.extend(["instructions", "cycles, est.", "flash", "interrupt without", "share without"]);
        }
        head.extend(["torque error", "of the limit", "joint", "loop gain", "may go"]);
        let mut table = table(head.clone(), 3);
        for report in &self.terms {
            let names = [report.term, report.state, &report.why].map(str::to_owned);
            let Some(dropped) = &report.dropped else {
                let empty = core::iter::repeat_n("-".to_owned(), head.len() - 3);
                table.add_row(names.into_iter().chain(empty).collect::<Vec<_>>());
                continue;
            };
            let Dropped { operations: OperationCount { mul, add, sub }, chip, torque_error, may_go, .. } = dropped;
            let worst = torque_error.worst();
            let joint = &self.joints[worst];
            let share = self.share(torque_error, worst);
            let most = engineering(torque_error.max[worst], joint.torque_unit);
            let may_go = if *may_go { "yes" } else { "no" };
            let counts = [mul, add, sub].map(i64::to_string);
            let on_chip = chip.iter().flat_map(|chip| {
                let Load { cycles, cpu_share, cpu_share_max, .. } = chip.interrupt;
                [
                    format!("{:.0}", chip.instructions),
                    format!("{:.0}", chip.cycles),
                    chip.flash.to_string(),
                    format!("{cycles:.0}"),
                    mean_share(cpu_share, cpu_share_max),
                ]
            });
            let rest = [most, share, joint.name.clone(), self.loop_gain(dropped), may_go.to_owned()];
            table.add_row(names.into_iter().chain(counts).chain(on_chip).chain(rest).collect::<Vec<_>>());
        }
        table
    }

    /// Share of a joint's torque limit, or of its greatest torque along the motion if it has no limit.
    fn share(&self, error: &Error, joint: usize) -> String {
        let share = percent(error.share[joint]);
        if error.of_limit[joint].is_some() { share } else { format!("{share} of its greatest torque") }
    }

    /// Description of the quantity to which the tolerance refers.
    fn whole(&self) -> &'static str {
        if self.joints.iter().all(|joint| joint.torque_limit.is_some()) {
            "each joint's torque limit"
        } else {
            "each joint's torque limit, or of its greatest torque on this motion where it has none; tracking at most doubled"
        }
    }

    /// The smallest loop gain and its weakest joint.
    fn loop_gain(&self, dropped: &Dropped) -> String {
        dropped.weakest_joint.map_or_else(
            || "1".to_owned(),
            |joint| format!("{} {}", percent(dropped.loop_gain), self.joints[joint].name),
        )
    }

    /// Table with a row per joint. Its columns: the errors with nothing dropped (if given), the errors without each present term, and the errors
    /// without all terms that can be dropped together.
    fn joint_table(
        &self,
        nothing: Option<&dyn Fn(usize) -> String>,
        cell: impl Fn(usize, &Dropped) -> String,
    ) -> Table {
        let each = self.terms.iter().filter_map(|report| Some((report.term, report.dropped.as_ref()?)));
        let together = (self.fewest.given_up.len() > 1).then_some(("all that may go", &self.fewest.dropped));
        let columns: Vec<(&str, &Dropped)> = each.chain(together).collect();
        let head =
            core::iter::once("joint").chain(nothing.map(|_| "nothing")).chain(columns.iter().map(|(name, _)| *name));
        let mut table = table(head.collect::<Vec<_>>(), 1);
        for (i, joint) in self.joints.iter().enumerate() {
            let cells = columns.iter().map(|(_, dropped)| cell(i, dropped));
            let cells = core::iter::once(joint.name.clone()).chain(nothing.map(|cell| cell(i))).chain(cells);
            table.add_row(cells.collect::<Vec<_>>());
        }
        table
    }

    fn fewest_lines(&self) -> String {
        let Fewest { chosen, given_up, dropped } = &self.fewest;
        let OperationCount { mul, add, sub } = dropped.operations;
        let what = if given_up.is_empty() {
            "nothing".to_owned()
        } else {
            let gain = self.loop_gain(dropped);
            let names = given_up.join(", ");
            let share = self.share(&dropped.torque_error, dropped.torque_error.worst());
            let share = if share.contains("greatest") { share } else { format!("{share} of a limit") };
            format!("{names}: {share} at most, loop gain {gain}, {mul} mul, {add} add, {sub} sub less")
        };
        let verb = if *chosen { "given up" } else { "could go" };
        let mut lines = vec![
            ("tolerance", format!("{} of {}", percent(self.tolerance), self.whole())),
            ("least loop gain", format!("{} of the full model's", LoopGain::LEAST)),
            (verb, what),
        ];
        let faults = self.terms.iter().filter_map(|report| {
            let fault = report.dropped.as_ref()?.tracking.fault.as_ref()?;
            Some(format!("{}: {fault}", report.term))
        });
        lines.extend(faults.map(|fault| ("fault without", fault)));
        if self.law == "pd" {
            lines.push(("law", "pd computes no inverse dynamics: in its loop only friction is felt".to_owned()));
        }
        lines.iter().fold(String::new(), |text, (name, line)| text + &format!("{name:<20}{line}\n"))
    }
}

fn percent(share: f64) -> String {
    format!("{:.3} %", 100.0 * share)
}
