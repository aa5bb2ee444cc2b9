//! Limit cases with a closed-form law: no friction, full slip, small steps of the clamping force.

use pushbelt::pulley::Pulley;
use pushbelt::variator::settings::{Axial, BeltKind, Drive, Outputs, Parameters, RingModel};
use pushbelt_support::checks::assert_close;
use pushbelt_support::load_cases::{pair, speeds};
use pushbelt_support::run::Run;
use pushbelt_support::shift::unloaded_shift;
use pushbelt_support::steady::turning;
use pushbelt_support::variators::{
    MODELS, SPEED, belt_alone, chain, coarse, full_slip_torque, inputs, rigid, variator,
};

/// Deviations from the frictionless law, of the thrust ratio from α_P/α_S and of S on P and on S
/// from (F − σV²)α/(2 tan β).
fn off_frictionless(
    parameters: &Parameters,
    ratio: f64,
    contact_stiffness: f64,
    refinement: i32,
) -> [f64; 3] {
    let mut parameters = belt_alone(rigid(parameters.clone()));
    (parameters.friction.pulley, parameters.friction.ring) = (1e-9, 0.0);
    parameters.contact.stiffness = contact_stiffness;
    parameters.mesh = parameters.mesh.refined(refinement);
    // The law neglects bending, whose share of the strand force, EI/(F r²), is 0.5 % for this ring
    // on the small pulley.
    parameters.ring.bending_stiffness = 1e-3;
    let state = turning(&parameters, ratio, 10e3, speeds(ratio, SPEED));
    let stations = state.stations();
    let strand: Vec<_> = stations.iter().filter(|at| at.segment == 1).collect();
    let middle = &strand[strand.len() / 2].sample;
    // σV² is the sum for elements and ring, with their masses and speeds.
    let elements = parameters.belt.mass_per_length * middle.density * middle.speed.powi(2);
    let ring = parameters.ring.mass_per_length * state.outputs.ring_speed.powi(2);
    let force = middle.tension - middle.push - elements - ring;
    let wrap = state.wrap();
    let law = |pulley: Pulley| force * wrap[pulley] / (2.0 * parameters.geometry.wedge_angle.tan());
    let o = &state.outputs;
    [
        o.thrust_ratio * wrap.secondary / wrap.primary - 1.0,
        o.primary.axial_force / law(Pulley::Primary) - 1.0,
        o.secondary.axial_force / law(Pulley::Secondary) - 1.0,
    ]
}

/// Without friction F_P/F_S = α_P/α_S and, of a pushbelt, S = (F − σV²)α/(2 tan β). A compliant
/// flank presses beside the arc too, over √(2 r g/tan β): the law is the limit of stiff contact on
/// a mesh that resolves this edge.
#[test]
fn without_friction_the_thrust_ratio_is_that_of_the_wrap_angles() {
    let worst = |parameters: &Parameters, stiffness: f64, refinement: i32| {
        let mut worst = [0.0_f64; 2];
        for ratio in [0.45, 1.0, 2.2] {
            let off = off_frictionless(parameters, ratio, stiffness, refinement).map(f64::abs);
            worst = [worst[0].max(off[0]), worst[1].max(off[1]).max(off[2])];
        }
        worst
    };
    for model in MODELS {
        let belt = variator(model);
        let [soft, stiffer, stiff] =
            [(2.5e9, 1), (1e10, 2), (4e10, 2)].map(|(k, mesh)| worst(&belt, k, mesh));
        for k in 0..2 {
            let falls = stiff[k] < 0.5 * stiffer[k] && stiffer[k] < 0.5 * soft[k];
            assert!(stiff[k] < 3e-4 && falls, "{model:?}: {soft:?}, {stiffer:?}, {stiff:?}");
        }
        let of_chain = worst(&chain(model), 4e10, 2)[0];
        assert!(of_chain < 3e-4, "{model:?}: {of_chain}");
    }
}

/// A pulley on which the whole belt slides tangentially transmits T = 2μSR/cos β, in the direction
/// of sliding.
#[test]
fn a_pulley_that_slips_all_around_transmits_its_capacity() {
    for parameters in MODELS.map(variator).into_iter().chain(MODELS.map(chain)) {
        let parameters = belt_alone(parameters);
        // The smaller pulley slips. At a slip far above micro-slip, friction has no radial
        // component.
        for (ratio, slip) in [(0.5, 0.5), (2.0, 0.5), (2.0, -0.5)] {
            if ratio < 1.0 && parameters.kind == BeltKind::PullChain {
                continue;
            }
            let slipping = pair(SPEED / ratio * (1.0 - slip), SPEED);
            let o = turning(&parameters, ratio, 10e3, slipping).outputs;
            let (pulley, sign) = if ratio < 1.0 {
                (&o.secondary, 1.0)
            } else {
                (&o.primary, -1.0)
            };
            let law = sign * slip.signum() * full_slip_torque(&parameters, pulley);
            assert_close(pulley.shaft_torque, law, 2e-3, "torque at full slip");
        }
    }
}

