//! The balance of a pack of cells, generic over the scalar.

use crate::reference_curve::{COORDINATES, Jet, MeshCurve, Path};
use crate::scalar::{Lanes, Real};
use crate::solver::View;
use crate::variator::assembly::kinds::RingKind;
use crate::variator::assembly::pack::Pack;
use crate::variator::assembly::unknowns::{ReadUnknowns, motion};
use crate::variator::belt::Belt;
use crate::variator::belt::equations::InForce;
use crate::variator::cell::balance::balance;
use crate::variator::cell::directions::Directions;
use crate::variator::cell::observer::{Sampler, StationObserver};
use crate::variator::cell::sample::Sample;
use crate::variator::cell::state::CellInput;
use crate::variator::law::place::CellBalance;
use crate::variator::rings::ring::{EulerianRing, RingForces};

/// The path along which a ring of kind `K` follows the curve, with the motion `path`: that of Θ as the variable, unless
/// the curve has other coordinates.
#[inline(always)]
pub(crate) fn path_of<T: Real, K: Directions>(path: Path<T>) -> Path<T> {
    if K::COORDINATES > 1 {
        return path;
    }
    let mut by_theta = [Jet::constant(0.0); COORDINATES];
    by_theta[0] = Jet::variable(path[0].v);
    by_theta
}

/// The frame of the curve at a state.
#[inline(always)]
pub(crate) fn frame<K: Directions, C: MeshCurve>(belt: &Belt, view: View<'_>) -> C::Frame<Lanes> {
    C::on_path(&belt.curve, &path_of::<_, K>(belt.path(view).map(Jet::lifted)))
}

/// The balance of a pack of cells; `record` is called with the values at every station.
#[inline(never)]
pub(crate) fn sampled_balance<K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    acting: InForce<'_>,
    of: (&K, &Pack),
    frame: &C::Frame<Lanes>,
    unknowns: &impl ReadUnknowns<Lanes>,
    record: &mut dyn FnMut(Sample<Lanes>),
) {
    let seed = |value, _, _| value;
    pack_balance::<_, _, K, D, C>(acting, of, frame, unknowns, [0.0; 2], seed, &mut Sampler(record));
}

/// The balance of a pack of cells with this kind of ring; `seed` makes a scalar from a value, its direction and its
/// derivative.
#[inline(always)]
pub(crate) fn pack_balance<
    T: Real<Constant = Lanes>,
    S: StationObserver<T, D>,
    K: RingKind<D, C>,
    const D: usize,
    C: MeshCurve,
>(
    InForce { law, friction, .. }: InForce<'_>,
    (kind, pack): (&K, &Pack),
    frame: &C::Frame<T>,
    unknowns: &impl ReadUnknowns<Lanes>,
    slopes: [f64; 2],
    seed: impl Fn(Lanes, usize, f64) -> T,
    observer: &mut S,
) -> (CellBalance<T>, RingForces<T, D>) {
    let motion = motion::<T, K>(unknowns, slopes, &seed);
    let place = pack.place::<T, C>(law, frame);
    let reference = |slot: usize| C::point(frame, pack.segment, place.fraction(slot));
    let at = (frame, pack.segment);
    let mut ring = kind.ring::<T>(&law.ring, (&place, &motion.reference), at, unknowns, slopes, &seed);
    let given = CellInput {
        law,
        friction,
        place: &place,
        motion: &motion,
    };
    let b = balance(&given, &mut ring, reference, observer);
    (b, ring.forces())
}
