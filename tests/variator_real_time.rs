//! Real time: bounded work in each millisecond, closeness to the accurate run, no allocation, stored states.

use pushbelt::archive::Archive;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Inputs, Mode, Parameters, RingModel};
use pushbelt_support::checks::assert_close;
use pushbelt_support::loads::{Driven, LOADS, LoadHistory};
use pushbelt_support::meter::{ABOVE, EFFORT, Meter};
use pushbelt_support::noise;
use pushbelt_support::tracking::{Trace, trace};
use pushbelt_support::variators::{MODELS, coarse, inputs, one_cell, variator};

fn in_real_time(mut parameters: Parameters) -> Parameters {
    parameters.solver.mode = Mode::RealTime;
    parameters
}

/// The meshes among which a test rig chooses.
fn meshes() -> [Parameters; 3] {
    [
        variator(RingModel::Ale0),
        one_cell(RingModel::Ale),
        variator(RingModel::Ale),
    ]
}

/// Steps begun again in the last communication step; `before` is their number until then.
fn new_rollbacks(variator: &mut Variator, before: &mut i32) -> i32 {
    let now = variator.outputs().work.rollbacks;
    now - std::mem::replace(before, now)
}

/// Every load at every ratio: work within the bound in each communication step, its mean as well; no step fails, all outputs are finite,
/// and the energy balance holds.
fn work_of(model: RingModel, effort: i32, seconds: f64, unaccounted: f64) {
    for load in LOADS {
        for &ratio in load.ratios() {
            let mut parameters = in_real_time(one_cell(model));
            parameters.solver.effort = effort;
            let mut of_run = Meter::new(&Driven::new(load, parameters.clone(), ratio).variator);
            let found = trace(load, &parameters, ratio, seconds, |driven| {
                let bound = EFFORT * f64::from(effort) * (load.step() / 1e-3);
                let work = of_run.read(&driven.variator);
                assert!(work <= bound + ABOVE, "{load:?} at ratio {ratio}: {work}");
                assert!(driven.variator.outputs().work.behind < 0.02 + 1e-9);
            });
            let mean = of_run.sum * 1e-3 / seconds;
            println!(
                "{model:?} {load:?} {ratio}: {mean:.1} a millisecond, defect {:.1e}, unaccounted {:.4}",
                found.defect, found.unaccounted
            );
            assert!(mean <= EFFORT * f64::from(effort) + ABOVE * 1e-3 / seconds, "{mean}");
            if load == LoadHistory::Smooth && effort >= 4 {
                assert!(mean < 14.0, "{load:?} at ratio {ratio}: {mean}");
            }
            assert!(
                found.rows.iter().flatten().all(|x| x.is_finite()),
                "{load:?} at ratio {ratio}"
            );
            let allowed = if load == LoadHistory::Launch {
                IN_A_LAUNCH
            } else {
                unaccounted
            };
            assert!(
                found.unaccounted.abs() < allowed,
                "{load:?} at ratio {ratio}: {}",
                found.unaccounted
            );
        }
    }
}

/// Relative to the transmitted energy, which is almost zero in the first moments of a launch.
const UNACCOUNTED: f64 = 0.002;
const IN_A_LAUNCH: f64 = 0.1;
const WITH_LEAST_EFFORT: f64 = 0.005;

#[test]
fn work_of_ale_is_bounded() {
    work_of(RingModel::Ale, 4, 0.3, UNACCOUNTED);
}

#[test]
fn work_of_ale0_is_bounded() {
    work_of(RingModel::Ale0, 4, 0.3, UNACCOUNTED);
    work_of(RingModel::Ale0, 1, 0.1, WITH_LEAST_EFFORT);
}

fn beside_accurate(load: LoadHistory, model: RingModel, ratio: f64, seconds: f64) -> (Trace, Trace) {
    beside(&one_cell(model), (load, model, ratio), 4, seconds)
}

/// Compared with an accurate run of these parameters.
fn beside(
    accurate: &Parameters,
    (load, model, ratio): (LoadHistory, RingModel, f64),
    effort: i32,
    seconds: f64,
) -> (Trace, Trace) {
    let exact = trace(load, accurate, ratio, seconds, |_| ());
    let mut parameters = in_real_time(one_cell(model));
    parameters.solver.effort = effort;
    let found = trace(load, &parameters, ratio, seconds, |_| ());
    println!(
        "{model:?} {load:?} {ratio}: off by {:?} of {:?}",
        found.off(&exact),
        exact.ranges()
    );
    (found, exact)
}

