//! Another belt system with the same ring code: three pulleys, one of them a back-side idler (paper
//! section 7).

use pushbelt::solver::sdirk::Sdirk;
use pushbelt_paper::reference_curve::ReferenceCurve;
use pushbelt_paper::ring::Ring;
use pushbelt_paper::ring::ale_ring::AleRing;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper::ring::model::RingFormulation;
use pushbelt_paper_lab::drive::{BeltDrive, DrivePulley, Tensioner};
use pushbelt_paper_lab::*;

fn pulley(x: f64, y: f64, radius: f64) -> DrivePulley {
    DrivePulley {
        center: [x, y],
        radius,
    }
}

/// An idler on the back of the lower strand.
fn fixed() -> BeltDrive<3> {
    BeltDrive::new([
        pulley(0.0, 0.0, 0.04),
        pulley(0.25, 0.02, 0.06),
        pulley(0.12, -0.05, -0.02),
    ])
    .expect("a belt runs around them")
}

/// An idler inside the upper strand, on an upright arm.
fn tensioned() -> BeltDrive<3> {
    BeltDrive::new([pulley(0.0, 0.0, 0.05), pulley(0.13, 0.1, 0.02), pulley(0.26, 0.0, 0.05)])
        .and_then(|drive| {
            drive.with_tensioner(Tensioner {
                pulley: 1,
                pivot: [0.13, -0.05],
            })
        })
        .expect("the arm can move")
}

/// Arcs and strands in the order of the curve: arc, strand, arc, strand, arc, strand, arc.
fn mesh(refinement: usize, points: usize) -> RingMesh {
    RingMesh::even(&[2, 3, 2, 3, 2, 4, 2].map(|n| n * refinement), points)
}

/// A ring soft enough for differences.
fn soft() -> Ring {
    Ring {
        mass_per_length: 0.24,
        axial_stiffness: 5.57e3,
        bending_stiffness: 0.5,
        lateral_bending_stiffness: 0.5,
        damping: 0.0,
    }
}

/// Force and inertia on a drive whose arm moves: gradient of V, differences of M.
#[test]
fn the_laws_hold() {
    for mut system in [
        RingSystem::new(AleRing::flexible(soft(), tensioned(), mesh(1, 3))),
        RingSystem::new(AleRing::rigid(soft(), tensioned(), mesh(1, 3))),
    ] {
        system.held.clear();
        let rest = system.rest(0.1);
        let force = residual(&mut system, rest.view());
        let h = 1.0e-7;
        for i in 0..rest.q.len() {
            let energy = |h: f64| {
                let mut moved = rest.clone();
                moved.q[i] += h;
                system.energy(moved.view()).total()
            };
            let difference = (energy(h) - energy(-h)) / (2.0 * h);
            assert!(
                (force[i] - difference).abs() < 1e-6 * force.amax(),
                "{i}: {} {difference}",
                force[i]
            );
        }
        system.model.ring = without_stiffness(&system.model.ring);
        let mut state = rest;
        let (s, theta) = (system.drift(), system.theta());
        (state.y[s], state.y[theta]) = (3.0, 5.0);
        (state.y_dot[s], state.y_dot[theta]) = (70.0, -40.0);
        let off = residual(&mut system, state.view()) - inertia_by_differences(&system, &state);
        let scale = residual(&mut system, state.view()).amax();
        assert!(off.amax() < 1e-7 * scale, "{} of {scale}", off.amax());
    }
}

/// The bending energy is least with the arm upright. The arm oscillates about this position and
/// conserves the energy.
#[test]
fn the_arm_oscillates() {
    let mut system = RingSystem::new(AleRing::rigid(solid(), tensioned(), mesh(1, 3)));
    system.tolerance = 1.0e-8;
    assert_eq!(system.degrees_of_freedom(), 2);
    let (s, theta) = (system.drift(), system.theta());
    let mut state = system.rest(0.0);
    state.y[theta] = 200.0;
    let start = system.energy(state.view());
    let mut integrator = Sdirk::new(&system, 1.0e-5, 1.0e-3);
    let (mut drift, mut low, mut high) = (0.0_f64, 0.0_f64, 0.0_f64);
    for k in 0..200 {
        let t = f64::from(k) * 5.0e-5;
        run(&mut system, &mut integrator, &mut state, t, t + 5.0e-5);
        drift = drift.max((system.energy(state.view()).total() - start.total()).abs() / start.kinetic);
        (low, high) = (low.min(state.q[theta]), high.max(state.q[theta]));
    }
    println!(
        "Θ from {low:.3} to {high:.3}, s = {:.1e} m, energy drift {drift:.1e} of the first kinetic energy",
        state.q[s]
    );
    assert!(drift < 1e-3 && (low + high).abs() < 0.02 * high && high < 0.3);
}

/// A running string is in equilibrium on every closed curve if EAγ = m ṡ²(1 + γ), also on one with
/// a back bend.
#[test]
fn a_running_string_keeps_any_shape() {
    let ring = Ring {
        bending_stiffness: 0.0,
        ..band(0.185e-3)
    };
    let curve = fixed();
    let speed = 100.0;
    let pull = ring.mass_per_length * speed * speed;
    let gamma = pull / (ring.axial_stiffness - pull);
    let frame = curve.frame::<f64>(0.0);
    let turn = curve.length() / speed;
    let errors = [1, 2, 4].map(|refinement| {
        let mut system = RingSystem::new(AleRing::flexible(ring.clone(), curve.clone(), mesh(refinement, 3)));
        let place = |xi: f64| curve.at(&frame, xi);
        let mut state = system.rest_on(0.0, &|xi| [place(xi).r * (1.0 + gamma), place(xi).t * (1.0 + gamma)]);
        let s = system.drift();
        state.y[s] = speed;
        let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-3);
        run(&mut system, &mut integrator, &mut state, 0.0, 0.1 * turn);
        let off = (0..200)
            .map(|k| {
                let xi = curve.length() * f64::from(k) / 200.0;
                (system.particle_at(state.view(), xi).r - place(xi).r * (1.0 + gamma)).norm()
            })
            .fold(0.0, f64::max);
        println!(
            "{} elements: off by {off:.1e} m, {:?}",
            system.model.elements(),
            integrator.newton.counts
        );
        off
    });
    assert!(
        errors[2] < 1e-5 && errors.windows(2).all(|e| e[1] < 0.3 * e[0]),
        "{errors:?}"
    );
}
