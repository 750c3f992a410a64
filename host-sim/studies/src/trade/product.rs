//! The set of choices to measure.

use super::baseline::Baseline;
use super::choice::{Choice, Every, TermSet};
use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use dynamics_core::control::Between;
use dynamics_core::trig::Method;
use robot_compiler::kernel::Level;
use robot_compiler::names::Named as _;
use robot_compiler::scene::ScalarChoice;
use sim::failure::Failure;
use sim::terminal::named;

/// Values to combine on each axis.
#[derive(Clone, Debug, PartialEq, Args)]
pub struct TradeAxes {
    /// Floating-point types.
    #[arg(long, value_parser = named::<ScalarChoice>(), value_delimiter = ',', default_values = ["f32"])]
    pub scalar: Vec<ScalarChoice>,
    /// Sines and cosines.
    #[arg(
        long,
        value_parser = named::<Method>(),
        value_delimiter = ',',
        default_values = ["polynomial", "polynomial-3", "table"]
    )]
    pub trig: Vec<Method>,
    /// Sets of terms.
    #[arg(long, value_parser = named::<TermSet>(), value_delimiter = ',', default_values = ["full", "no-coriolis", "diagonal", "gravity", "none"])]
    pub terms: Vec<TermSet>,
    /// Friction feedforward, if the scene has it.
    #[arg(long, value_parser = switch(), value_delimiter = ',', default_values = ["on"])]
    pub friction: Vec<bool>,
    /// Rotors in the model, if the scene has them.
    #[arg(long, value_parser = switch(), value_delimiter = ',', default_values = ["on"])]
    pub rotors: Vec<bool>,
    /// Ticks in which the model is evaluated.
    #[arg(long, value_delimiter = ',', default_values = ["1", "4:extrapolate"], value_name = "TICKS[:BETWEEN]")]
    pub every: Vec<Every>,
    /// Levels of the arm's kernel.
    #[arg(long, value_parser = named::<Level>(), value_delimiter = ',', default_values = ["regrouped"])]
    pub kernel: Vec<Level>,
    /// Control rates, Hz. Without it, the scene's.
    #[arg(long, value_delimiter = ',', value_name = "HZ")]
    pub rate: Vec<f64>,
    /// Only the combinations of the given options, without the scene's own settings and their single changes.
    #[arg(long)]
    pub alone: bool,
}

/// Parser of `on` and `off`.
fn switch() -> impl TypedValueParser<Value = bool> {
    let values = [PossibleValue::new("on").help("It counts"), PossibleValue::new("off").help("It is left out")];
    PossibleValuesParser::new(values).map(|name| name == "on")
}

/// Other evaluation schedules to compare with the scene's own.
const OTHER_TICKS: [Every; 5] = [
    Every::TICK,
    Every { ticks: 2, between: Between::Hold },
    Every { ticks: 4, between: Between::Hold },
    Every { ticks: 4, between: Between::Extrapolate },
    Every { ticks: 16, between: Between::Extrapolate },
];

/// The product of the axes and, unless `alone` is set, the scene's own choice and its variations in one axis. Each choice occurs once. A given `rate`
/// (Hz) replaces every control rate.
pub fn choices(axes: &TradeAxes, base: &Baseline, rate: Option<f64>) -> Result<Vec<Choice>, Failure> {
    let own = Choice { rate: rate.unwrap_or(base.file.control.rate), ..base.own() };
    let rates = match rate {
        None if !axes.rate.is_empty() => axes.rate.clone(),
        _ => vec![own.rate],
    };
    if let Some(rate) = rates.iter().find(|rate| !(**rate >= 16.0 && **rate <= 1e5)) {
        return Err(Failure::Input(miette::miette!("--rate {rate}: expected a rate in Hz, 16 to 100,000")));
    }
    let model = &base.file.model;
    let (with_friction, turns) = (model.friction, !matches!(model.rotor, dynamics_core::Term::Absent));
    // If the scene has no friction or rotors, leaving them out is not a choice.
    let on = |switches: &[bool], there: bool| if there { switches.to_vec() } else { vec![true] };
    let mut product = vec![own];
    spread(&mut product, &rates, |choice, rate| Choice { rate, ..choice });
    spread(&mut product, &axes.scalar, |choice, scalar| Choice { scalar, ..choice });
    spread(&mut product, &axes.terms, |choice, terms| Choice { terms, ..choice });
    spread(&mut product, &on(&axes.friction, with_friction), |choice, friction| Choice { friction, ..choice });
    spread(&mut product, &on(&axes.rotors, turns), |choice, rotors| Choice { rotors, ..choice });
    spread(&mut product, &axes.kernel, |choice, kernel| Choice { kernel, ..choice });
    spread(&mut product, &axes.every, |choice, every| Choice { every, ..choice });
    spread(&mut product, &axes.trig, |choice, trig| Choice { trig, ..choice });
    if !axes.alone {
        product.push(own);
        product.extend(ScalarChoice::NAMES.iter().map(|&(.., scalar)| Choice { scalar, ..own }));
        product.extend(Method::NAMES.iter().map(|&(.., trig)| Choice { trig, ..own }));
        product.extend(TermSet::NAMES.iter().map(|&(.., terms)| Choice { terms, ..own }));
        product.extend(with_friction.then_some(Choice { friction: false, ..own }));
        product.extend(turns.then_some(Choice { rotors: false, ..own }));
        product.extend(OTHER_TICKS.map(|every| Choice { every, ..own }));
        product.extend(Level::ALL.map(|kernel| Choice { kernel, ..own }));
    }
    let mut all: Vec<Choice> = Vec::new();
    for choice in product {
        // Axes without effect take their simplest value, except in the scene's own choice.
        let choice = if choice == own { own } else { choice.plain() };
        if !all.contains(&choice) {
            all.push(choice);
        }
    }
    Ok(all)
}

/// Combines every choice with each of these values.
fn spread<T: Copy>(choices: &mut Vec<Choice>, values: &[T], with: impl Fn(Choice, T) -> Choice) {
    let with = &with;
    *choices = choices.iter().flat_map(|&choice| values.iter().map(move |&value| with(choice, value))).collect();
}
