//! `cargo fmu belt`: a parameter set for a belt of given dimensions, checked by the FMU.

use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// Dimensions of the belt.
#[derive(Args)]
pub struct Arguments {
    /// Passed on to the program: --width 30 --layers 12 --length 0.70 --center-distance 0.17 …; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, required = true)]
    passed_on: Vec<String>,
}

/// Writes the set, and prints its values and the path.
///
/// # Errors
/// The FMU doesn't build, the dimensions belong to no belt, or the stress of the ring is beyond its limits.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let mut belt = python_program(workspace, "pushbelt.belt", "belt", "Computing")?;
    cargo::run(belt.args(&arguments.passed_on))
}
