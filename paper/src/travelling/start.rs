//! Start of a travelling ring on the shape of the deflecting ring of `ALE`.
//!
//! Its nodes pass under the stations, so it has no steady state but a periodic one, with the period
//! of an element. The steady solver computes the state of `ALE`. Position, slope and velocity of
//! the nodes are those of its material; everything else is the same. The elements cannot follow
//! this shape exactly and are stretched by it. This transient decays within the first pass of an
//! element.

use crate::reference_curve::{TwoPulley, TwoPulleyFrame};
use crate::ring::ale_ring::AleRing;
use crate::ring::kinematics::Motion;
use crate::ring::lagrangian::{LagrangianElement, LagrangianRing};
use crate::ring::mesh::{RingMesh, gauss};
use crate::ring::model::{Coordinates, ElementPlace, NODAL, RingFormulation};
use crate::ring::particle::Particle;
use crate::solver::State;
use pushbelt::variator::ring_models::{Belt, NodeUnknown};
use std::f64::consts::{PI, TAU};

/// Half the time of the difference quotient of the unknowns, s, in which the ring moves by a
/// micrometre.
const MOMENT: f64 = 1.0e-7;

/// The state of `belt` in which its `ring` has the shape of the deflecting ring of `ale`, on the
/// same mesh.
#[must_use]
pub(crate) fn state_on_ale<E: LagrangianElement>(
    belt: &Belt,
    ring: &LagrangianRing<E, TwoPulley>,
    ale: &Belt,
    state: &State,
) -> State {
    let layout = &belt.layout;
    let mut out = State::zero(layout.len());
    for (to, from) in belt.cells_at.iter().zip(&ale.cells_at) {
        out.y[to.speed] = state.y[from.speed];
        out.y[to.content] = state.y[from.content];
    }
    for (to, from) in layout.globals().zip(ale.layout.globals()) {
        out.y[to] = state.y[from];
        out.q[to] = state.q[from];
    }
    out.q[layout.drift()] = 0.0;
    let shape = AleShape::new(ale, state);
    let placed = |time: f64| {
        let at = |xi: f64| {
            let p = shape.particle(xi);
            [p.r + p.velocity * time, p.slope + p.velocity_slope * time]
        };
        let mut q = vec![0.0; ring.elements() * E::BLOCK + 2];
        ring.place_on(&at, &mut q);
        q
    };
    let [before, now, after] = [-MOMENT, 0.0, MOMENT].map(placed);
    for (k, NodeUnknown { index, is_length }) in layout.node_unknowns().enumerate() {
        let mut change = after[k] - before[k];
        if !is_length {
            // Difference of angles, within half a turn.
            change = (change + PI).rem_euclid(TAU) - PI;
        }
        out.q[index] = now[k];
        out.y[index] = change / (2.0 * MOMENT);
    }
    out
}

/// The deflecting ring in a state.
struct AleShape<'a> {
    model: AleRing<TwoPulley>,
    frame: TwoPulleyFrame<f64>,
    belt: &'a Belt,
    state: &'a State,
}

impl<'a> AleShape<'a> {
    fn new(belt: &'a Belt, state: &'a State) -> Self {
        let mesh = RingMesh {
            elements: belt.mesh.elements.clone(),
            stations: Vec::new(),
            quadrature: gauss(3),
        };
        Self {
            model: AleRing::flexible(belt.law.ring.clone(), belt.curve.clone(), mesh),
            frame: belt.curve.frame(belt.theta(state.view())),
            belt,
            state,
        }
    }

    /// The particle at ξ, m.
    fn particle(&self, xi: f64) -> Particle<f64> {
        let ElementPlace { element, x } = self.model.locate(&self.frame, 0.0, xi);
        let layout = &self.belt.layout;
        let motion: Coordinates<f64> = std::array::from_fn(|k| {
            let at = match k {
                0..NODAL => layout.node(element + k / 4, k % 4),
                NODAL => layout.drift(),
                _ => layout.theta(),
            };
            Motion {
                value: self.state.q[at],
                rate: self.state.y[at],
                acceleration: self.state.y_dot[at],
            }
        });
        self.model.particle(&self.frame, element, x, &motion)
    }
}
