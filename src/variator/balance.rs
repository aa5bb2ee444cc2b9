//! Power, losses and stored energy of a state: each loss from its own law, never as a remainder.

use super::boundary::SpeedMode;
use super::cell::Sample;
use super::layout::Global;
use super::mesh::{BeltMesh, Cell, P, S};
use super::parameters::SPEED_LAG;
use super::signals::Losses;
use super::system::VariatorSystem;
use crate::reference_curve::ReferenceCurve;
use crate::solver::View;
use crate::{chain, contact};

/// The belt at one state.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// A sample for each station, in the order of ξ: those of a cell follow each other.
    pub samples: Vec<Sample>,
    /// Sums over them.
    pub sums: BeltSums,
    /// Energy of a ring that counts it on elements of its own, J.
    pub travelling: f64,
}

impl Survey {
    /// Cells and samples of all stations.
    pub fn stations<'a>(&'a self, mesh: &'a BeltMesh) -> impl Iterator<Item = (&'a Cell, &'a Sample)> {
        let cells = mesh.cells.iter();
        cells
            .zip(self.samples.chunks_exact(mesh.points))
            .flat_map(|(cell, samples)| samples.iter().map(move |sample| (cell, sample)))
    }
}

/// Sums over the belt at one state.
#[derive(Clone, Copy, Debug, Default)]
pub struct BeltSums {
    /// Losses, W.
    pub losses: Losses,
    /// Axial force on one sheave, over pulleys, N.
    pub axial: [f64; 2],
    /// Torque of the belt on the pulley, N·m.
    pub torque: [f64; 2],
    /// ∫ axial · ϱ, N·m.
    pub axial_radius: [f64; 2],
    /// Sliding weighted by normal force, and its share of either sign.
    pub sliding: [Sliding; 2],
    /// Smallest net strand force T − Q, N.
    pub strand_force: f64,
}

/// How the loaded stations of a pulley slide.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sliding {
    /// ∫ normal dξ, N.
    pub load: f64,
    /// ∫ normal · v_t dξ, W.
    pub weighted: f64,
    /// ∫ normal dξ where v_t > 0, N.
    pub forward: f64,
}

impl BeltSums {
    /// Adds a station of a cell on pulley `j`.
    pub fn add(&mut self, j: usize, s: &Sample) {
        self.losses.sheaves += s.sheave_loss * s.weight;
        self.losses.ring += s.ring_loss * s.weight;
        self.losses.other += s.damping_loss * s.weight;
        self.axial[j] += s.axial * s.weight;
        self.torque[j] += s.torque * s.weight;
        self.axial_radius[j] += s.axial * s.weight * s.pitch_radius;
        let load = s.normal * s.weight;
        let sliding = &mut self.sliding[j];
        sliding.load += load;
        sliding.weighted += load * s.sliding;
        if s.sliding > 0.0 {
            sliding.forward += load;
        }
        if !s.on_arc() {
            self.strand_force = self.strand_force.min(s.tension - s.push);
        }
    }
}

impl VariatorSystem {
    /// Surveys the belt, in the memory of an earlier survey.
    pub fn survey(&self, view: View<'_>, survey: &mut Survey) {
        self.sample(view, &mut survey.samples);
        let mut sums = BeltSums {
            strand_force: f64::INFINITY,
            ..BeltSums::default()
        };
        for (cell, sample) in survey.stations(&self.mesh) {
            sums.add(cell.pulley, sample);
        }
        let (energy, loss) = self.travelling_energy(view);
        sums.losses.other += loss;
        survey.travelling = energy.total();
        survey.sums = sums;
    }

    /// The belt at a state. Allocates.
    #[must_use]
    pub fn surveyed(&self, view: View<'_>) -> Survey {
        let mut survey = Survey::default();
        self.survey(view, &mut survey);
        survey
    }

