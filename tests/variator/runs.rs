//! Runs of the variator: the manoeuvre's energy balance, tolerance, communication steps,
//! repeatability, counts.

use pushbelt::fmi::table::Value;
use pushbelt::variator::run::{CommunicationStep, InitialisationError, StepError, Variator};
use pushbelt::variator::settings::{
    Axial, Drive, Inputs, Mode, Outputs, Parameters, RingModel, Setting, parameters,
};
use pushbelt_support::checks::{assert_close, assert_pinned};
use pushbelt_support::manoeuvre::Manoeuvre;
use pushbelt_support::run::{Run, assert_continues_alike, restored, started};
use pushbelt_support::tracking::Tracked;
use pushbelt_support::variators::{MODELS, chain, coarse, inputs, rigid, variator};

/// Communication step of the manoeuvre, s.
const STEP: f64 = 1e-3;

/// The manoeuvre between two of its times.
fn drive(parameters: Parameters, from: f64, to: f64, mut see: impl FnMut(f64, &Outputs)) -> Run {
    let manoeuvre = Manoeuvre::read();
    let mut run = Run::new(parameters, manoeuvre.at(from));
    let steps = ((to - from) / STEP).round() as u32;
    for k in 0..steps {
        let clock = from + f64::from(k) * STEP;
        run.inputs = manoeuvre.at(clock);
        let outputs = run.go(STEP, STEP);
        see(clock + STEP, &outputs);
    }
    run
}

/// Launch from standstill, shift to overdrive, torque steps, over-torque, recovery: at every output
/// point the energy residual is at most 2e-3·∫|power| dt + 1e-3·(largest stored energy), and no
/// element is lost. The ratio covers `ratios[0]` to `ratios[1]`. The numbers of steps, residuals
/// and factorizations are pinned.
fn whole_manoeuvre(model: RingModel, ratios: [f64; 2], work: [u64; 3]) {
    let (mut low, mut high, mut slipped) = (f64::INFINITY, 0.0_f64, false);
    let mut run = drive(Manoeuvre::variator(variator(model)), 0.0, 10.0, |clock, o| {
        low = low.min(o.ratio_geometric);
        high = high.max(o.ratio_geometric);
        slipped |= o.macro_slip && clock > 8.5;
    });
    let last = run.outputs();
    assert_close(low, ratios[0], 0.02, "lowest ratio");
    assert_close(high, ratios[1], 0.02, "highest ratio");
    assert!(slipped);
    assert!(!last.macro_slip && last.slip.abs() < 0.03);
    run.assert_balances();
    let counts = run.variator.counts();
    assert_pinned(counts.steps, work[0], "steps");
    assert_pinned(counts.residuals, work[1], "residuals");
    assert_pinned(counts.factorizations, work[2], "factorizations");
}

#[test]
fn energy_balance_of_the_whole_manoeuvre_ale0() {
    whole_manoeuvre(RingModel::Ale0, [0.371, 2.349], [10_065, 27_394, 372]);
}

#[test]
fn energy_balance_of_the_whole_manoeuvre_ale() {
    whole_manoeuvre(RingModel::Ale, [0.371, 2.323], [10_090, 35_990, 956]);
}

