//! Runs continue under every kind of load and motion that an importer may connect to shafts and
//! sheaves.

use pushbelt::variator::settings::RingModel::{self, Ale, Ale0};
use pushbelt::variator::settings::{Axial, BeltKind, Drive, Inputs, Mode, Outputs, Parameters, StartState};
use pushbelt_support::checks::{assert_close, assert_mirrored};
use pushbelt_support::run::{Run, restored, tried};
use pushbelt_support::variators::{MODELS, SPEED, belt_alone, chain, coarse, inputs, variator};

/// At a standstill, at a ratio, with a flywheel on the secondary shaft.
fn at_rest(mut parameters: Parameters, ratio: f64) -> Parameters {
    (parameters.initial.primary_speed, parameters.initial.ratio) = (0.0, ratio);
    parameters.secondary.inertia = 0.3;
    parameters
}

/// The coarse variator whose primary shaft follows a set point.
fn driven(model: RingModel) -> Parameters {
    let mut parameters = coarse(model);
    parameters.primary.drive = Drive::Speed;
    parameters
}

/// Both values of something, of the primary and of the secondary pulley.
fn each<T: Copy>([one, other]: [T; 2]) -> [(T, T); 4] {
    [(one, one), (one, other), (other, one), (other, other)]
}

#[test]
fn torque_or_speed_at_either_shaft() {
    for model in MODELS {
        for (primary, secondary) in each([Drive::Torque, Drive::Speed]) {
            let mut parameters = belt_alone(coarse(model));
            (parameters.primary.drive, parameters.secondary.drive) = (primary, secondary);
            let mut given = inputs((50.0, 11e3), (-49.0, 9e3));
            // Half a percent of slip where both speeds are prescribed.
            given.secondary.speed_setpoint = 0.995 * SPEED;
            let mut run = Run::new(parameters, given);
            let o = run.go(0.05, 5e-3);
            for (drive, pulley, torque, speed) in [
                (primary, &o.primary, 50.0, SPEED),
                (secondary, &o.secondary, -49.0, 0.995 * SPEED),
            ] {
                match drive {
                    Drive::Torque => assert_eq!(pulley.external_torque, torque),
                    Drive::Speed => {
                        assert_close(pulley.speed, speed, 1e-6, "prescribed speed");
                        // At constant speed the shaft delivers the power that the belt takes.
                        assert_close(pulley.external_torque, -pulley.shaft_torque, 1e-3, "reaction");
                    }
                }
            }
            assert!(o.primary.shaft_torque < 0.0 && o.secondary.shaft_torque > 0.0);
            run.assert_balances();
        }
    }
}

#[test]
fn clamping_force_or_held_sheave_at_either_pulley() {
    for model in MODELS {
        for (primary, secondary) in each([Axial::Force, Axial::Held]) {
            let mut parameters = driven(model);
            (parameters.primary.axial, parameters.secondary.axial) = (primary, secondary);
            let mut run = Run::new(parameters, inputs((0.0, 11e3), (-49.0, 9e3)));
            let start = run.outputs();
            let o = run.go(0.1, 5e-3);
            assert_close(start.ratio_geometric, 1.0, 1e-4, "initial ratio");
            for (axial, pulley, before, force) in [
                (primary, &o.primary, &start.primary, 11e3),
                (secondary, &o.secondary, &start.secondary, 9e3),
            ] {
                match axial {
                    Axial::Held => assert!((pulley.position - before.position).abs() < 1e-10),
                    // The belt's force excludes the damper's force while the ratio shifts.
                    Axial::Force => assert_close(pulley.axial_force, force, 0.05, "clamping force"),
                }
            }
            if primary == Axial::Held || secondary == Axial::Held {
                assert_close(o.ratio_geometric, 1.0, 2e-3, "held ratio");
            }
            let both = primary == Axial::Held && secondary == Axial::Held;
            assert_eq!(run.warned("both sheaves are held"), both);
            run.assert_balances();
        }
    }
}

