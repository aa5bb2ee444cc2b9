//! The ring in space: a deflection w along z, the binormal of the drive, in addition to that in the
//! plane.

use nalgebra::{Complex, DMatrix, Rotation3, Vector2, Vector3};
use pushbelt::scalar::Dual;
use pushbelt::solver::State;
use pushbelt::solver::sdirk::Sdirk;
use pushbelt_paper::reference_curve::{ReferenceCurve, TwoPulley};
use pushbelt_paper::ring::Ring;
use pushbelt_paper::ring::ale_ring::{AleRing, OverlayDirections};
use pushbelt_paper::ring::kinematics::Motion;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper::ring::model::RingFormulation;
use pushbelt_paper_lab::*;
use pushbelt_support::checks::{assert_order, list};
use pushbelt_support::noise;
use std::f64::consts::{PI, TAU};

type Spatial<C> = RingSystem<AleRing<C, 3>, 3, 14>;

fn drive() -> TwoPulley {
    TwoPulley::new(0.168, 0.703)
}

/// Places of w and w' of the two nodes among an element's unknowns.
const LATERAL: [usize; 4] = [4, 5, 10, 11];

/// Stiffness, gyroscopic and mass matrix of small deflections w, w' of the nodes of a straight
/// strand of `count` elements and length 0.168 m, with the strain `strain` and the speed `speed`.
/// Exact derivatives of the ring's balance.
fn strand(ring: &Ring, count: usize, strain: f64, speed: f64) -> [DMatrix<f64>; 3] {
    let model = AleRing::spatial(ring.clone(), drive(), RingMesh::even(&[1, count, 2, count, 1], 4));
    let frame = model.curve.frame(Dual::from(0.0));
    let still = Motion {
        value: Dual::from(0.0),
        rate: Dual::from(0.0),
        acceleration: Dual::from(0.0),
    };
    let length = 0.168 / count as f64;
    let size = 2 * (count + 1);
    let mut matrices = [0, 1, 2].map(|_| DMatrix::zeros(size, size));
    for k in 0..count {
        // At ratio 1 the upper strand runs along x.
        let mut motion = [still; 14];
        motion[0].value = Dual::from(strain * length * k as f64);
        motion[6].value = Dual::from(strain * length * (k + 1) as f64);
        (motion[1].value, motion[7].value) = (Dual::from(strain), Dual::from(strain));
        motion[12].rate = Dual::from(speed);
        for (j, column) in LATERAL.into_iter().enumerate() {
            for (order, matrix) in matrices.iter_mut().enumerate() {
                let mut moved = motion;
                let unknown = &mut moved[column];
                [&mut unknown.value, &mut unknown.rate, &mut unknown.acceleration][order].eps = [1.0];
                let rows = model.balance(&frame, 1 + k, &moved);
                for (i, row) in LATERAL.into_iter().enumerate() {
                    matrix[(2 * k + i, 2 * k + j)] += rows[row].eps[0];
                }
            }
        }
    }
    matrices
}

/// Without the unknowns `gone`.
fn without(matrix: &DMatrix<f64>, gone: &[usize]) -> DMatrix<f64> {
    matrix.clone().remove_rows_at(gone).remove_columns_at(gone)
}

/// A wire: 200 N at a stretch of 1e-3.
fn wire(stiffness: f64) -> Ring {
    Ring {
        mass_per_length: 0.05,
        axial_stiffness: 2.0e5,
        bending_stiffness: stiffness,
        lateral_bending_stiffness: stiffness,
        damping: 0.0,
    }
}

const STRAIN: f64 = 1.0e-3;
const LENGTH: f64 = 0.168;

/// EAγ/(1 + γ): stiffness against w' per unstretched length, N.
fn pull(ring: &Ring) -> f64 {
    ring.axial_stiffness * STRAIN / (1.0 + STRAIN)
}

