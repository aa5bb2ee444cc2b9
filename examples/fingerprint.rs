//! A hash of every output bit of the manoeuvre, for each ring: what moves code and nothing else keeps it.
//!
//! `cargo run --release --example fingerprint` prints a line a run: the case, the hash (64-bit FNV-1a over the bits of
//! all figures after every step, the profile at the end), and the work that it took. Two builds for one kind of processor
//! agree in every bit or they calculate differently.
//!
//! `-- --write FILE` keeps all figures, and `-- --compare FILE` says by how much they differ from those of another build, as
//! a share of the range that each figure has in its case.

use std::error::Error;

use pushbelt::variator::Variator;
use pushbelt::variator::settings::{Inputs, Outputs, Parameters, Profile, PulleyOutputs, RingModel};
use pushbelt_lab::manoeuvre::Manoeuvre;

/// Communication step, s.
const STEP: f64 = 1e-3;

/// Figures of a run, one row a step.
#[derive(Default)]
struct Figures(Vec<Vec<f64>>);

impl Figures {
    /// 64-bit FNV-1a over all bits.
    fn hash(&self) -> u64 {
        let bytes = self.0.iter().flatten().flat_map(|value| value.to_bits().to_le_bytes());
        bytes.fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3)
        })
    }

    fn add(&mut self, value: f64) {
        if let Some(row) = self.0.last_mut() {
            row.push(value);
        }
    }

    /// Largest difference from the figures of another build, as a share of the range of the figure in this run.
    fn difference(&self, other: &[Vec<f64>]) -> f64 {
        let columns = self.0.first().map_or(0, Vec::len);
        let of_column = |k: usize| {
            let values = || self.0.iter().filter_map(move |row| row.get(k));
            let (low, high) = values().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
                (low.min(*x), high.max(*x))
            });
            // A figure that stays what it is differs by a share of its size.
            let range = (high - low).max(1e-3 * high.abs().max(low.abs())).max(1e-12);
            let off = values()
                .zip(other.iter().filter_map(|row| row.get(k)))
                .map(|(a, b)| (a - b).abs());
            off.fold(0.0, f64::max) / range
        };
        (0..columns).map(of_column).fold(0.0, f64::max)
    }

    fn add_outputs(&mut self, o: &Outputs) {
        self.0.push(Vec::new());
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
                tilt,
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
                tilt,
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
            o.belt_efficiency,
            o.losses.layers,
            o.losses.shafts,
        ] {
            self.add(value);
        }
    }

    fn add_profile(&mut self, p: &Profile) {
        self.0.push(Vec::new());
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

/// All cases of a build: name and figures.
type Cases = Vec<(String, Vec<Vec<f64>>)>;

/// Where figures go, and with what they are compared.
#[derive(Default)]
struct Report {
    kept: Cases,
    other: Option<Cases>,
}

impl Report {
    /// Runs `steps` of the manoeuvre and prints the line of the case.
    fn run(
        &mut self,
        name: &str,
        parameters: Parameters,
        trace: &[Inputs],
        steps: usize,
    ) -> Result<(), Box<dyn Error>> {
        let mut figures = Figures::default();
        let mut variator = Variator::new(parameters)?;
        variator.initialise(0.0, &trace[0])?;
        figures.add_outputs(variator.outputs());
        for (k, inputs) in trace.iter().take(steps).enumerate() {
            variator.advance((k + 1) as f64 * STEP, inputs)?;
            figures.add_outputs(variator.outputs());
        }
        let off = self
            .other
            .as_ref()
            .and_then(|cases| cases.iter().find(|(case, _)| case == name));
        let off = off.map_or(String::new(), |(_, rows)| {
            format!("  off by {:.1e} of the range", figures.difference(rows))
        });
        figures.add_profile(variator.profile());
        println!("{name:<34} {:016x}  {:?}{off}", figures.hash(), variator.counts());
        self.kept.push((name.to_string(), figures.0));
        Ok(())
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let trace = Manoeuvre::read().trace(STEP);
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (mut report, mut write) = (Report::default(), None);
    match arguments.iter().map(String::as_str).collect::<Vec<_>>().as_slice() {
        [] => {}
        ["--write", file] => write = Some(file.to_string()),
        ["--compare", file] => report.other = Some(serde_json::from_str(&std::fs::read_to_string(file)?)?),
        _ => return Err("usage: fingerprint [--write FILE | --compare FILE]".into()),
    }
    let with = |change: &dyn Fn(&mut Parameters)| {
        let mut parameters = Parameters::default();
        change(&mut parameters);
        parameters
    };
    let launch = |model: RingModel| Manoeuvre::variator(with(&|p| p.ring_model = model));
    let all = trace.len();
    report.run("ALE", launch(RingModel::Ale), &trace, all)?;
    report.run(
        "ALE, one cell an element",
        with(&|p| p.mesh.cells_per_element = 1),
        &trace,
        all / 5,
    )?;
    report.run("ALE0", launch(RingModel::Ale0), &trace, all)?;
    report.run(
        "ALE in space",
        with(&|p| (p.spatial, p.geometry.pulley_offset) = (true, 5e-4)),
        &trace,
        1000,
    )?;
    report.run(
        "ALE in directions of the curve",
        with(&|p| p.reference_directions = true),
        &trace,
        500,
    )?;
    report.run("ALE on even elements", with(&|p| p.mesh.aligned = false), &trace, 500)?;
    report.run(
        "ALE0 on even elements",
        with(&|p| (p.ring_model, p.mesh.aligned) = (RingModel::Ale0, false)),
        &trace,
        500,
    )?;
    report.run("RCM", with(&|p| p.ring_model = RingModel::Rcm), &trace, 30)?;
    report.run("ANCF", with(&|p| p.ring_model = RingModel::Ancf), &trace, 30)?;
    if let Some(file) = write {
        std::fs::write(file, serde_json::to_string(&report.kept)?)?;
    }
    Ok(())
}
