//! The belt out of its plane: misaligned pulleys and a ring that deflects along z.

use pushbelt::variator::settings::{Outputs, Parameters, RingModel};
use pushbelt_support::checks::assert_close;
use pushbelt_support::load_cases::speeds;
use pushbelt_support::run::Run;
use pushbelt_support::steady::{At, Steady, turning};
use pushbelt_support::variators::{SPEED, inputs, mesh, variator};

/// Ratio of the steady states.
const RATIO: f64 = 2.0;

/// A variator whose ring deflects in space. Its belt planes are `misalignment` apart at the ratio
/// of the tests.
fn spatial(misalignment: f64) -> Parameters {
    let mut parameters = Parameters {
        spatial: true,
        ..variator(RingModel::Ale)
    };
    parameters.geometry.pulley_offset = misalignment - OWN;
    parameters
}

/// Misalignment of aligned pulleys due to the ratio and the penetration, m.
const OWN: f64 = 4.60e-4;

fn at_ratio(parameters: &Parameters, ratio: f64) -> Steady {
    // Some slip, so that power flows.
    let mut speeds = speeds(ratio, SPEED);
    speeds.secondary *= 0.99;
    turning(parameters, ratio, 1.0e4, speeds)
}

/// With coinciding belt planes, the planar belt is in balance in space.
#[test]
fn aligned_pulleys_keep_the_belt_in_its_plane() {
    let flat = at_ratio(&variator(RingModel::Ale), RATIO).outputs;
    let mut parameters = spatial(0.0);
    parameters.geometry.pulley_offset = -flat.misalignment;
    let found = at_ratio(&parameters, RATIO).outputs;
    assert!(found.lateral_max < 1e-8);
    for (a, b, what) in [
        (found.thrust_ratio, flat.thrust_ratio, "thrust ratio"),
        (found.secondary.axial_force, flat.secondary.axial_force, "force"),
        (found.primary.shaft_torque, flat.primary.shaft_torque, "torque"),
        (found.push_force_max, flat.push_force_max, "push force"),
        (found.ring_tension_max, flat.ring_tension_max, "tension"),
        (found.losses.total(), flat.losses.total(), "losses"),
    ] {
        assert_close(a, b, 1e-6, what);
    }
}

/// A soft ring crosses the strands on straight lines with boundary layers of width √(EI_b/N) at
/// their ends, where N = T − Q − (m_r + m_e)V²: the tension straightens the strand, and the push
/// force bends it.
#[test]
fn strands_are_straight_between_boundary_layers() {
    let mut parameters = spatial(1.0e-3);
    parameters.ring.lateral_bending_stiffness = 0.1;
    parameters.mesh = mesh(16, 24);
    let state = at_ratio(&parameters, RATIO);
    let mass = parameters.ring.mass_per_length + parameters.belt.mass_per_length;
    for segment in [1, 3] {
        let mut stations = state.stations();
        stations.retain(|at| at.segment == segment);
        // Distance from the start of the strand, m, and slope w' there.
        let place = |at: &At| (at.sample.xi - stations[0].sample.xi, at.sample.lateral_slope);
        let slopes: Vec<_> = stations.iter().map(place).collect();
        let length = slopes.last().expect("a station").0;
        let net = |at: &At| at.sample.tension - at.sample.push;
        let force: f64 = stations.iter().map(net).sum::<f64>() / stations.len() as f64
            - mass * state.outputs.belt_speed * state.outputs.belt_speed;
        let at = |x: f64| {
            let i = slopes.partition_point(|s| s.0 < x);
            let ((x0, a), (x1, b)) = (slopes[i - 1], slopes[i]);
            a + (b - a) * (x - x0) / (x1 - x0)
        };
        let straight = at(0.5 * length);
        let width = (0.1 / force).sqrt();
        for x in [0.35, 0.65] {
            let layers = (-0.35 * length / width).exp();
            assert_close(at(x * length), straight, 2.0 * layers + 5e-4, "slope of a strand");
        }
        let nearest = |x: f64| {
            let by_distance = |a: &&(f64, f64), b: &&(f64, f64)| (a.0 - x).abs().total_cmp(&(b.0 - x).abs());
            *slopes.iter().min_by(by_distance).expect("stations")
        };
        let (near, far) = (nearest(1.5 * width), nearest(3.5 * width));
        let found = (far.0 - near.0) / ((1.0 - near.1 / straight) / (1.0 - far.1 / straight)).ln();
        assert_close(found, width, 0.03, "width of the boundary layer");
    }
}

