//! The variator as an implicit system: belt, pulleys and loads put together for the solver.

use crate::archive::Archive;
use crate::contact::Friction;
use crate::pulley::{PerPulley, Pulley};
use crate::scalar::Lanes;
use crate::solver::arrow::{Arrow, Shape};
use crate::solver::{Factors, System, View};
use crate::variator::belt::equations::{Assembly, InForce, PulleyLoad, ResultantDerivatives, RingEnergy};
use crate::variator::belt::ring::BeltRing;
use crate::variator::belt::{Belt, CONSTRAINT_SCALE};
use crate::variator::cell::sample::Sample;
use crate::variator::mesh::layout::{CONDITIONS, TURN};
use crate::variator::pulleys::loads::{Boundary, Loads};
use crate::variator::pulleys::rows::Pulleys;
use crate::variator::settings::{Parameters, ParametersInForce};
use std::sync::Arc;

/// The assembled variator.
#[derive(Clone, Debug)]
pub struct VariatorSystem {
    /// Constants of the belt.
    pub belt: Arc<Belt>,
    /// Loads and set points at the pulleys.
    pub loads: Loads,
    /// Parameters in force, including the friction coefficients, which can change in a run.
    pub parameters: ParametersInForce,
    /// Friction velocity v₀ in force, m/s: larger at first in steady solutions and soft starts.
    pub friction_velocity: f64,
    /// Loads of the belt on the pulleys in the last residual.
    pub(crate) of_belt: PerPulley<PulleyLoad>,
    assembly: Box<dyn Assembly>,
    /// Working memory.
    resultants: ResultantDerivatives,
}

impl VariatorSystem {
    /// Assembles a variator with the ring of [`Parameters::ring_model`].
    ///
    /// # Panics
    /// With parameters that [`Parameters::validate`] rejects.
    #[must_use]
    pub fn new(parameters: &Parameters) -> Self {
        Self::with_ring(parameters, parameters.ring_of_model())
    }

    /// Assembles a variator with this ring.
    ///
    /// # Panics
    /// With parameters that [`Parameters::validate`] or [`BeltRing::check`] rejects.
    pub fn with_ring(parameters: &Parameters, ring: Arc<dyn BeltRing>) -> Self {
        Self::with_belt(parameters, Belt::new(parameters, ring))
    }

    fn with_belt(parameters: &Parameters, belt: Belt) -> Self {
        Self {
            loads: Loads::Steady(Boundary::HELD),
            parameters: parameters.in_force(),
            friction_velocity: parameters.friction.velocity,
            assembly: belt.ring.equations(&belt),
            of_belt: PerPulley::default(),
            resultants: ResultantDerivatives::new(belt.layout.len()),
            belt: Arc::new(belt),
        }
    }

    /// The pulleys: shafts and sheaves.
    #[must_use]
    pub fn pulleys(&self) -> Pulleys<'_> {
        let is_steady = matches!(self.loads, Loads::Steady(_));
        Pulleys::new(&self.parameters, &self.belt, is_steady)
    }

    /// Conditions of the pulleys at a time, s.
    #[must_use]
    pub fn boundary(&self, time: f64) -> Boundary {
        self.loads.boundary(time, &self.parameters)
    }

    /// Friction in force.
    #[must_use]
    pub fn friction(&self) -> Friction {
        let own = &self.parameters.friction;
        let softened = self.friction_velocity > own.velocity;
        let ring_velocity = if softened {
            own.ring_velocity.max(self.friction_velocity)
        } else {
            own.ring_velocity
        };
        Friction {
            velocity: self.friction_velocity,
            ring_velocity,
            ..*own
        }
    }

    pub(crate) fn sample(&self, view: View<'_>, out: &mut Vec<Sample<Lanes>>) -> RingEnergy {
        let belt = &*self.belt;
        out.resize(belt.mesh.groups.len() * belt.mesh.points, Sample::default());
        let friction = &self.friction();
        self.assembly.sample(InForce { belt, friction }, view, out)
    }

    /// Sets loads. At `time` they replace those before, and the rates `y_dot` jump with them.
    pub fn change_loads(&mut self, loads: Loads, time: f64, y_dot: &mut [f64]) {
        let before = self.boundary(time);
        self.loads = loads;
        self.pulleys().jump(&before, &self.boundary(time), y_dot);
    }

    /// Clears the Jacobian cache: the next Jacobian evaluates all derivatives.
    pub(crate) fn forget_derivatives(&mut self) {
        self.assembly.forget_derivatives();
    }

    pub(crate) fn serialize(&mut self, archive: &mut Archive<'_>) {
        self.loads.serialize(archive);
        archive.real(&mut self.friction_velocity);
        self.parameters.serialize(archive);
    }

    /// Writes to an archive the states of the cached derivatives, or reads them and evaluates
    /// these.
    pub(crate) fn serialize_derivatives(&mut self, archive: &mut Archive<'_>) {
        let friction = &self.friction();
        let belt = &*self.belt;
        self.assembly.serialize_derivatives(InForce { belt, friction }, archive);
    }

    /// How often all derivatives of the cells were evaluated.
    #[must_use]
    pub fn differentiations(&self) -> u64 {
        self.assembly.differentiations()
    }
}