/// The slope at constant normal forces changes its sign where the torque over slip is within 1 % of
/// its peak: both shafts have given speeds. In underdrive all elements of the primary pulley slide
/// before.
#[test]
fn past_the_peak_of_traction_torque_falls_with_slip() {
    for model in MODELS {
        for (ratio, force, sign) in [(2.2, 30e3, 1.0), (2.2, 10e3, -1.0), (1.0, 15e3, 1.0), (0.5, 15e3, -1.0)]
        {
            let at = |slip: f64| {
                let slipping = pair(SPEED / ratio * (1.0 - sign * slip), SPEED);
                turning(&variator(model), ratio, force, slipping).outputs
            };
            let curve: Vec<_> = (0..17).map(|k| at(0.02 * f64::powf(1.162, f64::from(k)))).collect();
            let torque = |o: &Outputs| o.torque_utilisation.abs();
            let peak = curve.iter().map(torque).fold(0.0, f64::max);
            let past: Vec<_> = curve.iter().map(|o| o.past_peak).collect();
            let changes = past.partition_point(|past| !past);
            let there = curve.get(changes).map_or(0.0, torque);
            assert!(there > 0.99 * peak, "{model:?} {ratio}: {past:?}, {there}, peak {peak}");
            assert!(past[changes..].iter().all(|past| *past), "{model:?} {ratio}: {past:?}");
        }
    }
}

/// Torque over 2μSR/cos β of the pulley that slips more, if it slips all around. (On the other one
/// elements may have gaps before the entry: they move with the sheave until they reach the pushing
/// stack.)
fn slip_torque_ratio(run: &Run, outputs: &Outputs) -> Option<f64> {
    // Strand elements beside the arc hardly press, and their sliding is not considered.
    let sliding = &run.variator.energy_balance().last.sums.sliding;
    let mean = |pulley: Pulley| sliding[pulley].weighted / sliding[pulley].load;
    let (of, pulley) = if mean(Pulley::Primary).abs() > mean(Pulley::Secondary).abs() {
        (Pulley::Primary, &outputs.primary)
    } else {
        (Pulley::Secondary, &outputs.secondary)
    };
    let forward = sliding[of].forward / sliding[of].load;
    let full = forward.max(1.0 - forward) > 0.999 && mean(of).abs() > 1.0;
    full.then(|| pulley.shaft_torque.abs() / full_slip_torque(run.variator.parameters(), pulley))
}

/// With the secondary in speed drive and the primary driven beyond capacity, a pulley that slips
/// all around takes T = 2μSR/cos β; afterwards the belt grips again.
#[test]
fn over_torque_slips_at_capacity_and_recovers() {
    for model in MODELS {
        let mut parameters = belt_alone(coarse(model));
        parameters.secondary.drive = Drive::Speed;
        let normal = inputs((50.0, 12.0e3), (0.0, 9.0e3));
        let mut run = Run::new(parameters, normal);
        let before = run.go(0.02, 2e-3);
        assert!(!before.macro_slip && before.slip < 0.03);
        run.inputs.primary.torque = 150.0;
        let (mut seen, mut worst, mut flagged) = (0, 0.0_f64, false);
        for _ in 0..50 {
            let o = run.go(2e-3, 2e-3);
            flagged |= o.macro_slip;
            if let Some(ratio) = slip_torque_ratio(&run, &o) {
                seen += 1;
                worst = worst.max((ratio - 1.0).abs());
            }
        }
        run.inputs = normal;
        let after = run.go(0.4, 2e-3);
        assert!(flagged && seen > 10, "{model:?} did not slip");
        for text in ["begins to slip through", "grips again"] {
            assert!(run.reported(text), "{model:?}: {text}");
        }
        assert!(worst < 5e-3, "{model:?}: torque off by {worst}");
        let grips = !after.macro_slip && (0.0..0.01).contains(&after.slip);
        assert!(grips, "{model:?}: slip {}", after.slip);
        run.assert_balances();
    }
}

/// Factors on F_P.
const STEPS: [f64; 4] = [0.99, 0.995, 1.005, 1.01];

/// Geometric ratio of the steps. At 1 the direction of ring friction changes, and the equilibrium
/// has a step.
const RATIO: f64 = 1.25;

/// The variator of the theory at a ratio, without ring friction and play, with which the equilibrium
/// would depend on force and speed.
fn of_theory(model: RingModel, ratio: f64) -> Parameters {
    let mut parameters = belt_alone(variator(model));
    parameters.friction.ring = 0.0;
    parameters.belt.play = 0.0;
    parameters.primary.drive = Drive::Speed;
    parameters.initial.ratio = ratio;
    parameters
}

