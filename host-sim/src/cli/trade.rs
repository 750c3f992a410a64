//! `trade` and `choose`: what every choice costs, and the cheapest that does.

use crate::cli::document::Document;
use crate::cli::progress::progress_bar;
use crate::cli::run::{file_name, in_file};
use crate::cli::{AxisArgs, ChooseArgs, LevelName, RunScalar, Switch, TradeArgs};
use crate::failure::{self, Failure};
use crate::study::trade::base::Base;
use crate::study::trade::choice::{Choice, Every, TermSet};
use crate::study::trade::report::percent;
use crate::study::trade::{Costs, Point, Trade, Workshop, trade};
use clap::ValueEnum;
use dynamics_core::control::Between;
use dynamics_core::trig::Method;
use robot_compiler::scene::ControlSpec;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// Measure a trade-off, print and write it.
///
/// # Errors
/// A scene that is wrong or a choice that it cannot have; a chip that cannot be built or run; an interruption.
pub fn run(args: &TradeArgs, costs: &Costs<'_>, stop: &AtomicBool) -> Result<(), Failure> {
    let base = Base::load(&args.scene)?;
    let place = place_of(&base.file.name);
    let document = args.write.as_deref().map(|path| Document::read(path, &[&place])).transpose()?;
    let folder = folder(args.out.as_deref(), &base)?;
    let trade = measured(&base, &args.scene, &choices(&args.axes, &base, None)?, costs, &folder, args.fresh, stop)?;
    let csv = folder.join("trade.csv");
    trade.write_csv(&csv)?;
    let plot = folder.join("trade.svg");
    trade.write_plot(&plot).map_err(|error| in_file(&plot, &error))?;
    if let Some(mut document) = document {
        let picture = format!("trade_{}.svg", file_name(&base.file.name));
        let path = document.folder().join(&picture);
        trade.write_plot(&path).map_err(|error| in_file(&path, &error))?;
        document.put(&place, &format!("{}\n![every choice of {}]({picture})\n", trade.markdown(), trade.scene))?;
        document.write()?;
    }
    let text = if args.json {
        serde_json::to_string_pretty(&trade).map_err(|error| Failure::Output(error.into()))? + "\n"
    } else {
        format!("{}files     {}\n          {}\n", trade.table(), csv.display(), plot.display())
    };
    failure::print(&text)
}

fn place_of(scene: &str) -> String {
    format!("trade, {scene}")
}

fn folder(out: Option<&Path>, base: &Base) -> Result<PathBuf, Failure> {
    let folder = out.map_or_else(|| Path::new("out/trade").join(file_name(&base.file.name)), Path::to_owned);
    fs::create_dir_all(&folder).map_err(|error| in_file(&folder, &error))?;
    Ok(folder)
}

fn measured(
    base: &Base,
    scene: &Path,
    choices: &[Choice],
    costs: &Costs<'_>,
    folder: &Path,
    fresh: bool,
    stop: &AtomicBool,
) -> Result<Trade, Failure> {
    let progress = progress_bar(None, "measurements");
    trade(base, scene, choices, costs, &Workshop { folder, fresh, stop, progress: &progress })
}

