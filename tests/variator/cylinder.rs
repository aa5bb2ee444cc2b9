//! Hydraulic cylinders: pressure in, flow out; springs, rotating oil and seals.

use pushbelt::pulley::Pulley;
use pushbelt::scalar::Dual;
use pushbelt::solver::System;
use pushbelt::solver::arrow::Arrow;
use pushbelt::variator::linear::linearise;
use pushbelt::variator::settings::{
    Cylinder, Inputs, Mode, Outputs, Parameters, PulleyOutputs, RingModel, StartState,
};
use pushbelt_support::checks::assert_close;
use pushbelt_support::disturbed::{TIME, assert_jacobian, disturbed, small};
use pushbelt_support::run::{Run, restored, started};
use pushbelt_support::variators::{MODELS, coarse, inputs};

/// An area with which forces from pressures have no rounding error, m².
const AREA: f64 = 1.0 / 128.0;
const CYLINDER: Cylinder = Cylinder {
    area: 0.012,
    spring_force: 400.0,
    spring_stiffness: 1.5e4,
    centrifugal: 0.01,
    seal: 200.0,
};
const SMOOTH: Cylinder = Cylinder { seal: 0.0, ..CYLINDER };

fn with(mut parameters: Parameters, cylinder: Cylinder) -> Parameters {
    (parameters.primary.cylinder, parameters.secondary.cylinder) = (cylinder, cylinder);
    parameters
}

fn bare(area: f64) -> Cylinder {
    Cylinder {
        area,
        ..Cylinder::default()
    }
}

/// The same forces by pressures on pistons of this area.
fn by_pressure(mut forces: Inputs, area: f64) -> Inputs {
    for pulley in [&mut forces.primary, &mut forces.secondary] {
        pulley.pressure = pulley.clamping_force / area;
        pulley.clamping_force = 0.0;
    }
    forces
}

/// Jumps, ramps and derivatives, accurate and in real time.
#[test]
fn pressures_and_forces_give_the_same_bits() {
    for model in MODELS {
        for (mode, ramp) in [
            (Mode::Accurate, 0.0),
            (Mode::Accurate, 1e-3),
            (Mode::Accurate, -1.0),
            (Mode::RealTime, 5e-4),
        ] {
            let mut parameters = with(coarse(model), bare(AREA));
            (parameters.solver.mode, parameters.solver.input_ramp) = (mode, ramp);
            let of = |k: u32| {
                let [primary, secondary] = [256.0 * f64::from(k % 4), -128.0 * f64::from(k % 3)];
                inputs((50.0, 13e3 + primary), (-49.0, 10e3 + secondary))
            };
            let mut rates = Inputs::ZERO;
            rates.primary.clamping_force = 3e4;
            let mut force = started(parameters.clone(), &of(0));
            let mut pressure = started(parameters, &by_pressure(of(0), AREA));
            for k in 1..25 {
                let (to, rates) = (1e-3 * f64::from(k), if k % 5 == 0 { rates } else { Inputs::ZERO });
                force.advance_along(to, &of(k), &rates).expect("a step");
                let (of, rates) = (by_pressure(of(k), AREA), by_pressure(rates, AREA));
                pressure.advance_along(to, &of, &rates).expect("a step");
                assert_eq!(force.state(), pressure.state(), "{model:?}, {mode:?}, ramp {ramp}");
                assert_eq!(force.outputs().clone(), pressure.outputs().clone());
            }
        }
    }
}

/// What the oil supplies is the work on the sheave, less what spring, rotating oil, seals and clamp
/// supply: at each point of a shift, and over it in the energy balance.
#[test]
fn power_of_the_oil_is_the_work_on_the_sheave() {
    for model in MODELS {
        let mut given = by_pressure(inputs((50.0, 13e3), (-49.0, 10e3)), CYLINDER.area);
        given.secondary.clamping_force = 300.0;
        let mut run = Run::new(with(coarse(model), CYLINDER), given);
        let v0 = run.variator.parameters().friction.velocity;
        let (mut fluid, mut rubbed) = (0.0_f64, 0.0_f64);
        for step in [3e5, -4e5] {
            run.inputs.primary.pressure += step;
            let inputs = run.inputs;
            run.watch(0.1, 1e-3, |_, o: &Outputs| {
                let mut seals = 0.0;
                for (of, given) in [(&o.primary, &inputs.primary), (&o.secondary, &inputs.secondary)] {
                    assert_eq!(of.volume, CYLINDER.area * of.position);
                    let drag = CYLINDER.drag(of.sheave_velocity, v0);
                    let others = given.clamping_force + CYLINDER.passive_force(of.position, of.speed) - drag;
                    let mechanical = (of.clamping_force_total - others) * of.sheave_velocity;
                    let power = given.pressure * of.flow;
                    assert!((power - mechanical).abs() <= 1e-9 * power.abs(), "{power} {mechanical}");
                    fluid = fluid.max(power.abs());
                    seals += drag * of.sheave_velocity;
                }
                assert_close(o.losses.seals, seals, 1e-12, "loss of the seals");
                rubbed = rubbed.max(seals);
            });
        }
        assert!(fluid > 10.0 && rubbed > 0.1);
        run.assert_balances();
    }
}