/// A slam into macro-slip and back is reported within 5 ms, with speeds and slip within 2 % of their ranges.
#[test]
fn a_slam_is_followed() {
    for model in MODELS {
        let (found, exact) = beside_accurate(LoadHistory::Slam, model, 1.0, 0.4);
        let (off, ranges) = (found.off(&exact), exact.ranges());
        for k in [0, 1, 3] {
            assert!(off[k] < 0.02 * ranges[k], "{model:?} {k}: {} of {}", off[k], ranges[k]);
        }
        let first = |trace: &Trace| trace.first_slip().expect("it slips") as f64;
        assert_close(first(&found), first(&exact), 5.0, "first step of macro-slip");
        let last = |trace: &Trace| trace.slipping.iter().rposition(|&slips| slips).expect("it slips") as f64;
        assert_close(last(&found), last(&exact), 10.0, "last step of macro-slip");
    }
}

#[test]
fn macro_slip_is_reported_within_5_ms() {
    for parameters in meshes() {
        for &ratio in LoadHistory::Slam.ratios() {
            let first = |parameters: &Parameters| {
                let found = trace(LoadHistory::Slam, parameters, ratio, 0.03, |_| ());
                found.first_slip().expect("it slips") as f64
            };
            let (exact, found) = (first(&parameters), first(&in_real_time(parameters.clone())));
            assert_close(found, exact, 5.0, "first step of macro-slip");
        }
    }
}

/// Under smooth loads, ripple and noise, in the units of a controller.
#[test]
fn smooth_and_rippling_loads_are_followed() {
    for model in MODELS {
        for load in [LoadHistory::Smooth, LoadHistory::Ripple, LoadHistory::Noise] {
            let (found, exact) = beside_accurate(load, model, 1.0, 0.3);
            let [primary, secondary, ratio, slip, thrust] = found.off(&exact);
            assert!(
                primary < 5e-3 && secondary < 5e-3,
                "{model:?} {load:?}: {primary}, {secondary} rad/s"
            );
            assert!(ratio < 2e-4 && slip < 2e-4, "{model:?} {load:?}: {ratio}, {slip}");
            assert!(thrust < 2e-4, "{model:?} {load:?}: {thrust}");
        }
    }
}

/// A ripple of 100 Hz requires steps below 1 ms: with 1 ms the thrust ratio has errors of 5 % of its range.
#[test]
fn ripple_is_followed() {
    for model in MODELS {
        for ratio in [2.2, 0.5] {
            let mut sharp = one_cell(model);
            sharp.solver.tolerance = 1e-6;
            let (found, exact) = beside(&sharp, (LoadHistory::Ripple, model, ratio), 4, 0.5);
            let (off, ranges) = (found.off(&exact), exact.ranges());
            for (k, share) in [0.02, 0.02, 0.02, 0.02, 0.03].into_iter().enumerate() {
                let (off, range) = (off[k], ranges[k]);
                assert!(off < share * range, "{model:?} {ratio} {k}: {off} of {range}");
            }
        }
    }
}

/// Speeds and slip have errors within a share of their ranges, the thrust ratio within its own bound. The ratio, whose range is
/// some 1e-2, has errors within 1e-2.
fn assert_followed((load, model, ratio): (LoadHistory, RingModel, f64), effort: i32, share: f64, thrust_ratio: f64) {
    let (found, exact) = beside(&one_cell(model), (load, model, ratio), effort, 0.3);
    let (off, ranges) = (found.off(&exact), exact.ranges());
    for k in [0, 1, 3] {
        assert!(
            off[k] < share * ranges[k],
            "{load:?} {model:?} {k}: {} of {}",
            off[k],
            ranges[k]
        );
    }
    assert!(off[2] < 1e-2, "{load:?} {model:?} ratio: {}", off[2]);
    assert!(off[4] < thrust_ratio, "{model:?}: {}", off[4]);
}

