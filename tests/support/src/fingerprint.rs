//! A hash of every output bit of a run, for programs that compare two builds bit by bit.

use pushbelt::fmi::table::{Table, Value, Variable};
use pushbelt::fmi::unit::Unit;
use pushbelt::unit::{Settings, VariatorUnit};
use pushbelt::variator::Variator;
use pushbelt::variator::settings::{Inputs, Outputs, Profile, Readings};
use std::error::Error;
use std::hash::{DefaultHasher, Hasher};

/// Communication step, s.
pub const STEP: f64 = 1e-3;

/// Outputs of a run, one row per step.
type Rows = Vec<Vec<f64>>;

fn hash(rows: &[Vec<f64>]) -> u64 {
    let mut hasher = DefaultHasher::new();
    rows.iter()
        .flatten()
        .for_each(|value| hasher.write_u64(value.to_bits()));
    hasher.finish()
}

/// Largest difference from the outputs of another build, as a share of the range of the output in
/// this run.
fn difference(rows: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    let columns = rows.first().map_or(0, Vec::len);
    let of_column = |k: usize| {
        let values = || rows.iter().filter_map(move |row| row.get(k));
        let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(*x), high.max(*x))
        });
        // The difference of a constant output is a share of its size.
        let range = (high - low).max(1e-3 * high.abs().max(low.abs())).max(1e-12);
        let off = values()
            .zip(other.iter().filter_map(|row| row.get(k)))
            .map(|(a, b)| (a - b).abs());
        off.fold(0.0, f64::max) / range
    };
    (0..columns).map(of_column).fold(0.0, f64::max)
}

/// The FMU's numbers, without those of the work and of the profile.
fn row(table: &Table<Settings, Readings>, outputs: &Outputs) -> Vec<f64> {
    let (settings, readings) = (Settings::default(), Readings::from(outputs.clone()));
    let of = |variable: &Variable<Settings, Readings>| {
        let is_left_out = variable.causality.is_setting()
            || ["solver.", "profile."].iter().any(|of| variable.name.starts_with(of));
        match variable.value(&settings, Some(&readings)) {
            Some(Value::Real(value)) if !is_left_out => Some(value),
            _ => None,
        }
    };
    table.variables().iter().filter_map(of).collect()
}

fn profile_row(p: &Profile) -> Vec<f64> {
    let fields = [
        &p.push_force,
        &p.ring_tension,
        &p.normal_force,
        &p.radial_deviation,
        &p.sliding_speed,
        &p.lateral_deflection,
        &p.ring_stress,
    ];
    fields.into_iter().flatten().copied().collect()
}

/// All cases of a build: name and outputs.
type Cases = Vec<(String, Rows)>;

/// Destination of the outputs, and the outputs that they are compared with.
#[derive(Default)]
pub struct Report {
    kept: Cases,
    other: Option<Cases>,
    write: Option<String>,
}

impl Report {
    /// The report according to the program's arguments: none, `--write FILE` or `--compare FILE`.
    ///
    /// # Errors
    /// Other arguments, or a file that can't be read.
    pub fn of_arguments() -> Result<Self, Box<dyn Error>> {
        let arguments: Vec<String> = std::env::args().skip(1).collect();
        let mut report = Self::default();
        match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
            [] => {}
            ["--write", file] => report.write = Some(file.to_string()),
            ["--compare", file] => {
                report.other = Some(serde_json::from_str(&std::fs::read_to_string(file)?)?)
            }
            _ => return Err("usage: fingerprint [--write FILE | --compare FILE]".into()),
        }
        Ok(report)
    }

    /// Writes the outputs if the arguments request it.
    ///
    /// # Errors
    /// The file can't be written.
    pub fn finish(self) -> Result<(), Box<dyn Error>> {
        if let Some(file) = self.write {
            std::fs::write(file, serde_json::to_string(&self.kept)?)?;
        }
        Ok(())
    }

    /// Runs `steps` of the manoeuvre and prints the line of the case.
    ///
    /// # Errors
    /// The variator does not start, or a step fails.
    pub fn run(
        &mut self,
        name: &str,
        mut variator: Variator,
        trace: &[Inputs],
        steps: usize,
    ) -> Result<(), Box<dyn Error>> {
        let table = VariatorUnit::table();
        variator.initialise(0.0, &trace[0])?;
        let mut rows = vec![row(&table, variator.outputs())];
        for (k, inputs) in trace.iter().take(steps).enumerate() {
            variator.advance((k + 1) as f64 * STEP, inputs)?;
            rows.push(row(&table, variator.outputs()));
        }
        let other = self.other.iter().flatten().find(|(case, _)| case == name);
        let off = other.map_or(String::new(), |(_, other)| {
            format!("  off by {:.1e} of the range", difference(&rows, other))
        });
        rows.push(profile_row(variator.profile()));
        println!("{name:<34} {:016x}  {:?}{off}", hash(&rows), variator.counts());
        self.kept.push((name.to_string(), rows));
        Ok(())
    }
}
