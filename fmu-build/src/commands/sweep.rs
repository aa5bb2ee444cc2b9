//! `cargo fmu sweep`: a parameter study with the FMU on a cluster, its maps, and a report.

use clap::Args;

use crate::cargo;
use crate::commands::python_program;
use crate::workspace::Workspace;

/// Options of the study.
#[derive(Args)]
pub struct Arguments {
    /// Solve for 60 points instead of 2288
    #[arg(long)]
    short: bool,
    /// Address of a dask scheduler, tcp://host:port [default: a cluster on this machine]
    #[arg(long, value_name = "ADDRESS", conflicts_with = "workers")]
    scheduler: Option<String>,
    /// Processes of the cluster on this machine [default: one for each processor]
    #[arg(long, value_name = "N")]
    workers: Option<u32>,
    /// Ring model
    #[arg(long, value_parser = ["ALE", "ALE0"])]
    model: Option<String>,
    /// Measure points per second with one worker and with two, instead of the study
    #[arg(long)]
    measure: bool,
    /// Passed on to the program, such as --ratio 0.5,1,2 or --set belt.play=3e-4; `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the study, which prints the path of the report.
///
/// # Errors
/// The FMU doesn't build, the cluster can't be reached, or no point has a steady state.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    let mut sweep = python_program(workspace, "pushbelt.sweep", "sweep", "Solving")?;
    for (flag, set) in [("--short", arguments.short), ("--measure", arguments.measure)] {
        if set {
            sweep.arg(flag);
        }
    }
    for (flag, value) in [
        ("--scheduler", arguments.scheduler.clone()),
        ("--workers", arguments.workers.map(|count| count.to_string())),
        ("--model", arguments.model.clone()),
    ] {
        if let Some(value) = value {
            sweep.args([flag, &value]);
        }
    }
    cargo::run(sweep.args(&arguments.passed_on))
}
