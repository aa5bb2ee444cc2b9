//! Derivatives of a pack of cells by forward differentiation: of the laws in their few arguments, and of the kinematics with
//! frozen forces of the laws in every direction, where the geometry is new.
//!
//! A node moves the whole ring, the curve's coordinates move its frame as well. The other directions leave the ring where it is,
//! so its points are computed once.

use crate::chain::Transport;
use crate::reference_curve::{COORDINATES, Jet, Path, TwoPulley};
use crate::scalar::{Lanes, Tangent};
use crate::variator::assembly::jacobian_cache::{CacheUpdate, JacobianCache};
use crate::variator::assembly::kinds::{MeshCurve, RingKind};
use crate::variator::assembly::law_part::{LawWork, in_block};
use crate::variator::assembly::pack::Pack;
use crate::variator::assembly::regime::{Regime, RegimeObserver, TangentScales};
use crate::variator::assembly::unknowns::{Unknowns, motion, rows};
use crate::variator::belt::equations::{InForce, ReusePolicy};
use crate::variator::cell::balance::{apply, balance_in, unit_forces};
use crate::variator::cell::directions::{Directions, MOST};
use crate::variator::cell::laws::{Direct, Frozen, Laws, Recorded};
use crate::variator::cell::observer::{AtStation, NoObserver, StationObserver};
use crate::variator::cell::state::{CellInput, CellState, Slots, StationForces, chain_at_face};
use crate::variator::law::place::CellBalance;
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::{CellRing, EulerianRing};
use std::cell::OnceCell;
use std::ops::Range;

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;

/// Frames of the curve: plain; without derivatives in a pass; with those in its first coordinate or in all.
pub(crate) struct Frames<C: MeshCurve> {
    shape: C::Shape,
    plain: C::Frame<Lanes>,
    still: OnceCell<C::Frame<Tangent<PASS>>>,
    ratio: OnceCell<C::Frame<Tangent<1>>>,
    all: OnceCell<C::Frame<Tangent<COORDINATES>>>,
    slopes: [f64; 2],
}

impl<C: MeshCurve> Frames<C> {
    /// Frames at one place of a path; `slopes` are the factors of acceleration and position.
    pub fn new(curve: &TwoPulley, path: &Path<f64>, slopes: [f64; 2]) -> Self {
        let shape = C::shape(curve, path);
        Self {
            plain: C::mesh_frame(&shape, |_| Jet::constant(0.0)),
            still: OnceCell::new(),
            ratio: OnceCell::new(),
            all: OnceCell::new(),
            shape,
            slopes,
        }
    }

    /// The frame with the derivatives in the directions `first` and on of a ring of kind `K`.
    fn moving<K: Directions, const N: usize>(&self, first: usize) -> C::Frame<Tangent<N>> {
        let [alpha, beta] = self.slopes;
        C::mesh_frame(&self.shape, |k| {
            let seed = |slope| Tangent::seed(Lanes::from(0.0), (K::THETA + k).wrapping_sub(first), slope);
            Jet {
                v: seed(beta),
                d: seed(1.0),
                dd: seed(alpha),
            }
        })
    }
}

/// A pack of cells in a state.
#[derive(Clone, Copy)]
pub(crate) struct PackAt<'a, K, C: MeshCurve> {
    pub acting: InForce<'a>,
    pub kind: &'a K,
    pub pack: &'a Pack,
    pub frames: &'a Frames<C>,
    pub unknowns: &'a Unknowns<Lanes>,
    /// Factors of acceleration and position.
    pub slopes: [f64; 2],
}

/// A pack evaluated in a state.
struct Evaluated<'a, R, const D: usize> {
    given: CellInput<'a, Lanes>,
    /// The ring before it was loaded.
    unloaded: R,
    slots: Slots<Lanes, D>,
    forces: [Option<StationForces<Lanes, D>>; STATIONS],
    laws: Recorded,
}

