//! Runs continue under every kind of load and motion that a master may connect to shafts and sheaves.

use pushbelt::variator::settings::{Axial, Drive, Parameters, RingModel};
use pushbelt::variator::settings::{Inputs, Outputs, StartState};
use pushbelt_support::checks::assert_close;
use pushbelt_support::inside::strand_force;
use pushbelt_support::run::Run;
use pushbelt_support::variators::{MODELS, SPEED, belt_alone, coarse, inputs, variator};

/// At a standstill, at a ratio, with a flywheel on the secondary shaft.
fn at_rest(model: RingModel, ratio: f64) -> Parameters {
    let mut parameters = coarse(model);
    parameters.initial.primary_speed = 0.0;
    parameters.initial.ratio = ratio;
    parameters.secondary.inertia = 0.3;
    parameters
}

#[test]
fn torque_or_speed_at_either_shaft() {
    for model in MODELS {
        for primary in [Drive::Torque, Drive::Speed] {
            for secondary in [Drive::Torque, Drive::Speed] {
                let mut parameters = belt_alone(coarse(model));
                parameters.primary.drive = primary;
                parameters.secondary.drive = secondary;
                let mut given = inputs((50.0, 11e3), (-49.0, 9e3));
                // Half a percent of slip where both speeds are prescribed.
                given.secondary.speed_setpoint = 0.995 * SPEED;
                let mut run = Run::new(parameters, given);
                let o = run.go(0.05, 5e-3);
                println!(
                    "{model:?} {primary:?} {secondary:?}: speeds {:.3} {:.3}, belt torques {:.3} {:.3}, external {:.3} {:.3}",
                    o.primary.speed,
                    o.secondary.speed,
                    o.primary.shaft_torque,
                    o.secondary.shaft_torque,
                    o.primary.external_torque,
                    o.secondary.external_torque
                );
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
                assert!(
                    o.primary.shaft_torque < 0.0 && o.secondary.shaft_torque > 0.0,
                    "power flows from P to S"
                );
                run.assert_balances();
            }
        }
    }
}

#[test]
fn clamping_force_or_held_sheave_at_either_pulley() {
    for model in MODELS {
        for primary in [Axial::Force, Axial::Held] {
            for secondary in [Axial::Force, Axial::Held] {
                let mut parameters = coarse(model);
                parameters.primary.drive = Drive::Speed;
                parameters.primary.axial = primary;
                parameters.secondary.axial = secondary;
                let mut run = Run::new(parameters, inputs((0.0, 11e3), (-49.0, 9e3)));
                let start = run.variator.outputs().clone();
                let o = run.go(0.1, 5e-3);
                println!(
                    "{model:?} {primary:?} {secondary:?}: forces {:.1} {:.1} N, ratio {:.5} from {:.5}",
                    o.primary.axial_force, o.secondary.axial_force, o.ratio_geometric, start.ratio_geometric
                );
                assert_close(start.ratio_geometric, 1.0, 1e-4, "the run starts at the initial ratio");
                for (axial, pulley, before, force) in [
                    (primary, &o.primary, &start.primary, 11e3),
                    (secondary, &o.secondary, &start.secondary, 9e3),
                ] {
                    match axial {
                        Axial::Held => {
                            assert!((pulley.position - before.position).abs() < 1e-10, "a held sheave moves")
                        }
                        // The belt's force excludes the damper's force while the ratio shifts.
                        Axial::Force => assert_close(pulley.axial_force, force, 0.05, "clamping force"),
                    }
                }
                if primary == Axial::Held || secondary == Axial::Held {
                    assert_close(o.ratio_geometric, 1.0, 2e-3, "a held sheave holds the ratio");
                }
                assert_eq!(
                    run.warned("both sheaves are held"),
                    primary == Axial::Held && secondary == Axial::Held
                );
                run.assert_balances();
            }
        }
    }
}