/// A strand between two parallel guides with the offset a: EI w'''' = N w'' has the solution
/// w = a/2 + A y − B sinh ky, k = √(N/EI), y from the middle: a straight line with boundary layers
/// of width 1/k.
#[test]
fn offset_guides() {
    for layers in [2.0, 20.0] {
        let mut ring = wire(0.0);
        let k = layers / LENGTH;
        ring.lateral_bending_stiffness = pull(&ring) / (k * k);
        let offset = 1.0e-3;
        let (sinh, cosh) = ((0.5 * k * LENGTH).sinh(), (0.5 * k * LENGTH).cosh());
        let b = 0.5 * offset / (0.5 * k * LENGTH * cosh - sinh);
        let exact = |x: f64| {
            let y = x - 0.5 * LENGTH;
            0.5 * offset + b * k * cosh * y - b * (k * y).sinh()
        };
        let errors = [8, 16, 32].map(|count: usize| {
            let [stiffness, _, _] = strand(&ring, count, STRAIN, 0.0);
            let ends = [0, 1, 2 * count, 2 * count + 1];
            let load = (stiffness.column(2 * count) * -offset).remove_rows_at(&ends);
            let w = without(&stiffness, &ends).lu().solve(&load).expect("a held strand");
            (1..count)
                .map(|i| (w[2 * (i - 1)] - exact(LENGTH * i as f64 / count as f64)).abs() / offset)
                .fold(0.0, f64::max)
        });
        println!("kL = {layers}: errors {}", list(&errors));
        assert!(errors.windows(2).all(|e| e[1] < 0.2 * e[0] || e[1] < 1e-9) && errors[2] < 1e-5);
    }
}

/// Angular frequencies of a strand that runs through two eyes (w = 0, slope free), in ascending
/// order, rad/s.
fn frequencies(ring: &Ring, count: usize, speed: f64) -> Vec<f64> {
    let [stiffness, gyroscopic, mass] =
        strand(ring, count, STRAIN, speed).map(|m| without(&m, &[0, 2 * count]));
    let n = stiffness.nrows();
    let inverse = mass.try_inverse().expect("a strand with mass");
    // In a unit of time for which the entries have similar size.
    let unit = (&inverse * &stiffness).amax().sqrt();
    let mut companion = DMatrix::zeros(2 * n, 2 * n);
    companion.view_mut((0, n), (n, n)).fill_with_identity();
    companion
        .view_mut((n, 0), (n, n))
        .copy_from(&(&inverse * stiffness * (-1.0 / (unit * unit))));
    companion
        .view_mut((n, n), (n, n))
        .copy_from(&(&inverse * gyroscopic * (-1.0 / unit)));
    let values: Vec<Complex<f64>> = companion.complex_eigenvalues().iter().copied().collect();
    let largest = values.iter().map(|value| value.im).fold(0.0, f64::max);
    let gain = values.iter().map(|value| value.re.abs()).fold(0.0, f64::max);
    assert!(
        gain < 1e-6 * largest,
        "the strand neither gains nor loses: {gain} of {largest}"
    );
    let mut found: Vec<f64> = values
        .iter()
        .map(|value| value.im * unit)
        .filter(|&im| im > 0.0)
        .collect();
    found.sort_by(f64::total_cmp);
    found
}

/// A string that runs at v through two eyes: ω_n = nπ(c² − v²)/(cL), c = √(N/m). Convection lowers
/// all frequencies.
#[test]
fn travelling_string() {
    let ring = wire(0.0);
    let c = (pull(&ring) / ring.mass_per_length).sqrt();
    for share in [0.0, 0.3, 0.6, 0.9] {
        let found = frequencies(&ring, 16, share * c);
        let off: Vec<f64> = (1..=3)
            .map(|n| found[n - 1] / (n as f64 * PI * c * (1.0 - share * share) / LENGTH) - 1.0)
            .collect();
        println!("v = {share} c: off by {}", list(&off));
        assert!(off.iter().all(|off| off.abs() < 1e-4));
    }
}

/// A tensioned beam in two eyes at rest: m ω² = N k² + EI k⁴, k = nπ/L; of order 4 in the element
/// length at fixed tension.
#[test]
fn tensioned_beam() {
    let ring = wire(0.3);
    let k = 2.0 * PI / LENGTH;
    let exact = ((pull(&ring) + ring.lateral_bending_stiffness * k * k) / ring.mass_per_length).sqrt() * k;
    let errors = [4, 8, 16].map(|count| (frequencies(&ring, count, 0.0)[1] / exact - 1.0).abs());
    assert_order("second frequency of a tensioned beam", &errors, 4.0);
}

