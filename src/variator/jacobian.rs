//! The exact Jacobian: packs of cells looked at, differentiated where their derivatives no longer hold, and added to
//! the matrix.

use super::cell::balance;
use super::kept::{Kept, Look, Regime};
use super::pack::{
    InPlace, MOST, NOWHERE, Pack, Standing, Unknowns, amount_direction, direction, directions, motion, node_directions,
    nodes, own_directions, rows, tensions,
};
use super::ring::{Deflecting, GUIDED, Guided, TURNING, VaryingRing};
use super::sample::NoProbe;
use super::system::VariatorSystem;
use super::variation::Linearised;
use crate::chain::{self, Transport};
use crate::reference_curve::{TwoPulley, TwoPulleyShape};
use crate::scalar::{LANES, Lanes, Real, Tangent};
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::tape::Tape;
use num_traits::Zero;

/// Directions differentiated in one pass over a pack of cells.
const PASS: usize = 2;

impl VariatorSystem {
    /// Passes by a tape where the derivatives that are kept were taken: for packs of as many cells only.
    pub(super) fn pass_kept(&mut self, tape: &mut Tape<'_>) {
        let mut lanes = LANES as u64;
        tape.counter(&mut lanes);
        if lanes != LANES as u64 {
            tape.reject();
        }
        let count = directions(self.ring_kind(), self.layout.components);
        for (pack, kept) in self.packs.iter().zip(&mut self.kept) {
            kept.pass(tape, count, pack.group.used);
        }
    }

