//! `cargo fmu elements CASE…`: runs cases of single elements.

mod continuum;
mod report;

use clap::Parser as _;
use pushbelt::fmi::table::{Kind, Value};
use pushbelt::variator::settings::parameters;
use pushbelt_archive::Archive;
use pushbelt_elements::{Case, Options, Run, run::csv};
use std::error::Error;
use std::fs;
use std::io::IsTerminal as _;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Runs a belt of single elements, in steady states held at a ratio.
///
/// A case is RATIO-SHARE: a geometric ratio (low, under, medium, over, od or a number), and the
/// torque over that of full slip. Sets of cases with their settings are in
/// elements/results/sets.txt: short, loads, ladders, limit, laws, torque-free, idle, play, traction,
/// rigid, oil, shifts, pitch, tone.
#[derive(clap::Parser)]
#[command(name = "cargo fmu elements", bin_name = "cargo fmu elements")]
struct Arguments {
    /// Cases, as medium-0.4, or sets, as torque-free
    #[arg(required = true)]
    cases: Vec<String>,
    /// Folder of the results: CASE.csv (each millisecond), CASE-fields.csv (along the belt), with
    /// --tone CASE-tone.csv (forces and torques over revolutions), results.csv, shifts.csv or
    /// SET.csv (a line a case)
    #[arg(long, default_value = "target/elements", overrides_with = "output")]
    output: PathBuf,
    /// The file of the lines, a line a case; a line of the same case and settings is replaced
    #[arg(long)]
    results: Option<PathBuf>,
    #[command(flatten)]
    settings: Settings,
    /// Solve the cases with the FMU's model instead, on two meshes and with `ALE0`, and write the
    /// lines to continuum.csv, those of shifts to shifts-continuum.csv
    #[arg(long)]
    continuum: bool,
    /// Write CASE.html too, which plays two revolutions of the belt after the end of the run
    #[arg(long)]
    report: bool,
    /// Start again, also where a stored state could go on
    #[arg(long)]
    restart: bool,
    /// Steps between stored states
    #[arg(long, default_value_t = 20_000)]
    store: u64,
}

/// Settings of a case.
#[derive(PartialEq, clap::Parser)]
struct Settings {
    #[command(flatten)]
    options: Options,
    /// A parameter of the FMU, as belt.play=4e-4
    #[arg(long = "set", value_name = "NAME=VALUE")]
    parameters: Vec<String>,
    /// A word in the names of the files and lines
    #[arg(long)]
    label: Option<String>,
}