/// An engine's firing, also with noise on the forces.
#[test]
fn firing_is_followed() {
    for model in MODELS {
        let share = if model == RingModel::Ale { 0.1 } else { 0.01 };
        for &ratio in LoadHistory::Firing.ratios() {
            assert_followed((LoadHistory::Firing, model, ratio), 8, share, 5e-3);
        }
        assert_followed((LoadHistory::FiringAndNoise, model, 2.2), 8, 0.2, 3e-2);
    }
}

/// A torque that reverses from drive to coast, and a hunting clutch: they take the work of an effort of 13.
#[test]
fn flips_and_hunting_are_followed() {
    for ratio in [2.2, 1.0, 0.5] {
        assert_followed((LoadHistory::Flips, RingModel::Ale0, ratio), 13, 0.05, 2e-2);
    }
    for ratio in [1.0, 0.5] {
        assert_followed((LoadHistory::Flips, RingModel::Ale, ratio), 13, 0.1, 2e-2);
    }
    assert_followed((LoadHistory::Hunting, RingModel::Ale0, 2.2), 13, 0.05, 2e-2);
}

/// Also `ALE` at ratio 2.2, with a bound on the delay.
#[test]
fn with_more_effort_ale_follows_a_clutch_that_hunts() {
    for (load, ratio, share) in [
        (LoadHistory::Hunting, 2.2, 0.05),
        (LoadHistory::Hunting, 1.0, 0.05),
        (LoadHistory::Flips, 2.2, 0.05),
    ] {
        let accurate = one_cell(RingModel::Ale);
        let mut parameters = in_real_time(accurate.clone());
        parameters.solver.effort = 13;
        let mut latest = 0.0_f64;
        let exact = trace(load, &accurate, ratio, 0.2, |_| ());
        let found = trace(load, &parameters, ratio, 0.2, |driven| {
            latest = latest.max(driven.variator.outputs().work.behind);
        });
        let (off, ranges) = (found.off(&exact), exact.ranges());
        println!("{load:?} {ratio}: off by {off:?} of {ranges:?}, behind by {latest} s");
        assert!(latest < 4e-3, "{load:?} {ratio}: {latest} s");
        for speed in 0..2 {
            assert!(
                off[speed] < share * ranges[speed],
                "{load:?} {ratio}: {} of {}",
                off[speed],
                ranges[speed]
            );
        }
    }
}

/// A standstill, a launch and a stop; clamping forces that are applied to a slack belt.
#[test]
fn starts_without_load_are_smooth() {
    for model in MODELS {
        let mut parameters = in_real_time(coarse(model));
        parameters.initial.primary_speed = 0.0;
        let mut variator = Variator::new(parameters).expect("valid parameters");
        variator
            .initialise(0.0, &inputs((0.0, 13e3), (0.0, 10e3)))
            .expect("a start");
        assert!(variator.outputs().secondary.axial_force > 9e3, "clamped before the run");
        for k in 1..=300 {
            let torque = if k < 200 { 40.0 } else { 0.0 };
            let given = inputs((torque, 13e3), (-0.5 * torque, 10e3));
            variator.advance(1e-3 * f64::from(k), &given).expect("a step");
            let outputs = variator.outputs();
            assert!(
                outputs.primary.speed.is_finite() && outputs.primary.speed < 400.0,
                "{model:?} {k}"
            );
        }
        assert!(variator.outputs().primary.speed > 20.0, "{model:?}: it has been driven");
    }
}

/// Behind the clock too the outputs have the inputs of the clock's time.
#[test]
fn external_torques_are_those_of_the_clock() {
    let mut parameters = in_real_time(coarse(RingModel::Ale));
    (parameters.solver.effort, parameters.solver.input_ramp) = (1, -1.0);
    let mut variator = Variator::new(parameters).expect("valid parameters");
    variator
        .initialise(0.0, &inputs((50.0, 13e3), (-49.0, 10e3)))
        .expect("a start");
    let mut behind = 0.0_f64;
    for (k, torque) in [-50.0, 50.0].into_iter().cycle().take(20).enumerate() {
        let given = inputs((torque, 13e3), (-torque, 10e3));
        variator.advance(1e-3 * (k + 1) as f64, &given).expect("a step");
        let outputs = variator.outputs();
        assert_close(outputs.primary.external_torque, torque, 1e-9, "torque");
        behind = behind.max(outputs.work.behind);
    }
    assert!(behind > 1e-3, "{behind} s");
}

