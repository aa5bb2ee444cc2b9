//! The constitutive laws of a cell: flanks, friction between ring and elements, stack. Each law gives forces from a handful of
//! arguments. Its contribution to the derivatives of the balance is a sum of products L S R:
//!
//! - R, the derivative of an argument in a direction, and L, the derivative of the rows with respect to a force: geometry.
//! - S, the tangents: derivatives of the forces with respect to their arguments. They change by orders of magnitude where a
//!   gap closes or a cell begins to slide.
//!
//! The rest of the derivatives is that of the balance with [frozen](Frozen) forces. A balance calls the laws in one order: stack,
//! then the flanks and the friction of each station. L, S and R follow it.

use crate::chain::{Push, push_force};
use crate::contact::{FlankForce, FlankMotion, flank_force};
use crate::scalar::{Lanes, Real, Tangent, along};
use crate::variator::cell::state::CellInput;
use crate::variator::law::place::CellLaw;
use crate::variator::law::ring_friction::{layer_drag, ring_friction};
use crate::variator::mesh::belt_mesh::STATIONS;
use num_traits::Zero;

/// Forces of a flank with tangents: normal, friction around, friction along it.
pub(crate) const FLANK_FORCES: usize = 3;
/// Arguments of these forces: those of [`FlankMotion::arguments`].
pub(crate) const FLANK_ARGUMENTS: usize = 4;
/// Arguments of the friction between ring and elements: T − m_r ṡ², sliding speed, curvature.
pub(crate) const RING_ARGUMENTS: usize = 3;
/// Arguments of the drag of the ring's layers: its share, T − m_r ṡ², curvature, speed of the ring along itself.
const LAYER_ARGUMENTS: usize = 4;
/// Arguments of the push force: density, its material rate.
pub(crate) const STACK_ARGUMENTS: usize = 2;

/// The laws as a balance calls them.
pub trait Laws<T: Real> {
    /// The push force.
    fn stack(&mut self, given: &CellInput<'_, T>, arguments: [T; STACK_ARGUMENTS]) -> Push<T>;
    /// The forces of a flank, 0 or 1, at a station. In the plane both are equal, and the first is called alone.
    fn flank(&mut self, given: &CellInput<'_, T>, at: [usize; 2], motion: &FlankMotion<T>) -> FlankForce<T>;
    /// The friction between ring and elements at a station, N/m.
    fn ring(&mut self, given: &CellInput<'_, T>, station: usize, arguments: [T; RING_ARGUMENTS]) -> T;
    /// The drag of the ring's layers at a station, N/m. It is no part of L S R, because its tangents hardly change.
    fn layers(&mut self, station: usize, arguments: [T; LAYER_ARGUMENTS]) -> T;
}

/// The laws of the scalar in use.
pub(crate) struct Direct;

/// The push force; a chain has none.
#[inline(always)]
fn stack_force<T: Real>(law: &CellLaw, arguments: [T; STACK_ARGUMENTS]) -> Push<T> {
    if law.is_chain() {
        return Push {
            force: T::zero(),
            viscous: T::zero(),
        };
    }
    push_force(&law.chain, arguments)
}

impl<T: Real> Laws<T> for Direct {
    #[inline(always)]
    fn stack(&mut self, given: &CellInput<'_, T>, arguments: [T; STACK_ARGUMENTS]) -> Push<T> {
        stack_force(given.law, arguments)
    }

    #[inline(always)]
    fn flank(&mut self, given: &CellInput<'_, T>, _at: [usize; 2], motion: &FlankMotion<T>) -> FlankForce<T> {
        flank_force(&given.law.contact, given.friction, given.law.wedge[1], motion)
    }

    #[inline(always)]
    fn ring(&mut self, given: &CellInput<'_, T>, _station: usize, arguments: [T; RING_ARGUMENTS]) -> T {
        let [pressing, sliding, kappa] = arguments;
        ring_friction(given.friction, pressing, kappa, sliding)
    }

    #[inline(always)]
    fn layers(&mut self, _station: usize, [share, pressing, kappa, speed]: [T; LAYER_ARGUMENTS]) -> T {
        layer_drag(share, pressing, kappa, speed)
    }
}

/// Tangents of the normal force, of friction around and of friction along a flank with respect to each argument.
pub(crate) type FlankTangents = [[Lanes; FLANK_ARGUMENTS]; FLANK_FORCES];

/// Tangents of the laws of a pack of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawTangents {
    pub stack: [Lanes; STACK_ARGUMENTS],
    /// At a station: of the flank on the movable sheave, and in space of that on the fixed sheave.
    pub flanks: [[FlankTangents; 2]; STATIONS],
    pub ring: [[Lanes; RING_ARGUMENTS]; STATIONS],
}

impl LawTangents {
    /// All zero.
    pub fn zero() -> Self {
        let zero = Lanes::zero();
        Self {
            stack: [zero; STACK_ARGUMENTS],
            flanks: [[[[zero; FLANK_ARGUMENTS]; FLANK_FORCES]; 2]; STATIONS],
            ring: [[zero; RING_ARGUMENTS]; STATIONS],
        }
    }
}

/// Forces of the laws of a pack of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawForces {
    stack: Push<Lanes>,
    flanks: [[FlankForce<Lanes>; 2]; STATIONS],
    ring: [Lanes; STATIONS],
    layers: [Tangent<LAYER_ARGUMENTS>; STATIONS],
}

/// The forces, recorded with their tangents.
pub(crate) struct Recorded {
    pub forces: LawForces,
    pub tangents: LawTangents,
}

impl Recorded {
    /// All zero.
    pub fn zero() -> Self {
        let zero = Lanes::zero();
        Self {
            forces: LawForces {
                stack: Push {
                    force: zero,
                    viscous: zero,
                },
                flanks: [[FlankForce::of([zero; FLANK_FORCES]); 2]; STATIONS],
                ring: [zero; STATIONS],
                layers: [Tangent::zero(); STATIONS],
            },
            tangents: LawTangents::zero(),
        }
    }
}

/// The arguments of a law, each with its own derivative.
#[inline(always)]
fn seeded<const A: usize>(arguments: [Lanes; A]) -> [Tangent<A>; A] {
    std::array::from_fn(|k| Tangent::seed(arguments[k], k, 1.0))
}

impl Laws<Lanes> for Recorded {
    #[inline(always)]
    fn stack(&mut self, given: &CellInput<'_, Lanes>, arguments: [Lanes; STACK_ARGUMENTS]) -> Push<Lanes> {
        let push = stack_force(given.law, seeded(arguments));
        self.tangents.stack = push.force.eps;
        self.forces.stack = push.map(|of| of.re);
        self.forces.stack
    }

