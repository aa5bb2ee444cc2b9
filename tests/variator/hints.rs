//! Hopeless starts are seen before anything is solved, and loads that can hardly be meant are
//! remarked upon once.

use pushbelt::variator::settings::{Drive, Inputs, Parameters, RingModel, StartState};
use pushbelt_support::run::{Run, restored, tried};
use pushbelt_support::variators::{MODELS, SPEED, coarse, inputs, variator};

/// Far beyond capacity, or at a speed that breaks the ring: the error has variable, value and what
/// would do.
#[test]
fn a_hopeless_start_is_refused() {
    let refused = |parameters: Parameters, given: Inputs, texts: [&str; 3]| {
        let (residuals, error) = tried(parameters, &given);
        let error = error.expect("no state");
        assert!(
            texts.iter().all(|text| error.contains(text)) && residuals == 0,
            "{error}"
        );
    };
    for model in MODELS {
        for (force, ratio) in [(13.5, 1.0), (13.5, 0.4), (50.0, 0.6), (50.0, 2.2), (200.0, 2.2)] {
            let mut parameters = variator(model);
            parameters.initial.ratio = ratio;
            let value = format!("secondary.clampingForce = {force} N");
            let unit = format!("in kN? {force} kN carry");
            let given = inputs((50.0, force), (-50.0 * ratio, force));
            refused(parameters, given, [&value, &unit, "at least"]);
        }
        let mut parameters = variator(model);
        parameters.initial.primary_speed = 5000.0;
        let given = inputs((50.0, 13e3), (-49.0, 10e3));
        refused(parameters, given, ["initial.primarySpeed = 5000", "rad/s", "below"]);
    }
}

/// An eighth of the work that the ladder of torques beyond capacity took.
#[test]
fn torques_beyond_capacity_are_not_tried() {
    let (residuals, error) = tried(coarse(RingModel::Ale0), &inputs((50.0, 200.0), (-50.0, 200.0)));
    assert!(error.is_none() && residuals < 5_000, "{residuals} {error:?}");
}

/// Nothing clamps the belt: its elements leave each other before the run, so that the first step is
/// an ordinary one.
#[test]
fn a_slack_belt_at_rest_takes_its_first_step() {
    for model in MODELS {
        for (ratio, steady, force) in
            [(0.4, true, 0.0), (1.0, true, 0.0), (0.4, false, 1e4), (2.2, false, 0.0)]
        {
            let mut parameters = variator(model);
            (parameters.initial.ratio, parameters.initial.primary_speed) = (ratio, 0.0);
            parameters.initial.steady = steady;
            let mut run = Run::new(parameters, inputs((20.0, force), (0.0, force)));
            assert_eq!(run.go(1e-2, 1e-2).start_state, StartState::Unloaded);
            let [start, step] = [run.variator.start_work(), run.variator.counts()].map(|work| work.residuals);
            assert!(start < 5000 && step < 10_000);
        }
    }
}

#[test]
fn a_speed_in_rpm_is_remarked_upon_once() {
    let mut parameters = coarse(RingModel::Ale0);
    parameters.initial.primary_speed = 2000.0;
    let mut run = Run::new(parameters, inputs((50.0, 13e3), (-49.0, 10e3)));
    assert_eq!(run.warnings("is initial.primarySpeed in rpm? 2000 rpm are 209"), 1);
    run.go(5e-3, 1e-3);
    let parameters = run.variator.parameters().clone();
    run.variator = restored(&mut run.variator, parameters);
    run.go(1e-2, 1e-3);
    assert_eq!(run.warnings("faster than"), 1, "nor again after its state was stored");
    // A set point in the run.
    let mut parameters = coarse(RingModel::Ale0);
    (parameters.primary.drive, parameters.solver.input_ramp) = (Drive::Speed, -1.0);
    let mut run = Run::new(parameters, inputs((0.0, 60e3), (-20.0, 40e3)));
    assert_eq!(run.warnings("rpm?"), 0);
    run.inputs.primary.speed_setpoint = 2000.0;
    run.go(1.5, 1.5);
    run.go(0.02, 1e-2);
    assert_eq!(run.warnings("is primary.speedSetpoint in rpm? 2000 rpm"), 1);
}