/// Clamping forces that open or close a pulley bring it to its end stop and no further; the opposite force moves it away.
#[test]
fn end_stops_hold_and_are_left_again() {
    for model in MODELS {
        for towards_overdrive in [true, false] {
            let mut parameters = coarse(model);
            parameters.primary.drive = Drive::Speed;
            // The stops are near, so that they are reached soon.
            parameters.primary.min_radius = 0.0560;
            parameters.primary.max_radius = 0.0585;
            let (into, away) = if towards_overdrive {
                (inputs((0.0, 20e3), (-30.0, 6e3)), inputs((0.0, 5e3), (-30.0, 12e3)))
            } else {
                (inputs((0.0, 5e3), (-30.0, 12e3)), inputs((0.0, 20e3), (-30.0, 6e3)))
            };
            let mut run = Run::new(parameters.clone(), into);
            let mut travel = (f64::INFINITY, 0.0_f64);
            run.watch(0.8, 5e-3, |_, o| {
                travel = (travel.0.min(o.primary.radius), travel.1.max(o.primary.radius))
            });
            let stopped = run.variator.outputs().clone();
            let again = run.go(0.1, 5e-3);
            run.inputs = away;
            let left = run.go(0.3, 5e-3);
            println!(
                "{model:?}: radius {:.5} to {:.5} m, ratio {:.5} then {:.5}, F_P on the belt {:.0} N; left to {:.5}",
                travel.0,
                travel.1,
                stopped.ratio_geometric,
                again.ratio_geometric,
                again.primary.axial_force,
                left.ratio_geometric
            );
            // The stop acts on the sheave; the belt sinks into the flanks by some 20 µm/tan β.
            assert!(travel.0 > parameters.primary.min_radius - 3e-4, "{} m", travel.0);
            assert!(travel.1 < parameters.primary.max_radius + 3e-4, "{} m", travel.1);
            assert_close(
                again.ratio_geometric,
                stopped.ratio_geometric,
                1e-3,
                "the ratio at the stop",
            );
            let carried = into.primary.clamping_force - again.primary.axial_force;
            assert!(
                carried.abs() > 500.0 && (carried > 0.0) == towards_overdrive,
                "the stop carries {carried} N"
            );
            assert!((left.ratio_geometric > again.ratio_geometric + 5e-3) == towards_overdrive);
            assert!(
                (left.ratio_geometric - again.ratio_geometric).abs() > 5e-3,
                "the stop is not left"
            );
            run.assert_balances();
        }
    }
}

/// Mirrored in the line of the axes: speeds and torques change sign, all other outputs are the same.
#[test]
fn a_launch_in_reverse_mirrors_a_launch_forward() {
    for model in MODELS {
        let at = |sign: f64| -> Outputs {
            let mut parameters = at_rest(model, 1.5);
            // The direction in which the belt crept before.
            parameters.initial.primary_speed = sign * 1e-6;
            let mut run = Run::new(parameters, inputs((sign * 40.0, 9e3), (sign * -5.0, 10e3)));
            let outputs = run.go(0.2, 2e-3);
            run.assert_balances();
            outputs
        };
        let (forward, reverse) = (at(1.0), at(-1.0));
        assert!(forward.primary.speed > 20.0 && forward.belt_speed > 1.0);
        for (a, b, what) in [
            (reverse.primary.speed, -forward.primary.speed, "primary speed"),
            (reverse.secondary.speed, -forward.secondary.speed, "secondary speed"),
            (reverse.belt_speed, -forward.belt_speed, "belt speed"),
            (reverse.ring_speed, -forward.ring_speed, "ring speed"),
            (
                reverse.primary.shaft_torque,
                -forward.primary.shaft_torque,
                "shaft torque",
            ),
            (reverse.thrust_ratio, forward.thrust_ratio, "thrust ratio"),
            (reverse.ratio_geometric, forward.ratio_geometric, "ratio"),
            (reverse.push_force_max, forward.push_force_max, "push force"),
            (reverse.losses.total(), forward.losses.total(), "losses"),
        ] {
            println!("{model:?} {what}: {a:.6} and {b:.6}");
            assert_close(a, b, 1e-3, what);
        }
    }
}

/// A clamped belt at a standstill holds opposite torques below its capacity.
#[test]
fn at_standstill_the_clamped_belt_holds_the_torque() {
    for model in MODELS {
        let mut run = Run::new(at_rest(model, 1.0), inputs((20.0, 8e3), (-20.0, 8e3)));
        let o = run.go(0.2, 5e-3);
        println!(
            "{model:?}: speeds {:.2e} and {:.2e} rad/s, F_S {:.1} N, slip {}",
            o.primary.speed, o.secondary.speed, o.secondary.axial_force, o.slip
        );
        assert!(
            o.primary.speed.abs() < 0.1 && o.secondary.speed.abs() < 0.1,
            "the drive creeps away"
        );
        assert_close(o.secondary.axial_force, 8e3, 0.02, "secondary force");
        run.assert_balances();
    }
}