#[cfg(test)]
impl VariatorSystem {
    /// The variator mirrored in the plane of the drive: sheaves on the other sides.
    pub(crate) fn mirrored(parameters: &Parameters) -> Self {
        let mut belt = Belt::new(parameters, parameters.ring_of_model());
        for plane in belt.law.planes.each_mut() {
            (plane.side, plane.middle) = (-plane.side, -plane.middle);
        }
        Self::with_belt(parameters, belt)
    }
}

// The Newton scale: negligible errors. "Half" and "twice": change of Jacobians and residuals under
// the ten rough loads with `ALE0`.

/// Position of the ring and content of a cell, m (1 N of tension, 5 N/m of contact; 1e-7 of stack
/// strain, 1 N). Half: 0, 0 %; twice: +2, 0 %.
const POSITION: f64 = 1.0e-9;
/// Speed of the ring in steps below a microsecond, m/s. Half and twice: 0 %. Without it, some loose
/// belts have no steady state.
const RING_SPEED: f64 = 1.0e-3;
/// Sliding speed, as a fraction of the friction velocity. Half: +1, +5 %; twice: -4, -7 %.
const SLIP: f64 = 2.0e-3;
/// Slope of the overlay per metre of its deflection, 1/m. Half and twice, with `ALE`: 1, 0 %; with
/// a tenth, as of an element's length, some steady states are not found.
const PER_METRE: f64 = 1.0e3;
/// Tension as an unknown of its own, N. Half and twice: +1, -1 %.
const TENSION: f64 = 0.1;

impl System for VariatorSystem {
    fn shape(&self) -> Shape {
        self.belt.layout.shape
    }

    fn has_position(&self) -> &[bool] {
        &self.belt.has_position
    }

    fn residual(&mut self, time: f64, view: View<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let friction = &self.friction();
        let belt = &*self.belt;
        let loads = self.assembly.residual(InForce { belt, friction }, view, out);
        self.pulleys().residual(&self.boundary(time), &loads, view, out);
        for c in belt.gauge() {
            for (node, sign) in c.nodes.into_iter().zip(c.signs) {
                out[c.multiplier] += CONSTRAINT_SCALE * sign * view.y[node];
                out[node] += CONSTRAINT_SCALE * sign * view.y[c.multiplier];
            }
        }
        self.of_belt = loads;
    }

    fn jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        self.forget_derivatives();
        self.renew_jacobian(time, view, alpha, beta, out);
    }

    fn renew_jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) -> f64 {
        let before = self.differentiations();
        out.clear();
        let friction = &self.friction();
        let belt = &*self.belt;
        self.resultants.clear();
        let factors = Factors { alpha, beta };
        let acting = InForce { belt, friction };
        let loads = self.assembly.jacobian(acting, view, factors, out, &mut self.resultants);
        let boundary = self.boundary(time);
        self.pulleys()
            .jacobian(&boundary, &loads, &self.resultants, view, factors, out);
        for c in belt.gauge() {
            for (node, sign) in c.nodes.into_iter().zip(c.signs) {
                out.add(c.multiplier, node, CONSTRAINT_SCALE * sign);
                out.add(node, c.multiplier, CONSTRAINT_SCALE * sign);
            }
        }
        (self.differentiations() - before) as f64
    }

    fn newton_scale(&self, beta: f64, out: &mut [f64]) {
        let layout = &self.belt.layout;
        let velocity = (POSITION / beta).min(RING_SPEED);
        let slip = SLIP * self.friction().velocity;
        // The pitch radius at ratio 1 turns lengths into angles, and into Θ.
        let radius = self.belt.law.r0;
        if layout.has_tension() {
            for cell in 0..self.belt.mesh.cells.len() {
                out[layout.tension(cell)] = TENSION;
            }
        }
        let material = &self.belt.material_mesh;
        let of_ring = material
            .as_ref()
            .map_or(velocity, |of| velocity.min(of.speed_error * slip));
        for of in layout.node_unknowns() {
            out[of.index] = of_ring * if of.is_length { 1.0 } else { PER_METRE };
        }
        out[layout.free()].fill(1.0);
        if !layout.has_tension() {
            for condition in 0..CONDITIONS {
                out[layout.gauge(condition)] = 1.0 / CONSTRAINT_SCALE;
            }
        }
        for cell in &self.belt.cells_at {
            out[cell.speed] = slip;
            out[cell.content] = POSITION;
        }
        out[layout.drift()] = slip;
        out[layout.theta()] = velocity / radius;
        for centre in layout.centres() {
            out[centre] = velocity;
        }
        if layout.has_tension() {
            out[layout.centre(TURN)] = velocity / radius;
        }
        for pulley in Pulley::BOTH {
            out[layout.sheave(pulley)] = velocity;
            for axis in 0..2 {
                out[layout.tilt(pulley, axis)] = POSITION / radius;
            }
            out[layout.shaft_speed(pulley)] = slip / radius;
        }
    }
}