/// A running beam buckles where m v² = N + EI(π/L)².
#[test]
fn critical_speed() {
    for stiffness in [0.0, 0.3] {
        let ring = wire(stiffness);
        let critical = ((pull(&ring) + stiffness * (PI / LENGTH).powi(2)) / ring.mass_per_length).sqrt();
        let softest = |speed: f64| {
            let [stiffness, _, _] = strand(&ring, 16, STRAIN, speed);
            let stiffness = without(&stiffness, &[0, 32]);
            let asymmetry = (&stiffness - stiffness.transpose()).amax();
            assert!(asymmetry < 1e-9 * stiffness.amax());
            stiffness.symmetric_eigenvalues().min()
        };
        let around = [0.999 * critical, 1.001 * critical].map(softest);
        println!("EI {stiffness}: v = {critical:.2} m/s, softest mode {}", list(&around));
        assert!(around[0] > 0.0 && around[1] < 0.0);
    }
}

fn circle(elements: usize, ring: Ring) -> Spatial<pushbelt_paper_lab::Circle> {
    RingSystem::new(AleRing::spatial(ring, band_circle(), RingMesh::even(&[elements], 4)))
}

/// A ring of 40 elements on its circle after a rigid motion.
fn placed(system: &Spatial<pushbelt_paper_lab::Circle>, turn: &Rotation3<f64>, shift: Vector3<f64>) -> State {
    let curve = band_circle();
    let frame = curve.frame::<f64>(0.0);
    let space = |v: Vector2<f64>| turn * Vector3::new(v.x, v.y, 0.0);
    system.rest_on(0.0, &|xi| {
        let point = curve.at(&frame, xi);
        [space(point.r) + shift, space(point.t)]
    })
}

/// A shift along z has no energy and no force. A tilt has the energy ½π EI_b ψ²/R, because (24) has
/// no twist: the sections stay upright. Neither changes stretch and in-plane bending.
#[test]
fn rigid_motions() {
    let ring = band(0.185e-3);
    let radius = BAND_LENGTH / TAU;
    let mut system = circle(40, ring.clone());
    let here = placed(&system, &Rotation3::identity(), Vector3::zeros());
    let energy = |system: &Spatial<_>, state: &State| system.energy(state.view());
    let start = energy(&system, &here);
    let shifted = placed(&system, &Rotation3::identity(), Vector3::z() * 0.05);
    let after = energy(&system, &shifted);
    assert!((after.total() - start.total()).abs() < 1e-12 * start.total());
    let force = residual(&mut system, shifted.view()) - residual(&mut system, here.view());
    assert!(force.amax() < 1e-9 * start.total() / radius);
    for angle in [1.0e-3, 1.0e-2] {
        let turn = Rotation3::from_axis_angle(&Vector3::y_axis(), angle);
        let tilted = energy(&system, &placed(&system, &turn, Vector3::zeros()));
        let expected = 0.5 * PI * ring.lateral_bending_stiffness * angle * angle / radius;
        println!(
            "tilt {angle}: bending {:.4e} J, expected {expected:.4e}, membrane {:.1e}",
            tilted.bending - start.bending,
            tilted.membrane - start.membrane
        );
        assert!(((tilted.bending - start.bending) / expected - 1.0).abs() < 1e-3);
        assert!((tilted.membrane - start.membrane).abs() < 1e-3 * expected);
        let mut limp = system.clone();
        limp.model.ring.lateral_bending_stiffness = 0.0;
        let limp = energy(&limp, &placed(&limp, &turn, Vector3::zeros()));
        assert!((limp.total() - start.total()).abs() < 1e-3 * expected);
    }
}

/// A free ring out of its plane. With upright sections w bends like a straight beam, ω = n²
/// √(EI_b/m)/R². A thin band that is free to twist has ω² = EI_b/(m R⁴) n²(n² − 1)²/(n² + EI_b/GJ)
/// (Love 1927, § 293), which (24) does not describe: it is valid for a stocky section that is held
/// upright.
#[test]
fn frequency_out_of_plane() {
    let ring = Ring {
        axial_stiffness: 2.0e5,
        ..band(0.185e-3)
    };
    let radius = BAND_LENGTH / TAU;
    let exact = 4.0 * (ring.lateral_bending_stiffness / ring.mass_per_length).sqrt() / (radius * radius);
    let errors = [10, 20, 40].map(|elements| {
        let system = circle(elements, ring.clone());
        let rest = system.rest(0.0);
        let mut lateral = system.clone();
        // In-plane motion has its own tests.
        lateral.held = (0..elements)
            .flat_map(|i| (0..4).map(move |k| (i, k)))
            .map(|(i, k)| system.node(i, k))
            .collect();
        lateral.held.extend([system.drift(), system.theta()]);
        (mode(&lateral, &rest, 1.001 * exact).omega / exact - 1.0).abs()
    });
    assert_order("n = 2 out of the plane", &errors, 4.0);
}