/// Clamping forces that open or close a pulley bring it to its end stop and no further; the
/// opposite force moves it away.
#[test]
fn end_stops_hold_and_are_left_again() {
    let to_overdrive = inputs((0.0, 20e3), (-30.0, 6e3));
    let to_underdrive = inputs((0.0, 5e3), (-30.0, 12e3));
    for model in MODELS {
        for (into, away, sign) in [(to_overdrive, to_underdrive, 1.0), (to_underdrive, to_overdrive, -1.0)] {
            let mut parameters = driven(model);
            // The stops are near, so that they are reached soon.
            let stops = [0.0560, 0.0585];
            [parameters.primary.min_radius, parameters.primary.max_radius] = stops;
            let mut run = Run::new(parameters, into);
            // The stop acts on the sheave; the belt sinks into the flanks by some 20 µm/tan β.
            let travel = (stops[0] - 3e-4)..(stops[1] + 3e-4);
            run.watch(0.8, 5e-3, |_, o| {
                assert!(travel.contains(&o.primary.radius), "{} m", o.primary.radius)
            });
            let stopped = run.outputs().ratio_geometric;
            let again = run.go(0.1, 5e-3);
            assert_close(again.ratio_geometric, stopped, 1e-3, "the ratio at the stop");
            let carried = into.primary.clamping_force - again.primary.axial_force;
            assert!(sign * carried > 500.0, "the stop carries {carried} N");
            run.inputs = away;
            let left = run.go(0.3, 5e-3).ratio_geometric - again.ratio_geometric;
            assert!(sign * left > 5e-3, "the ratio leaves the stop by {left}");
            run.assert_balances();
        }
    }
}

#[test]
fn a_launch_in_reverse_mirrors_a_launch_forward() {
    for model in MODELS {
        let [forward, reverse] = [1.0, -1.0].map(|sign| {
            let mut parameters = at_rest(coarse(model), 1.5);
            // The direction in which the belt crept before.
            parameters.initial.primary_speed = sign * 1e-6;
            let mut run = Run::new(parameters, inputs((sign * 40.0, 9e3), (sign * -5.0, 10e3)));
            let outputs = run.go(0.2, 2e-3);
            run.assert_balances();
            outputs
        });
        assert!(forward.primary.speed > 20.0 && forward.belt_speed > 1.0);
        assert_mirrored(&reverse, &forward, 1e-3);
    }
}

/// A run from a standstill starts with a clamped belt: the forces act, it hardly moves under
/// opposite torques below its capacity, and a torque that acts at once takes no more work in the
/// first millisecond than a jump at another time.
#[test]
fn a_standstill_starts_clamped_and_holds_the_torque() {
    let pushbelt_as_chain = Parameters {
        kind: BeltKind::PullChain,
        ..Parameters::default()
    };
    // The chain vibrates: with the default tolerance its residual is 0.3 to 1.1 times the bound over
    // torques of 20.00 to 20.05 N·m, with a quarter of it 0.5, with a tenth 0.2.
    let chain = |model| {
        let mut chain = chain(model);
        chain.solver.tolerance *= 0.25;
        chain
    };
    let belts = [MODELS.map(coarse), MODELS.map(variator), MODELS.map(chain)]
        .concat()
        .into_iter();
    for parameters in belts.chain([pushbelt_as_chain]) {
        let mut run = Run::new(at_rest(parameters, 1.3), inputs((20.0, 11e3), (-26.0, 9e3)));
        let o = run.outputs();
        assert_eq!(o.start_state, StartState::Clamped);
        assert_close(o.primary.axial_force, 11e3, 0.02, "primary force");
        assert_close(o.secondary.axial_force, 9e3, 0.02, "secondary force");
        assert_close(o.ratio_geometric, 1.3, 0.02, "ratio");
        assert!(o.primary.speed.abs() < 0.1 && o.secondary.speed.abs() < 0.1);
        run.go(1e-3, 1e-3);
        let counts = run.variator.counts();
        assert!(counts.factorizations <= 20 && counts.residuals <= 200, "{counts:?}");
        let o = run.go(0.15, 1e-3);
        assert!(o.primary.speed.abs() < 0.1 && o.secondary.speed.abs() < 0.1);
        assert_close(o.secondary.axial_force, 9e3, 0.02, "secondary force");
        assert!(o.ring_tension_min > 0.0);
        run.assert_balances();
    }
}

/// Regularised friction creeps where a real belt sticks: under forces that don't balance the ratio
/// drifts at a standstill, nearly in proportion to the friction velocity.
#[test]
fn at_standstill_the_ratio_creeps_with_the_friction_velocity() {
    for model in MODELS {
        let creep = |velocity: f64| {
            let mut parameters = variator(model);
            (parameters.initial.ratio, parameters.initial.primary_speed) = (2.2, 0.0);
            parameters.friction.velocity = velocity;
            let mut run = Run::new(parameters, inputs((0.0, 4e3), (0.0, 7e3)));
            // After the first moments, in which the belt is clamped.
            let before = run.go(1.0, 10e-3).ratio_geometric;
            (run.go(5.0, 10e-3).ratio_geometric - before) / 5.0
        };
        let (usual, tenth) = (creep(5e-4), creep(5e-5));
        assert!(usual > 0.0 && usual < 0.01, "{model:?}");
        assert!(tenth > 0.0 && tenth < usual / 5.0, "{model:?}");
    }
}

