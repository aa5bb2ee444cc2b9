//! `cargo fmu elements CASE…`: runs cases of single elements.

mod continuum;

use clap::Parser as _;
use pushbelt::fmi::table::{Kind, Value};
use pushbelt::variator::settings::parameters;
use pushbelt_archive::Archive;
use pushbelt_elements::case::Case;
use pushbelt_elements::law::Options;
use pushbelt_elements::run::{Run, header};
use std::error::Error;
use std::fs;
use std::io::{IsTerminal as _, Write as _};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Runs a belt of single elements, in steady states held at a ratio.
///
/// A case is RATIO-SHARE: a geometric ratio (low, under, medium, over, od or a number), and the
/// torque over that of full slip. `short` is the set medium-0.4, medium-0.6, od-0.6, od-0.
#[derive(clap::Parser)]
#[command(name = "cargo fmu elements", bin_name = "cargo fmu elements")]
struct Arguments {
    /// Cases, as medium-0.4
    #[arg(required = true)]
    cases: Vec<String>,
    /// Folder of the results: CASE.csv (each millisecond), CASE-fields.csv (along the belt),
    /// results.csv (a line a case)
    #[arg(long, default_value = "target/elements", overrides_with = "output")]
    output: PathBuf,
    /// The file of the lines, a line a case; a line of the same case and settings is replaced
    #[arg(long)]
    results: Option<PathBuf>,
    #[command(flatten)]
    options: Options,
    /// A parameter of the FMU, as belt.play=4e-4
    #[arg(long = "set", value_name = "NAME=VALUE")]
    settings: Vec<String>,
    /// A word in the names of the files and lines
    #[arg(long)]
    label: Option<String>,
    /// Solve the cases with the FMU's model instead, on two meshes and with `ALE0`, and write the
    /// lines to continuum.csv
    #[arg(long)]
    continuum: bool,
    /// Start again, also where a stored state could go on
    #[arg(long)]
    restart: bool,
    /// Steps between stored states
    #[arg(long, default_value_t = 20_000)]
    store: u64,
}

/// The cases against which the prototype's figures stand.
const SHORT: [&str; 4] = ["medium-0.4", "medium-0.6", "od-0.6", "od-0"];

fn main() -> ExitCode {
    let arguments = Arguments::parse();
    let mut failed = false;
    let names = arguments.cases.iter().flat_map(|name| match name.as_str() {
        "short" => SHORT.map(str::to_owned).to_vec(),
        _ => vec![name.clone()],
    });
    for name in names {
        if let Err(error) = one(&arguments, &name) {
            eprintln!("{name}: {error}");
            failed = true;
        }
    }
    if failed { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}

fn case(arguments: &Arguments, name: &str) -> Result<Case, Box<dyn Error>> {
    let mut case = Case::named(name)?;
    if let Some(label) = &arguments.label {
        case.name = format!("{name}-{label}");
    }
    case.options = arguments.options.clone();
    for setting in &arguments.settings {
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

/// Runs a case, or what is left of it.
fn one(arguments: &Arguments, name: &str) -> Result<(), Box<dyn Error>> {
    let case = case(arguments, name)?;
    let results = |name: &str| arguments.results.clone().unwrap_or_else(|| arguments.output.join(name));
    if arguments.continuum {
        for model in continuum::MODELS {
            let name = format!("{},{}", case.name, model.0);
            match continuum::line(&case, model) {
                Ok(line) => {
                    println!("{name},{line}");
                    let header = format!("case,model,{}", continuum::COLUMNS);
                    add_line(&results("continuum.csv"), &header, &name, &line)?;
                }
                Err(error) => eprintln!("{name}: {error}"),
            }
        }
        return Ok(());
    }
    let file = |suffix: &str| arguments.output.join(format!("{}{suffix}", case.name));
    let (stored, settings) = (file(".state"), format!("{case:?}"));
    let mut run = Run::new(case.clone())?;
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
    if std::io::stderr().is_terminal() {
        eprintln!();
    }
    outcome?;
    write(&file("-fields.csv"), run.fields_csv())?;
    let (result, [idle_s, idle_p]) = (run.quarter(1), run.idle_arcs());
    let line = format!("{},{idle_s:.3},{idle_p:.3}", result.line());
    let header = format!("case,{},secondary.idleArc,primary.idleArc", header());
    add_line(&results("results.csv"), &header, &case.name, &line)?;
    let (ratio, thrust_ratio, [least, most]) = (result.ratio(), result.thrust_ratio(), result.push_force);
    let shares = [result.slip(), result.efficiency(), result.residual()];
    let [slip, efficiency, residual] = shares.map(|share| 100.0 * share);
    println!(
        "{}: ratio {ratio:.4}, thrust ratio {thrust_ratio:.4}, slip {slip:.4} %, \
         efficiency {efficiency:.3} %, idle arcs S {idle_s:.2}, P {idle_p:.2} rad, \
         push force {least:.1} to {most:.0} N, energy to {residual:.4} % of what passes",
        case.name
    );
    Ok(run.check_steady()?)
}

fn progress(run: &Run, steps_per_second: f64) {
    let (machine, duration) = (&run.machine, run.case.duration());
    let (time, percent) = (machine.time, 100.0 * machine.time / duration);
    let speed = steps_per_second * machine.law.count as f64;
    let left = (duration - time) / machine.dt / steps_per_second;
    let last = if std::io::stderr().is_terminal() { "\r" } else { "\n" };
    eprint!("{} {percent:3.0} %, {time:.4} s, ", run.case.name);
    eprint!("{speed:.2e} element steps a second, {left:.0} s left   {last}");
    let _ = std::io::stderr().flush();
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

/// Adds a line, or replaces that of the same name, in a file with a header.
fn add_line(path: &Path, header: &str, name: &str, line: &str) -> Result<(), String> {
    let before = fs::read_to_string(path).unwrap_or_default();
    let line = format!("{name},{line}");
    let start = &line[..=name.len()];
    let others = before.lines().skip(1).filter(|other| !other.starts_with(start));
    let mut lines: Vec<_> = others.chain([&*line]).collect();
    lines.sort_unstable();
    write(path, format!("{header}\n{}\n", lines.join("\n")))
}