/// Macro-slip of a belt at 40 to 70 m/s, in communication steps of 1 ms and of 50 µs: an unstable
/// wave of the mesh, which long steps damp, would grow in short ones.
#[test]
fn macro_slip_is_the_same_in_short_steps() {
    let mut parameters = Manoeuvre::variator(variator(RingModel::Ale));
    parameters.solver.input_ramp = STEP / 20.0;
    // From the steady state near that of the manoeuvre before the over-torque.
    (parameters.initial.ratio, parameters.initial.primary_speed) = (0.8, 120.0);
    let mut start = drive(parameters, 8.45, 8.6, |_, _| {});
    let manoeuvre = Manoeuvre::read();
    let [long, short] = [STEP, STEP / 20.0].map(|step| {
        let mut run = start.clone();
        (0..130_u32)
            .map(|k| {
                run.inputs = manoeuvre.at(8.6 + f64::from(k) * STEP);
                run.go(STEP, step)
            })
            .collect::<Vec<_>>()
    });
    assert!(start.outputs().macro_slip && long[110].belt_speed > 60.0);
    for (k, (name, read)) in WATCHED.iter().enumerate() {
        let off = |(a, b)| (read(a) / read(b) - 1.0).abs();
        let off: Vec<f64> = long.iter().zip(&short).map(off).collect();
        let [most, mean] = [off.iter().copied().fold(0.0, f64::max), off.iter().sum::<f64>() / 130.0];
        // Forces have waves, of which long steps damp those above 100 Hz.
        let agrees = if k < MOTIONS { most < 1e-3 } else { mean < 3e-2 };
        assert!(agrees, "{name}: {most} of its value at most, {mean} in the mean");
    }
}

/// Between rigid sheaves, waves of the mesh grow at the entry of an arc in sufficiently short
/// steps; they stay small.
#[test]
fn waves_between_rigid_sheaves_stay_small() {
    let mut parameters = rigid(variator(RingModel::Ale));
    parameters.primary.axial = Axial::Held;
    parameters.initial.ratio = 0.6;
    let mut run = Run::new(parameters, inputs((50.0, 12.0e3), (-30.0, 12.0e3)));
    run.go(0.05, 1e-3);
    for step in [1e-3, 5e-5] {
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        run.watch(0.2, step, |_, o| {
            (least, most) = (least.min(o.primary.axial_force), most.max(o.primary.axial_force));
        });
        assert!(most / least < 1.03, "{least} to {most} N");
    }
}

/// The compared outputs: motions, then forces.
const WATCHED: [Tracked; 7] = [
    ("ratio", |o| o.ratio_geometric),
    ("primary speed", |o| o.primary.speed),
    ("secondary speed", |o| o.secondary.speed),
    ("belt speed", |o| o.belt_speed),
    ("thrust ratio", |o| o.thrust_ratio),
    ("primary axial force", |o| o.primary.axial_force),
    ("push force", |o| o.push_force_max),
];
const MOTIONS: usize = 4;

/// A tolerance ten times tighter changes launch and shift by less than 0.2 % of each output's
/// range: motions at every output point, forces in the root mean square. (The moments at which
/// elements stick and slip move with the tolerance, and with them single values of forces: by up to
/// 1.3 % of the range.)
fn tighter_tolerance(model: RingModel, to: f64) {
    let [a, b] = [1.0, 0.1].map(|factor| {
        let mut parameters = Manoeuvre::variator(coarse(model));
        parameters.solver.tolerance *= factor;
        let mut rows = Vec::new();
        drive(parameters, 0.0, to, |clock, o| rows.push((clock, o.clone())));
        rows
    });
    for (k, (name, read)) in WATCHED.iter().enumerate() {
        let range = |f: fn(f64, f64) -> f64| a.iter().map(|row| read(&row.1)).reduce(f).expect("rows");
        let span = range(f64::max) - range(f64::min);
        // In the first milliseconds flanks close by a micrometre, and forces rise from zero.
        let first = if k < MOTIONS { 0 } else { 10 };
        let off = a
            .iter()
            .zip(&b)
            .skip(first)
            .map(|(x, y)| ((read(&x.1) - read(&y.1)).abs() / span, x.0));
        let square: f64 = off.clone().map(|d| d.0 * d.0).sum();
        let mean = (square / a.len() as f64).sqrt();
        let (most, clock) = off.fold((0.0, 0.0), |m, d| if d.0 > m.0 { d } else { m });
        assert!(mean < 2e-3, "{model:?} {name}: {mean} in the mean");
        let allowed = if k < MOTIONS { 2e-3 } else { 2e-2 };
        assert!(most < allowed, "{model:?} {name}: {most} at {clock} s");
    }
}

#[test]
fn a_tighter_tolerance_changes_little_ale0() {
    tighter_tolerance(RingModel::Ale0, 3.0);
}

