//! The linear model against the variator itself: small steps of each load.

use nalgebra::DMatrix;
use pushbelt::variator::linear::{LinearError, LinearModel, linearise, linearise_at, modes};
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Inputs, Outputs, Parameters, RingModel};
use pushbelt_support::run::started;
use pushbelt_support::variators::{chain, inputs, mesh};

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

const RATIO: &dyn Fn(&Outputs) -> f64 = &|o| o.ratio_geometric;

fn parameters() -> Parameters {
    let mut parameters = Parameters {
        mesh: mesh(8, 4),
        ..Parameters::default()
    };
    parameters.solver.tolerance = 1e-7;
    parameters
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

/// The steps must be small: elements change between sticking and sliding, and after a torque step
/// of 0.2 N·m the ratio already changes by 20 % less than in the linear model.
#[test]
fn the_linear_model_follows_small_steps_of_each_load() {
    let read = OUTPUTS.each_ref().map(|(_, _, read)| read as &dyn Fn(&Outputs) -> f64);
    let model = linearise(&parameters(), &Inputs::default(), 100.0, &read).expect("a steady state");
    let start = started(parameters(), &model.inputs);
    let times = [0.01, 0.02, 0.05, 0.1, 0.2];
    assert_eq!(model.loads.len(), 4);
    for (l, load) in model.loads.iter().enumerate() {
        let size = if load.unit() == "N" { 5.0 } else { 0.01 };
        let [less, more] = [-size, size].map(|by| {
            let mut inputs = model.inputs;
            load.add(by, &mut inputs);
            run(&inputs, &start, &times)
        });
        let linear: Vec<Vec<f64>> = times.iter().map(|time| response(&model, l, *time)).collect();
        for (i, (name, noise, _)) in OUTPUTS.iter().enumerate() {
            let pairs = more.iter().zip(&less);
            let found: Vec<f64> = pairs.map(|(more, less)| (more[i] - less[i]) / (2.0 * size)).collect();
            let largest = found.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            for (k, time) in times.iter().enumerate() {
                let (found, linear) = (found[k], linear[k][i]);
                let allowed = 0.05 * largest + noise / size;
                let name = format!("{} → {name} at {time} s", load.name());
                assert!((found - linear).abs() < allowed, "{name}: {found} against {linear}");
            }
        }
    }
}

/// The gain of the linear model of `ALE0` and of a chain is that of a run too.
#[test]
fn the_gain_is_that_of_a_run() {
    let mut ale0 = parameters();
    (ale0.ring_model, ale0.initial.ratio) = (RingModel::Ale0, 0.7);
    let usual = inputs((70.0, 13e3), (-49.0, 10e3));
    let of_chain = inputs((20.0, 11e3), (-19.0, 11e3));
    for (mut parameters, inputs, speed, time, allowed) in [
        (ale0.clone(), usual, 35.0, 0.5, 0.01),
        (ale0, usual, 200.0, 0.5, 0.01),
        (chain(RingModel::Ale), of_chain, 209.44, 0.05, 0.1),
        (chain(RingModel::Ale0), of_chain, 209.44, 0.05, 0.1),
    ] {
        (parameters.initial.primary_speed, parameters.solver.tolerance) = (speed, 1e-7);
        let model = linearise(&parameters, &inputs, 100.0, &[RATIO]).expect("a linear model");
        assert!(model.a.len() < 40, "{} states up to 100 Hz", model.a.len());
        let start = started(parameters, &inputs);
        let mut loads = model.loads.iter();
        let force = loads.position(|load| load.name() == "primary.clampingForce");
        let force = force.expect("a load");
        let size = 20.0;
        let [less, more] = [-size, size].map(|step| {
            let mut inputs = model.inputs;
            inputs.primary.clamping_force += step;
            run(&inputs, &start, &[time])[0][2]
        });
        let (found, linear) = ((more - less) / (2.0 * size), response(&model, force, time)[0]);
        assert!((found - linear).abs() < allowed * found.abs(), "{found} {linear}");
    }
}

/// More modes change only the fast part of the response; for `ALE0` on the default mesh, whose
/// unknowns have many units.
#[test]
fn slow_poles_do_not_depend_on_the_cut_off() {
    let ale0 = Parameters {
        ring_model: RingModel::Ale0,
        ..Parameters::default()
    };
    let [medium, more] = [50.0, 60.0].map(|torque| inputs((torque, 13e3), (-torque, 10e3)));
    for (parameters, inputs, cut_offs, share, about) in [
        (parameters(), Inputs::default(), [20.0, 200.0], 1e-5, 1.0),
        // A pole near zero is accurate to a share of the largest, some 500 1/s.
        (ale0.clone(), medium, [100.0, 400.0], 1e-6, 0.1),
        (ale0, more, [100.0, 400.0], 1e-6, 0.1),
    ] {
        let [few, many] = cut_offs.map(|frequency| {
            let model = linearise(&parameters, &inputs, frequency, &[]);
            model.expect("a linear model").poles
        });
        assert!(few.len() >= 2 && many.len() > few.len(), "{few:?} {many:?}");
        for pole in &few {
            let apart = many.iter().map(|other| (pole[0] - other[0]).hypot(pole[1] - other[1]));
            let nearest = apart.fold(f64::INFINITY, f64::min);
            let allowed = share * (about + pole[0].hypot(pole[1]));
            assert!(nearest < allowed, "{pole:?}: {nearest}");
            assert!(pole[0] < 1.0, "{pole:?}: the point is stable or slowly unstable");
        }
    }
}

/// An end stop takes part of the belt's axial force: the forces that hold the working point are the
/// specified ones.
#[test]
fn an_end_stop_takes_part_of_the_axial_force() {
    let mut parameters = parameters();
    parameters.initial.ratio = 0.437;
    let inputs = Inputs::default();
    let mut start = started(parameters.clone(), &inputs);
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
    let slow = linearise(&parameters(), &Inputs::default(), 1e-3, &[]).err();
    assert!(matches!(slow, Some(LinearError::NoMode(_))), "{slow:?}");
    let mut overloaded = Inputs::default();
    (overloaded.primary.torque, overloaded.secondary.torque) = (500.0, -490.0);
    let unsteady = linearise(&parameters(), &overloaded, 50.0, &[]).expect_err("it slips");
    assert!(unsteady.to_string().contains("no steady"), "{unsteady}");
    let mut wrong = parameters();
    wrong.friction.pulley = -1.0;
    let wrong = linearise(&wrong, &Inputs::default(), 50.0, &[]).expect_err("no such friction");
    assert!(wrong.to_string().contains("friction.pulley"), "{wrong}");
}

/// Communication steps of 1 ms damp modes above some 100 Hz. A steady state must be stable without
/// that: none of its oscillating modes up to 20 kHz grows by more than 6 1/s, and none with ten
/// times the ring's damping. Under constant torques and forces ratio and speed may drift away
/// within seconds: the slowest modes don't oscillate.
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
            let grows = swinging[0] >= 6.0 || most[0] >= 6.0;
            assert!(modes.len() > 100 && !grows, "{ratio}, {torque} N·m: {most:?}");
        }
    }
}

#[test]
fn a_run_at_rest_has_the_linear_model_of_its_start() {
    let start = linearise(&parameters(), &Inputs::default(), 20.0, &[RATIO]).expect("a linear model");
    let mut variator = started(parameters(), &start.inputs);
    variator.advance(0.05, &start.inputs).expect("a step");
    let here = linearise_at(&mut variator, &start.inputs, 20.0, &[RATIO]).expect("a linear model");
    assert_eq!(here.remarks, Vec::<String>::new());
    assert_eq!(here.poles.len(), start.poles.len());
    for (one, other) in here.poles.iter().zip(&start.poles) {
        let allowed = 2e-3 * one[0].abs().max(1.0);
        assert!((one[0] - other[0]).abs() < allowed, "{one:?} {other:?}");
    }
    // A state during a shift is not a working point.
    let mut inputs = start.inputs;
    inputs.primary.clamping_force += 3e3;
    variator.advance(0.1, &inputs).expect("a step");
    let moving = linearise_at(&mut variator, &inputs, 20.0, &[RATIO]).expect_err("it shifts");
    assert!(moving.to_string().contains("not a steady working point"), "{moving}");
}
