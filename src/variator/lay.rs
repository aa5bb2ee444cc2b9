//! Where a ring that travels with its mesh starts: on the deflecting ring of `ALE`.
//!
//! Its nodes pass under the stations, so it has no steady state, only one that repeats with every element. The steady
//! solver finds the state of `ALE`, and the ring is laid on it: nodes on r(ξ) with its slope, velocities those of the
//! material, everything else the same. What the elements cannot follow, and what they stretch by lying there, settles
//! within the first pass of an element.

use super::layout::Global;
use super::system::VariatorSystem;
use super::travelling::with_ring;
use crate::reference_curve::ReferenceCurve;
use crate::ring::ale_ring::AleRing;
use crate::ring::kinematics::Motion;
use crate::ring::mesh::{RingMesh, gauss};
use crate::ring::model::{Coordinates, NODAL, RingModel};
use crate::ring::particle::Particle;
use crate::solver::State;
use std::f64::consts::{PI, TAU};

/// Half the time over which the unknowns of the ring are differentiated, s: it moves by a micrometre.
const MOMENT: f64 = 1.0e-7;

impl VariatorSystem {
    /// The state in which the ring lies on that of `ale`, which has the same mesh and the deflecting ring.
    #[must_use]
    pub fn lay_on(&self, ale: &VariatorSystem, state: &State) -> State {
        let n = self.layout.len();
        let mut out = State::zero(n);
        for cell in 0..self.mesh.cells.len() {
            out.y[self.layout.speed(cell)] = state.y[ale.layout.speed(cell)];
            out.y[self.layout.amount(cell)] = state.y[ale.layout.amount(cell)];
        }
        for k in 0..Global::Gauge as usize {
            let (to, from) = (
                self.layout.global(Global::Drift, k),
                ale.layout.global(Global::Drift, k),
            );
            out.y[to] = state.y[from];
            out.q[to] = state.q[from];
        }
        out.q[self.layout.global(Global::Drift, 0)] = 0.0;
        let (Some(travelling), Some(ring)) = (&self.layout.travelling, &self.travelling) else {
            return out;
        };
        let nodes = travelling.nodes * travelling.block;
        let shape = AleShape::new(ale, state);
        let lay = |time: f64| {
            let mut q = vec![0.0; nodes + 2];
            let at = |xi: f64| {
                let p = shape.particle(xi);
                [p.r + p.velocity * time, p.slope + p.velocity_slope * time]
            };
            with_ring!(&**ring, ring => ring.place_on(&at, &mut q));
            q
        };
        let [before, now, after] = [-MOMENT, 0.0, MOMENT].map(lay);
        let first = self.layout.node(0, 0);
        for i in 0..nodes {
            let mut change = after[i] - before[i];
            if !ring.is_length(i % travelling.block) {
                // Angles are counted within a turn.
                change = (change + PI).rem_euclid(TAU) - PI;
            }
            out.q[first + i] = now[i];
            out.y[first + i] = change / (2.0 * MOMENT);
        }
        out
    }
}

/// The deflecting ring in a state.
struct AleShape<'a> {
    model: AleRing<crate::reference_curve::TwoPulley>,
    frame: <crate::reference_curve::TwoPulley as ReferenceCurve>::Frame<f64>,
    system: &'a VariatorSystem,
    state: &'a State,
}

impl<'a> AleShape<'a> {
    fn new(system: &'a VariatorSystem, state: &'a State) -> Self {
        let mesh = RingMesh {
            elements: system.mesh.elements.clone(),
            stations: Vec::new(),
            quadrature: gauss(3),
        };
        let theta = state.q[system.layout.global(Global::Theta, 0)];
        Self {
            model: AleRing::flexible(system.law.parameters.ring.clone(), system.curve.clone(), mesh),
            frame: system.curve.frame(theta),
            system,
            state,
        }
    }

    /// The particle at ξ, m.
    fn particle(&self, xi: f64) -> Particle<f64> {
        let (element, x) = self.model.locate(&self.frame, 0.0, xi);
        let layout = &self.system.layout;
        let motion: Coordinates<f64> = std::array::from_fn(|k| {
            let at = match k {
                0..NODAL => layout.node(element + k / 4, k % 4),
                _ => layout.global(Global::Drift, k - NODAL),
            };
            Motion {
                value: self.state.q[at],
                rate: self.state.y[at],
                acceleration: self.state.y_dot[at],
            }
        });
        self.model.particle(&self.frame, element, x, &motion).0
    }
}
