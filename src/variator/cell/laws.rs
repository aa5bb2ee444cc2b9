//! The constitutive laws of a cell, whose tangents change by orders of magnitude where a gap closes or a cell begins to
//! slide: flanks, friction between ring and elements, stack. Each gives some forces that depend on some arguments. In the
//! derivatives of the balance they are a sum of products L S R:
//!
//! - R is the derivative of an argument in a direction, L the place of a force in the rows: geometry.
//! - S are the tangents, the slopes of the forces by their arguments.
//!
//! So an update of S alone gives the present derivatives
//! ([`LawPart`](crate::variator::assembly::law_part::LawPart)), as long as the geometry has hardly changed.

use crate::chain::Stack;
use crate::scalar::{Lanes, Real, Tangent};
use crate::variator::cell::flank_variation::{FLANK_ARGUMENTS, FLANK_FORCES, FlankSlopes, flank_slopes, of_flank};
use crate::variator::cell::observer::{AtStation, Observer};
use crate::variator::law::ring_friction::ring_friction;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::CellRing;
use num_traits::Zero;

/// Arguments of the friction between ring and elements: T − m_r ṡ², sliding speed.
pub(crate) const RING_ARGUMENTS: usize = 2;
/// Forces in a stack: push force, collision force.
pub(crate) const STACK_FORCES: usize = 2;
/// Arguments of a stack's laws: density, its material rate, flow, difference of V, rate of the density at fixed mesh points.
pub(crate) const STACK_ARGUMENTS: usize = 5;

/// Arguments of the laws, or their variations in a direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arguments<T> {
    pub stations: [StationArguments<T>; STATIONS],
    pub stack: [T; STACK_ARGUMENTS],
}

/// Arguments at a station.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StationArguments<T> {
    /// Of the flank on the movable sheave; in space also of that on the fixed one.
    pub flanks: [[T; FLANK_ARGUMENTS]; 2],
    pub ring: [T; RING_ARGUMENTS],
}

impl<T: Real> Arguments<T> {
    /// All zero.
    #[inline(always)]
    pub fn zero() -> Self {
        let zero = T::zero();
        let station = StationArguments {
            flanks: [[zero; FLANK_ARGUMENTS]; 2],
            ring: [zero; RING_ARGUMENTS],
        };
        Self {
            stations: [station; STATIONS],
            stack: [zero; STACK_ARGUMENTS],
        }
    }
}

impl<T: Copy> Arguments<T> {
    /// A part of each.
    #[inline(always)]
    pub fn map<U>(&self, part: impl Fn(T) -> U) -> Arguments<U> {
        Arguments {
            stations: self.stations.each_ref().map(|at| StationArguments {
                flanks: at.flanks.map(|flank| flank.map(&part)),
                ring: at.ring.map(&part),
            }),
            stack: self.stack.map(&part),
        }
    }
}

/// How many laws a cell has: at so many stations, with so many flanks that differ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub stations: usize,
    pub flanks: usize,
}

impl Extent {
    /// Of a cell with so many stations, in so many components: in the plane both flanks are alike.
    pub fn new(stations: usize, components: usize) -> Self {
        Self {
            stations,
            flanks: components - 1,
        }
    }

    /// Number of forces.
    pub fn forces(self) -> usize {
        self.stations * (self.flanks * FLANK_FORCES + 1) + STACK_FORCES
    }

    /// Number of arguments.
    pub fn arguments(self) -> usize {
        self.stations * (self.flanks * FLANK_ARGUMENTS + RING_ARGUMENTS) + STACK_ARGUMENTS
    }
}

/// A force that a law gives.
#[derive(Clone, Copy, Debug)]
pub(crate) enum LawForce {
    /// At a station, on the flank 0 or 1: its number among [`FLANK_FORCES`].
    Flank { station: usize, flank: usize, force: usize },
    /// Friction of the ring at a station.
    Ring { station: usize },
    /// The push force.
    Push,
    /// The collision force.
    Collision,
}

/// Slopes of the laws of a pack of cells.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LawSlopes {
    pub stations: [StationSlopes; STATIONS],
    pub stack: [[Lanes; STACK_ARGUMENTS]; STACK_FORCES],
    /// Of the lag, which is no force.
    pub lag: [Lanes; STACK_ARGUMENTS],
}

/// Slopes of the laws at a station.
#[derive(Clone, Copy, Debug)]
pub(crate) struct StationSlopes {
    pub flanks: [FlankSlopes; 2],
    pub ring: [Lanes; RING_ARGUMENTS],
}

impl LawSlopes {
    /// No slopes.
    pub fn zero() -> Self {
        let zero = Lanes::zero();
        let station = StationSlopes {
            flanks: [[[zero; FLANK_ARGUMENTS]; FLANK_FORCES]; 2],
            ring: [zero; RING_ARGUMENTS],
        };
        Self {
            stations: [station; STATIONS],
            stack: [[zero; STACK_ARGUMENTS]; STACK_FORCES],
            lag: [zero; STACK_ARGUMENTS],
        }
    }
}

/// Finds the slopes of the laws: those of a second flank in space alone.
pub(crate) struct TangentRecorder<'a>(pub &'a mut LawSlopes);

impl<const D: usize> Observer<Lanes, D> for TangentRecorder<'_> {
    #[inline(always)]
    fn observe<R: CellRing<Lanes, D>>(&mut self, at: &AtStation<'_, Lanes, D, R>) {
        let (given, forces) = (at.given, at.forces);
        let to = &mut self.0.stations[at.index];
        for (to, motion) in to.flanks.iter_mut().zip(&forces.flanks.motions).take(D - 1) {
            *to = flank_slopes(given.law, given.friction, motion);
        }
        to.ring = ring_friction(
            given.friction,
            Tangent::<RING_ARGUMENTS>::seed(forces.pressing, 0, 1.0),
            Tangent::constant(at.station.ring.reference.kappa),
            Tangent::seed(forces.sliding, 1, 1.0),
        )
        .eps;
        if at.index == 0 {
            let arguments = at.cell.stack_arguments();
            let seeded = std::array::from_fn(|k| Tangent::<STACK_ARGUMENTS>::seed(arguments[k], k, 1.0));
            let Stack { push, collision, lag } = Stack::new(&given.law.chain, seeded);
            self.0.stack = [push.force.eps, collision.eps];
            self.0.stack[0][STACK_ARGUMENTS - 1] = Lanes::from(given.law.settling);
            self.0.lag = lag.eps;
        }
    }
}

/// Keeps the arguments of the laws.
pub(crate) struct ArgumentRecorder<'a, T>(pub &'a mut Arguments<T>);

impl<T: Real, const D: usize> Observer<T, D> for ArgumentRecorder<'_, T> {
    #[inline(always)]
    fn observe<R: CellRing<T, D>>(&mut self, at: &AtStation<'_, T, D, R>) {
        let to = &mut self.0.stations[at.index];
        to.flanks = at.forces.flanks.motions.each_ref().map(of_flank);
        to.ring = [at.forces.pressing, at.forces.sliding];
        let [nu, nu_rate, flow, difference] = at.cell.stack_arguments();
        self.0.stack = [nu, nu_rate, flow, difference, at.cell.density_rate];
    }
}