#[test]
fn a_tighter_tolerance_changes_little_ale() {
    tighter_tolerance(RingModel::Ale, 2.6);
}

/// The end of a run does not depend on its division into communication steps.
#[test]
fn the_result_does_not_depend_on_the_communication_step() {
    const SHORTEST: f64 = 1e-4;
    for model in MODELS {
        let run = |step: f64| {
            let mut parameters = coarse(model);
            parameters.solver.input_ramp = SHORTEST;
            let mut run = Run::new(parameters, Inputs::default());
            run.inputs.primary.clamping_force = 15e3;
            run.go(0.03, step)
        };
        let reference = run(1e-3);
        for step in [SHORTEST, 7.5e-3, 0.03] {
            let o = run(step);
            assert!((o.ratio_geometric - reference.ratio_geometric).abs() < 1e-4);
            assert_close(o.primary.speed, reference.primary.speed, 1e-4, "primary speed");
            assert_close(o.thrust_ratio, reference.thrust_ratio, 2e-3, "thrust ratio");
        }
    }
}

/// Two equal runs agree to the last bit, and so do copies and stored states, while inputs ramp and
/// with changed friction; also with cylinders under pressure.
#[test]
fn runs_and_snapshots_repeat_bit_for_bit() {
    let mut cylinders = coarse(RingModel::Ale);
    for pulley in [&mut cylinders.primary, &mut cylinders.secondary] {
        (pulley.cylinder.area, pulley.cylinder.spring_stiffness) = (0.012, 1.5e4);
        (pulley.cylinder.centrifugal, pulley.cylinder.seal) = (0.01, 200.0);
    }
    let mut real_time = cylinders.clone();
    real_time.solver.mode = Mode::RealTime;
    for mut parameters in [MODELS.map(coarse), MODELS.map(chain), [cylinders, real_time]].concat() {
        parameters.solver.input_ramp = -1.0;
        let of = |k: u32| {
            let mut given = inputs((50.0 + 30.0 * f64::from(k % 3), 13e3), (-49.0, 10e3));
            given.primary.pressure = 4e4 * f64::from(k % 3);
            given
        };
        let [mut one, two] = [(); 2].map(|()| {
            let mut variator = started(parameters.clone(), &of(0));
            variator.set_friction(0.08, 0.03).expect("in range");
            for k in 1..10 {
                variator.advance(1e-3 * f64::from(k), &of(k)).expect("a step");
            }
            variator
        });
        assert_eq!(one.state(), two.state());
        one.set_friction(0.07, 0.03).expect("in range");
        let mut k = 10;
        assert_continues_alike(&mut one, parameters, |_| {
            k += 1;
            (1e-3 * f64::from(k - 1), of(k))
        });
    }
}

/// A start doesn't depend on the previous run, even one whose friction velocity is still large.
#[test]
fn a_second_start_equals_the_first() {
    let mut parameters = coarse(RingModel::Ale0);
    parameters.primary.drive = Drive::Speed;
    let running = inputs((0.0, 13e3), (-49.0, 10e3));
    let mut resting = running;
    resting.primary.speed_setpoint = 0.0;
    let mut fresh = started(parameters.clone(), &running);
    let mut used = started(parameters, &resting);
    used.advance(3e-3, &resting).unwrap();
    used.initialise(0.0, &running).unwrap();
    for variator in [&mut fresh, &mut used] {
        variator.advance(1e-3, &running).unwrap();
    }
    assert_eq!(fresh.state(), used.state());
    assert_eq!(fresh.outputs(), used.outputs());
}

