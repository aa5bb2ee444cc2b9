//! The constitutive laws of a cell: flanks, friction between ring and elements, stack. Their tangents change by orders of
//! magnitude where a gap closes or a cell begins to slide. Each law has forces and arguments. Its contribution to the
//! derivatives of the balance is a sum of products L S R:
//!
//! - R, the derivative of an argument in a direction, and L, the derivative of the rows with respect to a force: geometry.
//! - S, the tangents: derivatives of the forces with respect to their arguments.
//!
//! While the geometry has hardly changed, an update of S alone yields the current derivatives
//! ([`LawPart`](crate::variator::assembly::law_part::LawPart)).

use crate::chain::{Push, push_force};
use crate::scalar::{Lanes, Real, Tangent};
use crate::variator::cell::flank_variation::{FLANK_ARGUMENTS, FLANK_FORCES, FlankTangents, flank_slopes, of_flank};
use crate::variator::cell::observer::{AtStation, StationObserver};
use crate::variator::law::ring_friction::ring_friction;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::CellRing;

/// Arguments of the friction between ring and elements, T − m_r ṡ² and sliding speed, and of the push force, density and its
/// material rate.
pub(crate) const ARGUMENTS: usize = 2;

/// A value `F` for each flank, and a value `A` for each other law of a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfLaws<F, A> {
    pub stations: [OfStation<F, A>; STATIONS],
    pub stack: A,
}

/// The values at a station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OfStation<F, A> {
    /// Of the flank on the movable sheave; in space also of the flank on the fixed sheave.
    pub flanks: [F; 2],
    pub ring: A,
}

/// Arguments of the laws, or their variations in a direction.
pub(crate) type LawArguments<T> = OfLaws<[T; FLANK_ARGUMENTS], [T; ARGUMENTS]>;
pub(crate) type StationArguments<T> = OfStation<[T; FLANK_ARGUMENTS], [T; ARGUMENTS]>;

/// Tangents of the laws of a pack of cells.
pub type LawTangents = OfLaws<FlankTangents, [Lanes; ARGUMENTS]>;
pub(crate) type StationTangents = OfStation<FlankTangents, [Lanes; ARGUMENTS]>;

impl<F: Copy, A: Copy> OfLaws<F, A> {
    /// The same values everywhere.
    #[inline(always)]
    pub fn filled(flank: F, other: A) -> Self {
        let station = OfStation {
            flanks: [flank; 2],
            ring: other,
        };
        Self {
            stations: [station; STATIONS],
            stack: other,
        }
    }
}

impl<T: Real> LawArguments<T> {
    /// All zero.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::filled([T::zero(); FLANK_ARGUMENTS], [T::zero(); ARGUMENTS])
    }

    /// Applies `f` to each.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> LawArguments<U> {
        OfLaws {
            stations: self.stations.map(|at| OfStation {
                flanks: at.flanks.map(|flank| flank.map(&f)),
                ring: at.ring.map(&f),
            }),
            stack: self.stack.map(&f),
        }
    }
}

impl LawTangents {
    /// All zero.
    pub(crate) fn zero() -> Self {
        Self::filled(FlankTangents::default(), Default::default())
    }
}

/// Numbers of stations and of distinct flanks of a cell, which determine the number of its laws.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extent {
    pub stations: usize,
    pub flanks: usize,
}

impl Extent {
    /// Of a cell with this number of stations and components; in the plane both flanks are equal.
    pub fn new(stations: usize, components: usize) -> Self {
        Self {
            stations,
            flanks: components - 1,
        }
    }

    /// Number of forces.
    pub fn forces(self) -> usize {
        self.stations * (self.flanks * FLANK_FORCES + 1) + 1
    }

    /// Number of arguments.
    pub fn arguments(self) -> usize {
        self.stations * (self.flanks * FLANK_ARGUMENTS + ARGUMENTS) + ARGUMENTS
    }
}

/// Records the tangents of the laws; those of the second flank in space only.
pub(crate) struct TangentRecorder<'a>(pub &'a mut LawTangents);

impl<const D: usize> StationObserver<Lanes, D> for TangentRecorder<'_> {
    #[inline(always)]
    fn observe<R: CellRing<Lanes, D>>(&mut self, at: &AtStation<'_, Lanes, D, R>) {
        let (given, forces) = (at.given, at.forces);
        let to = &mut self.0.stations[at.index];
        for (to, motion) in to.flanks.iter_mut().zip(&forces.flanks.motions).take(D - 1) {
            *to = flank_slopes(given.law, given.friction, motion);
        }
        to.ring = ring_friction(
            given.friction,
            Tangent::<ARGUMENTS>::seed(forces.pressing, 0, 1.0),
            Tangent::constant(at.station.ring.reference.kappa),
            Tangent::seed(forces.sliding, 1, 1.0),
        )
        .eps;
        if at.index == 0 {
            let arguments = at.cell.stack_arguments();
            let seeded = std::array::from_fn(|k| Tangent::<ARGUMENTS>::seed(arguments[k], k, 1.0));
            let law = given.law;
            let push = if law.is_chain() {
                Push::none()
            } else {
                push_force(&law.chain, seeded)
            };
            self.0.stack = push.force.eps;
        }
    }
}

/// Records the arguments of the laws.
pub(crate) struct ArgumentRecorder<'a, T>(pub &'a mut LawArguments<T>);

impl<T: Real, const D: usize> StationObserver<T, D> for ArgumentRecorder<'_, T> {
    #[inline(always)]
    fn observe<R: CellRing<T, D>>(&mut self, at: &AtStation<'_, T, D, R>) {
        let to = &mut self.0.stations[at.index];
        to.flanks = at.forces.flanks.motions.each_ref().map(of_flank);
        to.ring = [at.forces.pressing, at.forces.sliding];
        self.0.stack = at.cell.stack_arguments();
    }
}