    /// One pass over a pack: derivatives in the directions `first` and on.
    #[inline(never)]
    fn pack_pass<const N: usize, const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Tangent<N>>,
        unknowns: &Unknowns<Lanes>,
        slopes: [f64; 2],
        first: usize,
    ) -> ([Tangent<N>; MOST], Transport<Tangent<N>>) {
        let seed =
            |value: Lanes, direction: usize, slope: f64| Tangent::seed(value, direction.wrapping_sub(first), slope);
        let (b, ring) = self.pack_balance::<_, _, KIND, D, C>(pack, frame, unknowns, slopes, seed, &mut NoProbe);
        (rows::<_, KIND, D>(&b, &ring), b.transport)
    }

    /// Hands `put` the derivatives of a pack in all directions but Θ: rows of the balance, and what the balance of the
    /// amounts needs.
    #[inline(never)]
    fn vary_pack<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Lanes>,
        unknowns: &Unknowns<Lanes>,
        slopes: [f64; 2],
        put: impl FnMut(usize, &[Lanes; MOST], &Transport<Lanes>),
    ) {
        let plain = |value, _, _| value;
        let motion = motion::<Lanes, KIND, D>(unknowns, slopes, plain);
        let place = pack.place::<Lanes, C>(frame);
        let reference = |slot: usize| C::point(frame, pack.segment, place.fraction(slot));
        let (law, ring) = (&self.law, &self.law.parameters.ring);
        if KIND == GUIDED {
            let tensions = tensions::<Lanes>(unknowns, plain);
            let ring = Guided::new(ring, &place, &motion.reference, tensions);
            let linear = Linearised::new(law, &place, &motion, &ring, reference, slopes);
            Self::columns::<_, KIND, 2>(&linear, put);
        } else {
            let nodes = nodes::<Lanes, D>(unknowns, slopes, plain);
            let mut ring = Deflecting::new(ring, &place, &motion.reference, &nodes);
            balance(law, &place, &motion, &mut ring, reference, &mut NoProbe);
            let linear = Linearised::new(law, &place, &motion, &ring, reference, slopes);
            Self::columns::<_, KIND, D>(&linear, put);
        }
    }

    #[inline(always)]
    fn columns<R: VaryingRing<Lanes, D>, const KIND: u8, const D: usize>(
        linear: &Linearised<'_, R, D>,
        mut put: impl FnMut(usize, &[Lanes; MOST], &Transport<Lanes>),
    ) {
        for k in 0..directions(KIND, D) {
            if let Some(direction) = direction(KIND, D, k) {
                let (b, ring) = linear.vary(direction);
                put(k, &rows::<_, KIND, D>(&b, &ring), &b.transport);
            }
        }
    }

    /// Values of a pack and the regime that it is in.
    fn look<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frame: &C::Frame<Lanes>,
        unknowns: &Unknowns<Lanes>,
        alpha: f64,
    ) -> (Regime, Transport<Lanes>) {
        let mut regime = Regime::new();
        let mut look = Look {
            law: &self.law,
            alpha,
            ring_speed: unknowns.value[own_directions(KIND, D)],
            regime: &mut regime,
        };
        let b = self.sampled_balance::<KIND, D, C>(pack, frame, unknowns, &mut |sample| look.take(&sample));
        let own = node_directions(KIND, D);
        let [left, right] = [unknowns.value[own], unknowns.value[own + 1]];
        regime.see_difference(right - left);
        (regime, b.transport)
    }

    /// Differentiates a pack where `kept` says.
    fn differentiate<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frames: &Frames<C>,
        kept: &mut Kept,
        transports: &mut [Transport<[f64; MOST]>],
    ) {
        if KIND == TURNING {
            self.differentiate_forward::<KIND, D, C>(pack, frames, kept, transports);
            return;
        }
        let theta = own_directions(KIND, D) + 1;
        let (unknowns, slopes, mut columns) = Columns::of::<KIND, D>(pack, kept, transports);
        self.vary_pack::<KIND, D, C>(pack, &frames.plain, unknowns, slopes, |k, rows, transport| {
            columns.put(k, rows, transport);
        });
        let (rows, transport) = self.pack_pass::<1, KIND, D, C>(pack, &frames.of_theta, unknowns, slopes, theta);
        columns.put(theta, &rows.map(|row| row.eps[0]), &transport.map(|of| of.eps[0]));
    }

    /// The same by forward differentiation alone.
    fn differentiate_forward<const KIND: u8, const D: usize, C: Standing>(
        &self,
        pack: &Pack,
        frames: &Frames<C>,
        kept: &mut Kept,
        transports: &mut [Transport<[f64; MOST]>],
    ) {
        let (count, theta) = (directions(KIND, D), own_directions(KIND, D) + 1);
        let (unknowns, slopes, mut columns) = Columns::of::<KIND, D>(pack, kept, transports);
        for first in (0..count).step_by(PASS) {
            let moving = Tangent::seed(Lanes::zero(), theta.wrapping_sub(first), slopes[1]);
            let frame = C::stand(&self.curve, frames.shape.frame(moving));
            let (rows, transport) = self.pack_pass::<PASS, KIND, D, C>(pack, &frame, unknowns, slopes, first);
            for (i, k) in (first..count.min(first + PASS)).enumerate() {
                columns.put(k, &rows.map(|row| row.eps[i]), &transport.map(|of| of.eps[i]));
            }
        }
    }

    /// Largest difference between derivatives by hand and by forward differentiation, as a share of the largest entry
    /// of its column, and of all figures that the amounts need (at least 1e-6: they are of the order of 1).
    #[cfg(test)]
    pub(super) fn worst_derivative<const KIND: u8, const D: usize, C: Standing>(
        &self,
        view: View<'_>,
        alpha: f64,
    ) -> f64 {
        let count = directions(KIND, D);
        let frames = Frames::<C>::new(&self.curve, self.theta(view), 1.0 / alpha);
        let mut worst = 0.0_f64;
        for (pack, kept) in self.packs.iter().zip(&self.kept) {
            let mut kept = [kept.clone(), kept.clone()];
            let mut transports = [self.transport_slopes.clone(), self.transport_slopes.clone()];
            for k in &mut kept {
                (k.unknowns, k.slopes) = (InPlace { pack, view }.gather(count), [alpha, 1.0 / alpha]);
            }
            self.differentiate::<KIND, D, C>(pack, &frames, &mut kept[0], &mut transports[0]);
            self.differentiate_forward::<KIND, D, C>(pack, &frames, &mut kept[1], &mut transports[1]);
            for lane in 0..pack.group.used {
                let [hand, forward] = kept.each_ref().map(|kept| {
                    let entry = |row: usize, column: usize| kept.block[row * count + column].to_array()[lane];
                    let column = |column| (0..count - 1).map(move |row| entry(row, column)).collect::<Vec<_>>();
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
        }
        worst
    }

    /// Takes the derivatives that are kept once more, where they were taken.
    pub(super) fn retake<const KIND: u8, const D: usize, C: Standing>(&mut self) {
        let theta = own_directions(KIND, D) + 1;
        let (mut all, mut transports) = (
            std::mem::take(&mut self.kept),
            std::mem::take(&mut self.transport_slopes),
        );
        for (pack, kept) in self.packs.iter().zip(&mut all) {
            if !kept.slopes[0].is_nan() {
                let frames = Frames::<C>::new(&self.curve, kept.unknowns.position[theta].re(), kept.slopes[1]);
                (kept.regime, _) = self.look::<KIND, D, C>(pack, &frames.plain, &kept.unknowns, kept.slopes[0]);
                self.differentiate::<KIND, D, C>(pack, &frames, kept, &mut transports);
            }
        }
        (self.kept, self.transport_slopes) = (all, transports);
    }

    pub(super) fn assemble_jacobian<const KIND: u8, const D: usize, C: Standing>(
        &mut self,
        view: View<'_>,
        alpha: f64,
        beta: f64,
        out: &mut Arrow,
    ) {
        let (count, theta) = (directions(KIND, D), own_directions(KIND, D) + 1);
        let frames = Frames::<C>::new(&self.curve, self.theta(view), beta);
        let (mut all, mut transports) = (
            std::mem::take(&mut self.kept),
            std::mem::take(&mut self.transport_slopes),
        );
        for (pack, kept) in self.packs.iter().zip(&mut all) {
            let unknowns = InPlace { pack, view }.gather(count);
            let (regime, transport) = self.look::<KIND, D, C>(pack, &frames.plain, &unknowns, alpha);
            let length = C::segment_length(&frames.plain, pack.segment).v * pack.of_segment[1];
            if !kept.holds(
                &regime,
                &unknowns,
                length,
                [if KIND == GUIDED { 0 } else { D }, theta],
                alpha,
            ) {
                self.differentiations += 1;
                (kept.unknowns, kept.regime, kept.slopes) = (unknowns, regime, [alpha, beta]);
                self.differentiate::<KIND, D, C>(pack, &frames, kept, &mut transports);
            }
            for (entry, value) in pack.entries.iter().zip(&kept.block) {
                let value = value.to_array();
                for lane in 0..pack.group.used {
                    out.add_at(entry[lane], value[lane]);
                }
            }
            self.transports.set_pack(pack.group.cells[0], &transport);
        }
        (self.kept, self.transport_slopes) = (all, transports);
        self.add_flux_slopes(count, alpha, out);
    }

    /// Adds the derivatives of the balance of the amounts in `count` directions: fluxes through the left faces.
    fn add_flux_slopes(&self, count: usize, alpha: f64, out: &mut Arrow) {
        let cells = self.mesh.cells.len();
        for cell in 0..cells {
            let [_, row] = self.cells_at[cell];
            out.add(row, row, alpha);
            let before = (cell + cells - 1) % cells;
            let [by_before, by_own] = chain::flux_slopes(&self.transports.get(before), &self.transports.get(cell));
            let (of_before, of_own) = (&self.transport_slopes[before], &self.transport_slopes[cell]);
            let [own, other] = &self.flux_entries[cell];
            for k in 0..count {
                let (slope, slope_before) = (by_own.along(of_own, k), by_before.along(of_before, k));
                for (entries, slope) in [(own[k], slope), (other[k], slope_before)] {
                    for (entry, value) in entries.into_iter().zip([slope, -slope]) {
                        if entry != NOWHERE {
                            out.add_at(entry, value);
                        }
                    }
                }
            }
        }
    }
}

/// Where the derivatives of a pack go, a direction after the other.
struct Columns<'a> {
    pack: &'a Pack,
    /// Directions, and the one whose row the fluxes fill.
    count: usize,
    amount: usize,
    block: &'a mut [Lanes],
    transports: &'a mut [Transport<[f64; MOST]>],
}

impl<'a> Columns<'a> {
    /// The unknowns and slopes at which a pack is differentiated, and where its columns go.
    #[inline(always)]
    fn of<const KIND: u8, const D: usize>(
        pack: &'a Pack,
        kept: &'a mut Kept,
        transports: &'a mut [Transport<[f64; MOST]>],
    ) -> (&'a Unknowns<Lanes>, [f64; 2], Self) {
        let columns = Self {
            pack,
            count: directions(KIND, D),
            amount: amount_direction(KIND, D),
            block: &mut kept.block,
            transports,
        };
        (&kept.unknowns, kept.slopes, columns)
    }

    /// Puts the derivatives in a direction: rows of the balance, and what the balance of the amounts needs.
    #[inline(always)]
    fn put(&mut self, direction: usize, rows: &[Lanes; MOST], transport: &Transport<Lanes>) {
        let amount = self.amount;
        let rows = rows[..self.count].iter().enumerate().filter(|(k, _)| *k != amount);
        for ((_, row), block) in rows.zip(self.block.chunks_exact_mut(self.count)) {
            block[direction] = *row;
        }
        for (figure, slope) in transport.each().into_iter().enumerate() {
            for (&cell, slope) in self.pack.group.cells[..self.pack.group.used]
                .iter()
                .zip(slope.to_array())
            {
                self.transports[cell].each_mut()[figure][direction] = slope;
            }
        }
    }
}

/// The curve as it stands, without derivatives and with that along Θ.
struct Frames<C: Standing> {
    shape: TwoPulleyShape,
    plain: C::Frame<Lanes>,
    of_theta: C::Frame<Tangent<1>>,
}

impl<C: Standing> Frames<C> {
    /// Frames at `theta`, whose slope is `beta`.
    fn new(curve: &TwoPulley, theta: f64, beta: f64) -> Self {
        let shape = curve.shape(theta);
        Self {
            plain: C::stand(curve, shape.frame(Lanes::zero())),
            of_theta: C::stand(curve, shape.frame(Tangent::seed(Lanes::zero(), 0, beta))),
            shape,
        }
    }
}
