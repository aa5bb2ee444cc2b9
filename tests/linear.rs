//! The linear model against the variator itself: small steps of each load.

use nalgebra::DMatrix;
use pushbelt::pulley::Pulley;
use pushbelt::variator::linear::{LinearError, LinearModel, Load, linearise, linearise_at, modes};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Drive, Inputs, Outputs};
use pushbelt::variator::settings::{Mesh, Parameters, RingModel};
use pushbelt_support::variators::inputs;

type Read = fn(&Outputs) -> f64;

/// Outputs with the uncertainty of each due to the solver.
const OUTPUTS: [(&str, f64, Read); 6] = [
    ("primary.speed", 1e-6, |o| o.primary.speed),
    ("secondary.speed", 1e-6, |o| o.secondary.speed),
    ("ratio.geometric", 1e-8, |o| o.ratio_geometric),
    ("belt.speed", 1e-6, |o| o.belt_speed),
    ("primary.axialForce", 0.01, |o| o.primary.axial_force),
    ("secondary.shaftTorque", 2e-4, |o| o.secondary.shaft_torque),
];

fn parameters() -> Parameters {
    let mut parameters = Parameters {
        mesh: Mesh {
            primary_arc: 8,
            secondary_arc: 8,
            strand: 4,
            cells_per_element: 2,
        },
        ..Parameters::default()
    };
    parameters.solver.tolerance = 1e-7;
    parameters
}

fn model(frequency: f64) -> LinearModel {
    let read: Vec<&dyn Fn(&Outputs) -> f64> = OUTPUTS
        .iter()
        .map(|(_, _, read)| read as &dyn Fn(&Outputs) -> f64)
        .collect();
    linearise(&parameters(), &Inputs::default(), frequency, &read).expect("a steady state")
}

/// Deviation of the outputs at `time` after a unit step of load `l`.
fn response(model: &LinearModel, l: usize, time: f64) -> Vec<f64> {
    let n = model.a.len();
    let mut whole = DMatrix::<f64>::zeros(n + 1, n + 1);
    for i in 0..n {
        for j in 0..n {
            whole[(i, j)] = model.a[i][j] * time;
        }
        whole[(i, n)] = model.b[i][l] * time;
    }
    let flow = whole.exp();
    let output = |(c, d): (&Vec<f64>, &Vec<f64>)| d[l] + (0..n).map(|k| c[k] * flow[(k, n)]).sum::<f64>();
    model.c.iter().zip(&model.d).map(output).collect()
}

fn run(inputs: &Inputs, start: &Variator, times: &[f64]) -> Vec<Vec<f64>> {
    let mut variator = start.clone();
    let row = |time: &f64| {
        variator.advance(*time, inputs).expect("a small step");
        let outputs = variator.outputs();
        OUTPUTS.iter().map(|(_, _, read)| read(outputs)).collect()
    };
    times.iter().map(row).collect()
}

/// The steps must be small: elements change between sticking and sliding, and after a torque step of 0.2 N·m the ratio already
/// changes by 20 % less than in the linear model.
#[test]
fn the_linear_model_follows_small_steps_of_each_load() {
    let model = model(100.0);
    let mut start = Variator::new(parameters()).expect("valid");
    start.initialise(0.0, &model.inputs).expect("steady");
    let times = [0.01, 0.02, 0.05, 0.1, 0.2];
    assert_eq!(model.loads.len(), 4);
    for (l, load) in model.loads.iter().enumerate() {
        let size = match load {
            Load::ClampingForce(_) => 5.0,
            Load::Torque(_) => 0.01,
            Load::Pressure(_) | Load::SpeedSetpoint(_) => unreachable!("torque drive, no cylinder"),
        };
        let [less, more] = [-size, size].map(|by| {
            let mut inputs = model.inputs;
            *load.field(&mut inputs) += by;
            run(&inputs, &start, &times)
        });
        let linear: Vec<Vec<f64>> = times.iter().map(|time| response(&model, l, *time)).collect();
        for (i, (name, noise, _)) in OUTPUTS.iter().enumerate() {
            let found: Vec<f64> = (0..times.len())
                .map(|k| (more[k][i] - less[k][i]) / (2.0 * size))
                .collect();
            let largest = found.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (k, time) in times.iter().enumerate() {
                assert!(
                    (found[k] - linear[k][i]).abs() < 0.05 * largest + noise / size,
                    "{} → {name} at {time} s: {} against {} of the linear model",
                    load.name(),
                    found[k],
                    linear[k][i]
                );
            }
        }
    }
}

