//! Steady states of the variator: load cases, power balance, symmetry, errors of mesh and
//! regularisation.

use pushbelt::pulley::Pulley;
use pushbelt::solver::newton::Newton;
use pushbelt::variator::cell::sample::Sample;
use pushbelt::variator::pulleys::loads::{Boundary, ShaftMode};
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt::variator::steady::solve::{SteadySolver, SteadyTask};
use pushbelt::variator::steady::start::{Start, kinematic_state};
use pushbelt::variator::system::VariatorSystem;
use pushbelt_support::checks::{assert_close, assert_mirrored, assert_pinned};
use pushbelt_support::load_cases::{LoadCase, given, pair, ratio, speeds};
use pushbelt_support::steady::{At, Steady, load_case, steady, transmitting};
use pushbelt_support::variators::{MODELS, SPEED, belt_alone, coarse, mesh, variator};

/// Smallest and largest.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)))
}

/// The push force rises along the primary arc, is constant in the push strand, falls along the
/// secondary arc and is zero in the pulling strand. Changes against this trend are bounded by two
/// friction forces: the ring's, μ_r T times the angle, and the sheaves' where the belt slides in
/// the other direction.
fn assert_course_of_push_force(state: &Steady, name: &str) {
    let stations = state.stations();
    // Strand elements that press beside an arc count as part of it.
    let strand = |segment: usize| {
        let free = |at: &&At| at.segment == segment && at.sample.normal < 100.0;
        range(stations.iter().filter(free).map(|at| at.sample.push))
    };
    let (low, high) = strand(3);
    assert!(high - low <= 0.01 * high, "{name}: push strand, {low} to {high} N");
    let (_, left) = strand(1);
    assert!(left <= 0.01 * high, "{name}: pulling strand, {left} of {high} N");
    let friction = &state.system.parameters.friction;
    for (segments, sign, arc) in [(&[2][..], 1.0, "primary"), (&[4, 0], -1.0, "secondary")] {
        let of = |&segment: &usize| stations.iter().filter(move |at| at.segment == segment);
        let course: Vec<&Sample> = segments.iter().flat_map(of).map(|at| &at.sample).collect();
        let (mut best, mut carried) = (f64::NEG_INFINITY, 0.0);
        for s in &course {
            carried += friction.ring * state.outputs.ring_tension_max * s.weight / s.pitch_radius;
            if sign * s.sliding > 0.0 {
                carried += 2.0 * friction.pulley * s.normal * s.weight;
            }
            if sign * s.push > best {
                (best, carried) = (sign * s.push, 0.0);
            }
            let slack = 0.02 * state.outputs.push_force_max;
            assert!(
                sign * s.push >= best - carried - slack,
                "{name}: {} N after {} N in the {arc} arc, friction carries {carried} N",
                s.push,
                best.abs()
            );
        }
        let change = sign * (course[course.len() - 1].push - course[0].push);
        assert!(change > 0.75 * high, "{name}: {change} of {high} N on the {arc} arc");
    }
}

/// Nine load cases: the power supplied is the loss, slip is positive, the push force has its known
/// course, and the thrust ratio rises from underdrive to overdrive.
#[test]
fn nine_load_cases_balance_their_power() {
    for model in MODELS {
        let parameters = variator(model);
        for torque in [30.0, 50.0, 100.0] {
            let mut thrust = Vec::new();
            for case in LoadCase::three(&parameters, torque) {
                let state = load_case(&parameters, &case);
                assert_close(state.external_torques().primary, case.torque, 1e-4, "torque on P");
                let o = &state.outputs;
                let name = format!("{model:?} {} {torque} N·m", case.name);
                assert_close(o.ratio_geometric, ratio(case.theta), 1e-4, "ratio");
                assert!(state.power_defect().abs() < 2e-3, "{name}");
                // Measured belts slip by 2 to 4 % at 95 % of the peak of traction in underdrive;
                // here the utilisation is 0.77.
                assert!(o.slip > 0.0 && o.slip < 0.035, "{name}");
                assert!(o.efficiency < o.belt_efficiency && o.belt_efficiency < 1.0, "{name}");
                let losses = &o.losses;
                let positive = [losses.sheaves, losses.ring, losses.element_rotation, losses.shafts];
                assert!(positive.iter().all(|loss| *loss > 0.0), "{name}");
                assert!(losses.other >= 0.0 && losses.layers >= 0.0, "{name}");
                if model == RingModel::Ale {
                    // Tilt alone spreads the radius by R aΔ on a wrap of half a turn: 1.1 mm at 21
                    // kN on the large pulley.
                    for spiral in [o.primary.spiral, o.secondary.spiral] {
                        assert!(spiral > 5e-5 && spiral < 1.2e-3, "{name}");
                    }
                }
                assert_course_of_push_force(&state, &name);
                thrust.push(o.thrust_ratio);
            }
            assert!(thrust[0] < thrust[1] && thrust[1] < thrust[2], "{model:?}: {thrust:?}");
        }
    }
}