/// A run with the primary sheave held, whose set point brings the primary shaft from rest to speed,
/// 400 rad/s in a second.
fn brought_to_speed(mut parameters: Parameters, span: f64, step: f64) -> Run {
    (parameters.primary.drive, parameters.primary.axial) = (Drive::Speed, Axial::Held);
    let mut still = inputs((0.0, 0.0), (-10.0, 9e3));
    still.primary.speed_setpoint = 0.0;
    let mut run = Run::new(parameters, still);
    let mut rates = Inputs::ZERO;
    rates.primary.speed_setpoint = 400.0;
    run.ramp(span, step, &rates);
    run
}

/// A sheave held from a standstill is where the loaded belt has `initial.ratio`.
#[test]
fn a_sheave_held_from_a_standstill_has_its_ratio() {
    for model in MODELS {
        for ratio in [0.5, 1.0, 2.2] {
            let mut run = brought_to_speed(at_rest(coarse(model), ratio), 0.5, 1e-2);
            assert_close(run.go(0.2, 1e-2).ratio_geometric, ratio, 0.005, "ratio");
        }
    }
}

/// The work of inputs that change in proportion to time is that over the whole step: a clamping
/// force that rises and falls at low speed, a shaft brought to speed by its set point.
#[test]
fn energy_balance_under_ramped_inputs() {
    for model in MODELS {
        for speed in [20.0, 2.0] {
            let mut parameters = coarse(model);
            parameters.initial.primary_speed = speed;
            let mut run = Run::new(parameters, inputs((20.0, 13e3), (-19.0, 10e3)));
            let mut rates = Inputs::ZERO;
            for rate in [1e6, -1e6].repeat(8) {
                rates.primary.clamping_force = rate;
                run.ramp(0.01, 0.01, &rates);
            }
            run.assert_balances();
        }
        let mut parameters = variator(model);
        parameters.secondary.inertia = 0.3;
        let mut run = brought_to_speed(parameters, 0.3, 1e-3);
        assert_close(run.outputs().primary.speed, 120.0, 0.01, "primary speed");
        run.assert_balances();
    }
}

/// Clamping forces fall to zero at speed, and the belt transmits almost nothing and slips. They
/// return, and it grips.
#[test]
fn the_belt_slips_without_clamping_forces_and_grips_again_with_them() {
    for model in MODELS {
        let mut parameters = driven(model);
        parameters.secondary.inertia = 0.3;
        let normal = inputs((0.0, 11e3), (-20.0, 9e3));
        let mut run = Run::new(parameters, normal);
        run.go(0.02, 2e-3);
        run.inputs = inputs((0.0, 0.0), (-20.0, 0.0));
        // An acceleration that the load can't follow without a belt.
        run.inputs.primary.speed_setpoint = 1.3 * SPEED;
        let open = run.go(0.1, 2e-3);
        assert!(open.primary.axial_force < 1e3 && open.ring_tension_max < 5e3);
        assert!(open.primary.shaft_torque.abs() < 5.0 && open.slip > 0.1);
        run.inputs = normal;
        let closed = run.go(0.5, 2e-3);
        assert_close(closed.secondary.axial_force, 9e3, 0.05, "secondary force");
        assert!(closed.slip.abs() < 0.03 && !closed.macro_slip, "slip {}", closed.slip);
        run.assert_balances();
    }
}

