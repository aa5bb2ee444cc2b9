//! Loads with jumps, ripple or noise: their work, and ramps of inputs.

use pushbelt::pulley::Pulley;
use pushbelt::solver::System;
use pushbelt::variator::pulleys::loads::{InputProfile, Loads};
use pushbelt::variator::run::Message;
use pushbelt::variator::settings::{Drive, Inputs, Parameters, RingModel};
use pushbelt_support::checks::{assert_close, assert_pinned};
use pushbelt_support::loads::{Driven, LOADS, LoadHistory};
use pushbelt_support::noise;
use pushbelt_support::run::{Run, restored, started};
use pushbelt_support::variators::{coarse, inputs, variator};
use std::f64::consts::TAU;

/// Time for which each load acts, s.
const SPAN: f64 = 0.2;

/// Jacobians under each load at ratio 1, in the order of their letters.
fn jacobians(model: RingModel, pinned: [u64; 10]) {
    let found = LOADS.map(|load| {
        let mut driven = Driven::new(load, variator(model), 1.0);
        let start = driven.variator.counts().factorizations;
        while driven.until() < SPAN - 1e-9 {
            driven.step();
        }
        driven.variator.counts().factorizations - start
    });
    for ((load, found), pinned) in LOADS.iter().zip(found).zip(pinned) {
        assert_pinned(found, pinned, &format!("Jacobians of {load:?}"));
    }
}

#[test]
fn jacobians_of_ale() {
    jacobians(RingModel::Ale, [5, 341, 17, 10, 75, 16, 890, 18, 356, 617]);
}

#[test]
fn jacobians_of_ale0() {
    jacobians(RingModel::Ale0, [5, 211, 17, 9, 39, 13, 710, 20, 307, 575]);
}

/// A slow shift under a torque that oscillates, as a function of time, s.
fn shifting(time: f64) -> Inputs {
    let [torque, force] = [3.0, 2.0].map(|frequency| (TAU * frequency * time).sin());
    inputs((50.0 + 20.0 * torque, 13e3 + 2e3 * force), (-49.0, 10e3))
}

/// Residuals and Jacobians in communication steps of these lengths, s, until `end`, s.
fn work(model: RingModel, mut lengths: impl FnMut(u32) -> f64, end: f64) -> [u64; 2] {
    let mut parameters = variator(model);
    parameters.solver.input_ramp = -1.0;
    let mut run = started(parameters, &shifting(0.0));
    let before = run.counts();
    for k in 0.. {
        let to = run.time() + lengths(k);
        if to > end + 1e-9 {
            break;
        }
        run.advance(to, &shifting(to)).expect("a step");
    }
    let work = run.counts() - before;
    [work.residuals, work.factorizations]
}

/// Irregular communication steps take at most 1.3 times the work, residuals and 12 for each
/// Jacobian, of equal ones with the same mean: random ones of 0.055 to 0.145 ms, and 0.33 and 2.17
/// ms in turn.
fn irregular_steps(model: RingModel, random: u64, in_turn: u64) {
    let total = |[residuals, jacobians]: [u64; 2]| residuals + 12 * jacobians;
    let mut noise = noise(1);
    let found = work(model, |_| 1e-4 * (1.0 + 0.9 * noise()), 0.25);
    let alternating = work(model, |k| if k % 2 == 0 { 0.33e-3 } else { 2.17e-3 }, 1.0);
    for (what, found, pinned, equal) in [
        ("random", found, random, work(model, |_| 1e-4, 0.25)),
        ("in turn", alternating, in_turn, work(model, |_| 1.25e-3, 1.0)),
    ] {
        let share = total(found) as f64 / total(equal) as f64;
        assert!(share <= 1.3, "{what}: {share} times the work, {found:?} for {equal:?}");
        assert_pinned(total(found), pinned, what);
    }
}

#[test]
fn irregular_steps_of_ale() {
    irregular_steps(RingModel::Ale, 7630, 4325);
}

#[test]
fn irregular_steps_of_ale0() {
    irregular_steps(RingModel::Ale0, 6272, 4194);
}

/// Rates of sheaves and shafts jump with the loads, so that their equations of motion still hold.
#[test]
fn rates_jump_with_the_loads() {
    let mut parameters = ramping(0.0);
    (parameters.secondary.drive, parameters.secondary.sheave_mass) = (Drive::Speed, 9.0);
    let before = inputs((50.0, 13e3), (0.0, 10e3));
    let mut after = inputs((80.0, 12e3), (0.0, 14e3));
    after.secondary.speed_setpoint += 2.0;
    let start = started(parameters, &before);
    let (mut system, mut state) = (start.system().clone(), start.state().clone());
    let mut jumped = |loads: &Inputs| {
        system.change_loads(Loads::held(loads), 0.0, &mut state.y_dot);
        let mut rows = vec![0.0; state.y.len()];
        system.residual(0.0, state.view(), &mut rows);
        (rows, state.y_dot.clone())
    };
    let ((rows, rates), (jumped_rows, jumped_rates)) = (jumped(&before), jumped(&after));
    let layout = start.system().belt.layout;
    for row in Pulley::BOTH.map(|j| [layout.sheave(j), layout.shaft_speed(j)]).concat() {
        assert!((jumped_rates[row] - rates[row]).abs() > 100.0, "row {row}");
        assert!((jumped_rows[row] - rows[row]).abs() < 1e-9 * 13e3, "row {row}");
    }
}