/// A run whose clamping forces balance, the initial state of a step of F_P.
fn balanced(model: RingModel, omega: f64) -> Run {
    let mut parameters = of_theory(model, RATIO);
    // A step moves the ratio by 1e-4 to 1e-2 in the time observed.
    parameters.solver.tolerance = 1e-6;
    // Micro-slip at half the pulley speed must be far above it.
    parameters.friction.velocity *= 0.25;
    parameters.primary.sheave_damping = 0.0;
    parameters.secondary.sheave_damping = 0.0;
    let mut start = inputs((0.0, 10.0e3), (-40.0, 8.0e3));
    start.primary.speed_setpoint = omega;
    let mut run = Run::new(parameters, start);
    run.inputs.primary.clamping_force = run.variator.outputs().primary.axial_force;
    run.go(0.02, 0.02);
    run
}

/// d ln i_g/dt, ln i_F and ln i_g in the middle of `turns` belt turns, two turns after a step of
/// F_P by `factor`: within these two turns the distribution of sliding settles.
fn shift(balanced: &Run, omega: f64, factor: f64, turns: [f64; 2]) -> [f64; 3] {
    let mut run = balanced.clone();
    run.inputs.primary.clamping_force *= factor;
    let [first, last] = turns.map(|turn| turn * 0.7 / (0.052 * omega));
    let from = run.go(first, first);
    let to = run.go(last - first, last - first);
    let [before, after] = [from.ratio_geometric.ln(), to.ratio_geometric.ln()];
    [
        (after - before) / (last - first),
        0.5 * (from.thrust_ratio.ln() + to.thrust_ratio.ln()),
        0.5 * (before + after),
    ]
}

/// d ln(F_P/F_S)_eq/d ln i_g, from steady states with the primary sheave held.
fn equilibrium_slope(model: RingModel, omega: f64) -> f64 {
    let [low, high] = [0.99 * RATIO, 1.01 * RATIO].map(|ratio: f64| {
        let mut parameters = of_theory(model, ratio);
        parameters.primary.axial = Axial::Held;
        let mut start = inputs((0.0, 0.0), (-40.0, 8.0e3));
        start.primary.speed_setpoint = omega;
        let o = Run::new(parameters, start).variator.outputs().clone();
        (o.thrust_ratio.ln(), o.ratio_geometric.ln())
    });
    (high.0 - low.0) / (high.1 - low.1)
}

/// Coefficients c of d ln i_g/dt = c ω_P (ln(F_P/F_S) − ln(F_P/F_S)_eq) for small steps of either
/// sign, in ascending order of F_P. The equilibrium is that of the present ratio: that of the run
/// without a step, corrected for the ratio.
fn shift_coefficients(model: RingModel, omega: f64, turns: [f64; 2]) -> [f64; 4] {
    let run = balanced(model, omega);
    let slope = equilibrium_slope(model, omega);
    let [rest, equilibrium, ratio] = shift(&run, omega, 1.0, turns);
    STEPS.map(|factor| {
        let [rate, thrust, reached] = shift(&run, omega, factor, turns);
        let (rate, drive) = (rate - rest, thrust - equilibrium - slope * (reached - ratio));
        let coefficient = rate / (omega * drive);
        // More primary force shifts towards overdrive: i_g falls.
        assert!(coefficient < 0.0, "{model:?}: shifts against the force");
        coefficient
    })
}

/// Carbone, Mangialardi, Mantriota 2005: in creep mode di/dt ∝ ω_P (ln(F_P/F_S) − ln(F_P/F_S)_eq).
/// It results from the sliding that the tilted sheaves impose on the belt in every turn.
#[test]
fn shift_speed_is_proportional_to_pulley_speed_and_to_the_logarithm_of_the_thrust() {
    let [slow, fast] = [0.5, 1.0].map(|share| shift_coefficients(RingModel::Ale, share * SPEED, [2.0, 4.0]));
    let later = shift_coefficients(RingModel::Ale, SPEED, [4.0, 12.0]);
    for c in [slow, fast] {
        let mean = 0.5 * (c[1] + c[2]);
        // The coefficients of opposite steps differ by an amount of the order of the step, at most
        // 6 times it.
        for (k, step) in [(0, 0.01), (1, 0.005), (2, 0.005), (3, 0.01)] {
            assert_close(c[k], mean, 6.0 * step, "coefficient of a step");
        }
        assert_close(c[0] + c[3], c[1] + c[2], 2e-2, "mean of opposite steps");
    }
    for ((a, b), c) in slow.iter().zip(&fast).zip(&later) {
        // The inertia of the driven pulley has an effect in a fast shift.
        assert_close(*a, *b, 0.1, "half the pulley speed");
        assert_close(*c, *b, 0.1, "later turns");
    }
}

/// Circles about free centres (`ALE0`) have the sliding that tilted sheaves impose on the belt, so
/// they shift as fast as the deflecting ring. Circles about the axes shifted some fifty times
/// slower, because the belt stuck.
#[test]
fn arcs_about_free_centres_shift_as_the_deflecting_ring_does() {
    for (s, force) in [(0.6, 8e3), (1.0, 12e3), (1.8, 20e3)] {
        let [deflecting, guided] = [RingModel::Ale, RingModel::Ale0].map(|model| {
            let found = unloaded_shift(model, s, force);
            found.run.assert_balances();
            found.gain
        });
        assert_close(guided, deflecting, 0.2, "gain of ALE0");
    }
}