/// Communication steps that are not whole milliseconds have work in proportion to their time.
#[test]
fn the_bound_is_in_proportion_to_time() {
    let mut variator = Variator::new(in_real_time(coarse(RingModel::Ale0))).expect("valid parameters");
    let given = inputs((50.0, 13e3), (-49.0, 10e3));
    variator.initialise(0.0, &given).expect("a start");
    let mut of_run = Meter::new(&variator);
    let mut time = 0.0;
    for step in [1e-5, 0.4e-3, 1e-3, 1.0000001e-3, 2.5e-3, 10e-3] {
        time += step;
        variator
            .advance(time, &inputs((60.0, 13e3), (-49.0, 10e3)))
            .expect("a step");
        let work = of_run.read(&variator);
        assert!(work <= 4.0 * EFFORT * step / 1e-3 + ABOVE, "{step} s: {work}");
        assert_close(
            variator.outputs().primary.external_torque,
            60.0,
            1e-9,
            "torque at the end",
        );
    }
    assert_eq!(variator.outputs().work.behind, 0.0);
}

/// Steps without a solution are begun again, and the run continues: it never stops, and ends near the speed and the ratio of an accurate
/// run.
#[test]
fn a_run_continues_after_steps_without_a_solution() {
    let mut rollbacks = 0;
    for model in MODELS {
        for (load, ratio) in [
            (LoadHistory::Flips, 2.2),
            (LoadHistory::Flips, 0.5),
            (LoadHistory::Slam, 0.5),
        ] {
            let ended = [Mode::Accurate, Mode::RealTime].map(|mode| {
                let mut parameters = variator(model);
                parameters.solver.mode = mode;
                parameters.solver.effort = 8;
                let mut driven = Driven::new(load, parameters, ratio);
                let (mut before, mut held) = (0.0, 0);
                while driven.until() < 1.2 {
                    let inputs = driven.inputs();
                    driven.variator.advance(driven.until(), &inputs).expect("a step");
                    let outputs = driven.variator.outputs();
                    held = if outputs.primary.speed == before { held + 1 } else { 0 };
                    assert!(held < 6, "{model:?} {load:?} {ratio} stands at {}", driven.until());
                    before = outputs.primary.speed;
                }
                rollbacks += driven.variator.outputs().work.rollbacks;
                driven.variator.outputs().clone()
            });
            let [exact, found] = ended
                .each_ref()
                .map(|outputs| [outputs.primary.speed, outputs.ratio_geometric]);
            println!("{model:?} {load:?} {ratio}: {found:.3?} instead of {exact:.3?}");
            assert!((found[0] - exact[0]).abs() < 0.03 * exact[0], "{model:?} {load:?}");
            assert!((found[1] - exact[1]).abs() < 0.02 * exact[1], "{model:?} {load:?}");
        }
    }
    println!("{rollbacks} rollbacks");
    // Of 7200 milliseconds.
    assert!(rollbacks <= 720, "{rollbacks}");
}

/// Clamping forces far from equilibrium lead to a fast shift in overdrive: few steps are begun again.
#[test]
fn few_steps_are_begun_again() {
    for parameters in meshes() {
        let mut parameters = in_real_time(parameters);
        parameters.initial.ratio = 0.5;
        parameters.secondary.inertia = 4.0;
        let mut variator = Variator::new(parameters).expect("valid parameters");
        let given = inputs((50.0, 12e3), (-25.0, 12e3));
        variator.initialise(0.0, &given).expect("a start");
        for k in 1..=500 {
            variator.advance(1e-3 * f64::from(k), &given).expect("a step");
        }
        let rollbacks = variator.outputs().work.rollbacks;
        println!("{rollbacks} steps begun again in 500 ms");
        assert!(rollbacks <= 5, "{rollbacks}");
    }
}

/// Torques of 150 N·m and forces of 20 kN that jump at random, each 1 to 200 ms, also to no force.
struct Jumps {
    variator: Variator,
    noise: Box<dyn FnMut() -> f64>,
    ratio: f64,
    cruise: f64,
    /// Torque on P, forces on P and S, and the time of the next jump.
    load: (f64, f64, f64),
    until: f64,
    step: u32,
}