/// At the stiffness of the ring sets the boundary layers of a strand overlap: it is an S between
/// two clamps, and the arcs hold the belt in their planes.
#[test]
fn belt_follows_the_planes_of_its_pulleys() {
    let state = at_ratio(&spatial(1.0e-3), RATIO);
    let o = &state.outputs;
    assert_close(o.misalignment, 1.0e-3, 1e-2, "misalignment");
    assert_close(o.lateral_max, 0.5 * o.misalignment, 2e-2, "largest deflection");
    let strand = 0.168 * (1.0 - (o.primary.radius - o.secondary.radius).powi(2) / 0.168_f64.powi(2)).sqrt();
    // The flanks yield within about a centimetre of the arc borders, so the strands do not take all
    // of it.
    let share = o.skew * strand / o.misalignment;
    assert!((0.95..1.0).contains(&share), "{share}");
    let stations = state.stations();
    let mut pressed = stations.iter().filter(|at| at.sample.normal > 5.0e4);
    assert!(pressed.all(|at| at.sample.offset.abs() < 2.0e-5));
}

/// The movable sheaves are on opposite sides, so the distance of the planes is (r_P + r_S − 2r₀)
/// tan β: zero at ratio 1 and of the same sign in underdrive and overdrive.
#[test]
fn misalignment_follows_the_ratio() {
    let parameters = variator(RingModel::Ale);
    for ratio in [0.5, 1.0, 2.0] {
        let state = at_ratio(&parameters, ratio);
        let o = &state.outputs;
        let law = &state.system.belt.law;
        let geometric = -(o.primary.radius + o.secondary.radius - 2.0 * law.r0) * law.wedge.tan;
        // The flanks' penetration closes the pulleys a little more.
        assert!((o.misalignment - geometric).abs() < 1.5e-4);
        assert!((ratio - 1.0).abs() < 0.1 || o.misalignment > 3.0e-4);
        assert_eq!(o.lateral_max, 0.0);
    }
}

/// Skewed strands change thrust ratio and losses little, and losses by three to four times at twice
/// the misalignment: losses, not their share of a power that changes too at the same slip.
#[test]
fn losses_rise_steeply_with_the_misalignment() {
    let state = |misalignment: f64| at_ratio(&spatial(misalignment), RATIO);
    let aligned = state(0.0).outputs;
    let loss = |o: &Outputs| o.losses.total();
    let even = |m: f64| {
        let both = [state(m), state(-m)];
        for s in &both {
            assert!(s.power_defect().abs() < 1e-3, "{}", s.power_defect());
        }
        let mean = |of: &dyn Fn(&Outputs) -> f64| 0.5 * (of(&both[0].outputs) + of(&both[1].outputs));
        let thrust = mean(&|o| o.thrust_ratio) - aligned.thrust_ratio;
        [thrust, mean(&loss) - loss(&aligned)]
    };
    let (small, large) = (even(4.0e-4), even(8.0e-4));
    let growth = large[1] / small[1];
    assert!((3.0..4.2).contains(&growth), "loss at twice the misalignment: {growth}");
    let [thrust, loss] = large;
    assert!(thrust.abs() < 8e-3 && loss.abs() < 1e-3 * aligned.primary.power);
}

/// The power of a misaligned belt balances, better on a finer mesh.
#[test]
fn power_balance_out_of_plane() {
    for (refinement, bound) in [(1, 6e-5), (2, 4e-5), (4, 2e-5)] {
        let mut parameters = spatial(1.0e-3);
        parameters.mesh = parameters.mesh.refined(refinement);
        let defect = at_ratio(&parameters, RATIO).power_defect();
        assert!(defect.abs() < bound, "{defect} with {refinement} times the elements");
    }
}

/// A shift moves the whole belt along the axes of its pulleys, and the energy balance holds.
#[test]
fn energy_balance_of_a_shift() {
    let mut parameters = spatial(0.0);
    parameters.geometry.pulley_offset = 5.0e-4;
    let mut run = Run::new(parameters, inputs((50.0, 1.4e4), (-49.0, 1.0e4)));
    let start = run.variator.outputs().primary.position;
    run.go(0.05, 1.0e-3);
    run.inputs.primary.clamping_force = 1.9e4;
    let o = run.go(0.2, 1.0e-3);
    assert!(o.primary.position - start > 1.0e-4);
    run.assert_balances();
}