/// Times that are none, or go back, are refused in one error, in both modes, and the run goes on.
#[test]
fn a_time_that_is_none_is_refused() {
    let given = Inputs::default();
    for mode in [Mode::Accurate, Mode::RealTime] {
        let mut parameters = coarse(RingModel::Ale0);
        parameters.solver.mode = mode;
        let mut variator = Variator::new(parameters).expect("valid parameters");
        for time in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -1e7, 1e300] {
            let refused = variator.initialise(time, &given).expect_err("no start");
            assert!(matches!(refused, InitialisationError::Time(_)), "{refused}");
        }
        variator.initialise(0.0, &given).expect("a start");
        variator.advance(2e-3, &given).expect("a step");
        let before = (variator.state().clone(), variator.outputs().clone());
        for to in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, 1e-3, -1.0] {
            let refused = variator.advance(to, &given).expect_err("no step");
            assert!(matches!(refused, StepError::Time(_)), "{refused}");
            let text = format!("the time {to} s is out of range: 0.002 to ");
            assert!(refused.to_string().starts_with(&text), "{refused}");
        }
        let mut rates = Inputs::ZERO;
        rates.secondary.torque = f64::NAN;
        let refused = variator.advance_along(3e-3, &given, &rates).expect_err("no rate");
        assert!(
            refused
                .to_string()
                .starts_with("the derivative of secondary.torque = NaN")
        );
        assert_eq!((variator.state().clone(), variator.outputs().clone()), before);
        // Rounding is no step back.
        variator.advance(2e-3 - 1e-15, &given).expect("no step");
        variator.advance(3e-3, &given).expect("a step");
        let mut step = CommunicationStep::begin(&mut variator, 4e-3, &given, &Inputs::ZERO).expect("a step");
        step.end_at(&variator, f64::NAN);
        assert!(!step.is_over(), "its end stays");
    }
}

/// A parameter that may be 0 and is next to it acts as at 0, or is refused.
#[test]
fn a_parameter_next_to_zero_is_as_at_zero_or_refused() {
    let given = inputs((20.0, 13e3), (-20.0, 10e3));
    let attempt = |parameters: Parameters| {
        let mut variator = Variator::new(parameters).map_err(|error| error.to_string())?;
        variator.initialise(0.0, &given).map_err(|_| "no start".to_owned())?;
        let more = inputs((23.0, 13e3), (-20.0, 10e3));
        variator.advance(3e-3, &more).map_err(|error| error.to_string())?;
        Ok::<_, String>(variator.outputs().clone())
    };
    let may_be_0 = |one: &Setting<Parameters>| one.range().is_some_and(|range| range.contains(&0.0));
    for variable in parameters().filter(may_be_0).map(Setting::variable) {
        let name = &variable.name;
        let [zero, next] = [0.0, 1e-170].map(|value| {
            let mut parameters = coarse(RingModel::Ale0);
            assert_eq!(variable.set(&mut parameters, Value::Real(value)), Ok(()), "{name}");
            attempt(parameters)
        });
        match (next, zero) {
            (Ok(found), Ok(expected)) => {
                assert_close(found.thrust_ratio, expected.thrust_ratio, 1e-3, name);
                assert_close(found.losses.total(), expected.losses.total(), 1e-3, name);
            }
            (Err(why), Ok(_)) => assert!(why.contains("or 0: "), "{name}: {why}"),
            (found, expected) => assert_eq!(found.is_ok(), expected.is_ok(), "{name}: {found:?}"),
        }
    }
}

/// A drift of friction, as with temperature, requires few new Jacobians.
#[test]
fn drifting_friction_takes_few_jacobians() {
    for model in MODELS {
        let inputs = inputs((50.0, 13e3), (-49.0, 10e3));
        let mut variator = started(variator(model), &inputs);
        let friction = variator.parameters().friction.clone();
        let before = variator.counts();
        for k in 1..=200 {
            let share = 1.0 + 1e-4 * f64::from(k);
            let [pulley, ring] = [friction.pulley, friction.ring].map(|friction| share * friction);
            variator.set_friction(pulley, ring).expect("in range");
            variator.advance(1e-3 * f64::from(k), &inputs).expect("a step");
        }
        let taken = variator.counts().factorizations - before.factorizations;
        assert!(taken < 50, "{model:?}: {taken} Jacobians in 200 steps");
    }
}