impl Jumps {
    fn new(parameters: &Parameters, seed: u64) -> Self {
        let mut next = noise(seed);
        let mut between = |least: f64, most: f64| least + (most - least) * (next() + 0.5);
        let mut parameters = in_real_time(parameters.clone());
        let (ratio, speed) = (between(0.5, 2.2), between(0.0, 400.0));
        parameters.initial.ratio = ratio;
        parameters.initial.primary_speed = if seed == 0 { 0.0 } else { speed };
        parameters.secondary.inertia = between(0.05, 4.0);
        let cruise = parameters.initial.primary_speed / ratio;
        let mut variator = Variator::new(parameters).expect("valid parameters");
        let load = (20.0, 15e3, 12e3);
        variator
            .initialise(0.0, &inputs((load.0, load.1), (-load.0 * ratio, load.2)))
            .expect("a start");
        Self {
            variator,
            noise: Box::new(next),
            ratio,
            cruise,
            load,
            until: 0.0,
            step: 0,
        }
    }

    /// Time of the next step, s, and its inputs.
    fn next(&mut self) -> (f64, Inputs) {
        self.step += 1;
        let time = 1e-3 * f64::from(self.step);
        let mut between = |least: f64, most: f64| least + (most - least) * ((self.noise)() + 0.5);
        if time > self.until {
            self.until = time + 10_f64.powf(between(-3.0, -0.7));
            let primary = if between(0.0, 1.0) < 0.05 {
                0.0
            } else {
                between(4e3, 22e3)
            };
            self.load = (between(-120.0, 150.0), primary, between(4e3, 22e3));
        }
        let (torque, primary, secondary) = self.load;
        let vehicle = -torque * self.ratio - 2.0 * (self.variator.outputs().secondary.speed - self.cruise);
        (time, inputs((torque, primary), (vehicle, secondary)))
    }
}

/// The run neither stops nor runs away, its delay is bounded, and so is its work.
#[test]
fn a_run_continues_under_random_jumps() {
    for parameters in meshes() {
        for (seed, effort) in [(0, 4), (1, 4), (2, 8), (3, 8), (2, 2)] {
            let mut parameters = parameters.clone();
            parameters.solver.effort = effort;
            let mut jumps = Jumps::new(&parameters, seed);
            let mut of_run = Meter::new(&jumps.variator);
            let (mut before, mut still, mut longest) = (f64::NAN, 0, 0);
            let (mut latest, mut behind) = (0.0_f64, 0.0);
            for _ in 1..=500 {
                let (time, given) = jumps.next();
                jumps.variator.advance(time, &given).expect("a step");
                let work = of_run.read(&jumps.variator);
                assert!(work <= EFFORT * f64::from(effort) + ABOVE, "{seed} at {time} s: {work}");
                let outputs = jumps.variator.outputs();
                let [p, s] = [&outputs.primary, &outputs.secondary];
                assert!(p.speed.is_finite() && s.speed.abs() < 1e3, "{seed} at {time} s");
                assert!(p.axial_force.abs().max(s.axial_force.abs()) < 1e5, "{seed} at {time} s");
                still = if p.speed == before { still + 1 } else { 0 };
                longest = longest.max(still);
                before = p.speed;
                latest = latest.max(outputs.work.behind);
                behind += outputs.work.behind / 500.0;
            }
            let rollbacks = jumps.variator.outputs().work.rollbacks;
            println!(
                "effort {effort}, seed {seed}: {rollbacks} steps begun again; behind by {behind:.1e} s in the mean, {latest:.1e} s at most; still for {longest} ms"
            );
            assert!(longest <= 20, "{seed}: still for {longest} ms");
            assert!(latest < 0.02 + 1e-9, "{seed}: {latest} s");
        }
    }
}

/// Copies of a run and its stored states continue with the same bits.
fn continue_alike(variator: &mut Variator, mut given: impl FnMut(&Variator) -> (f64, Inputs)) {
    let mut archive = Archive::writer();
    variator.serialize(&mut archive);
    let mut restored = Variator::new(variator.parameters().clone()).expect("valid parameters");
    let bytes = archive.into_bytes();
    let mut archive = Archive::reader(&bytes);
    restored.serialize(&mut archive);
    assert_eq!(archive.finish(), Ok(()));
    let mut copy = variator.clone();
    for _ in 0..20 {
        let (time, inputs) = given(variator);
        for run in [&mut *variator, &mut copy, &mut restored] {
            run.advance(time, &inputs).expect("a step");
        }
        assert_eq!(variator.state(), copy.state());
        assert_eq!(variator.state(), restored.state());
        assert_eq!(variator.outputs(), restored.outputs());
    }
}

