//! Derivatives of a pack of cells: analytic where available, otherwise by forward differentiation.

use crate::chain::Transport;
use crate::reference_curve::{COORDINATES, DisplacedCurve, Jet, Path, TwoPulley};
use crate::ring::Ring;
use crate::ring::kinematics::ReferenceMotion;
use crate::scalar::{Lanes, Real, Tangent};
use crate::variator::assembly::evaluate::pack_balance;
use crate::variator::assembly::jacobian_cache::{CacheUpdate, JacobianCache};
use crate::variator::assembly::kinds::{MeshCurve, RingKind};
use crate::variator::assembly::law_part::{LawPart, in_block};
use crate::variator::assembly::pack::Pack;
use crate::variator::assembly::regime::{Regime, RegimeObserver, TangentScales};
use crate::variator::assembly::unknowns::{ReadUnknowns, Unknowns, motion, rows};
use crate::variator::belt::equations::InForce;
use crate::variator::belt::equations::ReusePolicy;
use crate::variator::cell::balance::balance_in;
use crate::variator::cell::directions::{DeflectingRing, Directions, GuidedRing, MOST, MOST_ROWS};
use crate::variator::cell::laws::{ArgumentRecorder, LawArguments};
use crate::variator::cell::observer::{AtStation, NoObserver, StationObserver};
use crate::variator::cell::state::{CellInput, Slots, StationForces};
use crate::variator::cell::variation::{Evaluated, Linearised};
use crate::variator::law::place::{CellBalance, Place};
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::{CellRing, VaryingRing};
use num_traits::Zero;
use std::cell::OnceCell;

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;

/// A ring whose cells can be differentiated.
pub(crate) trait Differentiate<const D: usize, C: MeshCurve>: RingKind<D, C> {
    /// Frames of the curve, without derivatives and with those in the coordinates of this ring.
    type Frames;

    /// Frames at one place of a path of the coordinates; `slopes` are the factors of acceleration and position.
    fn frames(curve: &TwoPulley, path: &Path<f64>, slopes: [f64; 2]) -> Self::Frames;

    /// Shape of the curve.
    fn shape(frames: &Self::Frames) -> &C::Shape;

    /// The laws' part of analytic derivatives, for a pack with this number of stations.
    fn law_part(stations: usize) -> Option<LawPart> {
        Some(LawPart::new::<Self, D>(stations))
    }

    /// The balance of a pack at `unknowns`. Evaluates the derivatives that `policy` does not reuse from the `cache`,
    /// analytically if the ring supports it. Returns the part that was evaluated.
    fn update(
        &self,
        acting: InForce<'_>,
        pack: &Pack,
        frames: &Self::Frames,
        at: (&Unknowns<Lanes>, [f64; 2]),
        policy: ReusePolicy,
        cache: (&mut JacobianCache, &mut [Transport<[f64; MOST]>]),
    ) -> (CellBalance<Lanes>, CacheUpdate);
}

/// Implements the frames of a ring with derivatives in this number of coordinates of the curve.
macro_rules! frames_along {
    ($coordinates:expr) => {
        type Frames = Frames<C, { $coordinates }>;

        fn frames(curve: &TwoPulley, path: &Path<f64>, slopes: [f64; 2]) -> Self::Frames {
            Frames::new(curve, path, slopes)
        }

        fn shape(frames: &Self::Frames) -> &C::Shape {
            &frames.shape
        }
    };
}

impl<C: MeshCurve + DisplacedCurve> Differentiate<2, C> for GuidedRing {
    frames_along!(COORDINATES);

    fn update(
        &self,
        acting: InForce<'_>,
        pack: &Pack,
        frames: &Self::Frames,
        at: (&Unknowns<Lanes>, [f64; 2]),
        policy: ReusePolicy,
        cache: (&mut JacobianCache, &mut [Transport<[f64; MOST]>]),
    ) -> (CellBalance<Lanes>, CacheUpdate) {
        by_hand::<Self, 2, C, COORDINATES>(acting, (self, pack), frames, at, policy, cache)
    }
}

impl<const D: usize, C: MeshCurve> Differentiate<D, C> for DeflectingRing<D> {
    frames_along!(1);

    fn update(
        &self,
        acting: InForce<'_>,
        pack: &Pack,
        frames: &Self::Frames,
        at: (&Unknowns<Lanes>, [f64; 2]),
        policy: ReusePolicy,
        cache: (&mut JacobianCache, &mut [Transport<[f64; MOST]>]),
    ) -> (CellBalance<Lanes>, CacheUpdate) {
        by_hand::<Self, D, C, 1>(acting, (self, pack), frames, at, policy, cache)
    }
}