/// The paper's 5.4: at a constant ratio, belt speed has a minor influence. (In underdrive the
/// primary pulley of `ALE0` is near its own capacity at these forces; below 2000 rpm it slips.)
#[test]
fn belt_speed_changes_the_thrust_ratio_by_less_than_five_percent() {
    for model in MODELS {
        let parameters = variator(model);
        for case in LoadCase::three(&parameters, 50.0) {
            if model == RingModel::Ale0 && case.name == "underdrive" {
                continue;
            }
            let [half, full, more] = [0.5, 1.0, 1.5].map(|share| {
                let speeds = speeds(ratio(case.theta), share * SPEED);
                steady(&parameters, &case.task(), speeds).outputs.thrust_ratio
            });
            assert_close(half, full, 0.05, "1000 rpm");
            assert_close(more, full, 0.05, "3000 rpm");
        }
    }
}

/// Twice the elements in each of the load cases: thrust ratio of `ALE` within 1 %, spiral running
/// within 5 %. (In overdrive the release of elements at the small pulley determines the error,
/// `docs/notebook/figures.md`.) Four times the cells close the power balance to 5e-4. Half the
/// friction velocity changes the thrust ratio by less than 0.5 %.
#[test]
fn mesh_and_friction_velocity_are_fine_enough() {
    for torque in [30.0, 100.0] {
        for model in MODELS {
            let parameters = variator(model);
            for case in LoadCase::three(&parameters, torque) {
                let of = |change: fn(&mut Parameters)| {
                    let mut changed = parameters.clone();
                    change(&mut changed);
                    load_case(&changed, &case)
                };
                let defect = of(|p| p.mesh = p.mesh.refined(4)).power_defect();
                assert!(defect.abs() <= 5e-4, "{model:?} {} {torque} N·m: {defect:e}", case.name);
                if model == RingModel::Ale0 {
                    continue;
                }
                let [usual, finer, sharp] = [
                    of(|_| ()),
                    of(|p| p.mesh = p.mesh.refined(2)),
                    of(|p| p.friction.velocity *= 0.5),
                ]
                .map(|state| state.outputs);

                for (a, b, bound, what) in [
                    (usual.thrust_ratio, finer.thrust_ratio, 0.01, "thrust ratio"),
                    (usual.primary.spiral, finer.primary.spiral, 0.05, "spiral on P"),
                    (usual.secondary.spiral, finer.secondary.spiral, 0.05, "spiral on S"),
                    (usual.thrust_ratio, sharp.thrust_ratio, 5e-3, "sharp friction"),
                ] {
                    assert_close(a, b, bound, what);
                }
            }
        }
    }
}

/// The tension of a ring without friction is the same all around, except in elements at an arc
/// border. Largest deviation from the mean, of stations and of element means.
fn tension_ripple(state: &Steady) -> [f64; 2] {
    let elements = &state.system.belt.mesh.elements;
    let n = elements.len();
    let on_arc = |i: usize| elements[i % n].segment.is_multiple_of(2);
    let inner = |i: usize| on_arc(i + 1) == on_arc(i) && on_arc(i + n - 1) == on_arc(i);
    let stations = state.stations();
    let mean = |of: &dyn Fn(usize) -> bool| {
        let (force, length) = stations
            .iter()
            .filter(|at| of(at.element))
            .fold((0.0, 0.0), |(f, l), at| {
                (f + at.sample.tension * at.sample.weight, l + at.sample.weight)
            });
        force / length
    };
    let whole = mean(&|_| true);
    let off = |tension: f64| (tension / whole - 1.0).abs();
    let stations = stations.iter().filter(|at| inner(at.element));
    let points = stations.map(|at| off(at.sample.tension)).fold(0.0, f64::max);
    let means = (0..n).filter(|&i| inner(i)).map(|i| off(mean(&|element| element == i)));
    [points, means.fold(0.0, f64::max)]
}

