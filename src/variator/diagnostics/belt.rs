//! Power, losses and stored energy of a state: each loss from its own law, never as a remainder.

use crate::pulley::{PerPulley, Pulley};
use crate::scalar::{Lanes, Real};
use crate::solver::View;
use crate::stack;
use crate::variator::belt::Belt;
use crate::variator::cell::sample::Sample;
use crate::variator::mesh::belt_mesh::{BeltMesh, Cell, Group};
use crate::variator::settings::Losses;
use crate::variator::system::VariatorSystem;
use num_traits::Zero;

/// Axial force of an unclamped belt, at most, N: thrust ratio, utilisation and steady state are
/// then undefined.
pub(crate) const NO_FORCE: f64 = 1.0;

/// The belt at one state.
#[derive(Clone, Debug, Default)]
pub struct BeltDiagnostics {
    /// Samples of the stations of each [`Group`] of cells.
    samples: Vec<Sample<Lanes>>,
    /// Sums over the stations.
    pub sums: BeltSums,
    /// Energy of a ring that has elements of its own, J; else zero.
    ring_energy: f64,
}

/// Sums over the belt at one state, or over the cells in each lane.
#[derive(Clone, Copy, Debug, Default)]
pub struct BeltSums<L = f64> {
    /// Losses of belt, shafts and seals by their causes, W.
    pub losses: Losses<L>,
    /// Axial force on one sheave, N.
    pub axial: PerPulley<L>,
    /// Torque of the belt on the pulley, N·m.
    pub torque: PerPulley<L>,
    /// Resultant of the contact forces on the belt, N.
    pub resultant: PerPulley<[L; 2]>,
    /// Torque of belt and drag on the shaft, N·m.
    pub shaft_torque: PerPulley<L>,
    /// ∫ axial · ϱ, N·m.
    pub axial_radius: PerPulley<L>,
    /// Sliding weighted by normal force, and its fraction of either sign.
    pub sliding: PerPulley<Sliding<L>>,
    /// Smallest net strand force T − Q, N.
    pub strand_force: L,
    /// Largest push force, N.
    pub push_force: L,
    /// Length of the pitch line, m.
    pub pitch_length: L,
    /// ∫ V along it, m²/s.
    pub speed_integral: L,
}

/// Sliding of the loaded stations of a pulley.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sliding<L = f64> {
    /// ∫ normal dξ, N.
    pub load: L,
    /// ∫ normal · v_t dξ, W.
    pub weighted: L,
    /// ∫ normal dξ where v_t > 0, N.
    pub forward: L,
    /// Slope of the traction over the sliding speed at constant normal forces, N·s/m.
    pub slope: L,
}

impl BeltSums {
    /// Whether a loaded pulley would transmit less torque if its elements slid faster.
    #[must_use]
    pub fn past_peak(&self) -> bool {
        Pulley::BOTH.into_iter().any(|j| {
            let Sliding { load, slope, .. } = self.sliding[j];
            load >= NO_FORCE && slope < 0.0
        })
    }

    /// Pressure-weighted mean pitch radii, m; reference radius − e where nothing presses.
    #[must_use]
    pub fn mean_radii(&self, belt: &Belt, view: View<'_>) -> PerPulley<f64> {
        PerPulley::from_fn(|pulley| {
            if self.axial[pulley] > NO_FORCE {
                self.axial_radius[pulley] / self.axial[pulley]
            } else {
                let frame = belt.curve.frame::<f64>(belt.theta(view));
                frame.radius[pulley as usize].v - belt.law.stack.pitch_offset
            }
        })
    }

    /// r_S/r_P of the mean radii.
    #[must_use]
    pub fn geometric_ratio(&self, belt: &Belt, view: View<'_>) -> f64 {
        let radii = self.mean_radii(belt, view);
        radii.secondary / radii.primary
    }
}