/// Without motion out of the plane the results are those of the planar ring.
#[test]
fn planar_motion_is_the_planar_rings() {
    for directions in [OverlayDirections::Fixed, OverlayDirections::Reference] {
        let mesh = || RingMesh::even(&[1, 2, 3, 2, 1], 3);
        let mut flat = AleRing::flexible(solid(), solid_curve(), mesh());
        let mut spatial = AleRing::spatial(solid(), solid_curve(), mesh());
        (flat.directions, spatial.directions) = (directions, directions);
        let (mut flat, mut spatial) = (RingSystem::new(flat), RingSystem::new(spatial));
        let (mut state, mut lifted) = (flat.rest(0.25), spatial.rest(0.25));
        let mut random = noise(3);
        let mut places = Vec::new();
        for node in 0..flat.model.mesh.elements.len() {
            places.extend((0..4).map(|k| (flat.node(node, k), spatial.node(node, k))));
        }
        places.extend([(flat.drift(), spatial.drift()), (flat.theta(), spatial.theta())]);
        for &(i, j) in &places {
            state.q[i] += 1.0e-3 * random();
            state.y[i] = random();
            state.y_dot[i] = 100.0 * random();
            (lifted.q[j], lifted.y[j], lifted.y_dot[j]) = (state.q[i], state.y[i], state.y_dot[i]);
        }
        let (planar, mut rows) = (residual(&mut flat, state.view()), residual(&mut spatial, lifted.view()));
        for &(i, j) in &places {
            assert_eq!(planar[i], rows[j]);
            rows[j] = 0.0;
        }
        assert_eq!(rows.amax(), 0.0);
    }
}

/// A belt that runs, shifts its ratio and oscillates out of its plane: largest drift of the energy,
/// with the energy that damping dissipated, relative to the exchanged energy.
fn swinging(damping: f64, tolerance: f64) -> (f64, f64) {
    let ring = Ring { damping, ..solid() };
    let mut system = RingSystem::new(AleRing::spatial(
        ring,
        solid_curve(),
        RingMesh::even(&[1, 2, 2, 2, 1], 3),
    ));
    system.tolerance = tolerance;
    let mut state = system.rest(0.2);
    system
        .set_in_motion(&mut state, |xi| {
            let (sin, cos) = (TAU * xi).sin_cos();
            let point = solid_curve().at(&solid_curve().frame::<f64>(0.2), xi);
            Vector3::new(30.0 * point.t.x, 30.0 * point.t.y, 12.0 * cos + 5.0 * (2.0 * sin * cos))
        })
        .expect("a ring with mass");
    let start = system.energy(state.view());
    let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-3);
    let (mut drift, mut most) = (0.0_f64, 0.0_f64);
    for k in 0..6 {
        let t = f64::from(k) * 1.0e-4;
        run(&mut system, &mut integrator, &mut state, t, t + 1.0e-4);
        let energy = system.energy(state.view());
        drift = drift.max((energy.total() + system.dissipated - start.total()).abs() / start.kinetic);
        for node in 0..system.model.mesh.elements.len() {
            most = most.max(state.q[system.node(node, 4)].abs());
        }
    }
    println!(
        "damping {damping}, tolerance {tolerance:.0e}: w up to {most:.2e} m, lost {:.2e}, drift {drift:.2e}, {:?}",
        system.dissipated / start.kinetic,
        integrator.newton.counts
    );
    assert!(most > 1e-3);
    (drift, system.dissipated / start.kinetic)
}

/// Power balance in space: only damping dissipates.
#[test]
fn energy_out_of_plane() {
    for damping in [0.0, 1.0e-5] {
        let runs = [1.0e-6, 1.0e-7, 1.0e-8].map(|tolerance| swinging(damping, tolerance));
        assert!(
            runs[2].0 < 3e-4 && runs.windows(2).all(|r| r[1].0 < 0.5 * r[0].0),
            "{runs:?}"
        );
        assert!((runs[2].1 > 1e-3) == (damping > 0.0));
    }
}
