//! The balance of a pack of cells and its rows, generic over the scalar, and their derivatives: by
//! hand where a ring has them, otherwise by forward differentiation.

use super::derivatives::Derivatives;
use super::pack::{Pack, Unknowns};
use super::rows::rows;
use crate::reference_curve::{COORDINATES, CurveCoordinates, Jet, Path, TwoPulley, TwoPulleyFrame};
use crate::scalar::{Lanes, Real, Tangent};
use crate::solver::Factors;
use crate::variator::belt::equations::InForce;
use crate::variator::cell::balance::balance;
use crate::variator::cell::laws::{
    ARGUMENTS, Arguments, OfLaws, Tangents, record_arguments, record_tangents,
};
use crate::variator::cell::sample::AtStation;
use crate::variator::cell::state::{CellPoints, CellState};
use crate::variator::cell::variation::Linearised;
use crate::variator::law::arguments::{CellBalance, CellInput, CellMotion, FirstUnknowns, StateComponent};
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::{CellRing, RingInput, RingKind};
use num_traits::Zero;
use std::cell::RefCell;
use std::ops::Range;

/// The curve at one place of a path for a ring of kind `K`: without other coordinates, Θ is the
/// variable of the path.
#[inline(always)]
pub(super) fn frame<T: Real, K: RingKind<D>, const D: usize>(
    curve: &TwoPulley,
    path: &Path<T>,
) -> TwoPulleyFrame<T> {
    if K::DEGREES.coordinates == 1 {
        curve.frame(path.theta.v)
    } else {
        curve.on_path(path)
    }
}

