//! The regime of a pack of cells: the slopes of its laws, how it flows, and how it bends.

use crate::contact::Friction;
use crate::scalar::{Lanes, Real};
use crate::variator::cell::flank_variation::FlankSlopes;
use crate::variator::cell::laws::{LawSlopes, STACK_ARGUMENTS, STACK_FORCES, TangentRecorder};
use crate::variator::cell::observer::{AtStation, Observer};
use crate::variator::law::place::CellLaw;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::CellRing;
use num_traits::Zero;

/// Change of a figure at which derivatives are no longer good, relative to its size and to one.
const CHANGED: f64 = 0.03;
/// Least coefficient of friction that slopes of friction are compared with.
const LEAST_FRICTION: f64 = 0.01;

/// How elements flow through a station, and how the belt bends there.
#[derive(Clone, Copy, Debug)]
struct Flow {
    /// Cell lengths that pass in the time of the step.
    convection: Lanes,
    /// Reference curvature, 1/m: where arcs move through the mesh it jumps.
    curvature: Lanes,
}

/// Regime of a pack of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Regime {
    pub laws: LawSlopes,
    flows: [Flow; STATIONS],
}

/// What slopes of the laws are compared with.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Units {
    /// One by the stiffness of a flank, m²/N; the same by its coefficient of friction.
    flank: f64,
    friction: f64,
    /// One by the stiffness of the stack, 1/N.
    stack: f64,
    /// One by the inertia of the elements per belt length that resists in the step, m²/(N·s).
    inertia: f64,
    /// The same for those of a station, m/(N·s), and one by its length, 1/m.
    station: Lanes,
    per_length: Lanes,
}

impl Units {
    /// In a step with this factor 1/(hγ), 1/s, for stations of this length, m.
    #[inline(always)]
    pub fn new(law: &CellLaw, friction: &Friction, alpha: f64, length: Lanes) -> Self {
        let flank = 1.0 / (law.contact.stiffness * law.wedge[1]);
        let inertia = 1.0 / (law.chain.mass_per_length * alpha);
        let per_length = length.recip();
        Self {
            flank,
            friction: flank / friction.pulley.max(LEAST_FRICTION),
            stack: 1.0 / law.chain.push_stiffness,
            inertia,
            station: per_length * inertia,
            per_length,
        }
    }

    /// Slopes of a flank's forces by penetration, and of its friction by sliding.
    #[inline(always)]
    fn flank(&self, [normal, around, across]: &FlankSlopes) -> [Lanes; 6] {
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

    /// Slopes of the push force by density and by its rate, and of the collision force by the difference of V.
    #[inline(always)]
    fn stack(&self, [push, collision]: &[[Lanes; STACK_ARGUMENTS]; STACK_FORCES]) -> [Lanes; 3] {
        [
            push[0] * self.stack,
            push[1] * self.station * self.per_length,
            collision[3] * self.station,
        ]
    }
}

/// Whether each of these figures has hardly changed, in every lane.
#[inline(always)]
fn alike<const N: usize>(now: [Lanes; N], then: [Lanes; N]) -> bool {
    now.iter().zip(&then).all(|(&now, &then)| {
        let off = now - then;
        let allowed = then * then + 1.0;
        // |off| < CHANGED·√(1 + then²), in every lane; not so for NaN.
        let (off, allowed) = ((off * off).to_array(), (allowed * (CHANGED * CHANGED)).to_array());
        off.iter().zip(&allowed).all(|(off, allowed)| off < allowed)
    })
}

impl Regime {
    /// No slopes and no flow.
    pub fn zero() -> Self {
        let zero = Lanes::zero();
        Self {
            laws: LawSlopes::zero(),
            flows: [Flow {
                convection: zero,
                curvature: zero,
            }; STATIONS],
        }
    }

    /// Whether the slopes of the laws in the regime `earlier` are good in this one.
    #[inline(always)]
    pub fn has_laws_of(&self, earlier: &Self, units: &Units) -> bool {
        let (now, then) = (&self.laws, &earlier.laws);
        let mut stations = now.stations.iter().zip(&then.stations);
        alike(units.stack(&now.stack), units.stack(&then.stack))
            && stations.all(|(now, then)| {
                let mut flanks = now.flanks.iter().zip(&then.flanks);
                flanks.all(|(now, then)| alike(units.flank(now), units.flank(then)))
                    && alike([now.ring[1] * units.inertia], [then.ring[1] * units.inertia])
            })
    }

    /// Whether the belt flows and bends as in the regime `earlier`, when 1/(hγ) was a `ratio` smaller.
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

impl<const D: usize> Observer<Lanes, D> for RegimeObserver<'_> {
    #[inline(always)]
    fn observe<R: CellRing<Lanes, D>>(&mut self, at: &AtStation<'_, Lanes, D, R>) {
        TangentRecorder(&mut self.regime.laws).observe(at);
        self.regime.flows[at.index] = Flow {
            convection: at.station.chain.flow / (at.station.weight * self.alpha),
            curvature: at.station.ring.reference.kappa,
        };
    }
}
