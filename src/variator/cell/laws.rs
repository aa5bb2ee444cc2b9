//! The constitutive laws of a cell: flanks, friction between ring and elements, stack. Their
//! tangents change by orders of magnitude where a gap closes or a cell begins to slide. The
//! contribution of a law to the derivatives of the balance is a sum of products L S R: R, the
//! derivative of an argument in a direction, and L, that of the rows with respect to a force, are
//! geometry; S, the tangents, are derivatives of the forces with respect to their arguments. While
//! the geometry has hardly changed, an update of S alone yields the current derivatives
//! ([`Derivatives`](crate::variator::assembly::derivatives::Derivatives)).

use crate::contact::{FlankMotion, flank_force};
use crate::ring::kinematics::WithRate;
use crate::scalar::{Lanes, Real, Tangent};
use crate::stack::push_force;
use crate::variator::cell::sample::AtStation;
use crate::variator::law::ring_friction::ring_friction;
use crate::variator::mesh::belt_mesh::STATIONS;

/// Most forces and arguments of a law; those that a law does not have are zero.
///
/// | law | forces | arguments |
/// |---|---|---|
/// | flank | elastic and viscous normal force, circumferential friction, friction along the flank | penetration, its rate, circumferential sliding, sliding along |
/// | ring | friction on the elements | contact force, sliding speed |
/// | stack | push force | density, its material rate |
pub(crate) const FORCES: usize = 4;
pub(crate) const ARGUMENTS: usize = 4;

/// A value for each law of a cell: at each station of D laws, those of the flank on the movable
/// sheave, in space of that on the fixed sheave, and of the ring; then of the stack.
pub type OfLaws<V> = [V; 3 * STATIONS + 1];

/// Number of arguments of a law; the last of the `laws` is the stack's.
#[inline(always)]
pub(crate) fn argument_count<const D: usize>(law: usize, laws: usize) -> usize {
    if law % D < D - 1 && law + 1 < laws {
        ARGUMENTS
    } else {
        2
    }
}

pub(crate) type Forces = [Lanes; FORCES];
pub(crate) type Arguments<T> = [T; ARGUMENTS];
/// Tangents of each force with respect to the arguments.
pub type Tangents = [Arguments<Lanes>; FORCES];

/// Two values of the law of ring or stack.
#[inline(always)]
pub(crate) fn padded<T: Real>([first, second]: [T; 2]) -> Arguments<T> {
    [first, second, T::zero(), T::zero()]
}

#[inline(always)]
pub(crate) fn stack_arguments<T: Real>(density: WithRate<T>) -> Arguments<T> {
    padded([density.value, density.rate])
}

#[inline(always)]
pub(crate) fn flank_arguments<T: Copy>(motion: &FlankMotion<T>) -> Arguments<T> {
    [
        motion.penetration,
        motion.penetration_rate,
        motion.tangential,
        motion.along_flank,
    ]
}

#[inline(always)]
fn seeded<const N: usize>(arguments: [Lanes; N]) -> [Tangent<N>; N] {
    std::array::from_fn(|k| Tangent::seed(arguments[k], k, 1.0))
}

#[inline(always)]
pub(crate) fn record_tangents<const D: usize>(to: &mut OfLaws<Tangents>, at: &AtStation<'_, Lanes, D>) {
    let (law, friction, forces) = (at.given.law, at.given.friction, at.forces);
    let first = at.index * D;
    for (to, motion) in to[first..][..D - 1].iter_mut().zip(&forces.flanks.motions) {
        let [penetration, penetration_rate, tangential, along_flank] = seeded(flank_arguments(motion));
        let motion = FlankMotion {
            penetration,
            penetration_rate,
            tangential,
            along_flank,
        };
        let force = flank_force(&law.contact, friction, law.wedge.cos, &motion);
        *to = [force.elastic(), force.viscous, force.tangential, force.along_flank].map(|force| force.eps);
    }
    let [load, sliding] = seeded([forces.inward[0], forces.sliding]);
    to[first + D - 1][0] = padded(ring_friction(friction, load, sliding).eps);
    if at.index == 0 && !law.is_pull_chain() {
        let density = at.cell.density_with_rate();
        let [value, rate] = seeded([density.value, density.rate]);
        let push = push_force(&law.stack, WithRate { value, rate });
        to[at.given.geometry.stations.len() * D][0] = padded(push.force.eps);
    }
}

#[inline(always)]
pub(crate) fn record_arguments<T: Real, const D: usize>(
    to: &mut OfLaws<Arguments<T>>,
    at: &AtStation<'_, T, D>,
) {
    let first = at.index * D;
    for (to, motion) in to[first..][..D - 1].iter_mut().zip(&at.forces.flanks.motions) {
        *to = flank_arguments(motion);
    }
    to[first + D - 1] = padded([at.forces.inward[0], at.forces.sliding]);
    to[at.given.geometry.stations.len() * D] = stack_arguments(at.cell.density_with_rate());
}