/// The balance of a pack of cells, from the `unknown` of a component and a direction, and what
/// `then` returns for the loaded ring.
#[inline(always)]
pub(super) fn pack_balance<T: Real<Constant = Lanes>, K: RingKind<D>, const D: usize, O>(
    InForce { belt, friction }: InForce<'_>,
    kind: &K,
    pack: &Pack,
    frame: &TwoPulleyFrame<T>,
    unknown: impl Fn(StateComponent, usize) -> T,
    observe: impl FnMut(&AtStation<'_, T, D>),
    then: impl FnOnce(&K::Ring<'_, T>, CellInput<'_, T>, CellState<T>, &CellPoints<T, D>) -> O,
) -> (CellBalance<T>, O) {
    let law = &belt.law;
    let degrees = K::DEGREES;
    let first = FirstUnknowns {
        own: degrees.nodes,
        drift: degrees.drift,
        sheave: degrees.sheave,
    };
    let mut motion = CellMotion::from_unknowns(first, &unknown);
    if degrees.coordinates > 1 {
        // The curve holds derivatives along the motion, so time replaces Θ.
        (motion.reference.theta.rate, motion.reference.theta.acceleration) = (T::one(), T::zero());
    }
    let geometry = pack.geometry(law, frame);
    let of_ring = RingInput {
        ring: &law.ring,
        geometry: &geometry,
        motion: &motion.reference,
        frame,
        segment: pack.segment,
    };
    let mut ring = kind.ring(of_ring, &unknown);
    let given = CellInput {
        law,
        friction,
        geometry: &geometry,
        motion: &motion,
    };
    let mut points = CellPoints::empty();
    let (b, cell) = balance(&given, &mut ring, &mut points, observe);
    (b, then(&ring, given, cell, &points))
}

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Scope {
    /// The tangents of the laws alone.
    Tangents,
    /// All: forward only with drift and coordinates of the curve, else by hand.
    ByHand,
    /// All, by forward differentiation.
    Forward,
}

/// The balance of a pack at `unknowns`. Evaluates the derivatives in the scope of the frames.
#[inline(never)]
pub(crate) fn differentiate<K: RingKind<D>, const D: usize>(
    acting: InForce<'_>,
    kind: &K,
    pack: &Pack,
    frames: &Frames,
    unknowns: &Unknowns,
    derivatives: &mut Derivatives,
) -> CellBalance<Lanes> {
    let plain = |component: StateComponent, k: usize| unknowns[component as usize][k];
    let seen = RefCell::new((OfLaws::<Tangents>::default(), [None; STATIONS]));
    let (b, ()) = pack_balance::<Lanes, K, D, _>(
        acting,
        kind,
        pack,
        &frames.plain,
        plain,
        |at| {
            let (tangents, forces) = &mut *seen.borrow_mut();
            record_tangents(tangents, at);
            forces[at.index] = Some(*at.forces);
        },
        |ring, given, cell, points| {
            let (tangents, forces) = &*seen.borrow();
            derivatives.set_tangents(tangents, frames.scope == Scope::Tangents);
            if frames.scope == Scope::ByHand {
                let ring = K::by_hand(ring).expect("a kind of ring with derivatives by hand");
                let linear = Linearised::new(ring, given, cell, points, forces, tangents, frames.factors);
                derivatives.record_by_hand::<K, _, D>(&linear);
            }
        },
    );
    let mut arguments: OfLaws<Arguments<_>> = [[Tangent::zero(); ARGUMENTS]; _];
    for (directions, frame) in frames.passes() {
        let seeded = |component: StateComponent, k: usize| {
            let value = unknowns[component as usize][k];
            seed(frames.factors, value, component, k, directions.start)
        };
        let (b, ring) = pack_balance::<Tangent<PASS>, K, D, _>(
            acting,
            kind,
            pack,
            frame,
            seeded,
            |at| record_arguments(&mut arguments, at),
            |ring, _, _, _| ring.forces(),
        );
        let rows = rows::<_, K, D>(&b, &ring);
        for (i, k) in directions.enumerate() {
            derivatives.record::<K, _, D>(k, &rows, &b.transport, &arguments, |of| of.eps[i]);
        }
    }
    b
}

/// Frames of the curve at one place of a path: without derivatives, and for each pass of forward
/// differentiation with those in its directions. An update of tangents has no passes.
pub(crate) struct Frames {
    /// Derivatives of rate and position of an unknown with respect to it.
    factors: Factors,
    scope: Scope,
    plain: TwoPulleyFrame<Lanes>,
    /// Directions that move the curve, and the frame for each pass over them.
    of_curve: Range<usize>,
    moving: [Option<TwoPulleyFrame<Tangent<PASS>>>; (1 + COORDINATES).div_ceil(PASS)],
    /// All other directions that are differentiated forward, and the frame for them.
    others: [Range<usize>; 2],
    still: Option<TwoPulleyFrame<Tangent<PASS>>>,
}

impl Frames {
    /// Frames for a ring of kind `K`.
    pub fn new<K: RingKind<D>, const D: usize>(
        curve: &TwoPulley,
        path: Path<f64>,
        factors: Factors,
        scope: Scope,
    ) -> Self {
        let degrees = K::DEGREES;
        let curve_moves = degrees.drift..degrees.sheave;
        let others = [0..degrees.drift, degrees.sheave..degrees.count];
        let (of_curve, others) = match scope {
            Scope::Tangents => (0..0, [0..0, 0..0]),
            Scope::ByHand => (curve_moves, [0..0, 0..0]),
            Scope::Forward => (curve_moves, others),
        };
        let plain = path.map(|of| of.map(Lanes::from));
        let path = path.to_array();
        let mut frames = Self {
            factors,
            scope,
            plain: frame::<_, K, D>(curve, &plain),
            of_curve,
            moving: std::array::from_fn(|_| None),
            others,
            still: None,
        };
        let pass_from = |first: usize| {
            let seed = |k: usize, value, component| {
                seed(factors, Lanes::from(value), component, degrees.theta + k, first)
            };
            let seeded = std::array::from_fn(|k| Jet {
                v: seed(k, path[k].v, StateComponent::Position),
                d: seed(k, path[k].d, StateComponent::Value),
                dd: seed(k, path[k].dd, StateComponent::Rate),
            });
            frame::<_, K, D>(curve, &CurveCoordinates::from_array(seeded))
        };
        // Frames are kilobytes, so they are written in place.
        for (to, first) in frames.moving.iter_mut().zip(frames.of_curve.clone().step_by(PASS)) {
            *to = Some(pass_from(first));
        }
        if !frames.others[0].is_empty() {
            frames.still = Some(pass_from(degrees.count));
        }
        frames
    }

    fn passes(&self) -> impl Iterator<Item = (Range<usize>, &TwoPulleyFrame<Tangent<PASS>>)> {
        let passes = |range: &Range<usize>| {
            let end = range.end;
            range
                .clone()
                .step_by(PASS)
                .map(move |first| first..end.min(first + PASS))
        };
        let others = self.others.iter().flat_map(passes).zip(std::iter::repeat(&self.still));
        let all = passes(&self.of_curve).zip(&self.moving).chain(others);
        all.filter_map(|(pass, frame)| Some((pass, frame.as_ref()?)))
    }
}

/// A part of unknown `k` with its derivatives in the directions of a pass from `first` on.
#[inline(always)]
fn seed(factors: Factors, value: Lanes, component: StateComponent, k: usize, first: usize) -> Tangent<PASS> {
    Tangent::seed(value, k.wrapping_sub(first), component.derivative(factors))
}
