//! Cells on a mesh that stands still: residual, Jacobian and samples, a pack of cells at a time.

use crate::chain::Transport;
use crate::pulley::PerPulley;
use crate::reference_curve::COORDINATES;
use crate::scalar::Lanes;
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::solver::sdirk::Geometry;
use crate::tape::Tape;
use crate::variator::assembly::equations::{Assembly, InForce};
use crate::variator::assembly::evaluate::{frame, pack_balance, sampled_balance};
use crate::variator::assembly::global_slopes::GlobalSlopes;
use crate::variator::assembly::jacobian::Differentiate;
#[cfg(test)]
use crate::variator::assembly::jacobian::worst_of_pack;
use crate::variator::assembly::kept::{Kept, Renewal, Wanted};
use crate::variator::assembly::kinds::MeshCurve;
use crate::variator::assembly::law_part::{MOST_FORCES, Through};
use crate::variator::assembly::pack::{FluxEntries, InPlace, NOWHERE, Pack, flux_entries, packs};
use crate::variator::assembly::sums::{PulleyLoad, ResultantSlopes};
use crate::variator::assembly::transports::Transports;
use crate::variator::assembly::unknowns::{path, rows};
use crate::variator::belt::Belt;
use crate::variator::cell::directions::{MOST, RESULTANT};
use crate::variator::cell::probe::NoProbe;
use crate::variator::cell::sample::Sample;
use crate::variator::law::place::CellBalance;
use num_traits::Zero;
use std::marker::PhantomData;

/// Cells with a ring of kind `K` in D components, whose mesh lies on the curve `C`.
#[derive(Clone, Debug)]
pub(crate) struct PackedCells<K, const D: usize, C> {
    pub(crate) packs: Vec<Pack>,
    /// Kept derivatives of each pack.
    pub(crate) kept: Vec<Kept>,
    /// Number of packs that were differentiated, and that got new slopes of their laws alone.
    pub(crate) differentiations: [u64; 2],
    pub(crate) transports: Transports,
    /// Slopes of `transports` in the cell's directions, kept as those of the packs are.
    pub(crate) transport_slopes: Vec<Transport<[f64; MOST]>>,
    pub(crate) flux_entries: Vec<FluxEntries>,
    /// Working memory.
    globals: GlobalSlopes,
    through: Box<Through>,
    kind: PhantomData<(K, C)>,
}

impl<K: Differentiate<D, C>, const D: usize, C: MeshCurve> PackedCells<K, D, C> {
    /// The cells of a belt.
    pub fn new(belt: &Belt) -> Self {
        let cells = belt.mesh.cells.len();
        let packs = packs::<K>(belt);
        Self {
            kept: packs
                .iter()
                .map(|pack| {
                    let entries = pack.entries.len() + RESULTANT * K::COUNT;
                    Kept::new(entries, K::law_part(belt.mesh.points))
                })
                .collect(),
            packs,
            differentiations: [0; 2],
            transports: Transports::new(cells),
            transport_slopes: vec![Transport::default().map(|()| [0.0; MOST]); cells],
            flux_entries: flux_entries::<K>(belt),
            globals: GlobalSlopes::new::<K>(),
            through: Box::new([[Lanes::zero(); MOST]; MOST_FORCES]),
            kind: PhantomData,
        }
    }

    /// Adds the derivatives of the balance of the amounts: fluxes through the left faces, which no pulley moves.
    fn add_flux_slopes(&self, belt: &Belt, alpha: f64, out: &mut Arrow) {
        for face in self.transports.faces(belt) {
            let [before, cell] = face.cells;
            let row = face.amounts[1];
            out.add(row, row, alpha);
            let [own, other] = &self.flux_entries[cell];
            for k in 0..K::SHEAVE {
                let of_own = face.slopes(1, &self.transport_slopes[cell], k);
                let of_before = face.slopes(0, &self.transport_slopes[before], k);
                for (entries, slopes) in [(own[k], of_own), (other[k], of_before)] {
                    for (entry, slope) in entries.into_iter().zip(slopes) {
                        if entry != NOWHERE {
                            out.add_at(entry, slope);
                        }
                    }
                }
            }
        }
    }
}

impl<K: Differentiate<D, C>, const D: usize, C: MeshCurve> Assembly for PackedCells<K, D, C> {
    fn boxed(&self) -> Box<dyn Assembly> {
        Box::new(self.clone())
    }

