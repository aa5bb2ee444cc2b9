//! `cargo fmu bench`: runs the programs in `benches/`.

use clap::Args;

use crate::cargo;
use crate::progress;
use crate::workspace::{MODEL_PACKAGE, Workspace};

/// What to measure.
#[derive(Args)]
pub struct Arguments {
    /// Passed on to the programs: `-- --quick` runs everything once
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the measurements.
///
/// # Errors
/// A program in `benches/` doesn't compile or fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    progress::headline("Measuring");
    let mut bench = cargo::command(workspace);
    bench.args(["bench", "--package", MODEL_PACKAGE, "--benches"]);
    bench.arg("--").args(&arguments.passed_on);
    cargo::run(&mut bench)
}