    /// Energy of ring, stack and flanks, J.
    #[must_use]
    pub fn belt_energy(&self, survey: &Survey) -> f64 {
        let (law, p) = (&self.law, &self.law.parameters);
        let mut sum = survey.travelling;
        for cell in survey.samples.chunks_exact(self.mesh.points) {
            let stack = chain::energy_density(&p.belt, cell[0].density);
            for s in cell {
                let flanks = contact::energy_density(&p.contact, law.wedge[1], s.penetration, s.offset);
                sum += (s.kinetic + s.ring_elastic + s.lambda * (stack + flanks)) * s.weight;
            }
        }
        sum
    }

    /// Pressure-weighted mean pitch radii over pulleys, m; reference radius − e where nothing presses.
    #[must_use]
    pub fn mean_radii(&self, view: View<'_>, sums: &BeltSums) -> [f64; 2] {
        [S, P].map(|j| {
            if sums.axial[j] > 1.0 {
                sums.axial_radius[j] / sums.axial[j]
            } else {
                self.curve.frame::<f64>(self.theta(view)).radius[j].v - self.law.parameters.belt.pitch_offset
            }
        })
    }

    /// Losses of the pulleys: sheave damper, tilt relaxation, end stops, W.
    #[must_use]
    pub fn pulley_losses(&self, view: View<'_>) -> f64 {
        let mut loss = 0.0;
        for j in [S, P] {
            let pulley = self.pulley(j);
            let z = self.layout.global(Global::Sheave, j);
            let rate = view.y[z];
            loss += pulley.sheave_damping * rate * rate - self.travel[j].stop_force(view.q[z], rate).viscous * rate;
            if !self.rigid(j) {
                for k in 0..2 {
                    let rate = view.y_dot[self.layout.global(Global::Tilt, 2 * j + k)];
                    loss += 2.0 * pulley.tilt_stiffness * pulley.tilt_time * rate * rate;
                }
            }
        }
        loss
    }

    /// Energy of the pulleys: rotation, axial motion, tilt, end stops, J.
    #[must_use]
    pub fn pulley_energy(&self, view: View<'_>) -> f64 {
        let mut energy = 0.0;
        for j in [S, P] {
            let pulley = self.pulley(j);
            let z = self.layout.global(Global::Sheave, j);
            let omega = view.y[self.layout.global(Global::Speed, j)];
            energy += 0.5 * pulley.inertia * omega * omega
                + 0.5 * pulley.sheave_mass * view.y[z] * view.y[z]
                + self.travel[j].energy(view.q[z]);
            if !self.rigid(j) {
                for k in 0..2 {
                    let psi = view.y[self.layout.global(Global::Tilt, 2 * j + k)];
                    energy += pulley.tilt_stiffness * psi * psi;
                }
            }
        }
        energy
    }

    /// External torque at a shaft, N·m; `torque` is the belt's.
    #[must_use]
    pub fn external_torque(&self, j: usize, view: View<'_>, torque: f64) -> f64 {
        let i = self.layout.global(Global::Speed, j);
        match self.boundary.speed[j] {
            SpeedMode::Torque(external) | SpeedMode::Balanced(external, _) => external,
            SpeedMode::Setpoint(set) => self.pulley(j).inertia * (set - view.y[i]) / SPEED_LAG - torque,
            SpeedMode::Fixed | SpeedMode::Transmit(_) => -torque,
        }
    }

    /// External force on a movable sheave, N.
    #[must_use]
    pub fn external_force(&self, j: usize) -> f64 {
        match self.boundary.sheave[j] {
            super::boundary::SheaveMode::Force(force) => force,
            _ => 0.0,
        }
    }

    /// Power supplied at the shafts, W; `torques` are the belt's on the pulleys.
    #[must_use]
    pub fn shaft_power(&self, view: View<'_>, torques: [f64; 2]) -> f64 {
        [S, P]
            .map(|j| {
                let omega = view.y[self.layout.global(Global::Speed, j)];
                self.external_torque(j, view, torques[j]) * omega
            })
            .iter()
            .sum()
    }
}