    fn residual(&mut self, acting: InForce<'_>, view: View<'_>, out: &mut [f64]) -> PerPulley<PulleyLoad> {
        let belt = acting.belt;
        let frame = frame::<C>(belt, view);
        let [mut drift, mut theta] = [Lanes::zero(); 2];
        let mut centres = [Lanes::zero(); COORDINATES - 1];
        let mut loads = PerPulley::<PulleyLoad<Lanes>>::default();
        for pack in &self.packs {
            let (b, ring) = pack_balance::<_, _, K, D, C>(
                acting,
                pack,
                &frame,
                &InPlace { pack, view },
                [0.0; 2],
                |value, _, _| value,
                &mut NoProbe,
            );
            let rows = rows::<_, K, D>(&b, &ring);
            pack.scatter::<K, D>(&rows, out);
            let in_use = pack.group.in_use();
            drift += rows[K::DRIFT] * in_use;
            theta += rows[K::THETA] * in_use;
            for (k, sum) in centres.iter_mut().enumerate().take(K::COORDINATES - 1) {
                *sum += rows[K::THETA + 1 + k] * in_use;
            }
            add_loads(&mut loads, pack, &b);
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        }
        out[belt.layout.drift()] += drift.sum();
        out[belt.layout.theta()] += theta.sum();
        for (k, sum) in centres.into_iter().enumerate().take(K::COORDINATES - 1) {
            out[belt.layout.centre(k)] += sum.sum();
        }
        self.transports.add_fluxes(belt, view, out);
        loads.map(|of| of.sum())
    }

    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        slopes: [f64; 2],
        geometry: Option<Geometry>,
        (out, resultants): (&mut Arrow, &mut ResultantSlopes),
    ) -> PerPulley<PulleyLoad> {
        let InForce { belt, .. } = acting;
        let alpha = slopes[0];
        let wanted = |pack: usize| match geometry {
            None => Wanted::Needed,
            Some(Geometry::All) => Wanted::All,
            Some(Geometry::Part { number, parts }) if pack % parts == number => Wanted::All,
            Some(Geometry::Part { .. } | Geometry::Kept) => Wanted::Laws,
        };
        let frames = K::frames(&belt.curve, &belt.path(view), slopes);
        self.globals.clear();
        let mut loads = PerPulley::<PulleyLoad<Lanes>>::default();
        for (number, (pack, kept)) in self.packs.iter().zip(&mut self.kept).enumerate() {
            let unknowns = InPlace { pack, view }.gather(K::COUNT);
            let of_pack = (&mut *kept, &mut *self.transport_slopes, &mut *self.through);
            let at = (&unknowns, slopes);
            let (b, renewal) = K::renew(acting, pack, &frames, at, wanted(number), of_pack);
            for (count, of) in self.differentiations.iter_mut().zip([Renewal::All, Renewal::Laws]) {
                *count += u64::from(renewal == of);
            }
            let mut rows = kept.block.chunks_exact(K::COUNT);
            let mut entries = pack.entries.chunks_exact(K::COUNT);
            for (row, entries) in rows.by_ref().zip(entries.by_ref()).take(K::DRIFT - 1) {
                pack.add_entries(row, entries, out);
            }
            for (k, row) in rows.enumerate() {
                let (own, globals) = row.split_at(K::DRIFT);
                if let Some(entries) = entries.next() {
                    pack.add_entries(own, entries, out);
                } else {
                    pack.add_resultant(own, k + K::DRIFT - K::COUNT, belt, resultants);
                }
                self.globals.add(k, globals, &pack.group);
            }
            add_loads(&mut loads, pack, &b);
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        }
        self.globals.spill::<K>(belt, (out, resultants));
        self.add_flux_slopes(belt, alpha, out);
        loads.map(|of| of.sum())
    }

    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]) {
        let frame = frame::<C>(acting.belt, view);
        let mut places = out.iter_mut();
        for pack in &self.packs {
            sampled_balance::<K, D, C>(acting, pack, &frame, &InPlace { pack, view }, &mut |sample| {
                *places.next().expect("a place for each station") = sample;
            });
        }
    }

    fn forget_derivatives(&mut self) {
        self.kept.iter_mut().for_each(Kept::forget);
    }

    fn restore_derivatives(&mut self, acting: InForce<'_>) {
        for (pack, kept) in self.packs.iter().zip(&mut self.kept) {
            let origins = [&kept.origin, &kept.laws_origin].map(Clone::clone);
            kept.forget();
            for (origin, wanted) in origins.iter().zip([Wanted::All, Wanted::Laws]) {
                if origin.exists() {
                    let frames = K::frames(&acting.belt.curve, &path::<K>(&origin.unknowns), origin.slopes);
                    let at = (&origin.unknowns, origin.slopes);
                    let of_pack = (&mut *kept, &mut *self.transport_slopes, &mut *self.through);
                    K::renew(acting, pack, &frames, at, wanted, of_pack);
                }
            }
        }
    }

    fn pass_derivatives(&mut self, _belt: &Belt, tape: &mut Tape<'_>) {
        for (pack, kept) in self.packs.iter().zip(&mut self.kept) {
            kept.pass(tape, K::COUNT, pack.group.used);
        }
    }

    fn differentiations(&self) -> [u64; 2] {
        self.differentiations
    }

    #[cfg(test)]
    fn worst_derivative(&self, acting: InForce<'_>, view: View<'_>, alpha: f64) -> f64 {
        let frames = K::frames(&acting.belt.curve, &acting.belt.path(view), [alpha, 1.0 / alpha]);
        let of_pack = |(pack, kept): (&Pack, &Kept)| {
            let unknowns = InPlace { pack, view }.gather(K::COUNT);
            let at = (&unknowns, [alpha, 1.0 / alpha]);
            worst_of_pack::<K, D, C>(acting, pack, &frames, at, kept, &self.transport_slopes)
        };
        self.packs.iter().zip(&self.kept).map(of_pack).fold(0.0, f64::max)
    }
}

/// Adds the loads of a pack on the pulleys.
#[inline(always)]
pub(crate) fn add_loads(loads: &mut PerPulley<PulleyLoad<Lanes>>, pack: &Pack, b: &CellBalance<Lanes>) {
    loads.secondary.add(b, pack.group.on.secondary);
    loads.primary.add(b, pack.group.on.primary);
}