/// The gain of the linear model of `ALE0` is that of a run too.
#[test]
fn the_gain_of_ale0_is_that_of_a_run() {
    let mut parameters = parameters();
    parameters.ring_model = RingModel::Ale0;
    parameters.initial.ratio = 0.7;
    let mut inputs = Inputs::default();
    (inputs.primary.torque, inputs.secondary.clamping_force) = (70.0, 10.0e3);
    let read: &dyn Fn(&Outputs) -> f64 = &|o| o.ratio_geometric;
    for speed in [35.0, 200.0] {
        parameters.initial.primary_speed = speed;
        let model = linearise(&parameters, &inputs, 20.0, &[read]).expect("a linear model");
        let mut start = Variator::new(parameters.clone()).expect("valid");
        start.initialise(0.0, &inputs).expect("steady");
        let force = model
            .loads
            .iter()
            .position(|l| *l == Load::ClampingForce(Pulley::Primary))
            .expect("a load");
        let (size, time) = (20.0, 0.5);
        let end = |step: f64| {
            let mut inputs = model.inputs;
            inputs.primary.clamping_force += step;
            let mut variator = start.clone();
            variator.advance(time, &inputs).expect("a small step");
            variator.outputs().ratio_geometric
        };
        let (found, linear) = (
            (end(size) - end(-size)) / (2.0 * size),
            response(&model, force, time)[0],
        );
        println!("{speed} rad/s: ratio by {found:.3e} a newton after {time} s, linear model {linear:.3e}");
        assert!((found - linear).abs() < 0.01 * found.abs(), "{found} {linear}");
    }
}

/// More modes change only the fast part of the response.
#[test]
fn slow_modes_do_not_depend_on_the_cut_off() {
    let (few, many) = (model(20.0), model(200.0));
    assert!(few.a.len() < many.a.len());
    for pole in &few.poles {
        let nearest = many
            .poles
            .iter()
            .map(|other| (pole[0] - other[0]).hypot(pole[1] - other[1]));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-5 + 1e-5 * pole[0].hypot(pole[1]), "{pole:?}: {nearest}");
        assert!(
            pole[0] < 1.0,
            "{pole:?}: the working point is stable or slowly unstable"
        );
    }
}

/// An end stop takes part of the belt's axial force: the forces that hold the working point are the specified ones.
#[test]
fn an_end_stop_takes_part_of_the_axial_force() {
    let mut parameters = parameters();
    parameters.initial.ratio = 0.437;
    let inputs = Inputs::default();
    let mut start = Variator::new(parameters.clone()).expect("valid");
    start.initialise(0.0, &inputs).expect("a steady state");
    let given = inputs.secondary.clamping_force;
    let by_stop = start.outputs().secondary.axial_force - given;
    assert!(by_stop > 0.1, "{by_stop} N");
    let model = linearise(&parameters, &inputs, 20.0, &[]).expect("a working point");
    let held = model.inputs.secondary.clamping_force;
    // To the accuracy of a steady solution, 1e-6 of the force.
    assert!((held - given).abs() < 1e-2, "{held} {given}");
}

#[test]
fn errors_explain_why_there_is_no_linear_model() {
    let nothing: [&dyn Fn(&Outputs) -> f64; 0] = [];
    let slow = linearise(&parameters(), &Inputs::default(), 1e-3, &nothing).err();
    assert!(matches!(slow, Some(LinearError::NoMode(_))), "{slow:?}");
    let mut overloaded = Inputs::default();
    (overloaded.primary.torque, overloaded.secondary.torque) = (500.0, -490.0);
    let unsteady = linearise(&parameters(), &overloaded, 50.0, &nothing).expect_err("it slips");
    assert!(unsteady.to_string().contains("no steady"), "{unsteady}");
    let mut wrong = parameters();
    wrong.friction.pulley = -1.0;
    let wrong = linearise(&wrong, &Inputs::default(), 50.0, &nothing).expect_err("no such friction");
    assert!(wrong.to_string().contains("friction.pulley"), "{wrong}");
}

/// Communication steps of 1 ms damp modes above some 100 Hz. A steady state must be stable without that: none of its
/// oscillating modes up to 20 kHz grows by more than 6 1/s, and none with ten times the ring's damping. Under constant torques and forces ratio
/// and speed may drift away within seconds: the slowest modes don't oscillate.
#[test]
fn no_oscillating_mode_of_a_steady_state_grows() {
    for (ratio, torque) in [(2.0, 50.0), (1.0, 50.0), (1.0, -50.0), (0.5, 50.0), (0.5, 0.0)] {
        for damping in [1.0, 10.0] {
            let mut parameters = Parameters::default();
            parameters.initial.ratio = ratio;
            parameters.ring.damping *= damping;
            let inputs = inputs((torque, 12.0e3), (-torque * ratio, 12.0e3));
            let modes = modes(&parameters, &inputs, 2.0e4).expect("a steady state");
            let most = modes[0];
            let swinging = modes.iter().find(|mode| mode[1] > 0.0).expect("an oscillating mode");
            println!(
                "{ratio}, {torque} N·m, {damping} times: {} modes, at most {most:?} 1/s",
                modes.len()
            );
            assert!(
                modes.len() > 100 && swinging[0] < 6.0 && most[0] < 6.0,
                "{ratio}, {torque} N·m: {most:?}, {swinging:?} 1/s"
            );
        }
    }
}

