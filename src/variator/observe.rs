//! From state to outputs.

use super::balance::{BeltSums, Sliding};
use super::cell::Sample;
use super::layout::Global;
use super::mesh::{P, S};
use super::signals::{Losses, Outputs, PROFILE_POINTS, PulleyOutputs};
use super::system::VariatorSystem;
use crate::solver::View;

/// Belt force below which a thrust ratio or torque utilisation means nothing, N.
const NO_FORCE: f64 = 1.0;
/// Rim speed below which slip means nothing, m/s.
const NO_SPEED: f64 = 1.0e-3;
/// Shaft power below which an efficiency means nothing, W.
const NO_POWER: f64 = 1.0e-3;

/// A station with what the profile needs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Place {
    xi: f64,
    pulley: usize,
    arc: bool,
    element: usize,
    sample: Sample,
}

/// Mean ring tension of an element.
#[derive(Clone, Copy, Debug, Default)]
struct ElementTension {
    /// Middle of the element, m.
    xi: f64,
    /// Mean tension, N.
    tension: f64,
    length: f64,
}

/// Memory that observing reuses.
#[derive(Clone, Debug, Default)]
pub struct Observer {
    places: Vec<Place>,
    tensions: Vec<ElementTension>,
}

/// What the state alone does not tell.
#[derive(Clone, Copy, Debug)]
pub struct Context {
    /// External torques as held over the last step, over pulleys, N·m.
    pub external_torque: [f64; 2],
    /// Macro-slip flag with its hysteresis.
    pub macro_slip: bool,
    /// Stored energy at the start, J.
    pub initial_energy: f64,
}

impl Observer {
    /// Fills `out` from the state.
    pub fn observe(&mut self, system: &VariatorSystem, view: View<'_>, context: &Context, out: &mut Outputs) {
        let mut sums = BeltSums {
            strand_force: f64::INFINITY,
            ..BeltSums::default()
        };
        self.places.clear();
        let places = &mut self.places;
        system.probe::<true>(view, |cell, sample| {
            let cell = &system.mesh.cells[cell];
            sums.add(cell.pulley, cell.arc, sample);
            places.push(Place {
                xi: sample.xi,
                pulley: cell.pulley,
                arc: cell.arc,
                element: cell.element,
                sample: *sample,
            });
        });
        system.add_travelling(view, &mut sums);
        let radii = system.mean_radii(view, &sums);
        let layout = &system.layout;
        let omega = [S, P].map(|j| view.y[layout.global(Global::Speed, j)]);
        out.primary = self.pulley(system, view, P, &sums, radii[P], context);
        out.secondary = self.pulley(system, view, S, &sums, radii[S], context);
        out.thrust_ratio = if sums.axial[S].abs() < NO_FORCE {
            0.0
        } else {
            (sums.axial[P] / sums.axial[S]).clamp(-100.0, 100.0)
        };
        let (mut speed, mut length) = (0.0, 0.0);
        for place in &self.places {
            let weight = place.sample.weight * place.sample.lambda;
            speed += place.sample.speed * weight;
            length += weight;
        }
        out.belt_speed = speed / length;
        out.ring_speed = view.y[layout.global(Global::Drift, 0)];
        out.ratio_speed = if omega[S].abs() * radii[S] < NO_SPEED {
            0.0
        } else {
            omega[P] / omega[S]
        };
        out.ratio_geometric = radii[S] / radii[P];
        out.reference_theta = view.q[layout.global(Global::Theta, 0)];
        out.slip = if omega[P].abs() * radii[P] < NO_SPEED {
            0.0
        } else {
            (1.0 - omega[S] / omega[P] * out.ratio_geometric).clamp(-2.0, 2.0)
        };
        out.losses = Losses {
            other: sums.losses.other + system.pulley_losses(view),
            ..sums.losses
        };
        let (driving, driven) = if out.primary.power >= out.secondary.power {
            (out.primary.power, -out.secondary.power)
        } else {
            (out.secondary.power, -out.primary.power)
        };
        out.efficiency = if driving < NO_POWER {
            0.0
        } else {
            (driven / driving).clamp(0.0, 1.0)
        };
        let friction = system.law.parameters.friction.pulley;
        out.torque_utilisation = if sums.axial[S] < NO_FORCE {
            0.0
        } else {
            let capacity = 2.0 * friction * sums.axial[S] * radii[P] / system.law.wedge[1];
            if capacity > 0.0 {
                (sums.torque[P].abs() / capacity).min(10.0)
            } else {
                10.0
            }
        };
        out.macro_slip = context.macro_slip;
        out.push_force_max = self.places.iter().map(|p| p.sample.push).fold(0.0, f64::max);
        self.mean_tensions(system.mesh.elements.len());
        let tensions = || self.tensions.iter().map(|e| e.tension);
        out.ring_tension_max = tensions().fold(f64::NEG_INFINITY, f64::max);
        out.ring_tension_min = tensions().fold(f64::INFINITY, f64::min);
        out.stored_energy = sums.energy + system.pulley_energy(view);
        let ledger = &system.ledger;
        out.energy_residual = ledger.supplied - ledger.lost - (out.stored_energy - context.initial_energy);
        self.profile(system, radii, out);
    }

