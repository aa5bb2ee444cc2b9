//! Power, losses and stored energy of a state: each loss from its own law, never as a remainder.

use super::boundary::{SheaveMode, SpeedMode};
use super::layout::Global;
use super::mesh::{BeltMesh, Cell, Group, P, S};
use super::parameters::SPEED_LAG;
use super::sample::Sample;
use super::signals::Losses;
use super::system::VariatorSystem;
use crate::reference_curve::ReferenceCurve;
use crate::scalar::Lanes;
use crate::solver::View;
use crate::{chain, contact};
use num_traits::Zero;

/// Axial force below which nothing presses: no thrust ratio, utilisation or steady state means anything, N.
pub(super) const NO_FORCE: f64 = 1.0;

/// The belt at one state.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// Samples of the stations of each [`Group`] of cells.
    samples: Vec<Sample<Lanes>>,
    /// Sums over them.
    pub sums: BeltSums,
    /// Energy of a ring that counts it on elements of its own, J.
    pub travelling: f64,
}

impl Survey {
    /// The sample of a station of a cell.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self, mesh: &BeltMesh, cell: &Cell, station: usize) -> Sample {
        self.samples[cell.group * mesh.points + station].get(cell.lane)
    }

    /// Groups of cells, and the samples of their stations.
    fn groups<'a>(&'a self, mesh: &'a BeltMesh) -> impl Iterator<Item = (&'a Group, &'a [Sample<Lanes>])> {
        mesh.groups.iter().zip(self.samples.chunks_exact(mesh.points))
    }

    /// Cells and samples of all stations, in the order of ξ.
    #[inline(always)]
    pub fn stations<'a>(&'a self, mesh: &'a BeltMesh) -> impl Iterator<Item = (&'a Cell, Sample)> {
        mesh.cells
            .iter()
            .flat_map(move |cell| (0..mesh.points).map(move |station| (cell, self.sample(mesh, cell, station))))
    }
}

/// Sums over the belt at one state, or over the cells in each lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct BeltSums<L = f64> {
    /// Losses, W.
    pub losses: Losses<L>,
    /// Axial force on one sheave, over pulleys, N.
    pub axial: [L; 2],
    /// Torque of the belt on the pulley, N·m.
    pub torque: [L; 2],
    /// ∫ axial · ϱ, N·m.
    pub axial_radius: [L; 2],
    /// Sliding weighted by normal force, and its share of either sign.
    pub sliding: [Sliding<L>; 2],
    /// Smallest net strand force T − Q, N.
    pub strand_force: L,
    /// Largest push force, N.
    pub push_force: L,
    /// Length of the pitch line, m.
    pub pitch_length: L,
    /// ∫ V along it, m²/s.
    pub carried: L,
}

/// How the loaded stations of a pulley slide.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sliding<L = f64> {
    /// ∫ normal dξ, N.
    pub load: L,
    /// ∫ normal · v_t dξ, W.
    pub weighted: L,
    /// ∫ normal dξ where v_t > 0, N.
    pub forward: L,
}

impl BeltSums<Lanes> {
    /// Nothing yet.
    fn empty() -> Self {
        Self {
            strand_force: f64::INFINITY.into(),
            ..Self::default()
        }
    }

    /// Adds a station of the cells of a group.
    fn add(&mut self, group: &Group, s: &Sample<Lanes>) {
        let in_use = group.in_use();
        let weight = s.weight * in_use;
        self.losses.sheaves += s.sheave_loss * weight;
        self.losses.ring += s.ring_loss * weight;
        self.losses.other += s.damping_loss * weight;
        for j in [S, P] {
            let weight = s.weight * group.on[j];
            self.axial[j] += s.axial * weight;
            self.torque[j] += s.torque * weight;
            self.axial_radius[j] += s.axial * weight * s.pitch_radius;
            let load = s.normal * weight;
            let sliding = &mut self.sliding[j];
            sliding.load += load;
            sliding.weighted += load * s.sliding;
            sliding.forward += s.sliding.if_positive(load, Lanes::zero());
        }
        let none = f64::INFINITY.into();
        let strand = s.curvature[0].if_positive(none, s.tension - s.push);
        self.strand_force = self.strand_force.min(in_use.if_positive(strand, none));
        self.push_force = self.push_force.max(s.push);
        let length = s.lambda * weight;
        self.pitch_length += length;
        self.carried += s.speed * length;
    }

