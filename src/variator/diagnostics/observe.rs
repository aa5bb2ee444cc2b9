//! Outputs: scalar ones, and profiles along the belt.

use super::belt::{BeltDiagnostics, BeltSums, NO_FORCE, Sliding};
use super::idle_arc::idle_arcs;
use super::{NO_SPEED, ONE_WAY, SLIPPING_RIM, SLIPPING_VELOCITY, STILL_SLIPPING, UNLOADED};
use crate::contact::full_slip_torque;
use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::TwoPulley;
use crate::ring::stress::{RingPart, RingStress, ring_stress};
use crate::solver::View;
use crate::variator::belt::Belt;
use crate::variator::cell::sample::Sample;
use crate::variator::mesh::belt_mesh::BeltMesh;
use crate::variator::settings::{Losses, Outputs, PROFILE_POINTS, Profile, PulleyOutputs};
use crate::variator::system::VariatorSystem;

use Pulley::{Primary, Secondary};

/// Working memory for outputs and profile.
#[derive(Clone, Debug, Default)]
pub struct Observer {
    elements: Vec<RingPart>,
    /// Stress of the most loaded face in each element, Pa.
    stresses: Vec<f64>,
    /// Samples of all stations, in the order of ξ.
    stations: Vec<Sample>,
}

impl Observer {
    /// Fills `out` from the state at a time, s, and the diagnostics of the belt there, without
    /// quantities of the run before.
    pub fn observe(
        &mut self,
        system: &VariatorSystem,
        time: f64,
        view: View<'_>,
        diagnostics: &BeltDiagnostics,
        out: &mut Outputs,
    ) {
        let sums = &diagnostics.sums;
        let boundary = system.boundary(time);
        let external = system
            .pulleys()
            .external(&boundary, view, sums.shaft_torque, sums.axial);
        let belt = &*system.belt;
        let radii = sums.mean_radii(belt, view);
        self.stations.clear();
        self.stations
            .extend(diagnostics.stations(&belt.mesh).map(|(_, sample)| sample));
        let stations = &self.stations;
        let idle = if belt.law.is_pull_chain() {
            PerPulley::default()
        } else {
            idle_arcs(&belt.mesh, stations, belt.curve.length(), sums.speed_integral < 0.0)
        };
        let outputs = |j: Pulley| PulleyOutputs {
            speed: view.y[belt.layout.shaft_speed(j)],
            radius: radii[j],
            position: view.q[belt.layout.sheave(j)],
            axial_force: sums.axial[j],
            shaft_torque: sums.torque[j],
            external_torque: external[j].torque,
            clamping_force_total: external[j].clamping,
            sheave_velocity: view.y[belt.layout.sheave(j)],
            flow: system.parameters.pulley(j).cylinder.area * view.y[belt.layout.sheave(j)],
            volume: system.parameters.pulley(j).cylinder.area * view.q[belt.layout.sheave(j)],
            power: -sums.torque[j] * view.y[belt.layout.shaft_speed(j)],
            spiral: spiral(&belt.mesh, stations, j),
            idle_arc: idle[j],
            tilt: f64::hypot(view.y[belt.layout.tilt(j, 0)], view.y[belt.layout.tilt(j, 1)]),
        };
        (out.primary, out.secondary) = (outputs(Primary), outputs(Secondary));
        out.past_peak = sums.past_peak();
        out.belt_speed = sums.speed_integral / sums.pitch_length;
        out.ring_speed = view.y[belt.layout.drift()];
        out.reference_theta = view.q[belt.layout.theta()];
        out.set_quotients(sums.shaft_torque);
        out.losses = Losses {
            other: sums.losses.other + system.pulleys().losses(view),
            ..sums.losses
        };
        out.torque_utilisation = torque_utilisation(system, sums, radii.primary);
        out.push_force_max = sums.push_force;
        self.mean_elements(&belt.mesh, belt.curve.length());
        let tensions = || self.elements.iter().map(|e| e.tension);
        out.ring_tension_max = tensions().fold(f64::NEG_INFINITY, f64::max);
        out.ring_tension_min = tensions().fold(f64::INFINITY, f64::min);
        out.ring_stress = self.ring_stress(belt, view, radii);
        lateral(belt, view, &self.stations, out);
        out.stored_energy = diagnostics.belt_energy(belt) + system.pulleys().energy(view);
    }

