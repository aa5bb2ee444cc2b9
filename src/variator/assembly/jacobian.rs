//! Derivatives of a pack of cells: by hand where a ring has them, otherwise by forward differentiation.

use crate::reference_curve::{COORDINATES, Jet, MeshCurve, Path, TwoPulley};
use crate::scalar::{Lanes, Tangent};
use crate::variator::assembly::derivatives::Columns;
use crate::variator::assembly::kinds::{RingKind, frame, pack_balance, path_of};
use crate::variator::assembly::pack::Pack;
use crate::variator::assembly::unknowns::{Unknowns, motion, rows};
use crate::variator::belt::equations::InForce;
use crate::variator::cell::balance::balance;
use crate::variator::cell::directions::Directions;
use crate::variator::cell::laws::{LawArguments, LawTangents};
use crate::variator::cell::state::{CellInput, Slots};
use crate::variator::cell::variation::Evaluated;
use crate::variator::law::place::CellBalance;
use crate::variator::mesh::belt_mesh::STATIONS;
use std::cell::OnceCell;
use std::ops::Range;

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;
/// Most passes over drift and coordinates of the curve.
const PASSES: usize = (1 + COORDINATES).div_ceil(PASS);

/// The balance of a pack at `unknowns`. Evaluates the tangents of its laws and, unless `update`, all its derivatives.
#[inline(never)]
pub(crate) fn differentiate<K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    acting: InForce<'_>,
    (kind, pack): (&K, &Pack),
    frames: &Frames<'_, C>,
    unknowns: &Unknowns<Lanes>,
    update: bool,
    mut columns: Columns<'_>,
) -> CellBalance<Lanes> {
    let (InForce { law, friction, .. }, frame, slopes) = (acting, &frames.plain, frames.slopes);
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
    let (mut slots, mut forces, mut tangents) = (Slots::empty(), [None; STATIONS], LawTangents::default());
    let (b, cell) = balance(&given, &mut ring, reference, &mut slots, |at| {
        tangents.record(at);
        forces[at.index] = Some(*at.forces);
    });
    columns.derivatives.set_tangents(&tangents, update);
    if update {
        return b;
    }
    if frames.by_hand {
        let evaluated = Evaluated {
            given,
            cell,
            slots: &slots,
            forces: &forces,
            laws: &tangents,
            slopes,
        };
        K::by_hand(&ring, evaluated, &mut columns);
    }
    for (directions, frame) in frames.passes::<K>() {
        let first = directions.start;
        let mut arguments = LawArguments::zero();
        let seed = |value, k: usize, slope| Tangent::seed(value, k.wrapping_sub(first), slope);
        let (b, ring) =
            pack_balance::<Tangent<PASS>, K, D, C>(acting, (kind, pack), frame, unknowns, slopes, seed, |at| {
                arguments.record(at);
            });
        let rows = rows::<_, K, D>(&b, &ring);
        for (i, k) in directions.enumerate() {
            columns.record::<K, _>(k, (&rows, &b.transport, &arguments), |of| of.eps[i]);
        }
    }
    b
}

/// Frames of the curve at one place of a path: without derivatives, and with those in the directions of a pass of forward
/// differentiation, computed at first use.
pub(crate) struct Frames<'a, C: MeshCurve> {
    curve: &'a TwoPulley,
    path: Path<f64>,
    slopes: [f64; 2],
    /// Whether only drift and coordinates of the curve are differentiated forward.
    by_hand: bool,
    plain: C::Frame<Lanes>,
    /// For the passes over drift and coordinates of the curve; the last for all others, without derivatives.
    moving: [OnceCell<C::Frame<Tangent<PASS>>>; PASSES + 1],
}

impl<'a, C: MeshCurve> Frames<'a, C> {
    /// Frames for a ring of kind `K`, with derivatives `by_hand` or by forward differentiation alone.
    pub fn new<K: Directions>(curve: &'a TwoPulley, path: Path<f64>, slopes: [f64; 2], by_hand: bool) -> Self {
        Self {
            curve,
            path,
            slopes,
            by_hand,
            plain: frame::<K, C>(curve, path),
            moving: std::array::from_fn(|_| OnceCell::new()),
        }
    }

    /// Directions and frame of each pass.
    fn passes<K: Directions>(&self) -> impl Iterator<Item = (Range<usize>, &C::Frame<Tangent<PASS>>)> {
        let [own, pulley] = if self.by_hand {
            [0..0, 0..0]
        } else {
            [0..K::DRIFT, K::SHEAVE..K::COUNT]
        };
        let passes = |range: Range<usize>| {
            let end = range.end;
            range.step_by(PASS).map(move |first| first..end.min(first + PASS))
        };
        let of_curve = passes(K::DRIFT..K::SHEAVE).zip(&self.moving);
        let still = &self.moving[PASSES];
        let others = passes(own).chain(passes(pulley)).map(move |pass| (pass, still));
        let slopes = self.slopes;
        of_curve.chain(others).map(move |(pass, frame)| {
            let moving = || {
                let seed = |k: usize, value, slope| {
                    let direction = (K::THETA + k).wrapping_sub(pass.start);
                    Tangent::seed(Lanes::from(value), direction, slope)
                };
                let path = std::array::from_fn(|k| Jet {
                    v: seed(k, self.path[k].v, slopes[1]),
                    d: seed(k, self.path[k].d, 1.0),
                    dd: seed(k, self.path[k].dd, slopes[0]),
                });
                C::on_path(self.curve, &path_of::<_, K>(path))
            };
            let frame = frame.get_or_init(moving);
            (pass, frame)
        })
    }
}