fn entry(matrix: &Arrow, row: usize, column: usize) -> f64 {
    let mut unit = vec![0.0; matrix.shape().len()];
    let mut product = unit.clone();
    unit[column] = 1.0;
    matrix.multiply(&unit, &mut product);
    product[row]
}

/// The rows of the sheaves against a cylinder's derivatives by dual numbers, and the whole Jacobian
/// against differences.
#[test]
fn derivatives_of_a_cylinder() {
    let (alpha, beta) = (1e4, 1e-4);
    for model in MODELS {
        let [(mut without, state), (mut system, _)] =
            [Cylinder::default(), CYLINDER].map(|cylinder| disturbed(&with(small(model), cylinder), 200.0));
        let v0 = system.parameters.friction.velocity;
        let [before, after] = [&mut without, &mut system].map(|system| {
            let mut matrix = Arrow::new(system.shape());
            system.jacobian(TIME, state.view(), alpha, beta, &mut matrix);
            matrix
        });
        for pulley in Pulley::BOTH {
            let layout = &system.belt.layout;
            let (z, speed) = (layout.sheave(pulley), layout.shaft_speed(pulley));
            let (place, rate, omega) = (state.q[z], state.y[z], state.y[speed]);
            let by_sheave = CYLINDER.passive_force(Dual::seed(place, 0, beta), omega.into())
                - CYLINDER.drag(Dual::seed(rate, 0, 1.0), v0);
            let by_speed = CYLINDER.passive_force(place.into(), Dual::seed(omega, 0, 1.0));
            for (column, expected) in [(z, by_sheave.eps[0]), (speed, by_speed.eps[0])] {
                let [before, after] = [&before, &after].map(|matrix| entry(matrix, z, column));
                let allowed = 1e-9 * expected.abs() + 1e-15 * before.abs();
                let off = before - after - expected;
                assert!(off.abs() <= allowed, "{before} {after} {expected}");
            }
        }
        assert_jacobian((system, state), 0.1);
    }
}

/// A slow triangle of the primary pressure: where the sheave passes a place on its ways in and out,
/// the force of the pressure beyond the belt's differs by twice the friction of the seals more than
/// without it.
#[test]
fn seals_make_a_hysteresis_of_thrust_over_position() {
    let (seal, area) = (400.0, 0.01);
    let loop_width = |seal: f64| {
        let mut parameters = with(coarse(RingModel::Ale0), Cylinder { seal, ..bare(area) });
        (parameters.initial.equilibrium, parameters.initial.primary_speed) = (true, 600.0);
        parameters.friction.velocity = 5e-5;
        let mut run = Run::new(parameters, by_pressure(inputs((0.0, 11e3), (0.0, 10e3)), area));
        let [there, back] = [(150, 1e5), (250, -1e5)].map(|(steps, rate)| {
            let mut rates = Inputs::ZERO;
            rates.primary.pressure = rate;
            let way = (0..steps).map(|_| {
                run.ramp(0.02, 0.02, &rates);
                let pressed = area * run.inputs.primary.pressure;
                let of = &run.variator.outputs().primary;
                (of.position, pressed - of.axial_force)
            });
            way.collect::<Vec<_>>()
        });
        // In the middle of the way in, where the sheave follows the ramp.
        let (place, closing) = there[100];
        let passed = back.windows(2).find(|two| two[0].0 > place && two[1].0 <= place);
        let two = passed.expect("the place is passed");
        let ((before, high), (after, low)) = (two[0], two[1]);
        closing - (low + (high - low) * (place - after) / (before - after))
    };
    let (seal_friction, free) = (loop_width(seal), loop_width(0.0));
    assert_close(seal_friction - free, 2.0 * seal, 0.01, "width of the loop");
}