    /// The tension of a cubic element oscillates about its mean wherever the curvature changes
    /// fast. The balance along the ring determines the mean; that of its curvature is more accurate
    /// too.
    fn mean_elements(&mut self, mesh: &BeltMesh, length: f64) {
        self.elements.clear();
        self.elements.resize(mesh.elements.len(), RingPart::default());
        for (k, sample) in self.stations.iter().enumerate() {
            let cell = &mesh.cells[k / mesh.points];
            let mean = &mut self.elements[cell.element];
            mean.xi += sample.xi * sample.weight;
            mean.tension += sample.tension * sample.weight;
            mean.curvature += sample.ring_curvature * sample.weight;
            mean.turning += sample.curvature * sample.weight;
            mean.length += sample.weight;
            mean.pulley = cell.pulley;
        }
        for mean in &mut self.elements {
            mean.xi /= mean.length;
            mean.tension /= mean.length;
            mean.curvature /= mean.length;
            if mean.turning == 0.0 {
                mean.pulley = if mean.xi > 0.5 * length {
                    Pulley::Primary
                } else {
                    Pulley::Secondary
                };
            }
        }
    }

    fn ring_stress(&mut self, belt: &Belt, view: View<'_>, radii: PerPulley<f64>) -> RingStress {
        let (law, speed) = (&belt.law, view.y[belt.layout.drift()]);
        self.stresses.resize(self.elements.len(), 0.0);
        ring_stress(&law.ring, &law.layers, speed, radii, &self.elements, &mut self.stresses)
    }

    /// Fills fields along the belt, linear between stations. The last [`observe`](Self::observe)
    /// must have been at the same state, with these sums.
    pub fn profile(&self, belt: &Belt, view: View<'_>, sums: &BeltSums, profile: &mut Profile) {
        let mesh = &belt.mesh;
        let radii = sums.mean_radii(belt, view);
        let length = belt.curve.length();
        let middles = belt.middles(view);
        let plane = 0.5 * (middles.secondary + middles.primary);
        let deviation = |k: usize| {
            let sample = &self.stations[k];
            if sample.on_arc() {
                sample.pitch_radius - radii[mesh.cells[k / mesh.points].pulley]
            } else {
                sample.outward
            }
        };
        // Stretch between the pins of a chain is no gap.
        let thickness = if belt.law.is_pull_chain() {
            0.0
        } else {
            belt.law.stack.element_thickness
        };
        let gap = |k: usize| thickness * (self.stations[k].density.recip() - 1.0).max(0.0);
        let sliding = |k: usize| {
            let sample = &self.stations[k];
            if sample.normal > UNLOADED { sample.sliding } else { 0.0 }
        };
        let (mut station, mut element) = (0, 0);
        for k in 0..PROFILE_POINTS {
            let xi = k as f64 * length / PROFILE_POINTS as f64;
            let on_ring = Bracket::new(&self.elements, |e| e.xi, xi, length, &mut element);
            profile.position[k] = xi;
            profile.ring_tension[k] = on_ring.interpolate(|e| self.elements[e].tension);
            profile.ring_stress[k] = on_ring.interpolate(|e| self.stresses[e]);
            let stations = &self.stations;
            let on_belt = Bracket::new(stations, |sample| sample.xi, xi, length, &mut station);
            profile.push_force[k] = on_belt.interpolate(|k| stations[k].push);
            profile.gap[k] = on_belt.interpolate(gap);
            profile.normal_force[k] = on_belt.interpolate(|k| stations[k].normal);
            profile.sliding_speed[k] = on_belt.interpolate(sliding);
            profile.radial_deviation[k] = on_belt.interpolate(deviation);
            if belt.layout.is_spatial() {
                profile.lateral_deflection[k] = on_belt.interpolate(|k| stations[k].lateral) - plane;
            }
        }
    }
}

impl Outputs {
    /// Sets the quotients of the pulleys' outputs: both ratios, slip, thrust ratio and
    /// efficiencies. `shaft_torques` are those of belt and drag, N·m.
    pub fn set_quotients(&mut self, shaft_torques: PerPulley<f64>) {
        let (p, s) = (&self.primary, &self.secondary);
        let stands = |of: &PulleyOutputs| of.speed.abs() * of.radius < NO_SPEED;
        self.ratio_speed = if stands(s) { 0.0 } else { p.speed / s.speed };
        self.ratio_geometric = s.radius / p.radius;
        self.slip = if stands(p) {
            0.0
        } else {
            (1.0 - s.speed / p.speed * self.ratio_geometric).clamp(-2.0, 2.0)
        };
        self.thrust_ratio = if s.axial_force.abs() < NO_FORCE {
            0.0
        } else {
            (p.axial_force / s.axial_force).clamp(-100.0, 100.0)
        };
        self.efficiency = efficiency(-shaft_torques.primary * p.speed, -shaft_torques.secondary * s.speed);
        self.belt_efficiency = efficiency(p.power, s.power);
    }
}

/// Power out at the driven side / power in at the driving side, from the powers into the belt at
/// each side, W; 0 where no power flows in.
fn efficiency(primary: f64, secondary: f64) -> f64 {
    let (driving, driven) = (primary.max(secondary), -primary.min(secondary));
    if driving < NO_FORCE * NO_SPEED {
        return 0.0;
    }
    // Avoids −0 where the driven shaft stands still.
    (driven / driving).clamp(0.0, 1.0) + 0.0
}

