//! The regime of a pack of cells: the tangents of its laws, its flow and its curvature.

use crate::contact::Friction;
use crate::scalar::{Lanes, Real};
use crate::variator::cell::laws::{FlankTangents, LawTangents, STACK_ARGUMENTS};
use crate::variator::cell::observer::{AtStation, StationObserver};
use crate::variator::law::place::CellLaw;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::CellRing;
use num_traits::Zero;

/// Change of a value, relative to its size and to one, at which derivatives are no longer valid.
const CHANGED: f64 = 0.03;
/// Lower bound of the friction coefficient in the scale of friction tangents.
const LEAST_FRICTION: f64 = 0.01;

/// Flow of the elements at a station, and curvature of the belt there.
#[derive(Clone, Copy, Debug)]
struct Flow {
    /// Number of cell lengths that pass during the step.
    convection: Lanes,
    /// Reference curvature, 1/m. It jumps where arcs move through the mesh.
    curvature: Lanes,
}

/// Regime of a pack of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Regime {
    pub laws: LawTangents,
    flows: [Flow; STATIONS],
}

/// Scales of the tangents of the laws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TangentScales {
    /// Reciprocal of the stiffness of a flank, m²/N, and the same divided by its friction coefficient.
    flank: f64,
    friction: f64,
    /// Reciprocal of the stiffness of the stack, 1/N.
    stack: f64,
    /// Reciprocal of the inertia of the elements per belt length in the step, m²/(N·s).
    inertia: f64,
    /// The same, divided by the square of the length of a station, 1/(N·s).
    of_rate: Lanes,
}

impl TangentScales {
    /// For a step with this factor 1/(hγ), 1/s, and stations of this length, m.
    #[inline(always)]
    pub fn new(law: &CellLaw, friction: &Friction, alpha: f64, length: Lanes) -> Self {
        let flank = 1.0 / (law.contact.stiffness * law.wedge[1]);
        let inertia = 1.0 / (law.sliding_mass() * alpha);
        let per_length = length.recip();
        Self {
            flank,
            friction: flank / friction.pulley.max(LEAST_FRICTION),
            stack: 1.0 / law.chain.push_stiffness,
            inertia,
            of_rate: per_length * per_length * inertia,
        }
    }

    /// Tangents of a flank's forces with respect to penetration, and of its friction with respect to sliding.
    #[inline(always)]
    fn flank(&self, [normal, around, across]: &FlankTangents) -> [Lanes; 6] {
        let inertia = 2.0 * self.inertia;
        [
            normal[0] * self.flank,
            around[0] * self.friction,
            across[0] * self.friction,
            around[2] * inertia,
            around[3] * inertia,
            across[3] * inertia,
        ]
    }

    /// Tangents of the push force with respect to density and its rate.
    #[inline(always)]
    fn stack(&self, push: &[Lanes; STACK_ARGUMENTS]) -> [Lanes; 2] {
        [push[0] * self.stack, push[1] * self.of_rate]
    }
}

/// Whether all of these values have hardly changed, in every lane.
#[inline(always)]
fn alike<const N: usize>(now: [Lanes; N], then: [Lanes; N]) -> bool {
    now.iter().zip(&then).all(|(&now, &then)| {
        let off = now - then;
        let allowed = then * then + 1.0;
        // |off| < CHANGED·√(1 + then²) in every lane; false for NaN.
        let (off, allowed) = ((off * off).to_array(), (allowed * (CHANGED * CHANGED)).to_array());
        off.iter().zip(&allowed).all(|(off, allowed)| off < allowed)
    })
}

impl Regime {
    /// All zero.
    pub fn zero() -> Self {
        let zero = Lanes::zero();
        Self {
            laws: LawTangents::zero(),
            flows: [Flow {
                convection: zero,
                curvature: zero,
            }; STATIONS],
        }
    }

    /// Whether the tangents of the laws in the regime `earlier` are valid in this one.
    #[inline(always)]
    pub fn has_laws_of(&self, earlier: &Self, scales: &TangentScales) -> bool {
        let (now, then) = (&self.laws, &earlier.laws);
        let mut flanks = (now.flanks.as_flattened().iter()).zip(then.flanks.as_flattened());
        let mut ring = now.ring.iter().zip(&then.ring);
        alike(scales.stack(&now.stack), scales.stack(&then.stack))
            && flanks.all(|(now, then)| alike(scales.flank(now), scales.flank(then)))
            && ring.all(|(now, then)| alike([now[1] * scales.inertia], [then[1] * scales.inertia]))
    }

    /// Whether flow and curvature are those of the regime `earlier`, in which 1/(hγ) was smaller by the factor `ratio`.
    #[inline(always)]
    pub fn flows_as(&self, earlier: &Self, ratio: f64) -> bool {
        self.flows.iter().zip(&earlier.flows).all(|(now, then)| {
            alike(
                [now.convection * ratio, now.curvature],
                [then.convection, then.curvature],
            )
        })
    }
}

/// Records the regime of a pack.
pub(crate) struct RegimeObserver<'a> {
    /// Factor 1/(hγ) of ẏ in the derivatives, 1/s.
    pub alpha: f64,
    pub regime: &'a mut Regime,
}

impl<const D: usize> StationObserver<Lanes, D> for RegimeObserver<'_> {
    #[inline(always)]
    fn observe<R: CellRing<Lanes, D>>(&mut self, at: &AtStation<'_, Lanes, D, R>) {
        self.regime.flows[at.index] = Flow {
            convection: at.station.chain.flow / (at.station.weight * self.alpha),
            curvature: at.station.ring.reference.kappa,
        };
    }
}