/// At the default mesh the tension of each element (its mean, as in the outputs) is constant;
/// within the second element from an arc border the cubic shape has ripples above 5 %, but not on
/// twice the elements. Found, at most: 1.0 %, 7.5 %, 1.5 %.
#[test]
fn ring_tension_is_constant_without_ring_friction() {
    let mut parameters = belt_alone(variator(RingModel::Ale));
    parameters.friction.ring = 0.0;
    let mut fine = parameters.clone();
    fine.mesh = parameters.mesh.refined(2);
    for case in LoadCase::three(&parameters, 50.0) {
        let [points, means] = tension_ripple(&load_case(&parameters, &case));
        let [fine_points, _] = tension_ripple(&load_case(&fine, &case));
        assert!(means < 0.015 && points < 0.09 && fine_points < 0.02, "{}", case.name);
    }
}

/// Rotation by 180° about the midpoint of the axes swaps the pulleys: i_F(i; P drives)·i_F(1/i; S
/// drives) = 1.
#[test]
fn swapped_pulleys_mirror_each_other() {
    for model in MODELS {
        let mut parameters = coarse(model);
        parameters.mesh = mesh(12, 8);
        for i in [0.5, ratio(0.2), 1.0, 1.6] {
            let direct = transmitting(&parameters, i, 9e3, 50.0, SPEED).outputs;
            let task = SteadyTask {
                shaft: pair(ShaftMode::Torque(50.0), ShaftMode::Fixed),
                ..given(1.0 / i, Pulley::Secondary, 9000.0)
            };
            let mirrored = steady(&parameters, &task, pair(SPEED, SPEED / i)).outputs;
            let product = direct.thrust_ratio * mirrored.thrust_ratio;
            assert!((product - 1.0).abs() < 1e-6);
        }
    }
}

/// Driving and braking; reverse running is mirrored in the line of the axes.
#[test]
fn reverse_running_mirrors_the_steady_state() {
    for model in MODELS {
        let parameters = variator(model);
        for torque in [50.0, -30.0] {
            for case in LoadCase::three(&parameters, 50.0) {
                let [forward, reverse] = [1.0, -1.0].map(|sign| {
                    let (torque, speed) = (sign * torque, sign * SPEED);
                    transmitting(&parameters, ratio(case.theta), case.clamping, torque, speed).outputs
                });
                assert_mirrored(&reverse, &forward, 1e-6);
            }
        }
    }
}

/// The work of a steady state, so that a slower solver is detected without a clock.
#[test]
fn a_steady_state_takes_its_usual_work() {
    let parameters = variator(RingModel::Ale);
    let counts = load_case(&parameters, &LoadCase::new(&parameters, "medium", 0.0, 50.0)).counts;
    assert_pinned(counts.residuals, 695, "residuals");
    assert_pinned(counts.factorizations, 118, "factorizations");
}

/// The default mesh is chosen for some thousand revolutions per minute; at 600 rad/s in overdrive
/// gaps are wider.
#[test]
fn the_default_mesh_at_high_speed() {
    let at = |factor: i32| {
        let mut parameters = variator(RingModel::Ale);
        parameters.mesh = parameters.mesh.refined(factor);
        let case = LoadCase::new(&parameters, "overdrive", 0.4, 50.0);
        let state = transmitting(&parameters, ratio(0.4), 1.3 * case.clamping, 50.0, 600.0);
        state.outputs.thrust_ratio
    };
    let (default, fine) = (at(1), at(4));
    assert_close(default, fine, 0.025, "thrust ratio");
}

/// Forces in the middle of a strand.
struct Strand {
    at: [f64; 2],
    direction: [f64; 2],
    tension: f64,
    push: f64,
    /// Momentum per time of ring and elements, N.
    ring_momentum: f64,
    element_momentum: f64,
}