/// All that can be read of a run but its work: time derivatives too.
fn readings(run: &mut Variator) -> impl PartialEq + std::fmt::Debug + use<> {
    let of_run = (run.time(), run.parameters().clone(), run.start_work());
    (of_run, run.outputs().clone(), run.profile().clone(), run.moment())
}

/// A copy, stored bytes and a step that is abandoned give back every reading, in each mode, after
/// each tunable parameter: before a step under it and after some.
#[test]
fn each_way_back_gives_every_reading() {
    for (mut parameters, mode) in [
        (coarse(RingModel::Ale), Mode::Accurate),
        (coarse(RingModel::Ale0), Mode::RealTime),
        (chain(RingModel::Ale0), Mode::Accurate),
    ] {
        (parameters.solver.mode, parameters.solver.effort) = (mode, 1);
        let given = |k: u32| inputs((60.0 - 30.0 * f64::from(k % 5), 13e3), (-49.0, 10e3));
        let mut run = started(parameters.clone(), &given(0));
        let mut behind = 0;
        let mut check = |run: &mut Variator, k: u32, friction: [f64; 2]| {
            let (expected, work) = (readings(run), run.counts());
            for other in [&mut run.clone(), &mut restored(run, parameters.clone())] {
                assert_eq!(readings(other), expected, "{mode:?}, {friction:?}");
                assert_eq!(other.counts(), work);
            }
            let to = run.time() + 1e-3;
            let later = [0.08, 0.05].map(|other| {
                let mut run = run.clone();
                let step = CommunicationStep::begin(&mut run, to, &given(k + 3), &Inputs::ZERO);
                let mut step = step.expect("in range");
                run.set_friction(other, 0.02).expect("in range");
                step.advance(&mut run).expect("a part of a step");
                let work = run.counts();
                step.discard(&mut run);
                assert_eq!(readings(&mut run), expected, "{mode:?}, {friction:?}");
                assert_eq!(run.counts(), work, "work that was in vain counts");
                run.advance(to, &given(k)).expect("a step");
                run.state().clone()
            });
            assert_eq!(later[0], later[1], "what follows does not depend on what was abandoned");
            behind += i32::from(run.outputs().work.behind > 0.0);
        };
        for (n, friction) in [[0.09, 0.05], [0.06, 0.05], [0.06, 0.03]].into_iter().enumerate() {
            run.set_friction(friction[0], friction[1]).expect("in range");
            let first = 3 * n as u32;
            check(&mut run, first, friction);
            for k in first + 1..=first + 3 {
                run.advance(1e-3 * f64::from(k), &given(k)).expect("a step");
            }
            check(&mut run, first + 3, friction);
        }
        assert_eq!(behind > 0, mode == Mode::RealTime, "an open step is stored too");
    }
}

/// What follows a step that can't be done does not depend on it, nor on friction set in it.
#[test]
fn a_failed_step_leaves_nothing() {
    let gentle = inputs((50.0, 13e3), (-49.0, 10e3));
    for (tolerance, span) in [(1e-4, 2e-3), (1e-10, 1e-6)] {
        let mut parameters = variator(RingModel::Ale);
        (parameters.friction.velocity, parameters.solver.tolerance) = (1e-6, tolerance);
        let mut start = started(parameters, &gentle);
        start.advance(1e-3, &gentle).expect("a step");
        let [one, other] = [(5e3, 0.09), (4e3, 0.05)].map(|(torque, friction)| {
            let large = inputs((torque, 5e5), (-torque, 5e5));
            let mut run = start.clone();
            let before = readings(&mut run);
            let mut step = CommunicationStep::begin(&mut run, 3e-3, &large, &Inputs::ZERO).expect("in range");
            run.set_friction(friction, 0.01).expect("in range");
            let mut outcome = Ok(());
            while outcome.is_ok() && !step.is_over() {
                outcome = step.advance(&mut run);
            }
            assert!(outcome.is_err(), "{tolerance}");
            assert_eq!(readings(&mut run), before, "{tolerance}");
            run.advance(1e-3 + span, &gentle).expect("a step");
            run
        });
        assert_eq!(one.state(), other.state(), "{tolerance}");
    }
}