    #[inline(always)]
    fn flank(
        &mut self,
        given: &CellInput<'_, Lanes>,
        [station, flank]: [usize; 2],
        motion: &FlankMotion<Lanes>,
    ) -> FlankForce<Lanes> {
        let motion = FlankMotion::of(seeded(motion.arguments()));
        let force = flank_force(&given.law.contact, given.friction, given.law.wedge[1], &motion);
        self.tangents.flanks[station][flank] = [force.normal.eps, force.tangential.eps, force.along_flank.eps];
        self.forces.flanks[station][flank] = force.map(|of| of.re);
        self.forces.flanks[station][flank]
    }

    #[inline(always)]
    fn ring(&mut self, given: &CellInput<'_, Lanes>, station: usize, arguments: [Lanes; RING_ARGUMENTS]) -> Lanes {
        let [pressing, sliding, kappa] = seeded(arguments);
        let friction = ring_friction(given.friction, pressing, kappa, sliding);
        self.tangents.ring[station] = friction.eps;
        self.forces.ring[station] = friction.re;
        friction.re
    }

    #[inline(always)]
    fn layers(&mut self, station: usize, arguments: [Lanes; LAYER_ARGUMENTS]) -> Lanes {
        let [share, pressing, kappa, speed] = seeded(arguments);
        self.forces.layers[station] = layer_drag(share, pressing, kappa, speed);
        self.forces.layers[station].re
    }
}

/// Laws whose forces are frozen. Records the derivatives of their arguments: R in N directions.
pub(crate) struct Frozen<'a, const N: usize> {
    pub forces: &'a LawForces,
    /// R: for each argument, a row of so many directions.
    pub right: &'a mut [Lanes],
    pub width: usize,
    /// The directions that are recorded.
    pub directions: std::ops::Range<usize>,
}

impl<const N: usize> Frozen<'_, N> {
    #[inline(always)]
    fn record<const A: usize>(&mut self, arguments: &[Tangent<N>; A]) {
        let right = std::mem::take(&mut self.right);
        let (own, next) = right.split_at_mut(A * self.width);
        self.right = next;
        for (row, argument) in own.chunks_exact_mut(self.width).zip(arguments) {
            row[self.directions.clone()]
                .iter_mut()
                .zip(argument.eps)
                .for_each(|(to, eps)| *to = eps);
        }
    }
}

impl<const N: usize> Laws<Tangent<N>> for Frozen<'_, N> {
    #[inline(always)]
    fn stack(
        &mut self,
        _given: &CellInput<'_, Tangent<N>>,
        arguments: [Tangent<N>; STACK_ARGUMENTS],
    ) -> Push<Tangent<N>> {
        self.record(&arguments);
        self.forces.stack.map(Tangent::constant)
    }

    #[inline(always)]
    fn flank(
        &mut self,
        _given: &CellInput<'_, Tangent<N>>,
        [station, flank]: [usize; 2],
        motion: &FlankMotion<Tangent<N>>,
    ) -> FlankForce<Tangent<N>> {
        self.record(&motion.arguments());
        self.forces.flanks[station][flank].map(Tangent::constant)
    }

    #[inline(always)]
    fn ring(
        &mut self,
        _given: &CellInput<'_, Tangent<N>>,
        station: usize,
        arguments: [Tangent<N>; RING_ARGUMENTS],
    ) -> Tangent<N> {
        self.record(&arguments);
        Tangent::constant(self.forces.ring[station])
    }

    #[inline(always)]
    fn layers(&mut self, station: usize, arguments: [Tangent<N>; LAYER_ARGUMENTS]) -> Tangent<N> {
        let Tangent { re, eps } = self.forces.layers[station];
        Tangent {
            re,
            eps: std::array::from_fn(|k| along(&eps, &arguments.map(|argument| argument.eps[k]))),
        }
    }
}