impl<'p, K, C: MeshCurve> PackAt<'p, K, C> {
    /// The balance, and the derivatives that `policy` does not reuse from the `cache`. Returns the part that was evaluated.
    #[inline(never)]
    pub fn update<const WHOLE: bool, const D: usize>(
        &self,
        policy: ReusePolicy,
        (cache, transports): (&mut JacobianCache, &mut [Transport<[f64; MOST]>]),
        work: &mut LawWork,
    ) -> (CellBalance<Lanes>, CacheUpdate)
    where
        K: RingKind<D, C>,
    {
        let (InForce { law, friction, .. }, frame, slopes) = (self.acting, &self.frames.plain, self.slopes);
        let plain = |value, _, _| value;
        let motion = &motion::<Lanes, K>(self.unknowns, slopes, plain);
        let place = &self.pack.place::<Lanes, C>(law, frame);
        let on_curve = (frame, self.pack.segment);
        let at = (place, &motion.reference);
        let mut ring = self
            .kind
            .ring::<Lanes>(&law.ring, at, on_curve, self.unknowns, slopes, plain);
        let mut evaluated = Evaluated {
            given: CellInput {
                law,
                friction,
                place,
                motion,
            },
            unloaded: ring.under_loads_alone(),
            slots: Slots::empty(),
            forces: [None; STATIONS],
            laws: Recorded::zero(),
        };
        let Evaluated {
            given,
            slots,
            forces,
            laws,
            ..
        } = &mut evaluated;
        let mut regime = Regime::zero();
        let mut observer = ForceRecorder {
            regime: RegimeObserver {
                alpha: slopes[0],
                regime: &mut regime,
            },
            forces,
        };
        let point = |ring: &K::Ring<'_, Lanes>, slot: usize| {
            ring.point(slot, C::point(frame, self.pack.segment, place.fraction(slot)))
        };
        let b = balance_in(given, &mut ring, (None, point), laws, slots, &mut observer);
        regime.laws = laws.tangents;
        let length = place.length.v;
        let scales = TangentScales::new(law, friction, slopes[0], length * place.stations[0].weight);
        let update = cache.update::<K>(policy, (&regime, &scales), (self.unknowns, slopes), length);
        if update == CacheUpdate::All {
            let mut columns = Columns {
                pack: self.pack,
                cache,
                transports,
            };
            if WHOLE {
                self.differentiate_whole(&evaluated, &mut columns);
            } else {
                self.differentiate(&evaluated, &mut columns);
                cache.add_laws::<K>(work);
            }
        }
        (b, update)
    }

    /// The derivatives with frozen forces of the laws; L and R.
    #[inline(always)]
    fn differentiate<R: EulerianRing<Lanes, D>, const D: usize>(
        &self,
        evaluated: &Evaluated<'p, R, D>,
        columns: &mut Columns<'_>,
    ) where
        K: RingKind<D, C>,
    {
        let still = self
            .frames
            .still
            .get_or_init(|| self.frames.moving::<K, PASS>(K::COUNT));
        let passes = |all: Range<usize>| {
            let end = all.end;
            all.step_by(PASS).map(move |first| first..end.min(first + PASS))
        };
        for directions in passes(0..K::NODES) {
            self.moving::<PASS, false, false, R, D>(still, directions, evaluated, columns);
        }
        for directions in passes(K::NODES..K::THETA).chain(passes(K::SHEAVE..K::COUNT)) {
            self.still(still, directions, evaluated, columns);
        }
        let of_curve = K::THETA..K::SHEAVE;
        if K::COORDINATES == 1 {
            let frame = self.frames.ratio.get_or_init(|| self.frames.moving::<K, 1>(K::THETA));
            self.moving::<1, true, false, R, D>(frame, of_curve, evaluated, columns);
        } else {
            let frame = self
                .frames
                .all
                .get_or_init(|| self.frames.moving::<K, COORDINATES>(K::THETA));
            self.moving::<COORDINATES, true, false, R, D>(frame, of_curve, evaluated, columns);
        }
        if let Some(laws) = &mut columns.cache.laws {
            let Evaluated {
                given, slots, forces, ..
            } = evaluated;
            let mut force = 0;
            unit_forces(given, (slots, forces), &evaluated.unloaded, |b, ring| {
                laws.record::<K, D>(force, b, ring);
                force += 1;
            });
        }
    }

    /// The derivatives by forward differentiation of laws and kinematics in every direction.
    fn differentiate_whole<R: EulerianRing<Lanes, D>, const D: usize>(
        &self,
        evaluated: &Evaluated<'p, R, D>,
        columns: &mut Columns<'_>,
    ) where
        K: RingKind<D, C>,
    {
        for first in (0..K::COUNT).step_by(PASS) {
            let frame = self.frames.moving::<K, PASS>(first);
            let directions = first..K::COUNT.min(first + PASS);
            self.moving::<PASS, true, true, R, D>(&frame, directions, evaluated, columns);
        }
    }

    /// The derivatives in at most N directions in which the ring moves, and the curve if CURVE. The forces of the laws are those
    /// that were `evaluated`, or vary if WHOLE.
    #[inline(never)]
    fn moving<const N: usize, const CURVE: bool, const WHOLE: bool, R, const D: usize>(
        &self,
        frame: &C::Frame<Tangent<N>>,
        directions: Range<usize>,
        evaluated: &Evaluated<'p, R, D>,
        columns: &mut Columns<'_>,
    ) where
        K: RingKind<D, C>,
    {
        let first = directions.start;
        let seed = |value: Lanes, k: usize, slope: f64| Tangent::<N>::seed(value, k.wrapping_sub(first), slope);
        let InForce { law, friction, .. } = self.acting;
        let (unknowns, slopes, segment) = (self.unknowns, self.slopes, self.pack.segment);
        let place = &if CURVE {
            self.pack.place::<Tangent<N>, C>(law, frame)
        } else {
            evaluated.given.place.constant()
        };
        let motion = &motion::<Tangent<N>, K>(unknowns, slopes, seed);
        let at = (place, &motion.reference);
        let mut ring = self
            .kind
            .ring::<Tangent<N>>(&law.ring, at, (frame, segment), unknowns, slopes, seed);
        let given = CellInput {
            law,
            friction,
            place,
            motion,
        };
        let reference = |slot| {
            if CURVE {
                C::point(frame, segment, place.fraction(slot))
            } else {
                evaluated.slots.ring(slot).reference.constant()
            }
        };
        // Of the face only the flow is needed: alone, its other quantities are not computed.
        let flow = chain_at_face(&given, &ring.point(0, reference(0))).flow;
        let at = (Some(flow), |ring: &K::Ring<'_, Tangent<N>>, slot| {
            ring.point(slot, reference(slot))
        });
        let mut slots = Slots::empty();
        let b = if WHOLE {
            balance_in(&given, &mut ring, at, &mut Direct, &mut slots, &mut NoObserver)
        } else {
            let laws = &mut columns.frozen::<N>(&evaluated.laws, directions.clone());
            balance_in(&given, &mut ring, at, laws, &mut slots, &mut NoObserver)
        };
        let rows = rows::<_, K, D>(&b, &ring.forces());
        for (i, direction) in directions.enumerate() {
            columns.record::<K>(direction, |row| rows[row].eps[i], &b.transport.map(|of| of.eps[i]));
        }
    }

    /// The derivatives in directions in which the ring stays where it is: the loads vary, and the rows are linear in them.
    #[inline(never)]
    fn still<R: EulerianRing<Lanes, D>, const D: usize>(
        &self,
        frame: &C::Frame<Tangent<PASS>>,
        directions: Range<usize>,
        evaluated: &Evaluated<'p, R, D>,
        columns: &mut Columns<'_>,
    ) where
        K: RingKind<D, C>,
    {
        let first = directions.start;
        let seed = |value: Lanes, k: usize, slope: f64| Tangent::<PASS>::seed(value, k.wrapping_sub(first), slope);
        let InForce { law, friction, .. } = self.acting;
        let (unknowns, slopes, segment) = (self.unknowns, self.slopes, self.pack.segment);
        let place = &evaluated.given.place.constant();
        let motion = &motion::<Tangent<PASS>, K>(unknowns, slopes, seed);
        let at = (place, &motion.reference);
        let ring = self
            .kind
            .ring::<Tangent<PASS>>(&law.ring, at, (frame, segment), unknowns, slopes, seed);
        let given = CellInput {
            law,
            friction,
            place,
            motion,
        };
        let mut slots = Slots::empty();
        let point = |slot| evaluated.slots.ring(slot).constant(&motion.reference);
        let cell = CellState::new(&given, 1, point, &mut slots);
        let laws = &mut columns.frozen::<PASS>(&evaluated.laws, directions.clone());
        let push = laws.stack(&given, cell.stack_arguments()).force;
        let mut sums: [_; PASS] = std::array::from_fn(|_| (CellBalance::zero(), evaluated.unloaded.clone()));
        for (i, at) in slots.stations.iter().zip(&evaluated.slots.stations).enumerate() {
            let (Some(station), Some(plain)) = at else { continue };
            let loads = StationForces::new(&given, &cell, (i, station), &ring, push, laws).loads(station);
            for (k, (out, ring)) in sums.iter_mut().enumerate() {
                apply(&evaluated.given, (i, plain), &loads.map(|load| load.eps[k]), ring, out);
            }
        }
        let transport = Transport {
            flow: chain_at_face(&given, &point(0)).flow,
            density: cell.density,
        };
        let own = rows::<_, K, D>(&CellBalance::zero(), &ring.forces());
        for (k, (direction, (b, ring))) in directions.zip(&sums).enumerate() {
            let rows = rows::<_, K, D>(b, &ring.forces());
            columns.record::<K>(
                direction,
                |row| rows[row] + own[row].eps[k],
                &transport.map(|of| of.eps[k]),
            );
        }
    }
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

