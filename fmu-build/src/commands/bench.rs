//! `cargo fmu bench`: measures the speed of the model.

use std::process::Command;

use clap::Args;

use crate::cargo::{self, Program};
use crate::commands::{maps, python_program};
use crate::progress;
use crate::workspace::Workspace;

/// The program in `benches/` that measures the variator.
const VARIATOR: &str = "variator";

/// Options that measure something else instead: its program in Python, the folder of its files, and the headline.
const OTHERS: [(&str, &str, &str, &str); 2] = [
    (
        "--calibrate",
        "pushbelt.calibrate.benchmark",
        "bench-calibrate",
        "Fitting",
    ),
    ("--forces", "pushbelt.force_benchmark", "bench-forces", "Measuring"),
];

/// Options of the benchmark.
#[derive(Args)]
pub struct Arguments {
    /// Measure the time of the default maps instead, of `cargo fmu maps`
    #[arg(long)]
    maps: bool,
    /// Passed on to the benchmark: `-- --quick` runs everything once, `-- --calibrate` times a calibration, `-- --forces` clamping forces and steady states, `-- --help` lists its options
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    passed_on: Vec<String>,
}

/// Runs the measurements.
///
/// # Errors
/// The benchmark doesn't compile or fails.
pub fn run(workspace: &Workspace, arguments: &Arguments) -> anyhow::Result<()> {
    // After `--` the option is among those that are passed on.
    if arguments.maps || arguments.passed_on.iter().any(|option| option == "--maps") {
        return maps::measure(workspace);
    }
    let asked = |option: &str| arguments.passed_on.iter().any(|word| word == option);
    if let Some((option, module, folder, headline)) = OTHERS.into_iter().find(|(option, ..)| asked(option)) {
        let mut program = python_program(workspace, module, folder, headline)?;
        let others = arguments.passed_on.iter().filter(|word| *word != option);
        return cargo::run(program.args(others));
    }
    let program = cargo::build_program(workspace, Program::Bench(VARIATOR))?;
    progress::headline("Measuring");
    let mut bench = Command::new(program);
    cargo::run(bench.current_dir(workspace.root()).args(&arguments.passed_on))
}