/// The coarse variator with a ramp of the inputs.
fn ramping(ramp: f64) -> Parameters {
    let mut parameters = coarse(RingModel::Ale);
    parameters.solver.input_ramp = ramp;
    parameters
}

/// Torque and forces change at communication steps of several lengths: at the end of each step the
/// input has the set value, the energy balance holds, and the result hardly depends on the ramp.
#[test]
fn held_inputs_reach_their_values_and_the_energy_balance_holds() {
    let speeds = [0.0, 1e-3, 3e-3, -1.0].map(|ramp| {
        let mut run = Run::new(ramping(ramp), inputs((50.0, 13e3), (-49.0, 10e3)));
        for k in 0..60 {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            run.inputs = inputs((50.0 + 20.0 * sign, 13e3 + 500.0 * sign), (-49.0, 10e3 - 300.0 * sign));
            let step = [1e-3, 2.5e-3, 0.4e-3][k % 3];
            let outputs = run.go(step, step);
            let torque = outputs.primary.external_torque;
            assert_close(torque, 50.0 + 20.0 * sign, 1e-9, "torque at the end of a step");
        }
        run.assert_balances();
        run.variator.outputs().primary.speed
    });
    for speed in speeds {
        assert_close(speed, speeds[0], 5e-3, "speed without a ramp");
    }
}

/// An input with a derivative starts at its value and follows the derivative; the others ramp.
#[test]
fn derivatives_take_precedence_over_the_ramp() {
    let start = inputs((50.0, 13e3), (-49.0, 10e3));
    let mut rates = Inputs::ZERO;
    rates.primary.torque = 1e4;
    let end_of = |ramp: f64| {
        let mut variator = started(ramping(ramp), &start);
        variator.advance_along(1e-3, &start, &rates).expect("a step");
        variator.outputs().primary.external_torque
    };
    for ramp in [0.0, 1e-3, -1.0] {
        assert_close(end_of(ramp), 60.0, 1e-9, "torque at the end of its ramp");
    }
    // A force that falls ends at zero.
    let falling = inputs((0.0, -2e3), (0.0, -1e3));
    let end = InputProfile::new(0.0, [0.0, 1.0], &start, &start, &falling).evaluate(60.0);
    assert_eq!([end.primary, end.secondary].map(|of| of.clamping_force), [0.0; 2]);
}

/// A hunting clutch takes more work than real time allows. The remark counts work, so it is the
/// same on a busy machine and after a state was stored and restored. The outputs count the same.
#[test]
fn a_remark_on_too_much_work_depends_on_the_inputs_alone() {
    let mut driven = Driven::new(LoadHistory::Hunting, variator(RingModel::Ale), 2.2);
    let mut again = None;
    let (start, mut remarks) = (driven.variator.counts(), Vec::new());
    while driven.until() < 1.0 - 1e-9 {
        let inputs = driven.inputs();
        let until = driven.until();
        for run in std::iter::once(&mut driven.variator).chain(&mut again) {
            run.advance(until, &inputs).expect("a step");
            let remark =
                |message: Message| message.text.contains("of simulation took").then_some(message.text);
            remarks.extend(run.take_messages().into_iter().filter_map(remark));
        }
        if again.is_none() && until > 0.9 {
            let parameters = driven.variator.parameters().clone();
            again = Some(restored(&mut driven.variator, parameters));
        }
    }
    let work = driven.variator.counts() - start;
    let counted = driven.variator.outputs().work;
    let counted = [counted.steps, counted.residuals, counted.jacobians]
        .map(|count| u64::try_from(count).expect("a count"));
    let steps = work.steps + work.rejected + work.failed;
    assert_eq!(counted, [steps, work.residuals, work.factorizations]);
    let expected = format!(
        "1.0 s of simulation took {} Jacobians and {} residuals",
        work.factorizations, work.residuals
    );
    assert_eq!(remarks.len(), 2, "{remarks:?}");
    for remark in &remarks {
        assert!(remark.starts_with(&expected), "{remark}, not {expected}");
        assert!(remark.contains("primary.torque varies most"), "{remark}");
    }
}
