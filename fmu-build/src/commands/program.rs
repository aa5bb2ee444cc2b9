//! The commands that start a Python program, with the words of the command line as they are: `cargo
//! fmu demo`, `cargo fmu sweep` and others.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Context;

use crate::cargo;
use crate::commands::{build, side_by_side};
use crate::platform::Version;
use crate::progress;
use crate::python::{DEMO, Environment, Packages, RUNNING};
use crate::workspace::{MODEL_IDENTIFIER, Workspace};

/// A command.
pub struct Program {
    pub name: &'static str,
    /// Its line in the help.
    pub about: &'static str,
    /// Whether it needs words.
    pub needs_words: bool,
    /// The Python module.
    module: &'static str,
    /// Options that select another module, which gets the words behind the name instead.
    others: &'static [(&'static str, &'static [&'static str])],
    packages: &'static Packages,
    fmu: Fmu,
}

/// The FMU that a program gets.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Fmu {
    /// Runs: it is built.
    Runs,
    /// Is read for its variables only.
    Variables,
    /// That of the paper's belts.
    OfPaper,
}

const HELP: [&str; 2] = ["--help", "-h"];

/// Other options for which nothing is built: the FMU is given, or it is not used.
const WITHOUT_BUILD: [&str; 4] = ["--fmu", "--check", "--template", "--print-job"];

const COMMON: Program = Program {
    name: "",
    about: "",
    needs_words: false,
    module: "",
    others: &[],
    packages: &RUNNING,
    fmu: Fmu::Runs,
};

/// All of them. A line in the help is the documentation of a command beside the program's own
/// `--help`.
pub const PROGRAMS: [Program; 12] = [
    Program {
        name: "demo",
        about: "Simulate published load cases with the FMU and write target/demo/report.html",
        module: "pushbelt.demo",
        packages: &DEMO,
        ..COMMON
    },
    Program {
        name: "drive",
        about: "Drive a car with the FMU on the WLTC and write target/drive/report.html; with --cosim by FMUs in ecos and libcosim",
        module: "pushbelt.drive",
        others: &[("--cosim", &["pushbelt_cosim"])],
        ..COMMON
    },
    Program {
        name: "durability",
        about: "Compute the fatigue of the ring over a run and write target/durability/report.html",
        needs_words: true,
        module: "pushbelt.durability",
        fmu: Fmu::Variables,
        ..COMMON
    },
    Program {
        name: "paper",
        about: "Run the paper's examples with every ring model and write target/paper/report.html",
        module: "pushbelt_paper",
        fmu: Fmu::OfPaper,
        ..COMMON
    },
    Program {
        name: "sweep",
        about: "Solve for 2288 steady states with the FMU and write target/sweep/report.html",
        module: "pushbelt.sweep",
        ..COMMON
    },
    Program {
        name: "belt",
        about: "Write a parameter set for a belt of given dimensions to target/belt/",
        needs_words: true,
        module: "pushbelt.belt",
        ..COMMON
    },
    Program {
        name: "maps",
        about: "Solve for maps of the variator and write them as NetCDF, MATLAB, Modelica and CSV files and target/maps/report.html",
        module: "pushbelt.maps",
        ..COMMON
    },
    Program {
        name: "calibrate",
        about: "Fit parameters to a table of measured steady points and write target/calibrate/report.html",
        needs_words: true,
        module: "pushbelt.calibrate",
        ..COMMON
    },
    Program {
        name: "validate",
        about: "Compare the FMU with theory and measurements and write target/validate/report.html",
        module: "pushbelt_validation",
        ..COMMON
    },
    Program {
        name: "compare",
        about: "Compare two runs and write target/compare/report.html",
        needs_words: true,
        module: "pushbelt.compare",
        fmu: Fmu::Variables,
        ..COMMON
    },
    Program {
        name: "linearize",
        about: "Write linear models A, B, C, D about steady working points and target/linearize/report.html",
        module: "pushbelt.linearize",
        ..COMMON
    },
    Program {
        name: "bench",
        about: "Measure the speed of the model, with --maps of the maps, with --calibrate of a calibration, with --forces of clamping forces",
        others: &[
            ("--maps", &["pushbelt.maps", "--measure"]),
            ("--calibrate", &["pushbelt_benchmarks.calibration"]),
            ("--forces", &["pushbelt_benchmarks.forces"]),
        ],
        ..COMMON
    },
];

