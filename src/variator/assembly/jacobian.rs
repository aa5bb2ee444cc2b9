//! Derivatives of a pack of cells: by hand where a ring has them, otherwise by forward
//! differentiation.

use crate::reference_curve::{COORDINATES, Jet, MeshCurve, Path, TwoPulley};
use crate::scalar::{Lanes, Tangent};
use crate::solver::Factors;
use crate::variator::assembly::derivatives::Columns;
use crate::variator::assembly::kinds::{RingKind, frame, pack_balance, rows};
use crate::variator::assembly::pack::{Pack, Unknowns};
use crate::variator::belt::equations::InForce;
use crate::variator::cell::degrees::DegreesOfFreedom;
use crate::variator::cell::laws::{
    ARGUMENTS, Arguments, OfLaws, Tangents, record_arguments, record_tangents,
};
use crate::variator::cell::variation::Linearised;
use crate::variator::law::arguments::{CellBalance, StateComponent};
use crate::variator::mesh::belt_mesh::STATIONS;
use crate::variator::rings::ring::EulerianRing;
use num_traits::Zero;
use std::cell::RefCell;
use std::ops::Range;

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;

/// The balance of a pack at `unknowns`. Evaluates the tangents of its laws and, unless the frames
/// are those of an update, all its derivatives.
#[inline(never)]
pub(crate) fn differentiate<K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    acting: InForce<'_>,
    of_pack: (&K, &Pack),
    frames: &Frames<C>,
    unknowns: &Unknowns,
    mut columns: Columns<'_>,
) -> CellBalance<Lanes> {
    let plain = |component: StateComponent, k: usize| unknowns[component as usize][k];
    let seen = RefCell::new((OfLaws::<Tangents>::default(), [None; STATIONS]));
    let into = &mut columns;
    let (b, _) = pack_balance::<Lanes, K, D, C, _>(
        acting,
        of_pack,
        &frames.plain,
        plain,
        |at| {
            let (tangents, forces) = &mut *seen.borrow_mut();
            record_tangents(tangents, at);
            forces[at.index] = Some(*at.forces);
        },
        |ring, (given, cell, points)| {
            let (tangents, forces) = &*seen.borrow();
            into.derivatives.set_tangents(tangents, frames.update);
            if let (false, true, Some(ring)) = (frames.update, frames.by_hand, K::by_hand(ring)) {
                let linear = Linearised::new(ring, given, cell, points, forces, tangents, frames.factors);
                into.record_by_hand::<K, _, D>(&linear);
            }
        },
    );
    let mut arguments: OfLaws<Arguments<_>> = [[Tangent::zero(); ARGUMENTS]; _];
    for (directions, frame) in frames.passes() {
        let seeded = |component: StateComponent, k: usize| {
            seed(
                frames.factors,
                unknowns[component as usize][k],
                component,
                k,
                directions.start,
            )
        };
        let (b, ring) = pack_balance::<Tangent<PASS>, K, D, C, _>(
            acting,
            of_pack,
            frame,
            seeded,
            |at| record_arguments(&mut arguments, at),
            |ring, _| ring.forces(),
        );
        let rows = rows::<_, K, D>(&b, &ring);
        for (i, k) in directions.enumerate() {
            columns.record::<K, _, D>(k, (&rows, &b.transport, &arguments), |of| of.eps[i]);
        }
    }
    b
}

/// Frames of the curve at one place of a path: without derivatives, and for each pass of forward
/// differentiation with those in its directions. An update of tangents has no passes.
pub(crate) struct Frames<C: MeshCurve> {
    /// Derivatives of rate and position of an unknown with respect to it.
    factors: Factors,
    /// Whether the tangents alone are evaluated.
    update: bool,
    /// Whether only drift and coordinates of the curve are differentiated forward.
    by_hand: bool,
    plain: C::Frame<Lanes>,
    /// Directions that move the curve, and the frame for each pass over them.
    of_curve: Range<usize>,
    moving: [Option<C::Frame<Tangent<PASS>>>; (1 + COORDINATES).div_ceil(PASS)],
    /// All other directions that are differentiated forward, and the frame for them.
    others: [Range<usize>; 2],
    still: Option<C::Frame<Tangent<PASS>>>,
}

impl<C: MeshCurve> Frames<C> {
    /// Frames for a ring of kind `K`, whose derivatives are `by_hand` or by forward differentiation
    /// alone, or for an `update`.
    pub fn new<K: DegreesOfFreedom>(
        curve: &TwoPulley,
        path: Path<f64>,
        factors: Factors,
        [update, by_hand]: [bool; 2],
    ) -> Self {
        let degrees = K::DEGREES;
        let of_curve = if update {
            0..0
        } else {
            degrees.drift..degrees.sheave
        };
        let others = if update || by_hand {
            [0..0, 0..0]
        } else {
            [0..degrees.drift, degrees.sheave..degrees.count]
        };
        let mut frames = Self {
            factors,
            update,
            by_hand,
            plain: frame::<_, K, C>(curve, path.map(|of| of.map(Lanes::from))),
            of_curve,
            moving: std::array::from_fn(|_| None),
            others,
            still: None,
        };
        let pass_from = |first: usize| {
            let seed = |k: usize, value, component| {
                seed(factors, Lanes::from(value), component, degrees.theta + k, first)
            };
            let path = std::array::from_fn(|k| Jet {
                v: seed(k, path[k].v, StateComponent::Position),
                d: seed(k, path[k].d, StateComponent::Value),
                dd: seed(k, path[k].dd, StateComponent::Rate),
            });
            frame::<_, K, C>(curve, path)
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

    /// Directions and frame of each pass.
    fn passes(&self) -> impl Iterator<Item = (Range<usize>, &C::Frame<Tangent<PASS>>)> {
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