    /// The tension of a cubic element swings about its mean wherever the curvature changes fast; the mean is what the
    /// balance along the ring determines.
    fn mean_tensions(&mut self, elements: usize) {
        self.tensions.clear();
        self.tensions.resize(elements, ElementTension::default());
        for place in &self.places {
            let (sample, mean) = (&place.sample, &mut self.tensions[place.element]);
            mean.xi += place.xi * sample.weight;
            mean.tension += sample.tension * sample.weight;
            mean.length += sample.weight;
        }
        for mean in &mut self.tensions {
            mean.xi /= mean.length;
            mean.tension /= mean.length;
        }
    }

    fn pulley(
        &self,
        system: &VariatorSystem,
        view: View<'_>,
        j: usize,
        sums: &BeltSums,
        radius: f64,
        context: &Context,
    ) -> PulleyOutputs {
        let layout = &system.layout;
        let speed = view.y[layout.global(Global::Speed, j)];
        let mut range = (f64::INFINITY, f64::NEG_INFINITY);
        // Faces too: the radius changes fastest at the arc borders, where the last station is not.
        let mut left_arc = self.places.last().is_some_and(|p| p.arc && p.pulley == j);
        for place in &self.places {
            let on_arc = place.arc && place.pulley == j;
            if on_arc {
                range.0 = range.0.min(place.sample.pitch_radius.min(place.sample.face_radius));
                range.1 = range.1.max(place.sample.pitch_radius.max(place.sample.face_radius));
            } else if left_arc && place.pulley == j {
                range.0 = range.0.min(place.sample.face_radius);
                range.1 = range.1.max(place.sample.face_radius);
            }
            left_arc = on_arc;
        }
        PulleyOutputs {
            speed,
            radius,
            position: view.q[layout.global(Global::Sheave, j)],
            axial_force: sums.axial[j],
            shaft_torque: sums.torque[j],
            external_torque: context.external_torque[j],
            power: -sums.torque[j] * speed,
            spiral: range.1 - range.0,
        }
    }

    /// Linear between stations, around the loop.
    fn profile(&self, system: &VariatorSystem, radii: [f64; 2], out: &mut Outputs) {
        let length = system.law.parameters.geometry.belt_length;
        let profile = &mut out.profile;
        let (mut place, mut element) = (0, 0);
        for k in 0..PROFILE_POINTS {
            let xi = k as f64 * length / PROFILE_POINTS as f64;
            let (a, b, share) = bracket(&self.places, |p| p.xi, xi, length, &mut place);
            let between = |f: &dyn Fn(&Place) -> f64| f(a) * (1.0 - share) + f(b) * share;
            let (before, after, part) = bracket(&self.tensions, |e| e.xi, xi, length, &mut element);
            profile.position[k] = xi;
            profile.push_force[k] = between(&|p| p.sample.push);
            profile.ring_tension[k] = before.tension * (1.0 - part) + after.tension * part;
            profile.normal_force[k] = between(&|p| p.sample.normal);
            profile.sliding_speed[k] = between(&|p| if p.sample.normal > 100.0 { p.sample.sliding } else { 0.0 });
            profile.radial_deviation[k] = between(&|p| {
                if p.arc {
                    p.sample.pitch_radius - radii[p.pulley]
                } else {
                    p.sample.outward
                }
            });
        }
    }
}

/// Neighbours of `xi` in a list sorted along a loop of length `length`, and the share of the second. `right` is the
/// place of the last answer: ask in ascending order.
fn bracket<'a, T>(
    list: &'a [T],
    at: impl Fn(&T) -> f64,
    xi: f64,
    length: f64,
    right: &mut usize,
) -> (&'a T, &'a T, f64) {
    let n = list.len();
    while *right < n && at(&list[*right]) < xi {
        *right += 1;
    }
    let (a, b) = (&list[(*right + n - 1) % n], &list[*right % n]);
    let from = if *right == 0 { at(a) - length } else { at(a) };
    let to = if *right == n { at(b) + length } else { at(b) };
    (a, b, ((xi - from) / (to - from)).clamp(0.0, 1.0))
}

/// Macro-slip: all loaded stations of a pulley slide tangentially one way, faster than 10 v₀ + 0.02 |ω| r on average.
/// Once set, it stays until the mean falls below half of that.
#[must_use]
pub fn macro_slip(system: &VariatorSystem, view: View<'_>, sums: &BeltSums, before: bool) -> bool {
    let radii = system.mean_radii(view, sums);
    let v0 = system.law.parameters.friction.velocity;
    [S, P].into_iter().any(|j| {
        let Sliding {
            load,
            weighted,
            forward,
        } = sums.sliding[j];
        if load < NO_FORCE {
            return false;
        }
        let one_way = (forward / load).max(1.0 - forward / load);
        let omega = view.y[system.layout.global(Global::Speed, j)];
        let limit = 10.0 * v0 + 0.02 * (omega * radii[j]).abs();
        let mean = (weighted / load).abs();
        if before {
            one_way > 0.9 && mean > 0.5 * limit
        } else {
            one_way > 0.99 && mean > limit
        }
    })
}