/// A run from a standstill starts with a clamped belt: the forces act, it hardly moves, and a torque that acts at once takes no
/// more work in the first millisecond than a jump at another time.
#[test]
fn a_standstill_starts_clamped() {
    for model in MODELS {
        let mut run = Run::new(at_rest(model, 1.3), inputs((20.0, 11e3), (-20.0, 9e3)));
        let o = run.variator.outputs().clone();
        println!(
            "{model:?}: {:?}, {:.0} and {:.0} N, speeds {:.1e} and {:.1e} rad/s, ratio {:.4}",
            o.start_state,
            o.primary.axial_force,
            o.secondary.axial_force,
            o.primary.speed,
            o.secondary.speed,
            o.ratio_geometric
        );
        assert_eq!(o.start_state, StartState::Clamped);
        assert_close(o.primary.axial_force, 11e3, 0.02, "primary force");
        assert_close(o.secondary.axial_force, 9e3, 0.02, "secondary force");
        assert_close(o.ratio_geometric, 1.3, 0.02, "ratio");
        assert!(o.primary.speed.abs() < 0.1 && o.secondary.speed.abs() < 0.1);
        run.go(1e-3, 1e-3);
        let counts = run.variator.counts();
        println!("{model:?}: {counts:?}");
        assert!(counts.factorizations <= 20 && counts.residuals <= 200);
        run.go(0.1, 1e-3);
        run.assert_balances();
    }
}

/// Regularised friction creeps where a real belt sticks: under forces that don't balance the ratio drifts at a
/// standstill, nearly in proportion to the friction velocity.
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
        println!(
            "{model:?}: the ratio 2.2 creeps by {usual:.2e} a second, by {tenth:.2e} with a tenth of the friction velocity"
        );
        assert!(usual > 0.0 && usual < 0.01, "{model:?}");
        assert!(
            tenth > 0.0 && tenth < usual / 5.0,
            "{model:?}: creep over friction velocity"
        );
    }
}

/// A run with the primary sheave held, whose set point brings the primary shaft from rest to speed, 400 rad/s in a second.
fn brought_to_speed(mut parameters: Parameters, span: f64, step: f64) -> Run {
    parameters.primary.drive = Drive::Speed;
    parameters.primary.axial = Axial::Held;
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
            let mut run = brought_to_speed(at_rest(model, ratio), 0.5, 1e-2);
            let off = run.go(0.2, 1e-2).ratio_geometric / ratio - 1.0;
            println!("{model:?}, held at {ratio}: {:+.2} % off at 200 rad/s", 100.0 * off);
            assert!(off.abs() < 0.005, "{model:?}, held at {ratio}: {off}");
        }
    }
}

/// Clamped without torque, on the default mesh too, where vibrations have hardly any energy.
#[test]
fn energy_balance_at_standstill() {
    for model in MODELS {
        let mut parameters = variator(model);
        parameters.initial.primary_speed = 0.0;
        parameters.secondary.inertia = 0.3;
        let mut run = Run::new(parameters, inputs((0.0, 10e3), (0.0, 10e3)));
        run.go(0.15, 1e-3);
        println!("{model:?}: {:.2} of what is allowed", run.residual);
        run.assert_balances();
    }
}

/// The work of inputs that change in proportion to time is that over the whole step: a clamping force that rises and falls at
/// low speed, a shaft brought to speed by its set point.
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
            println!("{model:?}, {speed} rad/s: {:.2} of what is allowed", run.residual);
            run.assert_balances();
        }
        let mut parameters = variator(model);
        parameters.secondary.inertia = 0.3;
        let mut run = brought_to_speed(parameters, 0.3, 1e-3);
        println!("{model:?}, to speed: {:.2} of what is allowed", run.residual);
        assert_close(run.variator.outputs().primary.speed, 120.0, 0.01, "primary speed");
        run.assert_balances();
    }
}