/// Lines of a set's name, a case and its settings.
const SETS: &str = include_str!("../results/sets.txt");

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut failed = false;
    let mut note = |name: &str, outcome: Result<(), Box<dyn Error>>| {
        if let Err(error) = outcome {
            eprintln!("{name}: {error}");
            failed = true;
        }
    };
    for name in &arguments.cases {
        let lines = SETS.lines().filter_map(|l| l.strip_prefix(name)?.strip_prefix(' '));
        if lines.clone().count() == 0 {
            note(name, one(&arguments, name, &arguments.settings, None));
        } else if arguments.settings != Settings::parse_from([""]) {
            note(name, Err("a set's cases have settings of their own".into()));
            continue;
        }
        for line in lines {
            // The case stands for the program's name.
            let (case, settings) = (line.split(' ').next(), Settings::parse_from(line.split(' ')));
            let case = case.unwrap_or(line);
            note(case, one(&arguments, case, &settings, Some(name)));
        }
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn case(settings: &Settings, name: &str) -> Result<Case, Box<dyn Error>> {
    let mut case = Case::named(name)?;
    if let Some(label) = &settings.label {
        case.name = format!("{name}-{label}");
    }
    case.options = settings.options.clone();
    for setting in &settings.parameters {
        let error = |cause: String| format!("--set {setting}: {cause}");
        let parts = setting.split_once('=');
        let (name, value) = parts.ok_or_else(|| error("NAME=VALUE is expected".to_owned()))?;
        let found = parameters::<_, ()>().find(|one| one.name() == name);
        let found = found.ok_or_else(|| error(format!("the FMU has no parameter {name}")))?;
        let variable = found.variable();
        let given = match variable.kind {
            Kind::Real { .. } => value.parse().map(Value::Real).ok(),
            Kind::Integer { .. } | Kind::Enumeration { .. } => value.parse().map(Value::Integer).ok(),
            Kind::Boolean { .. } => value.parse().map(Value::Boolean).ok(),
        };
        let given = given.ok_or_else(|| error(format!("{value} is no value of {name}")))?;
        variable.set(&mut case.parameters, given)?;
    }
    Ok(case)
}

/// Columns of shifts behind the case: the held state, the step of ln F_P, ds/dt in 1/s, and that
/// over the step.
const SHIFT_COLUMNS: &str = "ratio,thrustRatio,step,rate,gain";

/// Runs a case, or what is left of it.
fn one(of: &Arguments, name: &str, settings: &Settings, set: Option<&str>) -> Result<(), Box<dyn Error>> {
    let case = case(settings, name)?;
    let step = case.options.shift;
    let name = step.map_or_else(|| case.name.clone(), |step| format!("{}-shift{step:+}", case.name));
    let add = |file: &str, columns: &str, name: &str, line: &str| {
        let usual = of.output.join(format!("{file}.csv"));
        add_line(of.results.as_ref().unwrap_or(&usual), columns, name, line)
    };
    if of.continuum {
        if case.options.pitch || case.options.spread > 0.0 {
            return Err("the FMU's model has neither pitch nor single thicknesses".into());
        }
        for model in continuum::MODELS {
            let name = format!("{name},{}", model.0);
            match continuum::line(&case, model) {
                Err(error) => eprintln!("{name}: {error}"),
                Ok(line) if step.is_none() => add("continuum", continuum::COLUMNS, &name, &line)?,
                Ok(line) => add("shifts-continuum", &format!("model,{SHIFT_COLUMNS}"), &name, &line)?,
            }
        }
        return Ok(());
    }
    case.check()?;
    let mut held = case.clone();
    held.options.shift = None;
    let run = complete(of, Run::new(held)?)?;
    if let Some(step) = step {
        run.check_steady()?;
        let held = run.quarter(1);
        let mut shift = run.shifted(step);
        shift.case.name.clone_from(&name);
        let rate = complete(of, shift)?.shift_rate();
        println!("{name}: {rate:.4} 1/s, {:.4} 1/s over the step", rate / step);
        let line = csv(&[held.ratio(), held.thrust_ratio(), step, rate, rate / step]);
        return Ok(add(set.unwrap_or("shifts"), SHIFT_COLUMNS, &name, &line)?);
    }
    write(&of.output.join(format!("{name}-fields.csv")), run.fields_csv())?;
    let result = run.quarter(1);
    add(set.unwrap_or("results"), &run.header(), &name, &run.line())?;
    if !run.tone.is_empty() {
        write(&of.output.join(format!("{name}-tone.csv")), run.tone_csv())?;
    }
    let ([.., [idle_s, idle_p]], [least, most]) = (result.means, result.push_force);
    let (ratio, thrust_ratio) = (result.ratio(), result.thrust_ratio());
    let shares = [result.slip(), result.efficiency(), result.residual()];
    let [slip, efficiency, residual] = shares.map(|share| 100.0 * share);
    let figures = format!(
        "ratio {ratio:.4}, thrust ratio {thrust_ratio:.4}, slip {slip:.4} %, \
         efficiency {efficiency:.3} %, idle arcs S {idle_s:.2}, P {idle_p:.2} rad, \
         push force {least:.1} to {most:.0} N, energy to {residual:.4} % of what passes"
    );
    println!("{name}: {figures}");
    run.check_steady()?;
    if of.report {
        let file = of.output.join(format!("{name}.html"));
        write(&file, report::page(run, &figures)?)?;
        println!("{}", file.display());
    }
    Ok(())
}

/// The run at its end, from the state that its file holds.
fn complete(arguments: &Arguments, mut run: Run) -> Result<Run, Box<dyn Error>> {
    let case = run.case.clone();
    let file = |suffix: &str| arguments.output.join(format!("{}{suffix}", case.name));
    let (stored, settings) = (file(".state"), format!("{case:?}"));
    if !arguments.restart
        && let Some(again) = read(&run, &stored, &settings)
    {
        run = again;
        eprintln!("{}: goes on at {:.4} s", case.name, run.machine.time);
    }
    let (clock, from) = (Instant::now(), run.steps);
    let mut outcome = Ok(());
    while !run.is_done() && outcome.is_ok() {
        outcome = run.advance(arguments.store);
        write(&file(".csv"), run.rows_csv())?;
        if outcome.is_ok() {
            let mut archive = Archive::writer();
            run.serialize(&mut archive);
            write(&stored, [settings.as_bytes(), &archive.into_bytes()].concat())?;
        }
        progress(&run, (run.steps - from) as f64 / clock.elapsed().as_secs_f64());
    }
    Ok(outcome.map(|()| run)?)
}

fn progress(run: &Run, steps_per_second: f64) {
    let (machine, duration) = (&run.machine, run.case.duration());
    let (time, percent) = (machine.time, 100.0 * machine.time / duration);
    let speed = steps_per_second * machine.law.count as f64;
    let left = (duration - time) / machine.dt / steps_per_second;
    let stays = run.is_done() || !std::io::stderr().is_terminal();
    let last = if stays { "\n" } else { "\r" };
    eprint!("{} {percent:3.0} %, {time:.4} s, ", run.case.name);
    eprint!("{speed:.2e} element steps a second, {left:.0} s left   {last}");
}

/// The run that a file holds; none if there is no file, or it is of other settings.
fn read(start: &Run, path: &Path, settings: &str) -> Option<Run> {
    let bytes = fs::read(path).ok()?;
    let mut archive = Archive::reader(bytes.strip_prefix(settings.as_bytes())?);
    let mut run = start.clone();
    run.serialize(&mut archive);
    archive.finish().ok()?;
    Some(run)
}

/// Writes a file at once, so that an interrupted run leaves the one before.
fn write(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), String> {
    let part = path.with_extension("part");
    fs::create_dir_all(path.parent().unwrap_or(path))
        .and_then(|()| fs::write(&part, bytes))
        .and_then(|()| fs::rename(part, path))
        .map_err(|error| format!("{}: {error}", path.display()))
}

/// Adds a line, or replaces that of the same name, in a file of cases with these columns.
fn add_line(path: &Path, columns: &str, name: &str, line: &str) -> Result<(), String> {
    let before = fs::read_to_string(path).unwrap_or_default();
    let line = format!("{name},{line}");
    let start = &line[..=name.len()];
    let others = before.lines().skip(1).filter(|other| !other.starts_with(start));
    let mut lines: Vec<_> = others.chain([&*line]).collect();
    lines.sort_unstable();
    write(path, format!("case,{columns}\n{}\n", lines.join("\n")))
}
