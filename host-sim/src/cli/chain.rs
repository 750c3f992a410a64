//! Options for the ends of the chain that is read from a URDF robot.

use clap::Args;
use robot_compiler::Ends;

/// Options of every command that takes a robot.
#[derive(Clone, Debug, Default, Args)]
pub struct ChainArgs {
    /// For a URDF robot: the link at the tip of the arm; default: the end of the only chain.
    #[arg(long, value_name = "LINK")]
    pub tip: Option<String>,
    /// For a URDF robot: the link at the base of the arm; default: the root.
    #[arg(long, value_name = "LINK")]
    pub base: Option<String>,
}

impl ChainArgs {
    /// The ends in the form that the file readers use.
    #[must_use]
    pub fn ends(&self) -> Ends<'_> {
        Ends { base: self.base.as_deref(), tip: self.tip.as_deref() }
    }
}