#[test]
fn a_torque_of_the_wrong_sign_is_remarked_upon() {
    let mut run = Run::new(coarse(RingModel::Ale0), inputs((50.0, 13e3), (49.0, 10e3)));
    assert_eq!(run.warnings("secondary.torque = 49 N·m have the same sign"), 1);
    // Later it is seen where the belt runs away.
    run.go(0.8, 1e-2);
    assert_eq!(run.warnings("accelerate it"), 1);
    assert_eq!(run.warnings("the same sign"), 1);
}

/// The primary shaft under torque, the secondary one at a set point.
fn between_speeds() -> Run {
    let mut parameters = coarse(RingModel::Ale0);
    parameters.secondary.drive = Drive::Speed;
    let mut given = inputs((50.0, 13e3), (0.0, 10e3));
    given.secondary.speed_setpoint = SPEED;
    Run::new(parameters, given)
}

/// A force in kN, from a time on at which the belt turns; torques in N·mm.
#[test]
fn a_load_in_another_unit_is_remarked_upon_once() {
    for (torque, force, text) in [
        (50.0, 10.0, "in kN? 10 kN carry"),
        (5000.0, 10e3, "in N·mm? 5000 N·mm are 5 N·m"),
    ] {
        let mut run = between_speeds();
        (run.inputs.primary.torque, run.inputs.secondary.clamping_force) = (torque, force);
        let parameters = run.variator.parameters().clone();
        for (span, warnings) in [(0.1, 0), (0.02, 1), (0.28, 1)] {
            run.go(span, 1e-2);
            assert_eq!(run.warnings(text), warnings, "{:?}", run.messages);
            run.variator = restored(&mut run.variator, parameters.clone());
        }
    }
}

/// Launch, overrun, braking, standstill, no force, and a belt that is meant to slip through.
#[test]
fn ordinary_use_gets_no_hint() {
    let launch = |ratio: f64, given: Inputs| {
        let mut parameters = coarse(RingModel::Ale0);
        (parameters.initial.ratio, parameters.initial.primary_speed) = (ratio, 0.0);
        parameters.secondary.inertia = 4.0;
        Run::new(parameters, given)
    };
    let turning = |given: Inputs| Run::new(coarse(RingModel::Ale0), given);
    let mut runs = vec![
        launch(2.2, inputs((60.0, 13e3), (0.0, 15e3))),
        launch(1.0, inputs((0.0, 0.0), (0.0, 0.0))),
        turning(inputs((-20.0, 10e3), (20.0, 10e3))),
        turning(inputs((-10.0, 10e3), (-60.0, 10e3))),
        turning(inputs((0.0, 10e3), (0.0, 10e3))),
        turning(inputs((30.0, 10e3), (0.0, 10e3))),
    ];
    for run in &mut runs {
        run.go(0.3, 1e-2);
    }
    // The force of a launch comes in from zero under torque.
    let mut run = launch(2.2, inputs((30.0, 0.0), (0.0, 0.0)));
    let mut rates = Inputs::ZERO;
    (rates.primary.clamping_force, rates.secondary.clamping_force) = (5e4, 6e4);
    run.ramp(0.2, 1e-2, &rates);
    runs.push(run);
    // Slipping by design, at a tenth of the force.
    let mut run = between_speeds();
    (run.inputs.primary.clamping_force, run.inputs.secondary.clamping_force) = (1.2e3, 1e3);
    run.go(0.3, 1e-2);
    runs.push(run);
    for run in &runs {
        for text in ["kN?", "N·mm?", "rpm?", "sign"] {
            assert_eq!(run.warnings(text), 0, "{:?}", run.messages);
        }
    }
}
