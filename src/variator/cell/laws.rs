//! The constitutive laws of a cell: flanks, friction between ring and elements, stack. Their
//! tangents change by orders of magnitude where a gap closes or a cell begins to slide. Each law
//! has forces and arguments. Its contribution to the derivatives of the balance is a sum of
//! products L S R:
//!
//! - R, the derivative of an argument in a direction, and L, the derivative of the rows with
//!   respect to a force: geometry.
//! - S, the tangents: derivatives of the forces with respect to their arguments.
//!
//! While the geometry has hardly changed, an update of S alone yields the current derivatives
//! ([`Derivatives`](crate::variator::assembly::derivatives::Derivatives)).

use crate::contact::{FlankMotion, flank_force};
use crate::scalar::{Lanes, Real, Tangent};
use crate::stack::push_force;
use crate::variator::cell::sample::AtStation;
use crate::variator::law::ring_friction::ring_friction;
use crate::variator::mesh::belt_mesh::STATIONS;

/// Most forces of a law, and most arguments; those that a law does not have are zero.
///
/// | law | forces | arguments |
/// |---|---|---|
/// | flank | normal, circumferential friction, friction along the flank | penetration, penetration rate, circumferential sliding, sliding along |
/// | ring | friction on the elements | T − m_r ṡ², sliding speed |
/// | stack | push force | density, its material rate |
pub(crate) const FORCES: usize = 3;
pub(crate) const ARGUMENTS: usize = 4;

/// A value for each law of a cell: at each station of D laws, those of the flank on the movable
/// sheave, in space of that on the fixed sheave, and of the ring; then of the stack.
pub type OfLaws<V> = [V; 3 * STATIONS + 1];

/// Numbers of forces and arguments of a law, the last of which is the stack's.
#[inline(always)]
pub(crate) fn sizes<const D: usize>(law: usize, laws: usize) -> [usize; 2] {
    if law % D < D - 1 && law + 1 < laws {
        [FORCES, ARGUMENTS]
    } else {
        [1, 2]
    }
}

/// Forces of a law, or their variations.
pub(crate) type Forces = [Lanes; FORCES];
/// Arguments of a law, or their variations.
pub(crate) type Arguments<T> = [T; ARGUMENTS];
/// Tangents of each force with respect to the arguments.
pub type Tangents = [Arguments<Lanes>; FORCES];

/// The two arguments of the ring's law or of the stack's.
#[inline(always)]
pub(crate) fn of_two<T: Real>([first, second]: [T; 2]) -> Arguments<T> {
    [first, second, T::zero(), T::zero()]
}

/// The arguments of a flank's law.
#[inline(always)]
pub(crate) fn of_flank<T: Copy>(motion: &FlankMotion<T>) -> Arguments<T> {
    [
        motion.penetration,
        motion.penetration_rate,
        motion.tangential,
        motion.along_flank,
    ]
}

/// Arguments with their own derivatives.
#[inline(always)]
fn seeded<const N: usize>(arguments: [Lanes; N]) -> [Tangent<N>; N] {
    std::array::from_fn(|k| Tangent::seed(arguments[k], k, 1.0))
}

/// Records the tangents of the laws at a station.
#[inline(always)]
pub(crate) fn record_tangents<const D: usize>(to: &mut OfLaws<Tangents>, at: &AtStation<'_, Lanes, D>) {
    let (law, friction, forces) = (at.given.law, at.given.friction, at.forces);
    let first = at.index * D;
    for (to, motion) in to[first..][..D - 1].iter_mut().zip(&forces.flanks.motions) {
        let [penetration, penetration_rate, tangential, along_flank] = seeded(of_flank(motion));
        let motion = FlankMotion {
            penetration,
            penetration_rate,
            tangential,
            along_flank,
        };
        let force = flank_force(&law.contact, friction, law.wedge[1], &motion);
        *to = [force.normal.eps, force.tangential.eps, force.along_flank.eps];
    }
    let kappa = Tangent::constant(at.station.ring.reference.kappa);
    let [pressing, sliding] = seeded([forces.pressing, forces.sliding]);
    to[first + D - 1][0] = of_two(ring_friction(friction, pressing, kappa, sliding).eps);
    if at.index == 0 && !law.is_pull_chain() {
        let push = push_force(&law.stack, seeded(at.cell.stack_arguments()));
        to[at.given.geometry.stations.len() * D][0] = of_two(push.force.eps);
    }
}

/// Records the arguments of the laws at a station.
#[inline(always)]
pub(crate) fn record_arguments<T: Real, const D: usize>(
    to: &mut OfLaws<Arguments<T>>,
    at: &AtStation<'_, T, D>,
) {
    let first = at.index * D;
    for (to, motion) in to[first..][..D - 1].iter_mut().zip(&at.forces.flanks.motions) {
        *to = of_flank(motion);
    }
    to[first + D - 1] = of_two([at.forces.pressing, at.forces.sliding]);
    to[at.given.geometry.stations.len() * D] = of_two(at.cell.stack_arguments());
}