/// A strand under net compression, Q > T, would buckle, and a chain without tension would be slack:
/// a warning. Friction alone keeps T − Q above σV². Compression requires a load that reverses
/// suddenly while the clamping force falls, at a low speed, and elements without damping by oil, a
/// chain without damping.
#[test]
fn a_strand_that_would_buckle_or_be_slack_gives_a_warning() {
    for (mut parameters, force, text) in [
        (coarse(Ale), 1e3, "buckle"),
        (coarse(Ale0), 1e3, "buckle"),
        (chain(Ale), 100.0, "a real chain would be slack"),
    ] {
        parameters.initial.primary_speed = 20.0;
        (parameters.belt.film_damping, parameters.belt.squeeze_damping) = (0.0, 0.0);
        if parameters.kind == BeltKind::PullChain {
            parameters.ring.damping = 0.0;
        }
        parameters.solver.input_ramp = 0.0;
        let normal = inputs((40.0, 11e3), (-39.0, 9e3));
        let reversed = inputs((-150.0, force), (150.0, force));
        let mut run = Run::new(parameters, normal);
        run.go(5e-3, 1e-3);
        assert!(!run.warned(text), "warning without cause");
        run.inputs = reversed;
        run.go(0.03, 1e-3);
        assert!(run.warned(text), "{:?}", run.messages);
        // Not again within a second.
        let parameters = run.variator.parameters().clone();
        run.variator = restored(&mut run.variator, parameters);
        run.inputs = normal;
        run.go(0.025, 1e-3);
        assert!(run.variator.energy_balance().last.sums.strand_force > 0.0);
        run.inputs = reversed;
        run.go(0.02, 1e-3);
        assert_eq!(run.warnings(text), 1);
    }
}

/// A run at the forces of the solved equilibrium keeps its ratio, which may be far from the ratio
/// at which the search starts.
#[test]
fn a_start_in_equilibrium_stays_there() {
    for (mut parameters, force) in [
        (coarse(Ale0), 9.5e3),
        (variator(Ale), 11e3),
        (coarse(Ale0), 10.5e3),
        (coarse(Ale), 12.5e3),
    ] {
        parameters.primary.drive = Drive::Speed;
        parameters.initial.equilibrium = true;
        let mut run = Run::new(parameters, inputs((0.0, force), (-49.0, 8.5e3)));
        assert!(!run.warned(""), "{:?}", run.messages);
        let before = run.outputs();
        assert_eq!(before.start_state, StartState::Steady);
        let after = run.go(0.2, 5e-3);
        assert_close(before.primary.axial_force, force, 1e-3, "primary force");
        assert_close(before.secondary.axial_force, 8.5e3, 1e-3, "secondary force");
        assert_close(after.ratio_geometric, before.ratio_geometric, 1e-3, "ratio");
        // The ratio was solved for; it is not the initial guess.
        assert!((before.ratio_geometric - 1.0).abs() > 5e-3);
    }
}

/// Clamping forces that lead to an end stop start the run there.
#[test]
fn a_start_in_equilibrium_at_an_end_stop_stays_there() {
    for model in MODELS {
        for (primary, secondary) in [(26e3, 10e3), (30e3, 6e3), (60e3, 10e3), (5e3, 12e3)] {
            let mut parameters = driven(model);
            parameters.initial.equilibrium = true;
            let mut run = Run::new(parameters, inputs((0.0, primary), (-20.0, secondary)));
            assert!(run.warned("end stop"), "{model:?}: {:?}", run.messages);
            let before = run.outputs();
            let after = run.go(0.5, 5e-3);
            assert_eq!(before.start_state, StartState::Steady);
            assert_close(after.ratio_geometric, before.ratio_geometric, 1e-4, "ratio");
            assert_close(after.primary.axial_force, before.primary.axial_force, 1e-3, "force");
        }
    }
}

/// A loaded belt rests beyond the end stop of the unloaded curve, and a run may start from its
/// ratio there.
#[test]
fn a_run_may_start_beyond_an_end_stop() {
    for model in MODELS {
        let mut parameters = driven(model);
        let loads = inputs((0.0, 3e3), (-20.0, 22e3));
        let rests = Run::new(parameters.clone(), loads).go(1.0, 5e-3).ratio_geometric;
        parameters.initial.ratio = rests;
        let mut next = Run::new(parameters, loads);
        assert!(next.reported("beyond an end stop"), "{model:?}: {rests}");
        assert_close(next.go(0.3, 5e-3).ratio_geometric, rests, 2e-3, "ratio");
    }
}