/// Clamping forces fall to zero at speed, and the belt transmits almost nothing and slips. They return, and it grips.
#[test]
fn the_belt_slips_without_clamping_forces_and_grips_again_with_them() {
    for model in MODELS {
        let mut parameters = coarse(model);
        parameters.primary.drive = Drive::Speed;
        parameters.secondary.inertia = 0.3;
        let normal = inputs((0.0, 11e3), (-20.0, 9e3));
        let mut run = Run::new(parameters, normal);
        run.go(0.02, 2e-3);
        run.inputs.primary.clamping_force = 0.0;
        run.inputs.secondary.clamping_force = 0.0;
        // An acceleration that the load can't follow without a belt.
        run.inputs.primary.speed_setpoint = 1.3 * SPEED;
        let open = run.go(0.1, 2e-3);
        run.inputs = normal;
        let closed = run.go(0.5, 2e-3);
        println!(
            "{model:?}: open F_P {:.1} F_S {:.1} N, belt torque {:.3} N·m, slip {:.3}; closed F_S {:.1} N, slip {:.4}",
            open.primary.axial_force,
            open.secondary.axial_force,
            open.primary.shaft_torque,
            open.slip,
            closed.secondary.axial_force,
            closed.slip
        );
        assert!(open.primary.axial_force < 1e3 && open.ring_tension_max < 5e3);
        assert!(open.primary.shaft_torque.abs() < 5.0 && open.slip > 0.1);
        assert_close(closed.secondary.axial_force, 9e3, 0.05, "secondary force");
        assert!(closed.slip.abs() < 0.03 && !closed.macro_slip, "slip {}", closed.slip);
        run.assert_balances();
    }
}

/// A strand under net compression, Q > T, would buckle, which is a warning. Friction alone keeps T − Q above σV². Compression
/// requires a load that reverses suddenly while the clamping force falls, at a low speed, and elements without damping by oil.
#[test]
fn a_push_strand_in_net_compression_gives_a_warning() {
    for model in MODELS {
        let mut parameters = coarse(model);
        parameters.initial.primary_speed = 20.0;
        parameters.belt.film_damping = 0.0;
        parameters.belt.squeeze_damping = 0.0;
        parameters.solver.input_ramp = 0.0;
        let mut run = Run::new(parameters, inputs((40.0, 11e3), (-39.0, 9e3)));
        run.go(5e-3, 1e-3);
        assert!(!run.warned("buckle"), "{model:?}: warning without cause");
        run.inputs = inputs((-150.0, 1e3), (150.0, 1e3));
        run.go(0.02, 1e-3);
        let force = strand_force(&run.variator);
        for message in run.messages.iter().filter(|m| m.warning) {
            println!("{model:?}: {} (now {force:.0} N)", message.text);
        }
        assert!(
            run.warned("the net force in a strand is -") && run.warned("buckle"),
            "{model:?}"
        );
        // Not again within a second.
        run.inputs = inputs((40.0, 11e3), (-39.0, 9e3));
        run.go(0.025, 1e-3);
        assert!(strand_force(&run.variator) > 0.0);
        run.inputs = inputs((-150.0, 1e3), (150.0, 1e3));
        run.go(0.02, 1e-3);
        let warnings = run.messages.iter().filter(|m| m.text.contains("buckle")).count();
        assert_eq!(warnings, 1, "{model:?}");
    }
}

/// A run at the forces of the solved equilibrium keeps its ratio.
fn equilibrium(mut parameters: Parameters, force: f64) {
    let model = parameters.ring_model;
    parameters.primary.drive = Drive::Speed;
    parameters.initial.equilibrium = true;
    let mut run = Run::new(parameters, inputs((0.0, force), (-49.0, 8.5e3)));
    assert!(run.messages.iter().all(|m| !m.warning), "{:?}", run.messages);
    let before = run.variator.outputs().clone();
    assert_eq!(before.start_state, StartState::Steady);
    let after = run.go(0.2, 5e-3);
    println!(
        "{model:?}: ratio {:.6} then {:.6}, forces {:.1} {:.1} N",
        before.ratio_geometric, after.ratio_geometric, before.primary.axial_force, before.secondary.axial_force
    );
    assert_close(before.primary.axial_force, force, 1e-3, "primary force");
    assert_close(before.secondary.axial_force, 8.5e3, 1e-3, "secondary force");
    assert_close(after.ratio_geometric, before.ratio_geometric, 1e-3, "ratio");
    // The ratio was solved for; it is not the initial guess.
    assert!((before.ratio_geometric - 1.0).abs() > 5e-3);
}

#[test]
fn a_start_in_equilibrium_stays_there() {
    equilibrium(coarse(RingModel::Ale0), 9.5e3);
    equilibrium(variator(RingModel::Ale), 11e3);
}

