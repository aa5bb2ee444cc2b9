//! A drive played back: torques, clamping forces and the speed of the car as a table of `cargo fmu drive` has them.

use std::path::Path;

use cpu_time::ThreadTime;
use pushbelt::variator::instance::Variator;
use pushbelt::variator::parameters::{Drive, RingModel};
use pushbelt::variator::signals::{Inputs, PulleyInputs};
use serde_json::json;

use crate::{Table, common, numbers, text};

/// Communication step, s.
const STEP: f64 = 0.01;
/// Columns that are played.
const COLUMNS: [&str; 5] = [
    "time",
    "primary.shaftTorque",
    "primary.clampingForce",
    "secondary.clampingForce",
    "secondary.speed",
];

/// Plays `file` and prints what it takes. The secondary speed is prescribed, so the variator cannot run away from the car.
///
/// # Panics
/// The file is not such a table.
pub fn play(table: &mut Table, model: RingModel, file: &Path) {
    let rows = read(file);
    let mut parameters = common::variator(model);
    parameters.secondary.drive = Drive::Speed;
    parameters.initial.ratio = 2.2;
    parameters.initial.primary_speed = 0.0;
    let mut variator = Variator::new(parameters).expect("valid parameters");
    let start = ThreadTime::now();
    variator.initialise(0.0, &at(&rows, 0.0)).expect("a start");
    let end = rows[rows.len() - 1][0];
    let count = (end / STEP).round() as usize;
    for k in 0..count {
        let inputs = at(&rows, k as f64 * STEP);
        variator.advance((k + 1) as f64 * STEP, &inputs).expect("a step");
        std::hint::black_box(variator.outputs());
    }
    let (time, counts) = (start.elapsed().as_secs_f64(), variator.counts());
    table.row(
        &format!("drive of {end:.0} s in steps of 10 ms, {model:?}"),
        format!("{time:.1} s, {:.1} x real time, {}", end / time, text(&counts)),
        json!({"seconds": time, "real_time_factor": end / time, "counts": numbers(&counts)}),
    );
}

fn read(file: &Path) -> Vec<[f64; COLUMNS.len()]> {
    let text = std::fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().expect("a head").split(',').collect();
    let at = COLUMNS.map(|name| {
        head.iter()
            .position(|h| *h == name)
            .unwrap_or_else(|| panic!("no column {name}"))
    });
    lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            at.map(|k| cells[k].parse().expect("a number"))
        })
        .collect()
}

/// Inputs at time `t`, linear between rows.
fn at(rows: &[[f64; COLUMNS.len()]], t: f64) -> Inputs {
    let right = rows.partition_point(|row| row[0] <= t).clamp(1, rows.len() - 1);
    let (a, b) = (&rows[right - 1], &rows[right]);
    let share = ((t - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0);
    let value = |k: usize| a[k] + share * (b[k] - a[k]);
    let pulley = |torque, clamping_force: f64, speed_setpoint| PulleyInputs {
        torque,
        clamping_force,
        speed_setpoint,
    };
    Inputs {
        primary: pulley(value(1), value(2), 0.0),
        secondary: pulley(0.0, value(3), value(4)),
    }
}
