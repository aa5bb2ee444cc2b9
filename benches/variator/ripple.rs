//! What a ripple of the hydraulics costs: every millisecond another force, and the cells beside the arcs turn between
//! sticking and sliding with it.

use std::f64::consts::TAU;

use cpu_time::ThreadTime;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::Inputs;
use pushbelt::variator::settings::RingModel;
use pushbelt_lab::variators::{inputs, variator};
use serde_json::json;

use crate::{MODELS, STEP, Table, numbers, text};

/// Time that is run, s.
const SPAN: f64 = 0.5;
/// Frequency, Hz.
const FREQUENCY: f64 = 100.0;
/// Amplitudes as shares of the primary clamping force.
const AMPLITUDES: [f64; 3] = [0.0, 0.01, 0.05];

/// Rows of the table: ratio 1, 50 N·m, 12 kN on both pulleys, the forces as stairs and as ramps.
pub fn measure(table: &mut Table) {
    for model in MODELS {
        for amplitude in AMPLITUDES {
            for ramped in [false, true] {
                if amplitude == 0.0 && ramped {
                    continue;
                }
                row(table, model, amplitude, ramped);
            }
        }
    }
}

fn row(table: &mut Table, model: RingModel, amplitude: f64, ramped: bool) {
    let mean = inputs((50.0, 12e3), (-50.0, 12e3));
    let force = |time: f64| mean.primary.clamping_force * (1.0 + amplitude * (TAU * FREQUENCY * time).sin());
    let mut parameters = variator(model);
    parameters.initial.ratio = 1.0;
    let mut variator = Variator::new(parameters).expect("valid parameters");
    variator.initialise(0.0, &mean).expect("a start");
    let start = ThreadTime::now();
    let steps = (SPAN / STEP).round() as u32;
    for k in 0..steps {
        let [from, to] = [k, k + 1].map(|k| f64::from(k) * STEP);
        let (mut now, mut rates) = (mean, Inputs::ZERO);
        now.primary.clamping_force = force(from);
        if ramped {
            rates.primary.clamping_force = (force(to) - force(from)) / STEP;
        }
        variator.advance_along(to, &now, &rates).expect("a step");
    }
    let (time, counts) = (start.elapsed().as_secs_f64(), variator.counts());
    let shape = if ramped { ", ramped" } else { "" };
    table.row(
        &format!(
            "{SPAN} s, {FREQUENCY} Hz ripple of {} %{shape}, {model:?}",
            100.0 * amplitude
        ),
        format!("{time:.2} s, {:.2} x real time, {}", SPAN / time, text(&counts)),
        json!({"seconds": time, "real_time_factor": SPAN / time, "counts": numbers(&counts)}),
    );
}
