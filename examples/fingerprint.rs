//! A hash of every output bit of the manoeuvre, for each ring: what moves code and nothing else keeps it.
//!
//! `cargo run --release --example fingerprint` prints a line a run: the case, the hash (64-bit FNV-1a over the bits of
//! all figures after every step, the profile at the end), and the work that it took. Two builds for one kind of processor
//! agree in every bit or they calculate differently.

use std::error::Error;

use pushbelt::variator::instance::Variator;
use pushbelt::variator::parameters::{Parameters, RingModel};
use pushbelt::variator::signals::{Inputs, Outputs, Profile, PulleyOutputs};

/// The manoeuvre that the FMU carries: time, torques and clamping forces.
const MANOEUVRE: &str = include_str!("../resources/manoeuvre.csv");
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

/// Torques and clamping forces every millisecond.
fn inputs() -> Result<Vec<Inputs>, Box<dyn Error>> {
    let mut lines = MANOEUVRE.lines().filter(|line| !line.starts_with('#'));
    let names: Vec<&str> = lines.next().ok_or("an empty manoeuvre")?.split(',').collect();
    let column = |name: &str| {
        let found = names.iter().position(|n| n.trim().trim_matches('"') == name);
        found.ok_or_else(|| format!("no column {name}"))
    };
    let [time, tp, ts, fp, fs] = [
        column("time")?,
        column("primary.torque")?,
        column("secondary.torque")?,
        column("primary.clampingForce")?,
        column("secondary.clampingForce")?,
    ];
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|word| word.trim().parse()).collect())
        .collect::<Result<_, _>>()?;
    let end = rows.last().ok_or("no rows")?[time];
    let count = (end / STEP).round() as usize;
    let mut row = 0;
    Ok((0..count)
        .map(|k| {
            let t = k as f64 * STEP;
            while row + 2 < rows.len() && rows[row + 1][time] <= t {
                row += 1;
            }
            let (a, b) = (&rows[row], &rows[row + 1]);
            let share = ((t - a[time]) / (b[time] - a[time])).clamp(0.0, 1.0);
            let at = |column: usize| a[column] + share * (b[column] - a[column]);
            let mut inputs = Inputs::default();
            (inputs.primary.torque, inputs.secondary.torque) = (at(tp), at(ts));
            (inputs.primary.clamping_force, inputs.secondary.clamping_force) = (at(fp), at(fs));
            inputs
        })
        .collect())
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
    let trace = inputs()?;
    let with = |change: &dyn Fn(&mut Parameters)| {
        let mut parameters = Parameters::default();
        change(&mut parameters);
        parameters
    };
    // A vehicle's inertia on the secondary shaft, at a standstill in underdrive: what the manoeuvre is made for.
    let launch = |model: RingModel| {
        with(&|p| {
            p.ring_model = model;
            p.secondary.inertia = 4.0;
            (p.initial.ratio, p.initial.primary_speed) = (2.2, 0.0);
        })
    };
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
