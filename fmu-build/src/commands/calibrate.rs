//! `cargo fmu calibrate`: parameters of the FMU from a table of measured steady points, and a report.

use std::path::{Path, PathBuf};

use anyhow::Context;
use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::python::{Environment, RUNNING};
use crate::workspace::Workspace;

/// Options of the calibration.
#[derive(Args)]
pub struct Arguments {
    /// The measured points, CSV or .xlsx with units; `-- --help` explains the columns
    #[arg(value_name = "TABLE", required_unless_present_any = ["template", "passed_on"])]
    table: Option<PathBuf>,
    /// Write an example of a table, with what each column means, instead
    #[arg(long, value_name = "FILE", conflicts_with = "table")]
    template: Option<PathBuf>,
    /// Print what is understood of the table, without a fit and without the FMU
    #[arg(long, requires = "table")]
    check: bool,
    /// Parameters that are fitted, between commas, each with or without a start value: friction.pulley=0.08,belt.play
    #[arg(long, value_name = "NAMES")]
    fit: Option<String>,
    /// Fit on a coarse mesh, for a first look
    #[arg(long)]
    short: bool,
    /// Passed on to the program, such as --bounds belt.play=0:1e-3 or --variator belt155; `-- --help` lists its options
    #[arg(last = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the calibration, which prints the path of the report.
///
/// # Errors
/// The FMU doesn't build, the table can't be read, or it determines none of the parameters.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let mut calibrate = if arguments.check || arguments.template.is_some() {
        let mut reading = Environment::prepare(workspace, &RUNNING)?.command();
        reading.args(["-m", "pushbelt.calibrate"]);
        reading
    } else {
        python_program(workspace, "pushbelt.calibrate", "calibrate", "Fitting")?
    };
    if let Some(table) = &arguments.table {
        calibrate.arg(absolute(table)?);
    }
    if let Some(template) = &arguments.template {
        calibrate.arg("--template").arg(absolute(template)?);
    }
    if let Some(names) = &arguments.fit {
        calibrate.args(["--fit", names]);
    }
    if arguments.check {
        calibrate.arg("--check");
    }
    if arguments.short {
        calibrate.arg("--short");
    }
    cargo::run(calibrate.args(&arguments.passed_on))
}

/// The program runs at the top level of the workspace, independently of this tool's working directory.
fn absolute(path: &Path) -> anyhow::Result<PathBuf> {
    std::path::absolute(path).with_context(|| format!("{} is no path", path.display()))
}
