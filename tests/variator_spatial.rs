//! The belt out of its plane: misaligned pulleys and a ring that deflects along z.

use pushbelt::pulley::Pulley;
use pushbelt::variator::settings::{Outputs, Parameters, RingModel};
use pushbelt_support::checks::assert_close;
use pushbelt_support::load_cases::{given, speeds};
use pushbelt_support::run::Run;
use pushbelt_support::steady::{At, Steady, steady};
use pushbelt_support::variators::{SPEED, inputs, mesh, variator};

/// Ratio of the steady states.
const RATIO: f64 = 2.0;

/// A variator whose ring deflects in space. Its belt planes are `misalignment` apart at the ratio of the tests.
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
    steady(parameters, &given(ratio, Pulley::Primary, 1.0e4, 6.0e-3), speeds)
}

/// With coinciding belt planes, the planar belt is in balance in space.
#[test]
fn aligned_pulleys_keep_the_belt_in_its_plane() {
    let flat = at_ratio(&variator(RingModel::Ale), RATIO);
    let mut parameters = spatial(0.0);
    parameters.geometry.pulley_offset = -flat.outputs.misalignment;
    let lifted = flat.lifted(&parameters);
    let middles = lifted.middles;
    assert!((middles.primary - middles.secondary).abs() < 1e-16);
    // In units of the contact forces on an element.
    let scale = 100.0;
    for (row, [planar, spatial]) in lifted.shared.iter().enumerate() {
        assert!(
            (planar - spatial).abs() < 1e-9 * scale,
            "row {row}: {planar} and {spatial}"
        );
    }
    let most = lifted.lateral.iter().fold(0.0_f64, |a, x| a.max(x.abs()));
    assert!(most < 1e-9 * scale);
    let solved = at_ratio(&parameters, RATIO);
    let (a, b) = (flat.outputs.thrust_ratio, solved.outputs.thrust_ratio);
    assert!((a / b - 1.0).abs() < 1e-6 && solved.outputs.lateral_max < 1e-8);
}

/// Distance of the stations of a strand from its start, m, and slope w' there.
fn slopes(state: &Steady, segment: usize) -> (Vec<(f64, f64)>, Vec<At>) {
    let stations: Vec<At> = state
        .stations()
        .into_iter()
        .filter(|at| at.segment == segment)
        .collect();
    let start = stations[0].sample.xi;
    let slopes = stations
        .iter()
        .map(|at| (at.sample.xi - start, at.sample.lateral[1]))
        .collect();
    (slopes, stations)
}

/// A soft ring crosses the strands on straight lines with boundary layers of width √(EI_b/N) at their ends, where
/// N = T − Q − (m_r + m_e)V²: the tension straightens the strand, and the push force bends it.
#[test]
fn strands_are_straight_between_boundary_layers() {
    let mut parameters = spatial(1.0e-3);
    parameters.ring.lateral_bending_stiffness = 0.1;
    parameters.mesh = mesh(16, 24);
    let state = at_ratio(&parameters, RATIO);
    let mass = parameters.ring.mass_per_length + parameters.belt.mass_per_length;
    for segment in [1, 3] {
        let (slopes, stations) = slopes(&state, segment);
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
            slopes
                .iter()
                .copied()
                .min_by(|a, b| (a.0 - x).abs().total_cmp(&(b.0 - x).abs()))
                .expect("stations")
        };
        let (near, far) = (nearest(1.5 * width), nearest(3.5 * width));
        let found = (far.0 - near.0) / ((1.0 - near.1 / straight) / (1.0 - far.1 / straight)).ln();
        assert_close(found, width, 0.03, "width of the boundary layer");
    }
}

/// At the stiffness of the ring sets the boundary layers of a strand overlap: it is an S between two clamps, and the arcs
/// hold the belt in their planes.
#[test]
fn belt_follows_the_planes_of_its_pulleys() {
    let state = at_ratio(&spatial(1.0e-3), RATIO);
    let o = &state.outputs;
    assert_close(o.misalignment, 1.0e-3, 1e-2, "misalignment");
    assert_close(o.lateral_max, 0.5 * o.misalignment, 2e-2, "largest deflection");
    let strand = 0.168 * (1.0 - (o.primary.radius - o.secondary.radius).powi(2) / 0.168_f64.powi(2)).sqrt();
    // The flanks yield within about a centimetre of the arc borders, so the strands do not take all of it.
    let share = o.skew * strand / o.misalignment;
    assert!((0.95..1.0).contains(&share), "{share}");
    let largest = state
        .stations()
        .iter()
        .map(|at| at.sample)
        .filter(|s| s.normal > 5.0e4)
        .map(|s| s.offset.abs())
        .fold(0.0, f64::max);
    assert!(largest < 2.0e-5);
}

/// The movable sheaves are on opposite sides, so the distance of the planes is (r_P + r_S − 2r₀) tan β: zero at ratio 1 and of
/// the same sign in underdrive and overdrive.
#[test]
fn misalignment_follows_the_ratio() {
    let parameters = variator(RingModel::Ale);
    for ratio in [0.5, 1.0, 2.0] {
        let state = at_ratio(&parameters, ratio);
        let o = &state.outputs;
        let geometric = state.geometric_misalignment();
        // The flanks' penetration closes the pulleys a little more.
        assert!((o.misalignment - geometric).abs() < 1.5e-4);
        assert!((ratio - 1.0).abs() < 0.1 || o.misalignment > 3.0e-4);
        assert_eq!(o.lateral_max, 0.0);
    }
}

/// Skewed strands change thrust ratio and losses little, and losses with the square of the misalignment: losses, not their share
/// of a power that changes too at the same slip.
#[test]
fn losses_rise_with_the_square_of_the_misalignment() {
    let state = |misalignment: f64| at_ratio(&spatial(misalignment), RATIO);
    let aligned = state(0.0).outputs;
    let loss = |o: &Outputs| o.losses.total();
    let even = |m: f64| {
        let both = [state(m), state(-m)];
        for s in &both {
            assert!(s.power_defect().abs() < 1e-3, "{}", s.power_defect());
        }
        let mean = |of: &dyn Fn(&Outputs) -> f64| 0.5 * (of(&both[0].outputs) + of(&both[1].outputs));
        [
            mean(&|o| o.thrust_ratio) - aligned.thrust_ratio,
            mean(&loss) - loss(&aligned),
        ]
    };
    let (small, large) = (even(4.0e-4), even(8.0e-4));
    assert_close(large[1] / small[1], 4.0, 0.15, "loss at twice the misalignment");
    assert!(
        large[0].abs() < 8e-3 && large[1].abs() < 1e-3 * aligned.primary.power,
        "{large:?}"
    );
}

/// The power of a misaligned belt balances on each mesh.
#[test]
fn power_balance_out_of_plane() {
    let mut parameters = spatial(1.0e-3);
    let coarse = at_ratio(&parameters, RATIO).power_defect();
    parameters.mesh = parameters.mesh.refined(2);
    let fine = at_ratio(&parameters, RATIO).power_defect();
    parameters.mesh = parameters.mesh.refined(2);
    let finer = at_ratio(&parameters, RATIO).power_defect();
    assert!([coarse, fine, finer].iter().all(|defect| defect.abs() < 3e-5));
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