/// In a slam while the belt slips; under firing while a step is open; under ripple.
#[test]
fn copies_and_stored_states_continue_alike() {
    for (load, parameters) in [
        (LoadHistory::Slam, coarse(RingModel::Ale0)),
        (LoadHistory::Slam, coarse(RingModel::Ale)),
        (LoadHistory::Firing, one_cell(RingModel::Ale)),
        (LoadHistory::Ripple, coarse(RingModel::Ale0)),
    ] {
        let mut parameters = in_real_time(parameters);
        if load == LoadHistory::Firing {
            parameters.solver.effort = 1;
        }
        let mut driven = Driven::new(load, parameters, 1.0);
        for step in 0.. {
            let over = match load {
                LoadHistory::Slam => step == 40,
                LoadHistory::Ripple => step == 15,
                _ => driven.variator.outputs().work.behind > 0.0,
            };
            if over {
                break;
            }
            assert!(step < 300, "no step of {load:?} was open");
            let inputs = driven.inputs();
            driven.variator.advance(driven.until(), &inputs).expect("a step");
        }
        let mut variator = driven.variator.clone();
        continue_alike(&mut variator, |variator| {
            driven.variator = variator.clone();
            let inputs = driven.inputs();
            (driven.until(), inputs)
        });
    }
}

/// The same for states right after a step without a solution.
#[test]
fn states_after_a_step_without_a_solution_continue_alike() {
    let mut jumps = Jumps::new(&one_cell(RingModel::Ale), 2);
    while jumps.variator.outputs().work.rollbacks == 0 {
        let (time, given) = jumps.next();
        assert!(time < 1.0, "all steps had a solution");
        jumps.variator.advance(time, &given).expect("a step");
    }
    let mut variator = jumps.variator.clone();
    continue_alike(&mut variator, |variator| {
        jumps.variator = variator.clone();
        jumps.next()
    });
}

/// Also after a state was stored, read or copied, and with an open step. Steps with a remark for the log allocate its text.
#[test]
fn a_step_allocates_nothing() {
    for model in MODELS {
        let mut parameters = in_real_time(variator(model));
        parameters.solver.effort = 2;
        let mut driven = Driven::new(LoadHistory::Flips, parameters, 1.0);
        let mut open = 0;
        for step in 0..60 {
            let inputs = driven.inputs();
            let until = driven.until();
            let count =
                allocation_counter::measure(|| driven.variator.advance(until, &inputs).expect("a step")).count_total;
            if driven.variator.take_messages().is_empty() {
                assert_eq!(count, 0, "{model:?} until {until} s");
                open += i32::from(driven.variator.outputs().work.behind > 0.0);
            }
            if step == 20 {
                driven.variator = driven.variator.clone();
            }
            if step == 40 {
                let mut archive = Archive::writer();
                driven.variator.serialize(&mut archive);
                let bytes = archive.into_bytes();
                let mut archive = Archive::reader(&bytes);
                driven.variator.serialize(&mut archive);
                assert_eq!(archive.finish(), Ok(()));
            }
        }
        assert!(open > 0, "{model:?}: no step was open");
    }
}

/// `solver.defect` is the error of solved steps alone: below 1, as that of accurate steps.
#[test]
fn the_defect_is_an_error() {
    let mut jumps = Jumps::new(&one_cell(RingModel::Ale), 2);
    let mut before = 0;
    let mut again = 0;
    for _ in 0..300 {
        let (time, given) = jumps.next();
        jumps.variator.advance(time, &given).expect("a step");
        again += new_rollbacks(&mut jumps.variator, &mut before);
        let work = jumps.variator.outputs().work;
        assert!((0.0..1.0).contains(&work.defect), "at {time} s: {}", work.defect);
    }
    assert!(again > 0, "all steps had a solution");
}

#[test]
fn accurate_steps_report_their_defect() {
    let found = trace(LoadHistory::Firing, &coarse(RingModel::Ale0), 1.0, 0.05, |_| ());
    assert!(found.defect > 0.0 && found.defect < 1.0, "{}", found.defect);
}