/// A ring of kind `K` whose cells use forward differentiation alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Forward<K>(pub K);

impl<K: Directions> Directions for Forward<K> {
    const NODES: usize = K::NODES;
    const TENSIONS: usize = K::TENSIONS;
    const COORDINATES: usize = K::COORDINATES;
}

impl<const D: usize, C: MeshCurve, K: RingKind<D, C>> RingKind<D, C> for Forward<K> {
    type Ring<'a, T: Real> = K::Ring<'a, T>;

    #[inline(always)]
    fn ring<'a, T: Real>(
        &self,
        ring: &'a Ring,
        at: (&'a Place<'a, T>, &'a ReferenceMotion<T>),
        curve: (&'a C::Frame<T>, usize),
        unknowns: &impl ReadUnknowns<T::Constant>,
        slopes: [f64; 2],
        seed: impl Fn(T::Constant, usize, f64) -> T,
    ) -> Self::Ring<'a, T> {
        self.0.ring(ring, at, curve, unknowns, slopes, seed)
    }
}

impl<const D: usize, C: MeshCurve, K: RingKind<D, C>> Differentiate<D, C> for Forward<K> {
    frames_along!(1);

    fn law_part(_stations: usize) -> Option<LawPart> {
        None
    }

    fn update(
        &self,
        acting: InForce<'_>,
        pack: &Pack,
        frames: &Self::Frames,
        at: (&Unknowns<Lanes>, [f64; 2]),
        policy: ReusePolicy,
        cache: (&mut JacobianCache, &mut [Transport<[f64; MOST]>]),
    ) -> (CellBalance<Lanes>, CacheUpdate) {
        let (unknowns, slopes) = at;
        let mut regime = Regime::zero();
        let mut observer = RegimeObserver {
            alpha: slopes[0],
            regime: &mut regime,
        };
        let plain = |value, _, _| value;
        let (b, _) = pack_balance::<_, _, Self, D, C>(
            acting,
            (self, pack),
            &frames.plain,
            unknowns,
            slopes,
            plain,
            &mut observer,
        );
        let place = pack.place::<Lanes, C>(acting.law, &frames.plain);
        let scales = scales(acting, &place, slopes[0]);
        let update = cache.0.update::<Self>(policy, (&regime, &scales), at, place.length.v);
        if update == CacheUpdate::All {
            forward::<Self, D, C>(acting, (self, pack), &frames.shape, at, cache);
        }
        (b, update)
    }
}

/// [`Differentiate::update`] with analytic derivatives, and forward differentiation in N coordinates of the curve.
#[inline(never)]
fn by_hand<K: RingKind<D, C>, const D: usize, C: MeshCurve, const N: usize>(
    acting: InForce<'_>,
    (kind, pack): (&K, &Pack),
    frames: &Frames<C, N>,
    at: (&Unknowns<Lanes>, [f64; 2]),
    policy: ReusePolicy,
    (cache, transports): (&mut JacobianCache, &mut [Transport<[f64; MOST]>]),
) -> (CellBalance<Lanes>, CacheUpdate)
where
    for<'a> K::Ring<'a, Lanes>: VaryingRing<Lanes, D>,
{
    let (InForce { law, friction, .. }, frame, (unknowns, slopes)) = (acting, &frames.plain, at);
    let plain = |value, _, _| value;
    let motion = motion::<Lanes, K>(unknowns, slopes, plain);
    let place = pack.place::<Lanes, C>(law, frame);
    let reference = |slot: usize| C::point(frame, pack.segment, place.fraction(slot));
    let on_curve = (frame, pack.segment);
    let mut ring = kind.ring::<Lanes>(
        &law.ring,
        (&place, &motion.reference),
        on_curve,
        unknowns,
        slopes,
        plain,
    );
    let given = CellInput {
        law,
        friction,
        place: &place,
        motion: &motion,
    };
    let (mut slots, mut forces, mut regime) = (Slots::empty(), [None; STATIONS], Regime::zero());
    let mut observer = ForceRecorder {
        regime: RegimeObserver {
            alpha: slopes[0],
            regime: &mut regime,
        },
        forces: &mut forces,
    };
    let (b, cell) = balance_in(&given, &mut ring, reference, &mut slots, &mut observer);
    let scales = scales(acting, &place, slopes[0]);
    let update = cache.update::<K>(policy, (&regime, &scales), at, place.length.v);
    if update != CacheUpdate::All {
        return (b, update);
    }
    let evaluated = Evaluated {
        cell,
        slots: &slots,
        forces: &forces,
        laws: &regime.laws,
    };
    let linear = Linearised::new(given, &ring, evaluated, slopes);
    let mut columns = Columns::of::<K>(pack, cache, transports);
    for k in 0..K::COUNT {
        if let Some(direction) = K::direction(k) {
            let mut arguments = LawArguments::zero();
            let (b, ring) = linear.vary(direction, &mut arguments);
            columns.record::<K>(k, &rows::<_, K, D>(&b, &ring), &b.transport);
            columns.record_arguments::<K>(k, &arguments);
        }
    }
    let mut arguments = LawArguments::zero();
    let recorder = &mut ArgumentRecorder(&mut arguments);
    let (rows, transport) = pack_pass::<N, K, D, C>(acting, (kind, pack), frames.moving(), at, K::THETA, recorder);
    for i in 0..N {
        columns.record::<K>(
            K::THETA + i,
            &rows.map(|row| row.eps[i]),
            &transport.map(|of| of.eps[i]),
        );
        columns.record_arguments::<K>(K::THETA + i, &arguments.map(|of| of.eps[i]));
    }
    if let Some(laws) = &mut cache.laws {
        laws.keep::<K, _, D>(&linear, &regime.laws);
    }
    (b, update)
}