    /// Over all lanes.
    fn total(&self) -> BeltSums {
        let Losses { sheaves, ring, other } = self.losses;
        BeltSums {
            losses: Losses {
                sheaves: sheaves.sum(),
                ring: ring.sum(),
                other: other.sum(),
            },
            axial: self.axial.map(Lanes::sum),
            torque: self.torque.map(Lanes::sum),
            axial_radius: self.axial_radius.map(Lanes::sum),
            sliding: self.sliding.map(|of| Sliding {
                load: of.load.sum(),
                weighted: of.weighted.sum(),
                forward: of.forward.sum(),
            }),
            strand_force: self.strand_force.to_array().into_iter().fold(f64::INFINITY, f64::min),
            push_force: self.push_force.to_array().into_iter().fold(0.0, f64::max),
            pitch_length: self.pitch_length.sum(),
            carried: self.carried.sum(),
        }
    }
}

impl VariatorSystem {
    /// Surveys the belt, in the memory of an earlier survey.
    pub fn survey(&self, view: View<'_>, survey: &mut Survey) {
        self.sample(view, &mut survey.samples);
        let mut sums = BeltSums::empty();
        for (group, samples) in survey.groups(&self.mesh) {
            for sample in samples {
                sums.add(group, sample);
            }
        }
        survey.sums = sums.total();
        let (energy, loss) = self.travelling_energy(view);
        survey.sums.losses.other += loss;
        survey.travelling = energy.total();
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
        let mut sum = Lanes::zero();
        for (group, samples) in survey.groups(&self.mesh) {
            let stack = chain::energy_density(&p.belt, samples[0].density);
            let flank = |penetration| contact::energy_density(&p.contact, law.wedge[1], penetration);
            let in_use = group.in_use();
            for s in samples {
                let flanks = if self.layout.is_spatial() {
                    flank(s.penetration + s.offset) + flank(s.penetration - s.offset)
                } else {
                    flank(s.penetration) * 2.0
                };
                sum += (s.kinetic + s.ring_elastic + s.lambda * (stack + flanks)) * s.weight * in_use;
            }
        }
        survey.travelling + sum.sum()
    }

    /// Pressure-weighted mean pitch radii over pulleys, m; reference radius − e where nothing presses.
    #[must_use]
    pub fn mean_radii(&self, view: View<'_>, sums: &BeltSums) -> [f64; 2] {
        [S, P].map(|j| {
            if sums.axial[j] > NO_FORCE {
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

    /// External torque at a shaft, N·m, without what accelerates it towards a set point; `torque` is the belt's.
    fn torque_supplied(&self, j: usize, torque: f64) -> f64 {
        match self.boundary.speed[j] {
            SpeedMode::Torque(external) | SpeedMode::Balanced(external, _) => external,
            SpeedMode::Setpoint(_) | SpeedMode::Fixed | SpeedMode::Transmit(_) => -torque,
        }
    }

    /// External torques at the shafts, N·m; `torques` are the belt's on the pulleys.
    #[must_use]
    pub fn external_torques(&self, view: View<'_>, torques: [f64; 2]) -> [f64; 2] {
        [S, P].map(|j| {
            let omega = view.y[self.layout.global(Global::Speed, j)];
            let accelerating = match self.boundary.speed[j] {
                SpeedMode::Setpoint(set) => self.pulley(j).inertia * (set - omega) / SPEED_LAG,
                _ => 0.0,
            };
            self.torque_supplied(j, torques[j]) + accelerating
        })
    }

    /// External forces on the movable sheaves, N; 0 where they are held.
    #[must_use]
    pub fn external_forces(&self) -> [f64; 2] {
        self.boundary.sheave.map(|sheave| match sheave {
            SheaveMode::Force(force) => force,
            _ => 0.0,
        })
    }

    /// Power supplied at the shafts, W, without what accelerates a pulley in speed drive; `torques` are the belt's on
    /// the pulleys.
    #[must_use]
    pub fn shaft_power(&self, view: View<'_>, torques: [f64; 2]) -> f64 {
        [S, P]
            .map(|j| self.torque_supplied(j, torques[j]) * view.y[self.layout.global(Global::Speed, j)])
            .iter()
            .sum()
    }
}
