//! 1800 s of driving: torque and clamping forces as a car asks for them on a cycle like the WLTC,
//! in steps of 10 ms.
//!
//! The speed trace is made up, of hills with the WLTC's phases, their peaks and stops. The belt
//! shifts as long as the clamping forces are out of balance, so traces of both forces alone would
//! drift off to a stop: a PI controller leads them by the ratio. The secondary speed is given, the
//! car's inertia acts through the torque.

use std::hint::black_box;

use cpu_time::ThreadTime;
use pushbelt::contact::full_slip_torque;
use pushbelt::solver::newton::Counts;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Drive, Parameters, RingModel};
use pushbelt::variator::settings::{Inputs, PulleyInputs};
use pushbelt_support::bench::text;
use pushbelt_support::variators::{one_cell, variator};
use serde_json::json;

use crate::{Table, numbers};

/// Communication step, s.
const STEP: f64 = 1e-2;

/// Hills: start, end of the rise, start of the fall, end, s; speed on top, km/h.
const HILLS: [([f64; 4], f64); 15] = [
    ([12.0, 40.0, 70.0, 100.0], 44.0),
    ([140.0, 160.0, 172.0, 190.0], 30.0),
    ([205.0, 228.0, 280.0, 305.0], 56.5),
    ([330.0, 345.0, 362.0, 380.0], 37.0),
    ([400.0, 430.0, 455.0, 480.0], 47.0),
    ([500.0, 520.0, 555.0, 575.0], 26.0),
    ([600.0, 632.0, 660.0, 690.0], 55.0),
    ([715.0, 750.0, 800.0, 835.0], 66.0),
    ([850.0, 895.0, 985.0, 1015.0], 76.6),
    ([1030.0, 1075.0, 1120.0, 1150.0], 77.0),
    ([1165.0, 1205.0, 1260.0, 1290.0], 85.0),
    ([1300.0, 1350.0, 1440.0, 1475.0], 97.4),
    ([1490.0, 1530.0, 1555.0, 1565.0], 105.0),
    ([1560.0, 1600.0, 1640.0, 1660.0], 120.0),
    ([1650.0, 1690.0, 1750.0, 1795.0], 131.3),
];
const END: f64 = 1800.0;

/// `demoCar` of resources/variators.json: mass, kg; c_d A, m²; rolling resistance; wheel radius by
/// final drive, m; largest torque, N·m.
const MASS: f64 = 1300.0;
const DRAG_AREA: f64 = 0.65;
const ROLLING: f64 = 0.01;
const LEVER: f64 = 0.3 / 5.4;
const TORQUE: f64 = 150.0;

/// Speed at a time, m/s: hills with rounded feet and tops, the larger where two meet.
fn speed(time: f64) -> f64 {
    let smooth = |x: f64| {
        let x = x.clamp(0.0, 1.0);
        x * x * (3.0 - 2.0 * x)
    };
    HILLS
        .iter()
        .map(|([start, top, fall, end], peak)| {
            peak / 3.6 * smooth((time - start) / (top - start)) * smooth((end - time) / (end - fall))
        })
        .fold(0.0, f64::max)
}

/// Speed of the engine that is wanted at a road speed, m/s, and a power at the road, W; rad/s.
fn engine_speed(speed: f64, power: f64) -> f64 {
    (110.0 + 5.0 * speed + 0.006 * power.max(0.0)).min(450.0)
}

/// Rates of inputs that go from one communication point to the next, 1/s.
fn rates(from: &Inputs, to: &Inputs) -> Inputs {
    let pulley = |from: &PulleyInputs, to: &PulleyInputs| PulleyInputs {
        torque: (to.torque - from.torque) / STEP,
        clamping_force: (to.clamping_force - from.clamping_force) / STEP,
        speed_setpoint: (to.speed_setpoint - from.speed_setpoint) / STEP,
        pressure: 0.0,
    };
    Inputs {
        primary: pulley(&from.primary, &to.primary),
        secondary: pulley(&from.secondary, &to.secondary),
    }
}