/// The product of the axes and, unless the product is to be alone, the scene's own choice with each that differs from it in one
/// thing; each choice once, always at `rate` (Hz) where one is given.
fn choices(axes: &AxisArgs, base: &Base, rate: Option<f64>) -> Result<Vec<Choice>, Failure> {
    let own = Choice { rate: rate.unwrap_or(base.file.control.rate), ..base.own() };
    let rates = match rate {
        None if !axes.rate.is_empty() => axes.rate.clone(),
        _ => vec![own.rate],
    };
    if let Some(rate) = rates.iter().find(|rate| !(**rate >= 16.0 && **rate <= 1e5)) {
        return Err(Failure::Input(miette::miette!("--rate {rate}: expected a rate in Hz, 16 to 100,000")));
    }
    let model = &base.file.model;
    let (rubs, turns) = (model.friction, !matches!(model.rotor, dynamics_core::Term::Absent));
    // Without friction or rotors in the scene, leaving them out is no choice.
    let on = |switches: &[Switch], there: bool| -> Vec<bool> {
        if there { switches.iter().map(|switch| *switch == Switch::On).collect() } else { vec![true] }
    };
    let trigs: Vec<Method> = axes.trig.iter().filter_map(|name| ControlSpec::trig_named(name)).collect();
    let mut product = vec![own];
    spread(&mut product, &rates, |choice, rate| Choice { rate, ..choice });
    spread(&mut product, &axes.scalar, |choice, scalar| Choice { scalar, ..choice });
    spread(&mut product, &axes.terms, |choice, terms| Choice { terms, ..choice });
    spread(&mut product, &on(&axes.friction, rubs), |choice, friction| Choice { friction, ..choice });
    spread(&mut product, &on(&axes.rotors, turns), |choice, rotors| Choice { rotors, ..choice });
    spread(&mut product, &axes.kernel, |choice, kernel| Choice { kernel, ..choice });
    spread(&mut product, &axes.every, |choice, every| Choice { every, ..choice });
    spread(&mut product, &trigs, |choice, trig| Choice { trig, ..choice });
    if !axes.alone {
        product.push(own);
        product.extend(RunScalar::value_variants().iter().map(|&scalar| Choice { scalar, ..own }));
        let named = ControlSpec::trig_names();
        product.extend(named.iter().filter_map(|name| Some(Choice { trig: ControlSpec::trig_named(name)?, ..own })));
        product.extend(TermSet::value_variants().iter().map(|&terms| Choice { terms, ..own }));
        product.extend(rubs.then_some(Choice { friction: false, ..own }));
        product.extend(turns.then_some(Choice { rotors: false, ..own }));
        product.extend(OTHER_TICKS.map(|every| Choice { every, ..own }));
        product.extend(LevelName::value_variants().iter().map(|&kernel| Choice { kernel, ..own }));
    }
    let mut all: Vec<Choice> = Vec::new();
    for choice in product {
        // What has no effect is at its plainest, except in the scene's own choice.
        let choice = if choice == own { own } else { choice.plain() };
        if !all.contains(&choice) {
            all.push(choice);
        }
    }
    Ok(all)
}

/// When else the model is evaluated, to compare the scene's own choice with.
const OTHER_TICKS: [Every; 5] = [
    Every::TICK,
    Every { ticks: 2, between: Between::Hold },
    Every { ticks: 4, between: Between::Hold },
    Every { ticks: 4, between: Between::Extrapolate },
    Every { ticks: 16, between: Between::Extrapolate },
];

/// Every choice with each of these.
fn spread<T: Copy>(choices: &mut Vec<Choice>, values: &[T], with: impl Fn(Choice, T) -> Choice) {
    let with = &with;
    *choices = choices.iter().flat_map(|&choice| values.iter().map(move |&value| with(choice, value))).collect();
}

/// Choose the cheapest point that meets a request, and write its scene.
///
/// # Errors
/// As [`run`]; a request that is none, or one that no choice meets.
pub fn choose(args: &ChooseArgs, costs: &Costs<'_>, stop: &AtomicBool) -> Result<(), Failure> {
    if args.max_torque_error.is_none() && args.max_tracking_error.is_none() && args.budget.is_none() {
        return Err(Failure::Input(miette::miette!(
            "nothing was asked for: expected --max-torque-error, --max-tracking-error, --budget, or several of them"
        )));
    }
    let base = Base::load(&args.scene)?;
    let work = folder(None, &base)?;
    let rate = args.budget.map(|budget| budget.rate);
    let trade = measured(&base, &args.scene, &choices(&args.axes, &base, rate)?, costs, &work, args.fresh, stop)?;
    let request = Request {
        torque: args.max_torque_error.map(|share| share.0),
        tracking: args.max_tracking_error,
        share: args.budget.map(|budget| budget.share),
        clock: args.clock * 1e6,
    };
    let Some(chosen) = request.cheapest(&trade) else {
        return Err(Failure::Input(miette::miette!(
            help = request.nearest(&trade),
            "{}: none of {} choices meets the request",
            args.scene.display(),
            trade.points.len()
        )));
    };
    let path = args.out.clone().unwrap_or_else(|| work.join("chosen.toml"));
    let home = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::create_dir_all(home).map_err(|error| in_file(home, &error))?;
    let name = path.file_stem().map_or_else(|| base.file.name.clone(), |stem| stem.to_string_lossy().into_owned());
    fs::write(&path, base.with_in(&chosen.chosen, &name, home)).map_err(|error| in_file(&path, &error))?;
    if args.json {
        let text = serde_json::json!({ "scene": path, "point": chosen, "cpu_share": request.share_of(chosen) });
        let text = serde_json::to_string_pretty(&text).map_err(|error| Failure::Output(error.into()))?;
        return failure::print(&(text + "\n"));
    }
    failure::print(&request.explain(&trade, chosen, &path))
}

/// What a choice must meet.
struct Request {
    /// Greatest torque error, a share of the limit.
    torque: Option<f64>,
    /// Greatest tracking error, rad or m.
    tracking: Option<f64>,
    /// Greatest share of the processor.
    share: Option<f64>,
    /// Cycles in a second.
    clock: f64,
}

