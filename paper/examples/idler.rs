//! Another belt system with the same ring code: a steel belt around two pulleys and an idler that
//! presses on its back.
//!
//! `cargo run --release --package pushbelt-paper --example idler`
//!
//! Prints the geometry, the shape error of a running belt for each ring model (a string is in
//! equilibrium on any closed curve at EAγ = m ṡ²(1 + γ)), and the oscillation of a tensioner arm,
//! Θ, due to the bending energy of a belt.

use pushbelt::solver::sdirk::Sdirk;
use pushbelt_paper::reference_curve::ReferenceCurve;
use pushbelt_paper::ring::Ring;
use pushbelt_paper::ring::ale_ring::AleRing;
use pushbelt_paper::ring::ancf::Ancf;
use pushbelt_paper::ring::mesh::RingMesh;
use pushbelt_paper::ring::model::RingFormulation;
use pushbelt_paper::ring::rcm::Rcm;
use pushbelt_paper_lab::drive::{BeltDrive, DriveError, DrivePulley, Tensioner};
use pushbelt_paper_lab::{RingSystem, advance};
use std::error::Error;

/// Belt speed, m/s.
const SPEED: f64 = 40.0;

fn pulley(x: f64, y: f64, radius: f64) -> DrivePulley {
    DrivePulley {
        center: [x, y],
        radius,
    }
}

/// Clockwise: driver, driven, idler on the back of the lower strand.
fn drive() -> Result<BeltDrive<3>, DriveError> {
    BeltDrive::new([
        pulley(0.0, 0.0, 0.04),
        pulley(0.25, 0.02, 0.06),
        pulley(0.12, -0.03, -0.02),
    ])
}

/// Driver, idler inside the upper strand on an upright arm, driven.
fn tensioned() -> Result<BeltDrive<3>, DriveError> {
    BeltDrive::new([pulley(0.0, 0.0, 0.05), pulley(0.13, 0.1, 0.02), pulley(0.26, 0.0, 0.05)])?
        .with_tensioner(Tensioner {
            pulley: 1,
            pivot: [0.13, -0.05],
        })
}

/// Steel, 0.185 mm × 9.5 mm, without bending stiffness if `string`.
fn belt(string: bool) -> Ring {
    let (e, rho, width, thickness) = (2.1e11, 7800.0, 9.5e-3, 0.185e-3_f64);
    let bending = e * width * thickness.powi(3) / 12.0;
    Ring {
        mass_per_length: rho * thickness * width,
        axial_stiffness: e * thickness * width,
        bending_stiffness: if string { 0.0 } else { bending },
        lateral_bending_stiffness: 0.0,
        damping: 0.0,
    }
}

/// Runs a string through half the drive and prints the change of its shape.
fn run<M: RingFormulation>(name: &str, model: M, drive: &BeltDrive<3>) -> Result<(), Box<dyn Error>> {
    let mut system = RingSystem::new(model);
    system.tolerance = 1.0e-7;
    let ring = system.model.ring().clone();
    let pull = ring.mass_per_length * SPEED * SPEED;
    let stretch = 1.0 + pull / (ring.axial_stiffness - pull);
    let frame = drive.frame::<f64>(0.0);
    let at = |xi: f64| drive.at(&frame, xi);
    let mut state = system.rest_on(0.0, &|xi| [at(xi).r * stretch, at(xi).t * stretch]);
    system.set_in_motion(&mut state, |xi| at(xi).t * (SPEED * stretch))?;
    let mut integrator = Sdirk::new(&system, 1.0e-6, 1.0e-3);
    let time = 0.5 * drive.length() / SPEED;
    advance(&mut integrator, &mut system, &mut state, [0.0, time])?;
    let off = (0..200)
        .map(|k| drive.length() * f64::from(k) / 200.0)
        .map(|xi| (system.particle_at(state.view(), xi).r - at(xi).r * stretch).norm())
        .fold(0.0, f64::max);
    println!(
        "{name:>4}: {:3} elements, tension {:.2} N, off its shape by {:.1e} m after {:.1} ms in {} steps",
        system.model.elements(),
        ring.axial_stiffness * (stretch - 1.0),
        off,
        1.0e3 * time,
        integrator.newton.counts.steps
    );
    Ok(())
}

/// Prints the period of an oscillation of the arm.
fn swing(drive: BeltDrive<3>) -> Result<(), Box<dyn Error>> {
    let mesh = RingMesh::even(&[2, 3, 2, 3, 2, 4, 2], 3);
    let mut system = RingSystem::new(AleRing::rigid(belt(false), drive, mesh));
    system.tolerance = 1.0e-8;
    let theta = system.theta();
    let mut state = system.rest(0.0);
    state.y[theta] = 0.1;
    let start = system.energy(state.view());
    let mut integrator = Sdirk::new(&system, 1.0e-4, 1.0e-1);
    let (mut crossings, mut drift, mut t) = (Vec::new(), 0.0_f64, 0.0);
    let step = 2.0e-3;
    while crossings.len() < 2 && t < 60.0 {
        let before = state.q[theta];
        advance(&mut integrator, &mut system, &mut state, [t, t + step])?;
        let now = state.q[theta];
        if before * now < 0.0 {
            crossings.push(t + step * before / (before - now));
        }
        drift = drift.max((system.energy(state.view()).total() - start.total()).abs() / start.kinetic);
        t += step;
    }
    let [first, second] = crossings[..] else {
        return Err("the arm does not swing".into());
    };
    println!(
        "arm: swings about Θ = 0 with {:.2} Hz, energy drift {drift:.1e} of its kinetic energy",
        0.5 / (second - first)
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let drive = drive()?;
    let frame = drive.frame::<f64>(0.0);
    println!("belt {:.4} m", drive.length());
    for segment in 0..drive.segments() {
        let point = BeltDrive::<3>::point::<f64>(&frame, segment, 0.5);
        let length = BeltDrive::<3>::segment_length(&frame, segment).v;
        let kind = if point.kappa == 0.0 { "strand" } else { "arc" };
        let turn = (point.kappa * length).to_degrees();
        println!("{kind:>6} {:7.2} mm, turns {turn:7.2}°", 1.0e3 * length);
    }
    let ring = belt(true);
    let mesh = RingMesh::even(&[4, 6, 8, 4, 3, 4, 3], 3);
    run("ALE", AleRing::flexible(ring.clone(), drive.clone(), mesh), &drive)?;
    run("RCM", Rcm::new(ring.clone(), drive.clone(), 64, 5), &drive)?;
    run("ANCF", Ancf::new(ring, drive.clone(), 64, 3), &drive)?;
    swing(tensioned()?)
}
