//! Commands that can be called themselves and also have subcommands: `sweep STUDY`, and `sweep merge`.

use clap::{ArgMatches, Args, Command, Error, FromArgMatches, Subcommand};

/// A command, or a subcommand of it: combines clap's `Args` and `Subcommand`.
#[derive(Clone, Debug)]
pub enum OrPart<A, P> {
    /// The command itself.
    Itself(A),
    /// A part of it.
    Part(P),
}

impl<A: Args, P: Subcommand> FromArgMatches for OrPart<A, P> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        match matches.subcommand_name() {
            Some(_) => P::from_arg_matches(matches).map(Self::Part),
            None => A::from_arg_matches(matches).map(Self::Itself),
        }
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl<A: Args, P: Subcommand> Args for OrPart<A, P> {
    fn augment_args(command: Command) -> Command {
        let both = P::augment_subcommands(A::augment_args(command));
        both.args_conflicts_with_subcommands(true).subcommand_negates_reqs(true)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}