impl Strand {
    /// Of segment 1 (upper, from S to P) or 3.
    fn of(state: &Steady, segment: usize) -> Self {
        let p = &state.system.parameters;
        let free = |at: &&At| at.segment == segment && at.sample.normal < 1.0;
        let stations: Vec<Sample> = state.stations().iter().filter(free).map(|at| at.sample).collect();
        let inner = &stations[2..stations.len() - 2];
        let length: f64 = inner.iter().map(|s| s.weight).sum();
        let mean =
            |figure: fn(&Sample) -> f64| inner.iter().map(|s| figure(s) * s.weight).sum::<f64>() / length;
        let middle = stations.len() / 2;
        let (a, b) = (stations[middle - 3].r, stations[middle + 2].r);
        let chord = [b[0] - a[0], b[1] - a[1]];
        let tension = mean(|s| s.tension);
        let stretch = 1.0 + tension / p.ring.axial_stiffness;
        Self {
            at: stations[middle].r,
            direction: chord.map(|x| x / chord[0].hypot(chord[1])),
            tension,
            push: mean(|s| s.push),
            ring_momentum: p.ring.mass_per_length * state.outputs.ring_speed.powi(2) * stretch,
            element_momentum: p.belt.mass_per_length * mean(|s| s.density * s.flow) * mean(|s| s.speed),
        }
    }

    /// Moment about a pulley's axis of the strand's force less its momentum flow, N·m; that of the
    /// elements at the pitch line.
    fn moment(&self, axis: f64, pitch_offset: f64) -> f64 {
        let [x, y] = [self.at[0] - axis, self.at[1]];
        let lever = y * self.direction[0] - x * self.direction[1];
        (self.tension - self.ring_momentum) * lever
            - (self.push + self.element_momentum) * (lever - pitch_offset)
    }
}

/// Angular momentum: the difference of its flows in the two strands of a pulley is the torque on
/// the shaft. In contrast to the power balance, this depends on where friction between ring and
/// elements acts.
#[test]
fn strands_and_shafts_have_the_same_moments() {
    // The strands of ALE0 can't bend where contact begins.
    for (model, factor, allowed) in [
        (RingModel::Ale0, 1, 4e-3),
        (RingModel::Ale, 1, 1e-3),
        (RingModel::Ale, 2, 2e-4),
    ] {
        // With more layers, friction on the innermost has a couple that one speed leaves out.
        let mut parameters = belt_alone(variator(model));
        parameters.layers.count = 1;
        parameters.mesh = parameters.mesh.refined(factor);
        for torque in [50.0, -30.0] {
            for case in LoadCase::three(&parameters, 50.0) {
                let state = transmitting(&parameters, ratio(case.theta), case.clamping, torque, SPEED);
                let [upper, lower] = [1, 3].map(|segment| Strand::of(&state, segment));
                let o = &state.outputs;
                for (j, sign, pulley) in [
                    (Pulley::Secondary, 1.0, &o.secondary),
                    (Pulley::Primary, -1.0, &o.primary),
                ] {
                    let axis = state.system.belt.law.axes[j];
                    let [up, low] =
                        [&upper, &lower].map(|strand| strand.moment(axis, parameters.belt.pitch_offset));
                    let off = sign * (low - up) + pulley.shaft_torque;
                    let share = off / o.primary.shaft_torque.abs().max(o.secondary.shaft_torque.abs());
                    assert!(share.abs() < allowed, "{model:?} {}, {torque} N·m", case.name);
                }
            }
        }
    }
}

/// A search that runs out of work under soft friction leaves the specified one in force.
#[test]
fn a_failed_search_leaves_the_specified_friction() {
    let mut system = VariatorSystem::new(&Parameters::default());
    let clamping = pair(1.0e4, 1.3e4);
    let start = Start {
        ratio: 1.0,
        primary_speed: SPEED,
        clamping,
    };
    let mut state = kinematic_state(&system.belt, &start).unwrap();
    let mut newton = Newton::new(&system);
    newton.bound.remaining = 50.0;
    let task = SteadyTask {
        ratio: start.ratio,
        reaction: Pulley::Primary,
        clamping,
        shaft: Boundary::HELD.shaft,
        warm: false,
    };
    let mut solver = SteadySolver {
        system: &mut system,
        newton: &mut newton,
    };
    assert!(solver.solve(&mut state, &task).is_err());
    assert_eq!(system.friction_velocity, system.parameters.friction.velocity);
}