/// Springs and rotating oil are in the starts: steady, at equilibrium and at a standstill.
#[test]
fn starts_are_those_of_the_whole_forces() {
    for model in MODELS {
        let mut parameters = with(coarse(model), SMOOTH);
        parameters.initial.equilibrium = true;
        let given = by_pressure(inputs((50.0, 12e3), (-49.0, 9e3)), SMOOTH.area);
        let mut by_cylinder = started(parameters.clone(), &given);
        let o = by_cylinder.outputs().clone();
        let total = |pulley: &PulleyOutputs| pulley.clamping_force_total;
        let forces = inputs((50.0, total(&o.primary)), (-49.0, total(&o.secondary)));
        let mut same = started(with(parameters.clone(), Cylinder::default()), &forces);
        let expected = same.outputs();
        assert_eq!([o.start_state, expected.start_state], [StartState::Steady; 2]);
        assert_close(o.ratio_geometric, expected.ratio_geometric, 2e-5, "ratio");
        for (of, given) in [(&o.primary, &given.primary), (&o.secondary, &given.secondary)] {
            let force = given.pressure * SMOOTH.area + SMOOTH.passive_force(of.position, of.speed);
            assert_close(of.clamping_force_total, force, 1e-12, "whole force");
            assert_close(of.axial_force, force, 1e-4, "force of the belt");
        }
        by_cylinder.advance(0.05, &given).expect("a step");
        let later = by_cylinder.outputs().ratio_geometric;
        assert_close(later, o.ratio_geometric, 5e-4, "the ratio stays");
        // Springs alone clamp the belt at a standstill.
        let mut at_rest = parameters;
        at_rest.initial.primary_speed = 0.0;
        let mut run = Run::new(at_rest, inputs((0.0, 0.0), (0.0, 0.0)));
        let o = run.go(5e-3, 1e-3);
        assert_eq!(o.start_state, StartState::Clamped);
        let spring = SMOOTH.passive_force(o.secondary.position, 0.0);
        assert_close(o.secondary.axial_force, spring, 0.02, "force of the spring");
    }
}

/// In reverse the search goes by way of a firmer clamp, from springs as from clamps.
#[test]
fn a_start_clamped_by_springs_alone_is_that_of_clamps() {
    let mut parameters = coarse(RingModel::Ale0);
    parameters.initial.primary_speed *= -1.0;
    let [primary, secondary] = [5e3, 4e3];
    let mut clamped = started(parameters.clone(), &inputs((-15.0, primary), (15.0, secondary)));
    parameters.primary.cylinder.spring_force = primary;
    parameters.secondary.cylinder.spring_force = secondary;
    let mut sprung = started(parameters, &inputs((-15.0, 0.0), (15.0, 0.0)));
    assert_eq!(clamped.outputs().start_state, StartState::Steady);
    assert_close(sprung.outputs().slip, clamped.outputs().slip, 1e-6, "slip");
    let [by_springs, by_clamps] = [sprung, clamped].map(|run| run.start_work().residuals as f64);
    assert_close(by_springs, by_clamps, 0.03, "residuals of the search");
}

#[test]
fn a_start_without_load_has_springs_and_seals() {
    for model in MODELS {
        for speed in [0.0, 200.0] {
            let mut parameters = with(coarse(model), CYLINDER);
            (parameters.initial.steady, parameters.initial.primary_speed) = (false, speed);
            let mut run = Run::new(parameters, by_pressure(inputs((0.0, 11e3), (0.0, 10e3)), CYLINDER.area));
            let o = run.go(0.1, 1e-3);
            let clamped = o.secondary.clamping_force_total;
            assert_close(o.secondary.axial_force, clamped, 0.05, "force of the belt");
            // At a standstill hardly any energy moves.
            if speed != 0.0 {
                run.assert_balances();
            }
        }
    }
}

#[test]
fn a_pressure_that_opens_a_pulley_is_warned_about_once() {
    let given = by_pressure(inputs((0.0, 1e3), (0.0, 1e3)), AREA);
    let mut run = Run::new(with(coarse(RingModel::Ale0), bare(AREA)), given);
    for pressure in [-5e4, 1e5, -5e4] {
        run.inputs.primary.pressure = pressure;
        let o = run.go(2e-3, 1e-3);
        assert_eq!(o.primary.clamping_force_total, pressure * AREA);
        let parameters = run.variator.parameters().clone();
        run.variator = restored(&mut run.variator, parameters);
    }
    assert_eq!(run.warnings("primary.pressure = -50000 Pa"), 1, "{:?}", run.messages);
    // No clamping force at all is no opening pressure.
    let parameters = with(coarse(RingModel::Ale0), bare(AREA));
    let run = Run::new(parameters, inputs((0.0, 0.0), (0.0, 0.0)));
    assert!(!run.reported("opens"));
}