/// Scales of the tangents of the laws, for a step with this factor 1/(hγ), 1/s.
#[inline(always)]
fn scales(InForce { law, friction, .. }: InForce<'_>, place: &Place<'_, Lanes>, alpha: f64) -> TangentScales {
    TangentScales::new(law, friction, alpha, place.length.v * place.stations[0].weight)
}

/// Records the forces at the stations and the regime.
struct ForceRecorder<'a, const D: usize> {
    regime: RegimeObserver<'a>,
    forces: &'a mut [Option<StationForces<Lanes, D>>; STATIONS],
}

impl<const D: usize> StationObserver<Lanes, D> for ForceRecorder<'_, D> {
    #[inline(always)]
    fn observe<R: CellRing<Lanes, D>>(&mut self, at: &AtStation<'_, Lanes, D, R>) {
        self.regime.observe(at);
        self.forces[at.index] = Some(*at.forces);
    }
}

/// Differentiates a pack by forward differentiation alone.
fn forward<K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    acting: InForce<'_>,
    (kind, pack): (&K, &Pack),
    shape: &C::Shape,
    (unknowns, slopes): (&Unknowns<Lanes>, [f64; 2]),
    (cache, transports): (&mut JacobianCache, &mut [Transport<[f64; MOST]>]),
) {
    let mut columns = Columns::of::<K>(pack, cache, transports);
    for first in (0..K::COUNT).step_by(PASS) {
        let frame = C::mesh_frame(shape, |k| moving((K::THETA + k).wrapping_sub(first), slopes));
        let at = (unknowns, slopes);
        let (rows, transport) = pack_pass::<PASS, K, D, C>(acting, (kind, pack), &frame, at, first, &mut NoObserver);
        for (i, k) in (first..K::COUNT.min(first + PASS)).enumerate() {
            columns.record::<K>(k, &rows.map(|row| row.eps[i]), &transport.map(|of| of.eps[i]));
        }
    }
}

/// One pass over a pack: derivatives in the directions `first` and on.
#[inline(never)]
fn pack_pass<const N: usize, K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    acting: InForce<'_>,
    of: (&K, &Pack),
    frame: &C::Frame<Tangent<N>>,
    (unknowns, slopes): (&Unknowns<Lanes>, [f64; 2]),
    first: usize,
    observer: &mut impl StationObserver<Tangent<N>, D>,
) -> ([Tangent<N>; MOST_ROWS], Transport<Tangent<N>>) {
    let seed = |value: Lanes, direction: usize, slope: f64| Tangent::seed(value, direction.wrapping_sub(first), slope);
    let (b, ring) = pack_balance::<_, _, K, D, C>(acting, of, frame, unknowns, slopes, seed, observer);
    (rows::<_, K, D>(&b, &ring), b.transport)
}

