//! A hash of every output bit of the manoeuvre, for each ring: what moves code and nothing else keeps it.
//!
//! `cargo run --release --example fingerprint` prints a line a run: the case, the hash (64-bit FNV-1a over the bits of
//! all figures after every step, the profile at the end), and the work that it took. Two builds for one kind of processor
//! agree in every bit or they calculate differently.

use std::error::Error;

use pushbelt::variator::instance::Variator;
use pushbelt::variator::parameters::{Parameters, RingModel};
use pushbelt::variator::signals::{Inputs, Outputs, Profile, PulleyOutputs};
use pushbelt_lab::manoeuvre::Manoeuvre;

/// Communication step, s.
const STEP: f64 = 1e-3;

/// 64-bit FNV-1a.
struct Hash(u64);

impl Hash {
    fn add(&mut self, value: f64) {
        for byte in value.to_bits().to_le_bytes() {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    fn add_outputs(&mut self, o: &Outputs) {
        for pulley in [&o.primary, &o.secondary] {
            let PulleyOutputs {
                speed,
                radius,
                position,
                axial_force,
                shaft_torque,
                external_torque,
                power,
                spiral,
            } = *pulley;
            for value in [
                speed,
                radius,
                position,
                axial_force,
                shaft_torque,
                external_torque,
                power,
                spiral,
            ] {
                self.add(value);
            }
        }
        for value in [
            o.thrust_ratio,
            o.belt_speed,
            o.ring_speed,
            o.ratio_speed,
            o.ratio_geometric,
            o.reference_theta,
            o.slip,
            o.losses.sheaves,
            o.losses.ring,
            o.losses.other,
            o.efficiency,
            o.torque_utilisation,
            f64::from(u8::from(o.macro_slip)),
            o.push_force_max,
            o.ring_tension_max,
            o.ring_tension_min,
            o.misalignment,
            o.lateral_max,
            o.skew,
            o.stored_energy,
            o.energy_residual,
        ] {
            self.add(value);
        }
    }

    fn add_profile(&mut self, p: &Profile) {
        for field in [
            &p.push_force,
            &p.ring_tension,
            &p.normal_force,
            &p.radial_deviation,
            &p.sliding_speed,
            &p.lateral_deflection,
        ] {
            field.iter().for_each(|&value| self.add(value));
        }
    }
}

/// Runs `steps` of the manoeuvre and prints the line of the case.
fn run(name: &str, parameters: Parameters, trace: &[Inputs], steps: usize) -> Result<(), Box<dyn Error>> {
    let mut hash = Hash(0xcbf2_9ce4_8422_2325);
    let mut variator = Variator::new(parameters)?;
    variator.initialise(0.0, &trace[0])?;
    hash.add_outputs(variator.outputs());
    for (k, inputs) in trace.iter().take(steps).enumerate() {
        variator.advance((k + 1) as f64 * STEP, inputs)?;
        hash.add_outputs(variator.outputs());
    }
    hash.add_profile(variator.profile());
    println!("{name:<34} {:016x}  {:?}", hash.0, variator.counts());
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let trace = Manoeuvre::read().trace(STEP);
    let with = |change: &dyn Fn(&mut Parameters)| {
        let mut parameters = Parameters::default();
        change(&mut parameters);
        parameters
    };
    let launch = |model: RingModel| Manoeuvre::variator(with(&|p| p.ring_model = model));
    let all = trace.len();
    run("ALE", launch(RingModel::Ale), &trace, all)?;
    run(
        "ALE, one cell an element",
        with(&|p| p.mesh.cells_per_element = 1),
        &trace,
        all / 5,
    )?;
    run("ALE0", launch(RingModel::Ale0), &trace, all)?;
    run(
        "ALE in space",
        with(&|p| (p.spatial, p.geometry.pulley_offset) = (true, 5e-4)),
        &trace,
        1000,
    )?;
    run(
        "ALE in directions of the curve",
        with(&|p| p.reference_directions = true),
        &trace,
        500,
    )?;
    run("ALE on even elements", with(&|p| p.mesh.aligned = false), &trace, 500)?;
    run(
        "ALE0 on even elements",
        with(&|p| (p.ring_model, p.mesh.aligned) = (RingModel::Ale0, false)),
        &trace,
        500,
    )?;
    run("RCM", with(&|p| p.ring_model = RingModel::Rcm), &trace, 30)?;
    run("ANCF", with(&|p| p.ring_model = RingModel::Ancf), &trace, 30)?;
    Ok(())
}