struct Ride {
    seconds: f64,
    counts: Counts,
    /// Mean and largest |ln(ratio/target)| while the car moves.
    ratio_error: [f64; 2],
    /// Communication points with macro-slip.
    slipping: usize,
}

fn ride(mut parameters: Parameters) -> Ride {
    parameters.secondary.drive = Drive::Speed;
    parameters.initial.ratio = 2.2;
    parameters.initial.primary_speed = 0.0;
    let friction = parameters.friction.clone();
    let cosine = parameters.geometry.wedge_angle.cos();
    let mut variator = Variator::new(parameters).expect("valid parameters");
    let mut inputs = Inputs::ZERO;
    inputs.primary.clamping_force = 8e3;
    inputs.secondary.clamping_force = 8e3;
    let start = ThreadTime::now();
    variator.initialise(0.0, &inputs).expect("a start");
    let (mut target, mut integral, mut sum, mut most, mut moving, mut slipping) =
        (2.2_f64, 0.0, 0.0, 0.0_f64, 0, 0);
    let steps = (END / STEP).round() as usize;
    for k in 0..steps {
        let time = k as f64 * STEP;
        let (now, next) = (speed(time), speed(time + STEP));
        let acceleration = (next - now) / STEP;
        let road = MASS * (acceleration + 9.81 * ROLLING * (10.0 * now).tanh()) + 0.6 * DRAG_AREA * now * now;
        let outputs = variator.outputs();
        let ratio = outputs.ratio_geometric;
        // Brakes take what the engine's drag can't.
        let torque = (road * LEVER / ratio).clamp(-15.0, TORQUE) * (now / 2.0).min(1.0);
        let wanted = (engine_speed(now, road * now) / (now / LEVER).max(1.0)).clamp(0.5, 2.2);
        target *= (wanted / target).ln().clamp(-0.5 * STEP, 0.5 * STEP).exp();
        let error = (ratio / target).ln();
        if now > 3.0 {
            integral = (integral + error * STEP).clamp(-1.0, 1.0);
            sum += error.abs();
            most = most.max(error.abs());
            moving += 1;
        }
        slipping += usize::from(outputs.macro_slip);
        let per_force = full_slip_torque(&friction, cosine, 1.0, outputs.primary.radius);
        let needed = (1.3 * torque.abs() / per_force).max(4e3);
        let excess = (0.2 + integral + 3.0 * error).clamp(-1.2, 1.5);
        let from = inputs;
        inputs.primary.torque = torque;
        // The pulley that is clamped less carries the torque.
        inputs.secondary.clamping_force = needed * (-excess).max(0.0).exp();
        inputs.primary.clamping_force = needed * excess.max(0.0).exp();
        inputs.secondary.speed_setpoint = next / LEVER;
        variator
            .advance_along(time + STEP, &from, &rates(&from, &inputs))
            .expect("a step");
        black_box(variator.outputs());
    }
    Ride {
        seconds: start.elapsed().as_secs_f64(),
        counts: variator.counts(),
        ratio_error: [sum / f64::from(moving), most],
        slipping,
    }
}

/// Both ring models on the cycle, and `ALE` with one cell in an element.
pub fn rides(table: &mut Table) {
    let rides = [
        ("Ale0", variator(RingModel::Ale0)),
        ("Ale, one cell an element", one_cell(RingModel::Ale)),
        ("Ale", variator(RingModel::Ale)),
    ];
    for (name, parameters) in rides {
        let Ride {
            seconds,
            counts,
            ratio_error: [mean, most],
            slipping,
        } = ride(parameters);
        table.row(
            &format!("1800 s like a WLTC, steps of 10 ms, {name}"),
            format!("{seconds:.1} s, {:.1} x real time, {}", END / seconds, text(&counts)),
            json!({"seconds": seconds, "real_time_factor": END / seconds, "counts": numbers(&counts)}),
        );
        table.row(
            "  its ratio off the target: mean, most; points with macro-slip",
            format!("{:.1} %, {:.1} %; {slipping}", 100.0 * mean, 100.0 * most),
            json!({"mean": mean, "most": most, "macro_slip": slipping}),
        );
    }
}