/// Largest difference between analytic derivatives of a pack and forward differentiation, relative to the largest entry of
/// its column, or of all derivatives of the transport quantities (at least 1e-6: they are of the order of 1).
pub(crate) fn worst_of_pack<K: Differentiate<D, C>, const D: usize, C: MeshCurve>(
    acting: InForce<'_>,
    (kind, pack): (&K, &Pack),
    frames: &K::Frames,
    at: (&Unknowns<Lanes>, [f64; 2]),
    cache: &JacobianCache,
    transports: &[Transport<[f64; MOST]>],
) -> f64 {
    use crate::variator::cell::directions::RESULTANT;
    let count = K::COUNT;
    let mut worst = 0.0_f64;
    let mut cache = [cache.clone(), cache.clone()];
    let mut transports = [transports.to_vec(), transports.to_vec()];
    cache[0].forget();
    let of_hand = (&mut cache[0], &mut transports[0][..]);
    kind.update(acting, pack, frames, at, ReusePolicy::None, of_hand);
    forward::<K, D, C>(
        acting,
        (kind, pack),
        K::shape(frames),
        at,
        (&mut cache[1], &mut transports[1]),
    );
    for lane in 0..pack.group.used {
        let [hand, forward] = cache.each_ref().map(|cache| {
            let entry = |row: usize, column: usize| cache.block[row * count + column].to_array()[lane];
            let column = |column| {
                (0..count - 1 + RESULTANT)
                    .map(move |row| entry(row, column))
                    .collect::<Vec<_>>()
            };
            (0..count).map(column).collect::<Vec<_>>()
        });
        let [of_hand, of_forward] = transports
            .each_ref()
            .map(|t| t[pack.group.cells[lane]].each().map(|of| of[..count].to_vec()));
        let pairs = hand.iter().zip(&forward).chain(of_hand.iter().zip(&of_forward));
        for (hand, forward) in pairs {
            let scale = forward.iter().fold(1e-6_f64, |most, x| most.max(x.abs()));
            for (a, b) in hand.iter().zip(forward) {
                worst = worst.max((a - b).abs() / scale);
            }
        }
    }
    worst
}

/// Memory for the derivatives of a pack: a column for each direction.
struct Columns<'a> {
    pack: &'a Pack,
    /// Directions.
    count: usize,
    block: &'a mut [Lanes],
    laws: Option<&'a mut LawPart>,
    transports: &'a mut [Transport<[f64; MOST]>],
}

impl<'a> Columns<'a> {
    /// The columns of a pack.
    #[inline(always)]
    fn of<K: Directions>(
        pack: &'a Pack,
        cache: &'a mut JacobianCache,
        transports: &'a mut [Transport<[f64; MOST]>],
    ) -> Self {
        Self {
            pack,
            count: K::COUNT,
            block: &mut cache.block,
            laws: cache.laws.as_mut(),
            transports,
        }
    }

    /// Records the derivatives of balance and transport quantities in a direction.
    #[inline(always)]
    fn record<K: Directions>(&mut self, direction: usize, rows: &[Lanes; MOST_ROWS], transport: &Transport<Lanes>) {
        for (row, block) in in_block::<K>(rows).zip(self.block.chunks_exact_mut(self.count)) {
            block[direction] = *row;
        }
        for (figure, slope) in transport.each().into_iter().enumerate() {
            for (&cell, slope) in self.pack.cells().iter().zip(slope.to_array()) {
                self.transports[cell].each_mut()[figure][direction] = slope;
            }
        }
    }

    /// Records the variation of the arguments of the laws in a direction.
    #[inline(always)]
    fn record_arguments<K: Directions>(&mut self, direction: usize, by: &LawArguments<Lanes>) {
        if let Some(laws) = &mut self.laws {
            laws.record::<K>(direction, by);
        }
    }
}

/// Frames of the curve without derivatives, and with those in its first N coordinates, computed at first use.
pub(crate) struct Frames<C: MeshCurve, const N: usize> {
    shape: C::Shape,
    plain: C::Frame<Lanes>,
    moving: OnceCell<C::Frame<Tangent<N>>>,
    slopes: [f64; 2],
}

impl<C: MeshCurve, const N: usize> Frames<C, N> {
    /// Frames at one place of a path.
    fn new(curve: &TwoPulley, path: &Path<f64>, slopes: [f64; 2]) -> Self {
        let shape = C::shape(curve, path);
        Self {
            plain: C::mesh_frame(&shape, |_| Jet::constant(0.0)),
            moving: OnceCell::new(),
            shape,
            slopes,
        }
    }

    fn moving(&self) -> &C::Frame<Tangent<N>> {
        self.moving
            .get_or_init(|| C::mesh_frame(&self.shape, |k| moving(k, self.slopes)))
    }
}

/// Zero with the derivatives of a coordinate of the curve and of its rates, if it is direction `k` of a pass.
fn moving<const N: usize>(k: usize, [alpha, beta]: [f64; 2]) -> Jet<Tangent<N>> {
    let seed = |slope| Tangent::seed(Lanes::zero(), k, slope);
    Jet {
        v: seed(beta),
        d: seed(1.0),
        dd: seed(alpha),
    }
}