/// A start from the steady state at held ratio is at rest from the first step on, with a secondary
/// shaft under torque or with a set point, and a prescribed torque or speed of the primary.
#[test]
fn a_steady_start_is_at_rest() {
    for model in MODELS {
        for (primary, secondary) in [
            (Drive::Speed, Drive::Torque),
            (Drive::Torque, Drive::Speed),
            (Drive::Speed, Drive::Speed),
        ] {
            let mut parameters = variator(model);
            if secondary == Drive::Speed {
                parameters = belt_alone(parameters);
            }
            (parameters.primary.drive, parameters.secondary.drive) = (primary, secondary);
            parameters.primary.axial = Axial::Held;
            let mut given = inputs((50.0, 0.0), (-49.0, 8.5e3));
            given.secondary.speed_setpoint = 0.99 * SPEED;
            let mut run = Run::new(parameters, given);
            let start = run.outputs();
            assert_eq!(start.start_state, StartState::Steady, "{model:?}, {primary:?}");
            let watched = |o: &Outputs| {
                let torques = [o.primary.shaft_torque, o.secondary.shaft_torque];
                let speeds = [o.primary.speed, o.secondary.speed];
                [speeds, torques, [o.thrust_ratio, o.push_force_max]].concat()
            };
            run.watch(0.05, 1e-3, |time, o| {
                for (now, then) in watched(o).into_iter().zip(watched(&start)) {
                    assert_close(now, then, 1e-3, &format!("{model:?}, {primary:?} at {time} s"));
                }
            });
            if secondary == Drive::Speed {
                assert_close(start.secondary.speed, 0.99 * SPEED, 1e-9, "set point");
            }
            if primary == Drive::Torque {
                assert_close(start.primary.shaft_torque, -50.0, 1e-4, "torque");
            }
        }
    }
}

/// Shafts held at speeds 12 % apart have a steady state, in which the belt slips through: reported
/// from the start.
#[test]
fn a_start_in_macro_slip_is_reported() {
    for model in MODELS {
        for (share, ratio, slips) in [(0.88, 2.0, true), (0.99, 1.0, false), (1.12, 0.5, true)] {
            let mut parameters = driven(model);
            parameters.initial.ratio = ratio;
            parameters.secondary.drive = Drive::Speed;
            let mut inputs = inputs((0.0, 12e3), (0.0, 9e3));
            inputs.secondary.speed_setpoint *= share / parameters.initial.ratio;
            let mut run = Run::new(parameters, inputs);
            let o = run.outputs();
            let found = [o.macro_slip, run.warned("macro-slip")];
            assert_eq!(found, [slips; 2], "{model:?} at {share}");
            assert_close(o.slip, 1.0 - share, 0.05, "slip");
        }
    }
}

/// Torque beyond capacity has no steady state: the run starts from the nearest one and reports it
/// with the reason.
#[test]
fn torque_beyond_capacity_starts_from_the_nearest_state() {
    for model in MODELS {
        for torque in [400.0, 150.0, -400.0] {
            let mut run = Run::new(coarse(model), inputs((torque, 13e3), (-torque, 10e3)));
            let o = run.outputs();
            assert!(run.warned("no steady state") && run.warned("capacity") && run.warned("% of them"));
            assert!((0.75..1.05).contains(&o.torque_utilisation), "{}", o.torque_utilisation);
            assert!(!o.macro_slip && o.slip < 0.03);
            assert_eq!(o.start_state, StartState::ReducedTorque);
            assert_eq!(run.go(0.02, 1e-3).start_state, StartState::ReducedTorque);
            run.assert_balances();
        }
    }
}

/// Beyond capacity a pulley with a free speed runs away until drag balances its torque, at four
/// times the requested speed. That steady state is rejected as a start.
#[test]
fn a_state_with_a_runaway_pulley_is_rejected_as_a_start() {
    let mut parameters = variator(Ale);
    (parameters.initial.ratio, parameters.initial.primary_speed) = (0.671, 418.88);
    parameters.secondary.drive = Drive::Speed;
    let mut inputs = inputs((150.33, 18e3), (0.0, 12e3));
    inputs.secondary.speed_setpoint = 418.88 / 0.671;
    let o = Run::new(parameters, inputs).outputs();
    assert_eq!(o.start_state, StartState::ReducedTorque);
    assert!(!o.macro_slip && o.slip < 0.03);
}

#[test]
fn an_unloaded_start_is_without_slip() {
    let mut parameters = coarse(Ale0);
    (parameters.initial.ratio, parameters.initial.steady) = (2.0, false);
    parameters.secondary.drive = Drive::Speed;
    let o = Run::new(parameters, inputs((50.0, 10e3), (-49.0, 10e3))).outputs();
    assert_close(o.primary.speed, 2.0 * SPEED, 1e-9, "without slip");
}

/// A start: its kind, how it differs from the coarse variator, its inputs.
type Start = (StartState, fn(&mut Parameters), Inputs);