impl Program {
    /// The program of a command.
    pub fn of(name: &str) -> Option<&'static Self> {
        PROGRAMS.iter().find(|program| program.name == name)
    }

    /// The Python module with its arguments; none for the Rust benchmark. A `--` before options of
    /// the program is not needed.
    fn chosen(&self, words: &[String]) -> (Option<&'static str>, Vec<String>) {
        let mut words = words.to_vec();
        let mut remove = |word: &str| {
            let found = words.iter().position(|other| other == word);
            found.map(|place| words.remove(place)).is_some()
        };
        remove("--");
        let other = self.others.iter().find(|(option, _)| remove(option));
        let Some((_, [module, more @ ..])) = other else {
            return ((!self.module.is_empty()).then_some(self.module), words);
        };
        words.extend(more.iter().map(|&word| word.to_owned()));
        (Some(module), words)
    }

    /// Builds the FMU if it is needed and not given, installs the Python packages, and runs the
    /// program in the working directory. Its results go to a folder of the command's name below the
    /// target directory.
    ///
    /// # Errors
    /// The FMU doesn't build, the packages can't be installed, or the program fails.
    pub fn run(&self, workspace: &Workspace, words: &[String]) -> anyhow::Result<()> {
        let (module, words) = self.chosen(words);
        let Some(module) = module else {
            let program = cargo::build_program(workspace, cargo::BENCHMARK)?;
            progress::headline("Measuring");
            return cargo::run(Command::new(program).current_dir(workspace.root()).args(words));
        };
        let (fmu, environment) = side_by_side(
            || self.fmu(workspace, needs_build(&words)),
            || Environment::prepare(workspace, self.packages),
        )?;
        progress::headline(&format!("Running {module}"));
        let mut program = environment.command();
        program
            .current_dir(std::env::current_dir().context("there is no working directory")?)
            .args(["-m", module, "--fmu"])
            .arg(fmu)
            .arg("--output")
            .arg(workspace.target().join(self.name))
            .env("PUSHBELT_COMMAND", command_line(std::env::args().skip(1)));
        if self.fmu == Fmu::OfPaper && !has_one(&words, &HELP) {
            program
                .arg("--rings")
                .arg(cargo::build_program(workspace, cargo::RINGS)?);
        }
        cargo::run(program.args(words))
    }

    fn fmu(&self, workspace: &Workspace, needs_build: bool) -> anyhow::Result<PathBuf> {
        match (self.fmu, needs_build) {
            (Fmu::Runs, true) => build::run(workspace, &build::Arguments::default()),
            (Fmu::OfPaper, true) => build::run_paper(workspace),
            (Fmu::Variables, true) => build::run_description(workspace),
            // The same option in the words comes later and counts.
            (_, false) => Ok(workspace.fmu(MODEL_IDENTIFIER, Version::Two)),
        }
    }
}

fn needs_build(words: &[String]) -> bool {
    !has_one(words, &HELP) && !has_one(words, &WITHOUT_BUILD)
}

/// Whether one of the options is among the words, alone or with its value behind `=`.
fn has_one(words: &[String], options: &[&str]) -> bool {
    let mut given = words.iter().map(|word| word.split('=').next().unwrap_or(word));
    given.any(|word| options.contains(&word))
}

/// The command that started this tool, for a shell: the reports name it.
fn command_line(arguments: impl Iterator<Item = String>) -> String {
    let plain = |word: &str| {
        !word.is_empty() && word.chars().all(|c| c.is_alphanumeric() || "-_=./:,+@%".contains(c))
    };
    let quoted = |word: String| {
        if plain(&word) {
            word
        } else {
            format!("'{}'", word.replace('\'', "'\"'\"'"))
        }
    };
    let words: Vec<String> = ["cargo".to_owned(), "fmu".to_owned()]
        .into_iter()
        .chain(arguments.map(quoted))
        .collect();
    words.join(" ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<String> {
        line.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn the_command_line_can_be_pasted_into_a_shell() {
        let words =
            ["calibrate", "my table.csv", "--", "--map", "i=ratio.geometric", "it's"].map(str::to_owned);
        assert_eq!(
            command_line(words.into_iter()),
            "cargo fmu calibrate 'my table.csv' -- --map i=ratio.geometric 'it'\"'\"'s'"
        );
    }

    #[test]
    fn words_are_passed_on_with_and_without_dashes_before_them() {
        for (command, module, expected) in [
            ("demo", Some("pushbelt.demo"), ""),
            (
                "sweep --short -- --set a=1",
                Some("pushbelt.sweep"),
                "--short --set a=1",
            ),
            ("drive --cosim --short", Some("pushbelt_cosim"), "--short"),
            ("drive -- --until 400", Some("pushbelt.drive"), "--until 400"),
            ("bench -- --quick --only begj", None, "--quick --only begj"),
            ("bench --maps", Some("pushbelt.maps"), "--measure"),
            ("bench -- --calibrate", Some("pushbelt_benchmarks.calibration"), ""),
        ] {
            let (name, rest) = command.split_once(' ').unwrap_or((command, ""));
            let program = Program::of(name).expect(name);
            assert_eq!(program.chosen(&words(rest)), (module, words(expected)), "{command}");
        }
    }

    #[test]
    fn what_is_given_or_not_used_is_not_built() {
        for (line, expected) in [
            ("", true),
            ("points.csv --fit belt.play", true),
            ("points.csv --check", false),
            ("--template points.csv", false),
            ("initial.ratio=1 --fmu own.fmu", false),
            ("--fmu=own.fmu", false),
            ("--help", false),
        ] {
            assert_eq!(needs_build(&words(line)), expected, "{line}");
        }
    }

    /// Reading a run needs the names and units of variables, not a library.
    #[test]
    fn comparisons_of_files_compile_nothing() {
        let workspace = Workspace::find().unwrap();
        for name in ["compare", "durability"] {
            let program = Program::of(name).unwrap();
            assert!(program.fmu == Fmu::Variables, "{name}");
        }
        let path = Program::of("compare").unwrap().fmu(&workspace, true).unwrap();
        let archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
        assert!(archive.len() == 1 && archive.index_for_name("modelDescription.xml").is_some());
    }
}