/// Clamping forces that lead to an end stop start the run there.
#[test]
fn a_start_in_equilibrium_at_an_end_stop_stays_there() {
    for model in MODELS {
        for (primary, secondary) in [(26e3, 10e3), (30e3, 6e3), (60e3, 10e3), (5e3, 12e3)] {
            let mut parameters = coarse(model);
            parameters.primary.drive = Drive::Speed;
            parameters.initial.equilibrium = true;
            let mut run = Run::new(parameters, inputs((0.0, primary), (-20.0, secondary)));
            assert!(run.warned("end stop"), "{model:?}: {:?}", run.messages);
            let before = run.variator.outputs().clone();
            let after = run.go(0.5, 5e-3);
            println!(
                "{model:?}, {primary} and {secondary} N: ratio {:.5} then {:.5}, forces {:.0} {:.0} N",
                before.ratio_geometric, after.ratio_geometric, before.primary.axial_force, before.secondary.axial_force
            );
            assert_eq!(before.start_state, StartState::Steady);
            assert_close(after.ratio_geometric, before.ratio_geometric, 1e-4, "ratio");
            assert_close(after.primary.axial_force, before.primary.axial_force, 1e-3, "force");
        }
    }
}

/// A loaded belt rests beyond the end stop of the unloaded curve, and a run may start from its ratio there.
#[test]
fn a_run_may_start_beyond_an_end_stop() {
    for model in MODELS {
        let mut parameters = coarse(model);
        parameters.primary.drive = Drive::Speed;
        let loads = inputs((0.0, 3e3), (-20.0, 22e3));
        let mut run = Run::new(parameters.clone(), loads);
        let rests = run.go(1.0, 5e-3).ratio_geometric;
        parameters.initial.ratio = rests;
        let mut next = Run::new(parameters, loads);
        assert!(next.reported("beyond an end stop"), "{model:?}: {rests}");
        let o = next.go(0.3, 5e-3);
        println!("{model:?}: rests at {rests:.4}, then at {:.4}", o.ratio_geometric);
        assert_close(o.ratio_geometric, rests, 2e-3, "ratio");
    }
}

/// The equilibrium is far from the ratio at which the search starts.
#[test]
fn a_start_in_equilibrium_far_in_overdrive_stays_there() {
    equilibrium(coarse(RingModel::Ale0), 10.5e3);
    equilibrium(coarse(RingModel::Ale), 12.5e3);
}

/// Largest relative change of the observed outputs in the first 50 ms.
fn largest_change<const N: usize>(run: &mut Run, watched: fn(&Outputs) -> [f64; N]) -> f64 {
    let start = watched(run.variator.outputs());
    let mut worst = 0.0_f64;
    run.watch(0.05, 1e-3, |_, o| {
        for (now, then) in watched(o).into_iter().zip(start) {
            worst = worst.max((now / then - 1.0).abs());
        }
    });
    worst
}

/// A start from the steady state at held ratio is at rest from the first step on.
#[test]
fn a_steady_start_is_at_rest() {
    for model in MODELS {
        let mut parameters = variator(model);
        parameters.primary.drive = Drive::Speed;
        parameters.primary.axial = Axial::Held;
        let mut run = Run::new(parameters, inputs((0.0, 0.0), (-49.0, 8.5e3)));
        let worst = largest_change(&mut run, |o| [o.thrust_ratio, o.secondary.speed, o.push_force_max]);
        println!("{model:?}: largest relative change {worst:.1e}");
        assert!(worst < 1e-3, "{model:?}: {worst}");
    }
}

/// The same with a secondary shaft that follows a set point, and a prescribed torque or speed of the primary.
#[test]
fn a_steady_start_at_a_set_point_is_at_rest() {
    for model in MODELS {
        for drive in [Drive::Torque, Drive::Speed] {
            let mut parameters = belt_alone(variator(model));
            (parameters.primary.drive, parameters.secondary.drive) = (drive, Drive::Speed);
            parameters.primary.axial = Axial::Held;
            let mut inputs = inputs((50.0, 0.0), (0.0, 8.5e3));
            inputs.secondary.speed_setpoint = 0.99 * SPEED;
            let mut run = Run::new(parameters, inputs);
            let start = run.variator.outputs().clone();
            assert_eq!(start.start_state, StartState::Steady, "{model:?}, {drive:?}");
            assert_close(start.secondary.speed, 0.99 * SPEED, 1e-9, "set point");
            let worst = largest_change(&mut run, |o| {
                let torques = [o.primary.shaft_torque, o.secondary.shaft_torque];
                [o.thrust_ratio, o.primary.speed, torques[0], torques[1]]
            });
            println!(
                "{model:?}, {drive:?}: {:.3} and {:.3} N·m, slip {:.5}, largest relative change {worst:.1e}",
                start.primary.shaft_torque, start.secondary.shaft_torque, start.slip
            );
            assert!(worst < 1e-3, "{model:?}, {drive:?}: {worst}");
            if drive == Drive::Torque {
                assert_close(start.primary.shaft_torque, -50.0, 1e-4, "torque");
            }
        }
    }
}

