//! The constitutive laws of a cell: flanks, friction between ring and elements, stack. Their tangents change by orders of
//! magnitude where a gap closes or a cell begins to slide. Each law has forces and arguments. Its contribution to the
//! derivatives of the balance is a sum of products L S R:
//!
//! - R, the derivative of an argument in a direction, and L, the derivative of the rows with respect to a force: geometry.
//! - S, the tangents: derivatives of the forces with respect to their arguments.
//!
//! While the geometry has hardly changed, an update of S alone yields the current derivatives
//! ([`Derivatives`](crate::variator::assembly::derivatives::Derivatives)).

use crate::chain::push_force;
use crate::scalar::{Lanes, Real, Tangent};
use crate::variator::cell::flank_variation::{FLANK_ARGUMENTS, FlankTangents, flank_tangents, of_flank};
use crate::variator::cell::sample::AtStation;
use crate::variator::law::ring_friction::ring_friction;
use crate::variator::mesh::belt_mesh::STATIONS;

/// Arguments of the friction between ring and elements, T − m_r ṡ² and sliding speed, and of the push force, density and its
/// material rate.
pub(crate) const ARGUMENTS: usize = 2;

/// A value `F` for each flank, and a value `A` for each other law of a cell.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OfLaws<F, A> {
    pub stations: [OfStation<F, A>; STATIONS],
    pub stack: A,
}

/// The values at a station.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

impl LawTangents {
    /// Records the tangents of the laws at a station; those of the second flank in space only.
    #[inline(always)]
    pub(crate) fn record<const D: usize>(&mut self, at: &AtStation<'_, Lanes, D>) {
        let (given, forces) = (at.given, at.forces);
        let to = &mut self.stations[at.index];
        for (to, motion) in to.flanks.iter_mut().zip(&forces.flanks.motions).take(D - 1) {
            *to = flank_tangents(given.law, given.friction, motion);
        }
        to.ring = ring_friction(
            given.friction,
            Tangent::<ARGUMENTS>::seed(forces.pressing, 0, 1.0),
            Tangent::constant(at.station.ring.reference.kappa),
            Tangent::seed(forces.sliding, 1, 1.0),
        )
        .eps;
        if at.index == 0 && !given.law.is_chain() {
            let arguments = at.cell.stack_arguments();
            let seeded = std::array::from_fn(|k| Tangent::<ARGUMENTS>::seed(arguments[k], k, 1.0));
            self.stack = push_force(&given.law.chain, seeded).force.eps;
        }
    }
}

impl<T: Real> LawArguments<T> {
    /// All zero.
    #[inline(always)]
    pub(crate) fn zero() -> Self {
        let other = [T::zero(); ARGUMENTS];
        let station = OfStation {
            flanks: [[T::zero(); FLANK_ARGUMENTS]; 2],
            ring: other,
        };
        Self {
            stations: [station; STATIONS],
            stack: other,
        }
    }

    /// Records the arguments of the laws at a station.
    #[inline(always)]
    pub(crate) fn record<const D: usize>(&mut self, at: &AtStation<'_, T, D>) {
        let to = &mut self.stations[at.index];
        to.flanks = at.forces.flanks.motions.each_ref().map(of_flank);
        to.ring = [at.forces.pressing, at.forces.sliding];
        self.stack = at.cell.stack_arguments();
    }
}