/// A piston without area, from the start, where the start fails for it, later in the run, of one
/// pulley or both.
#[test]
fn a_pressure_without_an_area_is_warned_about_once() {
    for (mode, area) in [(Mode::Accurate, 0.0), (Mode::RealTime, 0.0), (Mode::Accurate, AREA)] {
        let mut parameters = with(coarse(RingModel::Ale0), bare(area));
        (parameters.solver.mode, parameters.primary.cylinder.area) = (mode, 0.0);
        let mut run = Run::new(parameters.clone(), inputs((50.0, 13e3), (-49.0, 10e3)));
        for pressure in [0.0, 1e5, 2e5] {
            (run.inputs.primary.pressure, run.inputs.secondary.pressure) = (pressure, 0.5 * pressure);
            run.go(2e-3, 1e-3);
            if pressure == 1e5 {
                run.variator = restored(&mut run.variator, parameters.clone());
            }
        }
        let idle = ["primary", "secondary"].map(|name| format!("{name}.cylinder.area is 0"));
        assert_eq!(run.warnings("has no effect"), 1, "{:?}", run.messages);
        assert_eq!(idle.map(|text| run.warnings(&text)), [1, usize::from(area == 0.0)]);
    }
    let mut given = inputs((50.0, 0.0), (-49.0, 0.0));
    (given.primary.pressure, given.secondary.pressure) = (1.2e6, 1e6);
    let run = Run::new(coarse(RingModel::Ale0), given);
    let first = &run.messages[0].text;
    assert!(
        first.starts_with("at 0 s secondary.pressure = 1000000 Pa has no effect"),
        "{first}"
    );
    assert_eq!(run.warnings("has no effect"), 1);
}

/// A pressure acts as its force does, and the flow is that of the sheave's speed. The held point is
/// one of pressures.
#[test]
fn the_linear_model_has_pressures_and_flows() {
    let mut given = by_pressure(inputs((50.0, 13e3), (-49.0, 9.7e3)), CYLINDER.area);
    given.secondary.clamping_force = 300.0;
    let read: [&dyn Fn(&Outputs) -> f64; 6] = [
        &|o| o.ratio_geometric,
        &|o| o.primary.sheave_velocity,
        &|o| o.primary.flow,
        &|o| o.primary.clamping_force_total,
        &|o| o.primary.position,
        &|o| o.primary.speed,
    ];
    let model =
        linearise(&with(coarse(RingModel::Ale), CYLINDER), &given, 20.0, &read).expect("a linear model");
    let column = |name: String| model.loads.iter().position(|load| load.name() == name).expect("a load");
    for pulley in Pulley::BOTH {
        let [force, pressure] =
            ["clampingForce", "pressure"].map(|name| column(format!("{}.{name}", pulley.name())));
        // D is from differences.
        let rows = model.b.iter().map(|row| (row, 1e-9));
        for (row, share) in rows.chain(model.d.iter().map(|row| (row, 1e-6))) {
            let (found, expected) = (row[pressure], CYLINDER.area * row[force]);
            assert!((found - expected).abs() <= share * expected.abs(), "{found} {expected}");
        }
    }
    // The whole force has a direct part, and follows place and speeds.
    let at = column("primary.pressure".into());
    let [total, place, speed] = [3, 4, 5].map(|row: usize| model.d[row][at]);
    let expected = CYLINDER.area - CYLINDER.spring_stiffness * place
        + 2.0 * CYLINDER.centrifugal * model.outputs.primary.speed * speed
        - CYLINDER.seal / Parameters::default().friction.velocity * model.d[1][at];
    assert_close(total, expected, 1e-4, "direct part of the whole force");
    for matrix in [&model.c, &model.d] {
        for (speed, flow) in matrix[1].iter().zip(&matrix[2]) {
            let expected = CYLINDER.area * speed;
            assert!((flow - expected).abs() <= 1e-9 * flow.abs(), "{flow} {speed}");
        }
    }
    let held = &model.inputs.secondary;
    assert_eq!(held.clamping_force, 300.0);
    assert_close(held.pressure, given.secondary.pressure, 1e-4, "pressure");
    assert!(held.pressure * CYLINDER.area + 800.0 < model.outputs.secondary.axial_force);
    let is_named = model.remarks.iter().any(|remark| remark.contains("primary.pressure"));
    assert!(is_named, "{:?}", model.remarks);
}