/// Memory for the derivatives of a pack: a column for each direction.
struct Columns<'a> {
    pack: &'a Pack,
    cache: &'a mut JacobianCache,
    transports: &'a mut [Transport<[f64; MOST]>],
}

impl Columns<'_> {
    /// The frozen laws, which record R in these directions.
    #[inline(always)]
    fn frozen<'b, const N: usize>(&'b mut self, laws: &'b Recorded, directions: Range<usize>) -> Frozen<'b, N> {
        let part = self.cache.laws.as_mut().expect("a laws' part");
        Frozen {
            forces: &laws.forces,
            width: part.width,
            right: &mut part.right,
            directions,
        }
    }

    /// Records the derivatives of balance and transport quantities in a direction.
    #[inline(always)]
    fn record<K: Directions>(&mut self, direction: usize, rows: impl Fn(usize) -> Lanes, transport: &Transport<Lanes>) {
        for (row, block) in in_block::<K>().zip(self.cache.block.chunks_exact_mut(K::COUNT)) {
            block[direction] = rows(row);
        }
        for (figure, slope) in transport.each().into_iter().enumerate() {
            for (&cell, slope) in self.pack.cells().iter().zip(slope.to_array()) {
                self.transports[cell].each_mut()[figure][direction] = slope;
            }
        }
    }
}