/// Each kind of start.
fn starts() -> [Start; 7] {
    let (usual, none) = (inputs((50.0, 12e3), (-49.0, 9e3)), inputs((50.0, 0.0), (-49.0, 0.0)));
    let still: fn(&mut Parameters) = |p| p.initial.primary_speed = 0.0;
    [
        (StartState::Unloaded, |p| p.initial.steady = false, usual),
        (StartState::Unloaded, still, none),
        (StartState::Steady, |_| {}, usual),
        (StartState::ReducedTorque, |_| {}, inputs((400.0, 12e3), (-400.0, 9e3))),
        (
            StartState::NoEquilibrium,
            |p| (p.initial.equilibrium, p.secondary.drive) = (true, Drive::Speed),
            inputs((100.0, 5e3), (0.0, 10e3)),
        ),
        (StartState::NotFound, |_| {}, none),
        (StartState::Clamped, still, inputs((0.0, 13e3), (0.0, 10e3))),
    ]
}

/// Also in real time: a coupled circuit reads no flow before the first step. The belt of a clamped
/// start keeps its forces.
#[test]
fn sheaves_are_at_rest_at_the_start() {
    for model in MODELS {
        for mode in [Mode::Accurate, Mode::RealTime] {
            for (kind, change, given) in starts() {
                let mut parameters = coarse(model);
                change(&mut parameters);
                (parameters.solver.mode, parameters.primary.cylinder.area) = (mode, 0.01);
                parameters.secondary.cylinder.area = 0.01;
                let mut run = Run::new(parameters, given);
                let o = run.outputs();
                let moves = [&o.primary, &o.secondary].map(|of| [of.sheave_velocity, of.flow]);
                assert_eq!((o.start_state, moves), (kind, [[0.0; 2]; 2]), "{model:?} {mode:?}");
                if kind == StartState::Clamped {
                    assert_close(o.primary.axial_force, 13e3, 0.02, "primary force");
                    let after = run.go(1e-3, 1e-3);
                    assert_close(after.ring_tension_max, o.ring_tension_max, 1e-3, "tension");
                    assert!(after.secondary.sheave_velocity != 0.0);
                }
            }
        }
    }
}

/// One warning where the start is another one than was asked for; with `initial.strict` it is an
/// error.
#[test]
fn another_start_is_one_warning_or_an_error() {
    for model in MODELS {
        for (kind, change, given) in starts() {
            let mut parameters = coarse(model);
            change(&mut parameters);
            let is_other = (3..=5).contains(&(kind as i32));
            let run = Run::new(parameters.clone(), given);
            let text = format!("(initial.found = {}, {kind:?}); what helps: ", kind as i32);
            assert_eq!(run.warnings(&text), usize::from(is_other), "{:?}", run.messages);
            assert_eq!(run.warnings("initial.found"), usize::from(is_other));
            let torque = format!("torques {} and", given.primary.torque);
            assert_eq!(
                run.warnings("asked for: ratio 1") * run.warnings(&torque),
                usize::from(is_other)
            );
            parameters.initial.strict = true;
            let (_, error) = tried(parameters, &given);
            assert_eq!(error.is_some(), is_other, "{kind:?}");
            assert!(error.is_none_or(|error| error.contains(&text) && error.contains("initial.strict")));
        }
    }
}

/// One sheave or both, also where they tilt at once: the spring that holds the ratio of the search
/// made a soft primary one ring.
#[test]
fn soft_sheaves_have_a_steady_start() {
    for model in MODELS {
        for (primary, secondary) in [(true, false), (false, true), (true, true)] {
            for (stiffness, ratio, time) in [
                (5e4, 1.0, 2e-3),
                (7e4, 1.0, 2e-3),
                (7e4, 2.0, 1e-5),
                (1e5, 2.0, 2e-3),
                (2e5, 1.0, 1e-5),
            ] {
                let mut parameters = variator(model);
                parameters.initial.ratio = ratio;
                let (of_primary, of_secondary) =
                    (&mut parameters.primary.tilt, &mut parameters.secondary.tilt);
                for (tilt, is_soft) in [(of_primary, primary), (of_secondary, secondary)] {
                    tilt.time = time;
                    if is_soft {
                        tilt.stiffness = stiffness;
                    }
                }
                let o = Run::new(parameters, inputs((50.0, 13e3), (-49.0 * ratio, 10e3))).outputs();
                assert_eq!(o.start_state, StartState::Steady, "{model:?} {stiffness} N·m, {ratio}");
            }
        }
    }
}
