//! `cargo fmu compare`: comparison of two runs, and a report.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// The runs.
#[derive(Args)]
pub struct Arguments {
    /// A result file of a run, or a folder of them
    a: PathBuf,
    /// The file or folder that it is compared with
    b: PathBuf,
    /// Passed on to the program; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the program, which prints where the report is.
///
/// # Errors
/// The FMU doesn't build, or the files contain no runs.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    // The program runs at the top level of the workspace.
    let absolute = |path: &Path| std::path::absolute(path).with_context(|| format!("can't find {}", path.display()));
    let runs = [absolute(&arguments.a)?, absolute(&arguments.b)?];
    let mut compare = python_program(workspace, "pushbelt.compare", "compare", "Comparing")?;
    cargo::run(compare.args(runs).args(&arguments.passed_on))
}