impl Request {
    /// Share of the processor that the mean tick takes.
    fn share_of(&self, point: &Point) -> f64 {
        point.cost.cycles * point.choice.rate / self.clock
    }

    /// The mean tick keeps the share, and the longest ends before the next is due.
    fn fits(&self, point: &Point) -> bool {
        let longest = point.cost.cycles_max * point.choice.rate / self.clock;
        self.share.is_none_or(|share| self.share_of(point) <= share) && longest <= 1.0
    }

    fn accurate(&self, point: &Point) -> bool {
        let keeps = |most: Option<f64>, found: Option<f64>| most.is_none_or(|most| found.is_some_and(|x| x <= most));
        point.tracking.is_some() && keeps(self.torque, point.torque_of_limit) && keeps(self.tracking, point.tracking)
    }

    /// Points come with the fewest cycles first.
    fn cheapest<'a>(&self, trade: &'a Trade) -> Option<&'a Point> {
        trade.points.iter().find(|point| self.accurate(point) && self.fits(point))
    }

    /// What it would take: the cheapest that is accurate enough, and the most accurate that fits.
    fn nearest(&self, trade: &Trade) -> String {
        let mut text = String::new();
        match trade.points.iter().find(|point| self.accurate(point)) {
            Some(point) => {
                let _ = writeln!(text, "accurate enough, and cheapest of those: {}", self.line(point));
            }
            None => text += "no choice is accurate enough\n",
        }
        let error = |point: &&Point| point.torque_of_limit.unwrap_or(f64::INFINITY);
        let fitting = trade.points.iter().filter(|point| self.fits(point) && point.tracking.is_some());
        match fitting.min_by(|a, b| error(a).total_cmp(&error(b))) {
            Some(point) => {
                let _ = write!(text, "within the budget, and most accurate of those: {}", self.line(point));
            }
            None => text += "no choice is within the budget",
        }
        text
    }

    fn line(&self, point: &Point) -> String {
        let n = &point.choice;
        let torque = point.torque_of_limit.map_or("fault".to_owned(), percent);
        let tracking = point.tracking.map_or("fault".to_owned(), |x| crate::run::summary::engineering(x, "rad"));
        format!(
            "{}, {} trig, terms {}, friction {}, rotors {}, model every {}, {}: {} of the processor at {} Hz, torque error {torque}, tracking error {tracking}",
            n.scalar,
            n.trig,
            n.terms,
            n.friction,
            n.rotors,
            n.every,
            n.kernel,
            percent(self.share_of(point)),
            n.rate
        )
    }

    fn explain(&self, trade: &Trade, chosen: &Point, path: &Path) -> String {
        let mut text = format!("chosen              {}\n", self.line(chosen));
        // The best in accuracy of all, to say what was given up.
        let error = |point: &&Point| point.torque_of_limit.unwrap_or(f64::INFINITY);
        if let Some(best) =
            trade.points.iter().filter(|point| point.tracking.is_some()).min_by(|a, b| error(a).total_cmp(&error(b)))
        {
            let given_up = differences(best, chosen);
            let what =
                if given_up.is_empty() { "nothing: it is the most accurate of all".to_owned() } else { given_up };
            let _ = writeln!(text, "given up            {what}");
            let _ = writeln!(text, "most accurate       {}", self.line(best));
        }
        let _ = writeln!(
            text,
            "instructions        {:.0} a tick, {} at most; {:.0} cycles (estimate), flash {}, RAM {}",
            chosen.cost.instructions,
            chosen.cost.instructions_max,
            chosen.cost.cycles,
            chosen.cost.flash,
            chosen.cost.ram
        );
        let _ = writeln!(text, "measured by         {}", chosen.command);
        let _ = writeln!(text, "scene               {}", path.display());
        text
    }
}

/// What one point has and the other has otherwise.
fn differences(best: &Point, chosen: &Point) -> String {
    let (a, b) = (&best.choice, &chosen.choice);
    let pairs = [
        ("scalar", &a.scalar, &b.scalar),
        ("trig", &a.trig, &b.trig),
        ("terms", &a.terms, &b.terms),
        ("model every", &a.every, &b.every),
        ("kernel", &a.kernel, &b.kernel),
    ];
    let mut all: Vec<String> =
        pairs.iter().filter(|(_, a, b)| a != b).map(|(what, a, b)| format!("{what} {b} in place of {a}")).collect();
    let switches = [("friction", a.friction, b.friction), ("rotors", a.rotors, b.rotors)];
    all.extend(switches.iter().filter(|(_, a, b)| a != b).map(|(what, _, b)| format!("{what} {b}")));
    all.join("; ")
}
