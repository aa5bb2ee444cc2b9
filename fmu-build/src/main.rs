//! `cargo fmu …`: one tool to build, test, demonstrate and measure the pushbelt FMU.
//!
//! | module | content |
//! |---|---|
//! | [`commands`] | one file for each command |
//! | [`workspace`], [`platform`] | paths of the workspace, and names of binaries by platform |
//! | [`cargo`], [`python`], [`mdbook`] | external programs |
//! | [`portable`], [`binary`] | binaries for other machines, and their requirements |
//! | [`distribution`] | a compiler for browsers, where rustup has none |
//! | [`archive`], [`licenses`], [`description`], [`icons`] | the other files of the FMU |
//! | [`progress`] | headlines on the terminal |

mod archive;
mod binary;
mod cargo;
mod commands;
mod date;
mod description;
mod distribution;
mod exports;
#[allow(dead_code, reason = "the file is that of the FMU, which has other uses too")]
#[path = "../../crates/fmi/src/hash.rs"]
mod hash;
mod icons;
mod licenses;
mod mdbook;
mod platform;
mod portable;
mod progress;
mod python;
mod workspace;
mod wrapper;

use std::process::ExitCode;

use clap::{Arg, ArgMatches, CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use crate::commands::program::{PROGRAMS, Program};
use crate::workspace::Workspace;

/// The words of a program.
const WORDS: &str = "WORDS";

/// Builds, tests, demonstrates and measures PushbeltVariator.fmu.
#[derive(Parser)]
#[command(name = "cargo fmu", bin_name = "cargo fmu", version, after_help = TIMES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// Durations of the commands, measured by `time cargo fmu …`. This is the only list of such times.
const TIMES: &str = "\
Times on two processor cores, once the model is compiled and the Python packages are installed:
  seconds      belt, build, demo, compare, describe, durability, linearize
  a minute     drive, live, sweep, calibrate (60 points), bench, elements (a case)
  two minutes  maps
  minutes      test (3), validate (3), paper, docs
  15 minutes   test --all
wheel takes 7.7 minutes of processor time in an empty clone (two cores of an AMD EPYC), build --portable as much; --arm adds 3.
The first command of a new clone compiles and installs for two minutes more.";

#[derive(Subcommand)]
enum Command {
    /// Compile the binary and pack target/PushbeltVariator.fmu, or with --fmi3
    /// target/PushbeltVariator3.fmu
    Build(commands::build::Options),
    /// Run the first tier of the Rust and Python tests, or with --all every test
    Test(commands::test::Arguments),
    /// Write target/wheels/pushbelt-…-py3-none-any.whl, the Python package with the portable FMUs
    /// inside, or with --arm that for Linux on ARM
    Wheel(commands::wheel::Arguments),
    /// Write what is generated: from the variable table the model descriptions,
    /// terminalsAndIcons.xml, docs/variables.md and the version of the Python package; from the
    /// Python package docs/commands.md and docs/python-interface.md
    Describe,
    /// Write the documentation as a book, target/book/index.html, and check its links
    Docs,
    /// Write target/live.html, the model in a page for browsers: one file, for file:// and any server
    Live,
    /// Run the belt element by element, the model that judges the FMU's, and write
    /// target/elements/CASE.csv
    Elements(commands::elements::Arguments),
}

fn main() -> ExitCode {
    if let Some(code) = wrapper::act() {
        return code;
    }
    match run(&command_line().get_matches()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}

/// The commands of this tool, and those that start a program, which parses its words itself.
fn command_line() -> clap::Command {
    Arguments::command().subcommands(PROGRAMS.iter().map(|program| {
        let words = Arg::new(WORDS)
            .num_args(0..)
            .trailing_var_arg(true)
            .allow_hyphen_values(true)
            .required(program.needs_words);
        clap::Command::new(program.name)
            .about(program.about)
            .disable_help_flag(true)
            .arg(words.help("Words and options of the program; --help lists them"))
    }))
}

fn run(matches: &ArgMatches) -> anyhow::Result<()> {
    let workspace = Workspace::find()?;
    if let Some((name, given)) = matches.subcommand()
        && let Some(program) = Program::of(name)
    {
        let words: Vec<String> = given.get_many(WORDS).into_iter().flatten().cloned().collect();
        return program.run(&workspace, &words);
    }
    match Arguments::from_arg_matches(matches)?.command {
        Command::Build(arguments) => commands::build::run_options(&workspace, &arguments),
        Command::Test(arguments) => commands::test::run(&workspace, &arguments),
        Command::Wheel(arguments) => commands::wheel::run(&workspace, &arguments),
        Command::Describe => commands::describe::run(&workspace),
        Command::Docs => commands::docs::run(&workspace),
        Command::Live => commands::live_page::run(&workspace),
        Command::Elements(arguments) => commands::elements::run(&workspace, &arguments),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        command_line().debug_assert();
    }

    #[test]
    fn a_program_gets_its_words_as_they_are() {
        for (line, expected) in [
            ("fmu compare a.csv b.csv", "a.csv b.csv"),
            ("fmu compare --help", "--help"),
            (
                "fmu calibrate points.csv --check -- --map i=x",
                "points.csv --check -- --map i=x",
            ),
            ("fmu sweep -- --ratio 0.5,1", "--ratio 0.5,1"),
        ] {
            let matches = command_line().try_get_matches_from(line.split(' ')).expect(line);
            let (_, given) = matches.subcommand().expect(line);
            let words: Vec<_> = given.get_many::<String>(WORDS).into_iter().flatten().collect();
            assert_eq!(words, expected.split(' ').collect::<Vec<_>>(), "{line}");
        }
        assert!(command_line().try_get_matches_from(["fmu", "compare"]).is_err());
    }

    /// Options of the programs are checked beside their parsers, in
    /// `tests/python/test_docs_commands.py`.
    #[test]
    fn command_lines_of_the_book_are_those_of_this_tool() {
        let root = Workspace::find().unwrap().root().to_owned();
        let pages = std::fs::read_dir(root.join("docs"))
            .unwrap()
            .map(|entry| entry.unwrap().path());
        let pages = pages.chain(["README.md", "CONTRIBUTING.md"].map(|name| root.join(name)));
        let mut seen = 0;
        for page in pages.filter(|path| path.extension().is_some_and(|extension| extension == "md")) {
            let text = std::fs::read_to_string(&page).unwrap();
            let code = text
                .split(['`', '\n'])
                .map(|line| line.split('#').next().unwrap_or(line).trim());
            for line in code.filter(|line| {
                line.starts_with("cargo fmu ") && !line.contains(['…', 'X']) && !line.contains("COMMAND")
            }) {
                let result = command_line().try_get_matches_from(line.split_whitespace().skip(1));
                let shown = result.err().map(|error| error.kind());
                let fine = [
                    None,
                    Some(clap::error::ErrorKind::DisplayHelp),
                    Some(clap::error::ErrorKind::DisplayVersion),
                ];
                assert!(fine.contains(&shown), "{}: {line}: {shown:?}", page.display());
                seen += 1;
            }
        }
        assert!(seen > 40, "{seen} command lines");
    }
}