/// Shafts held at speeds 12 % apart have a steady state, in which the belt slips through: reported from the start.
#[test]
fn a_start_in_macro_slip_is_reported() {
    for model in MODELS {
        for (share, slips) in [(0.88, true), (0.99, false)] {
            let mut parameters = coarse(model);
            parameters.primary.drive = Drive::Speed;
            parameters.secondary.drive = Drive::Speed;
            let mut inputs = inputs((0.0, 12e3), (0.0, 9e3));
            inputs.secondary.speed_setpoint *= share / parameters.initial.ratio;
            let mut run = Run::new(parameters, inputs);
            let o = run.variator.outputs().clone();
            println!("{model:?}: slip {:.3}, macro-slip {}", o.slip, o.macro_slip);
            assert_eq!(o.macro_slip, slips, "{model:?} at {share}");
            assert_eq!(run.warned("macro-slip"), slips, "{model:?} at {share}");
            assert_close(o.slip, 1.0 - share, 0.05, "slip");
        }
    }
}

/// Torque beyond capacity has no steady state: the run starts from the nearest one and reports it with the reason.
#[test]
fn torque_beyond_capacity_starts_from_the_nearest_state() {
    for (model, torque) in MODELS
        .into_iter()
        .flat_map(|model| [400.0, 150.0, -400.0].map(|torque| (model, torque)))
    {
        let mut run = Run::new(coarse(model), inputs((torque, 13e3), (-torque, 10e3)));
        for message in &run.messages {
            println!("{model:?}: {}", message.text);
        }
        let o = run.variator.outputs().clone();
        assert!(run.warned("no steady state") && run.warned("capacity") && run.warned("% of them"));
        assert!(
            o.torque_utilisation > 0.75 && o.torque_utilisation < 1.05,
            "{}",
            o.torque_utilisation
        );
        assert!(!o.macro_slip && o.slip < 0.03);
        assert_eq!(o.start_state, StartState::ReducedTorque);
        assert_eq!(run.go(0.02, 1e-3).start_state, StartState::ReducedTorque);
        run.assert_balances();
    }
}

/// Beyond capacity a pulley with a free speed runs away until drag balances its torque, at four times the requested speed.
/// That steady state is rejected as a start.
#[test]
fn a_state_with_a_runaway_pulley_is_rejected_as_a_start() {
    let mut parameters = variator(RingModel::Ale);
    parameters.initial.ratio = 0.671;
    parameters.initial.primary_speed = 418.88;
    parameters.secondary.drive = Drive::Speed;
    let mut inputs = inputs((150.33, 18e3), (0.0, 12e3));
    inputs.secondary.speed_setpoint = 418.88 / 0.671;
    let mut run = Run::new(parameters, inputs);
    let o = run.variator.outputs().clone();
    println!("{:?}: {} rad/s, slip {}", o.start_state, o.primary.speed, o.slip);
    assert_eq!(o.start_state, StartState::ReducedTorque);
    assert!(!o.macro_slip && o.slip < 0.03);
}

/// A run reports its start state, also if no steady state was requested or found.
#[test]
fn a_run_reports_its_start_state() {
    for model in MODELS {
        let start = |change: &dyn Fn(&mut Parameters), force: f64| {
            let mut parameters = coarse(model);
            change(&mut parameters);
            let mut run = Run::new(parameters, inputs((50.0, force), (-49.0, force)));
            for message in &run.messages {
                println!("{model:?}: {}", message.text);
            }
            run.variator.outputs().start_state
        };
        let steady = start(&|_| {}, 10e3);
        let standstill = start(&|p| p.initial.primary_speed = 0.0, 10e3);
        let slack = start(&|p| p.initial.primary_speed = 0.0, 0.0);
        let unloaded = start(&|p| p.initial.steady = false, 10e3);
        let no_force = start(&|_| {}, 0.0);
        println!("{model:?}: {steady:?} {standstill:?} {slack:?} {unloaded:?} {no_force:?}");
        assert_eq!(steady, StartState::Steady);
        assert_eq!(
            [standstill, slack, unloaded],
            [StartState::Clamped, StartState::Unloaded, StartState::Unloaded]
        );
        assert_eq!(no_force, StartState::NotFound);
    }
}