/// Torque at the primary pulley, where the belt runs at `radius`, m, relative to the full-slip
/// torque; at most 10.
fn torque_utilisation(system: &VariatorSystem, sums: &BeltSums, radius: f64) -> f64 {
    if sums.axial.secondary < NO_FORCE {
        return 0.0;
    }
    let friction = &system.parameters.friction;
    let cos_beta = system.belt.law.wedge.cos;
    let capacity = full_slip_torque(friction, cos_beta, sums.axial.secondary, radius);
    if capacity > 0.0 {
        (sums.torque.primary.abs() / capacity).min(10.0)
    } else {
        10.0
    }
}

/// Sets the misalignment, and the lateral deflection of a ring in space.
fn lateral(belt: &Belt, view: View<'_>, stations: &[Sample], out: &mut Outputs) {
    let middles = belt.middles(view);
    out.misalignment = middles.primary - middles.secondary;
    if !belt.layout.is_spatial() {
        return;
    }
    let plane = 0.5 * (middles.secondary + middles.primary);
    let (mut largest, mut rise, mut length) = (0.0_f64, 0.0, 0.0);
    let length_of_belt = belt.curve.length();
    for sample in stations {
        largest = largest.max((sample.lateral - plane).abs());
        if sample.on_arc() {
            continue;
        }
        let towards_primary = if sample.xi < 0.5 * length_of_belt { 1.0 } else { -1.0 };
        rise += towards_primary * sample.lateral_slope * sample.weight;
        length += sample.weight;
    }
    out.lateral_max = largest;
    out.skew = rise / length;
}

/// Difference between the largest and the smallest pitch radius on the arc of a pulley, m.
fn spiral(mesh: &BeltMesh, stations: &[Sample], j: Pulley) -> f64 {
    let (mut least, mut most) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut widen = |radius: f64| (least, most) = (least.min(radius), most.max(radius));
    // With faces: the radius changes fastest at the arc borders, beyond the last station. The face
    // after an arc is its end.
    let mut left_arc = false;
    for (k, sample) in stations.iter().enumerate() {
        let cell = &mesh.cells[k / mesh.points];
        if cell.pulley != j {
            continue;
        }
        if sample.on_arc() {
            widen(sample.pitch_radius);
        }
        if sample.face_curvature > 0.0 || left_arc {
            widen(sample.face_radius);
        }
        left_arc = sample.on_arc() && mesh.elements[cell.element].segment != TwoPulley::WHOLE;
    }
    most - least
}

/// The two neighbours of a point in a list along the belt.
struct Bracket {
    left: usize,
    right: usize,
    /// Weight of the right one.
    fraction: f64,
}

impl Bracket {
    /// Neighbours of `xi` in a list sorted by `position` along a loop of length `length`. `next` is
    /// the index of the last result, so `xi` must ascend from call to call.
    fn new<T>(list: &[T], position: impl Fn(&T) -> f64, xi: f64, length: f64, next: &mut usize) -> Self {
        let n = list.len();
        while *next < n && position(&list[*next]) < xi {
            *next += 1;
        }
        let (left, right) = ((*next + n - 1) % n, *next % n);
        let from = position(&list[left]) - if *next == 0 { length } else { 0.0 };
        let to = position(&list[right]) + if *next == n { length } else { 0.0 };
        let fraction = ((xi - from) / (to - from)).clamp(0.0, 1.0);
        Self { left, right, fraction }
    }

    fn interpolate(&self, value: impl Fn(usize) -> f64) -> f64 {
        value(self.left) * (1.0 - self.fraction) + value(self.right) * self.fraction
    }
}

/// Macro-slip: the loaded stations of a pulley slide tangentially in one direction, faster than a
/// limit on average; afterwards, faster than a fraction of that.
pub(crate) fn macro_slip(system: &VariatorSystem, view: View<'_>, sums: &BeltSums, before: bool) -> bool {
    let radii = sums.mean_radii(&system.belt, view);
    Pulley::BOTH.into_iter().any(|j| {
        let Sliding {
            load,
            weighted,
            forward,
            ..
        } = sums.sliding[j];
        let omega = view.y[system.belt.layout.shaft_speed(j)];
        let limit = SLIPPING_VELOCITY * system.friction_velocity + SLIPPING_RIM * (omega * radii[j]).abs();
        let mean = (weighted / load).abs();
        let one_way = (forward / load).max(1.0 - forward / load) > ONE_WAY;
        load >= NO_FORCE && (one_way && mean > limit || before && mean > STILL_SLIPPING * limit)
    })
}