/// On the default mesh, whose unknowns have many units.
#[test]
fn poles_of_ale0_do_not_depend_on_the_cut_off() {
    let parameters = Parameters {
        ring_model: RingModel::Ale0,
        ..Parameters::default()
    };
    let nothing: [&dyn Fn(&Outputs) -> f64; 0] = [];
    for torque in [50.0, 60.0] {
        let inputs = inputs((torque, 13.0e3), (-torque, 10.0e3));
        let poles = |frequency| {
            let model = linearise(&parameters, &inputs, frequency, &nothing);
            model.expect("a linear model").poles
        };
        let (few, many) = (poles(100.0), poles(400.0));
        assert!(few.len() >= 3 && many.len() > few.len(), "{few:?} {many:?}");
        for (one, other) in few.iter().zip(&many) {
            let apart = (one[0] - other[0]).hypot(one[1] - other[1]);
            // A pole near zero is accurate to a share of the largest, some 500 1/s.
            assert!(apart < 1e-6 * (one[0].hypot(one[1]) + 0.1), "{one:?} {other:?}");
        }
    }
}

/// A run at rest has the linear model of its start.
#[test]
fn a_run_at_rest_has_the_linear_model_of_its_start() {
    let read: &dyn Fn(&Outputs) -> f64 = &|o| o.ratio_geometric;
    let start = linearise(&parameters(), &Inputs::default(), 20.0, &[read]).expect("a linear model");
    let mut variator = Variator::new(parameters()).expect("valid");
    variator.initialise(0.0, &start.inputs).expect("steady");
    variator.advance(0.05, &start.inputs).expect("a step");
    let here = linearise_at(&mut variator, &start.inputs, 20.0, &[read]).expect("a linear model");
    assert_eq!(here.remarks, Vec::<String>::new());
    assert_eq!(here.poles.len(), start.poles.len());
    for (one, other) in here.poles.iter().zip(&start.poles) {
        assert!(
            (one[0] - other[0]).abs() < 2e-3 * one[0].abs().max(1.0),
            "{one:?} {other:?}"
        );
    }
    // A state during a shift is not a working point.
    let mut inputs = start.inputs;
    inputs.primary.clamping_force += 3e3;
    variator.advance(0.1, &inputs).expect("a step");
    let moving = linearise_at(&mut variator, &inputs, 20.0, &[read]).expect_err("it shifts");
    assert!(moving.to_string().contains("not a steady working point"), "{moving}");
}

/// A torque beyond capacity is transmitted in part: the model is that of the state from which the run starts.
#[test]
fn a_remark_names_the_difference_from_the_specified_point() {
    let mut beyond = Inputs::default();
    beyond.primary.torque = 400.0;
    let mut variator = Variator::new(parameters()).expect("valid");
    variator.initialise(0.0, &beyond).expect("a start");
    let model = linearise_at(&mut variator, &beyond, 50.0, &[]).expect("a linear model");
    assert!(!model.outputs.macro_slip && model.outputs.slip < 0.03);
    assert!(model.inputs.primary.torque < 200.0);
    let remarks = model.remarks.join("\n");
    assert!(
        remarks.contains("primary.torque = ") && remarks.contains("400 N.m is specified"),
        "{remarks}"
    );
}

/// Between prescribed speeds the belt may slip through permanently.
#[test]
fn a_remark_names_a_belt_that_slips_through() {
    let mut parameters = parameters();
    (parameters.primary.drive, parameters.secondary.drive) = (Drive::Speed, Drive::Speed);
    let mut inputs = Inputs::default();
    (inputs.primary.speed_setpoint, inputs.secondary.speed_setpoint) = (200.0, 160.0);
    let model = linearise(&parameters, &inputs, 50.0, &[]).expect("it slips steadily");
    assert!(model.outputs.macro_slip && model.outputs.slip > 0.15);
    let remarks = model.remarks.join("\n");
    assert!(remarks.contains("slips through"), "{remarks}");
}