impl BeltSums<Lanes> {
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
        self.losses.layers += s.layer_loss * weight;
        self.losses.element_rotation += s.rotation_loss * weight;
        self.losses.other += s.damping_loss * weight;
        for j in Pulley::BOTH {
            let weight = s.weight * group.on[j];
            self.axial[j] += s.axial * weight;
            self.torque[j] += s.torque * weight;
            for (sum, force) in self.resultant[j].iter_mut().zip(s.resultant) {
                *sum += force * weight;
            }
            self.axial_radius[j] += s.axial * weight * s.pitch_radius;
            let load = s.normal * weight;
            let sliding = &mut self.sliding[j];
            sliding.load += load;
            sliding.weighted += load * s.sliding;
            sliding.forward += s.sliding.if_positive(load, Lanes::zero());
            sliding.slope += s.traction_slope * weight;
        }
        let none = f64::INFINITY.into();
        let strand = s.curvature.if_positive(none, s.tension - s.push);
        self.strand_force = self.strand_force.min(in_use.if_positive(strand, none));
        self.push_force = self.push_force.max(s.push);
        let length = s.lambda * weight;
        self.pitch_length += length;
        self.speed_integral += s.speed * length;
    }

    fn total(&self) -> BeltSums {
        BeltSums {
            // The others are not sums over stations.
            losses: Losses {
                sheaves: self.losses.sheaves.sum(),
                ring: self.losses.ring.sum(),
                layers: self.losses.layers.sum(),
                element_rotation: self.losses.element_rotation.sum(),
                other: self.losses.other.sum(),
                ..Losses::default()
            },
            axial: self.axial.map(Lanes::sum),
            torque: self.torque.map(Lanes::sum),
            resultant: self.resultant.map(|of| of.map(Lanes::sum)),
            axial_radius: self.axial_radius.map(Lanes::sum),
            shaft_torque: PerPulley::default(),
            sliding: self.sliding.map(|of| Sliding {
                load: of.load.sum(),
                weighted: of.weighted.sum(),
                forward: of.forward.sum(),
                slope: of.slope.sum(),
            }),
            strand_force: self.strand_force.to_array().into_iter().fold(f64::INFINITY, f64::min),
            push_force: self.push_force.to_array().into_iter().fold(0.0, f64::max),
            pitch_length: self.pitch_length.sum(),
            speed_integral: self.speed_integral.sum(),
        }
    }
}

impl BeltDiagnostics {
    /// The sample of a station of a cell.
    #[inline(always)]
    #[must_use]
    pub fn sample(&self, mesh: &BeltMesh, cell: &Cell, station: usize) -> Sample {
        self.samples[cell.group * mesh.points + station].get(cell.lane)
    }

    fn groups<'a>(&'a self, mesh: &'a BeltMesh) -> impl Iterator<Item = (&'a Group, &'a [Sample<Lanes>])> {
        mesh.groups.iter().zip(self.samples.chunks_exact(mesh.points))
    }

    /// Cells and samples of all stations, in the order of ξ.
    #[inline(always)]
    pub fn stations<'a>(&'a self, mesh: &'a BeltMesh) -> impl Iterator<Item = (&'a Cell, Sample)> {
        mesh.cells.iter().flat_map(move |cell| {
            (0..mesh.points).map(move |station| (cell, self.sample(mesh, cell, station)))
        })
    }

    /// The belt at a state. Allocates.
    #[must_use]
    pub fn new(system: &VariatorSystem, view: View<'_>) -> Self {
        let mut diagnostics = Self::default();
        diagnostics.update(system, view);
        diagnostics
    }

    /// Evaluates the belt at a state.
    pub fn update(&mut self, system: &VariatorSystem, view: View<'_>) {
        let ring = system.sample(view, &mut self.samples);
        let mut sums = BeltSums::empty();
        for (group, samples) in self.groups(&system.belt.mesh) {
            for sample in samples {
                sums.add(group, sample);
            }
        }
        self.sums = sums.total();
        if system.belt.law.is_pull_chain() {
            // The law of drag along the ring is the same, its cause another.
            let losses = &mut self.sums.losses;
            (losses.joints, losses.layers) = (losses.layers, 0.0);
        }
        self.sums.losses.other += ring.loss;
        let speeds = system.belt.shaft_speeds(view);
        let drags = system.pulleys().drag_torques(view, self.sums.resultant);
        for j in Pulley::BOTH {
            self.sums.losses.shafts += drags[j] * speeds[j];
            self.sums.losses.seals += system.pulleys().seal_loss(j, view.y[system.belt.layout.sheave(j)]);
            self.sums.shaft_torque[j] = self.sums.torque[j] - drags[j];
        }
        self.ring_energy = ring.energy;
    }

    /// Energy of ring, stack and flanks, J.
    #[must_use]
    pub fn belt_energy(&self, belt: &Belt) -> f64 {
        let law = &belt.law;
        let mut sum = Lanes::zero();
        for (group, samples) in self.groups(&belt.mesh) {
            let stack = if law.is_pull_chain() {
                Lanes::zero()
            } else {
                stack::energy_density(&law.stack, samples[0].density)
            };
            let in_use = group.in_use();
            for s in samples {
                sum += (s.kinetic + s.ring_elastic + s.flank_elastic + s.lambda * stack) * s.weight * in_use;
            }
        }
        self.ring_energy + sum.sum()
    }
}
