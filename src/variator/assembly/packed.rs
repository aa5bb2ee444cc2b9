//! Cells on an Eulerian mesh: residual, Jacobian and samples, pack by pack.

use crate::archive::Archive;
use crate::chain::Transport;
use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::{COORDINATES, MeshCurve};
use crate::scalar::Lanes;
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::variator::assembly::jacobian::{Frames, update};
use crate::variator::assembly::jacobian_cache::{CacheUpdate, JacobianCache};
use crate::variator::assembly::kinds::{RingKind, frame, pack_balance};
use crate::variator::assembly::law_part::{LawPart, LawWork};
use crate::variator::assembly::pack::{FluxEntries, NOWHERE, Pack, flux_entries, packs};
use crate::variator::assembly::transports::{Transports, VANISHING};
use crate::variator::assembly::unknowns::{Unknowns, path, rows};
use crate::variator::belt::equations::{Assembly, InForce, ReusePolicy};
use crate::variator::belt::sums::{PulleyLoad, ResultantSlopes};
use crate::variator::belt::{Belt, CellUnknowns};
use crate::variator::cell::directions::{DeflectingRing, GuidedRing, MOST};
use crate::variator::cell::observer::{NoObserver, Sampler};
use crate::variator::cell::sample::Sample;
use crate::variator::law::place::CellBalance;
use num_traits::Zero;
use std::marker::PhantomData;

/// Cells with a ring of kind `K` in D components, on a mesh of the curve `C`.
#[derive(Clone, Debug)]
pub(crate) struct PackedCells<K, const D: usize, C> {
    pub(crate) packs: Vec<Pack>,
    /// Cached derivatives of each pack.
    pub(crate) caches: Vec<JacobianCache>,
    /// Numbers of packs that were differentiated, and of packs whose constitutive tangents alone were updated.
    pub(crate) differentiations: [u64; 2],
    pub(crate) transports: Transports,
    /// Derivatives of `transports` in the directions of the cells, cached with those of the packs.
    pub(crate) transport_slopes: Vec<Transport<[f64; MOST]>>,
    pub(crate) flux_entries: Vec<FluxEntries>,
    /// Working memory.
    unknowns: Box<Unknowns<Lanes>>,
    work: LawWork,
    kind: K,
    by_hand: bool,
    curve: PhantomData<C>,
}

impl<K: RingKind<D, C>, const D: usize, C: MeshCurve> PackedCells<K, D, C> {
    /// The cells of a belt, with derivatives by hand, of a ring that has them, if `by_hand`.
    fn of_belt(kind: K, belt: &Belt, by_hand: bool) -> Box<dyn Assembly> {
        let cells = belt.mesh.cells.len();
        let packs = packs::<K>(belt);
        let laws = by_hand.then(|| LawPart::new::<K, D>(belt.mesh.points));
        Box::new(Self {
            caches: vec![JacobianCache::new::<K>(laws); packs.len()],
            packs,
            differentiations: [0; 2],
            transports: Transports::new(cells),
            transport_slopes: vec![Transport::default().map(|()| [0.0; MOST]); cells],
            flux_entries: flux_entries::<K>(belt),
            unknowns: Box::new(Unknowns::zero()),
            work: LawWork::new::<K>(),
            kind,
            by_hand,
            curve: PhantomData,
        })
    }

    /// Adds the derivatives of the balance of the amounts. The fluxes do not depend on the pulleys.
    fn add_flux_slopes(&mut self, belt: &Belt, alpha: f64, out: &mut Arrow) {
        if belt.law.is_chain() {
            for i in belt.cells_at.iter().flat_map(CellUnknowns::each) {
                out.add(i, i, alpha + VANISHING);
            }
            return;
        }
        for face in self.transports.faces(belt) {
            let [before, cell] = face.cells;
            let row = face.amounts[1];
            out.add(row, row, alpha);
            for ((side, of), entries) in [(1, cell), (0, before)].into_iter().zip(&self.flux_entries[cell]) {
                let slopes = face.slopes(side, &self.transport_slopes[of]);
                for ([from, into], slope) in entries.iter().zip(slopes).take(K::SHEAVE) {
                    if *from != NOWHERE {
                        out.add_at(*from, slope);
                    }
                    if *into != NOWHERE {
                        out.add_at(*into, -slope);
                    }
                }
            }
        }
    }
}

impl<K: RingKind<D, C>, const D: usize, C: MeshCurve> Assembly for PackedCells<K, D, C> {
    fn boxed(&self) -> Box<dyn Assembly> {
        Box::new(self.clone())
    }

    fn residual(&mut self, acting: InForce<'_>, view: View<'_>, out: &mut [f64]) -> PerPulley<PulleyLoad> {
        let belt = acting.belt;
        let frame = frame::<K, C>(&belt.curve, belt.path(view));
        let [mut drift, mut theta] = [Lanes::zero(); 2];
        let mut centres = [Lanes::zero(); COORDINATES - 1];
        let mut loads = PerPulley::<PulleyLoad<Lanes>>::default();
        for pack in &self.packs {
            pack.gather::<K>(view, &mut self.unknowns);
            let (b, ring) = pack_balance::<_, _, K, D, C>(
                acting,
                (&self.kind, pack),
                &frame,
                &self.unknowns,
                [0.0; 2],
                |value, _, _| value,
                &mut NoObserver,
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
        loads.map(|of| of.map(Lanes::sum))
    }

    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        slopes: [f64; 2],
        policy: ReusePolicy,
        (out, resultants): (&mut Arrow, &mut ResultantSlopes),
    ) -> PerPulley<PulleyLoad> {
        let InForce { belt, .. } = acting;
        let alpha = slopes[0];
        let frames = Frames::<C>::new::<K>(&belt.curve, belt.path(view), slopes, self.by_hand);
        let mut loads = PerPulley::<PulleyLoad<Lanes>>::default();
        for (pack, cache) in self.packs.iter().zip(&mut self.caches) {
            pack.gather::<K>(view, &mut self.unknowns);
            let of_pack = (&mut *cache, &mut *self.transport_slopes);
            let at = (&*self.unknowns, slopes);
            let (b, update) = update::<K, D, C>(acting, (&self.kind, pack), &frames, at, policy, of_pack);
            for (count, of) in self
                .differentiations
                .iter_mut()
                .zip([CacheUpdate::All, CacheUpdate::Tangents])
            {
                *count += u64::from(update == of);
            }
            let block = cache.derivatives::<K>(&mut self.work);
            pack.add_derivatives(block, K::COUNT, out);
            pack.add_shared::<K>(block, belt, (out, resultants));
            add_loads(&mut loads, pack, &b);
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        }
        self.add_flux_slopes(belt, alpha, out);
        loads.map(|of| of.map(Lanes::sum))
    }

    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]) {
        let frame = frame::<K, C>(&acting.belt.curve, acting.belt.path(view));
        let (mut places, mut unknowns) = (out.iter_mut(), Unknowns::zero());
        for pack in &self.packs {
            pack.gather::<K>(view, &mut unknowns);
            let mut record = |sample| *places.next().expect("a place for each station") = sample;
            pack_balance::<_, _, K, D, C>(
                acting,
                (&self.kind, pack),
                &frame,
                &unknowns,
                [0.0; 2],
                |value, _, _| value,
                &mut Sampler(&mut record),
            );
        }
    }

    fn forget_derivatives(&mut self) {
        self.caches.iter_mut().for_each(JacobianCache::forget);
    }

    fn restore_derivatives(&mut self, acting: InForce<'_>) {
        for (pack, cache) in self.packs.iter().zip(&mut self.caches) {
            let origins = [&cache.origin, &cache.laws_origin].map(Clone::clone);
            cache.forget();
            for (origin, policy) in origins.iter().zip([ReusePolicy::None, ReusePolicy::Geometry]) {
                if origin.exists() {
                    let (curve, path) = (&acting.belt.curve, path::<K>(&origin.unknowns));
                    let frames = Frames::<C>::new::<K>(curve, path, origin.slopes, self.by_hand);
                    let at = (&origin.unknowns, origin.slopes);
                    let of_pack = (&mut *cache, &mut *self.transport_slopes);
                    update::<K, D, C>(acting, (&self.kind, pack), &frames, at, policy, of_pack);
                }
            }
        }
    }

    fn serialize_derivatives(&mut self, _belt: &Belt, archive: &mut Archive<'_>) {
        for (pack, cache) in self.packs.iter().zip(&mut self.caches) {
            cache.serialize(archive, K::COUNT, pack.group.used);
        }
    }

    fn differentiations(&self) -> [u64; 2] {
        self.differentiations
    }
}

/// Equations of a belt whose ring follows the curve `C` (`ALE0`), with derivatives by hand or by forward differentiation
/// alone.
#[must_use]
pub fn guided_equations<C: MeshCurve>(belt: &Belt, by_hand: bool) -> Box<dyn Assembly> {
    PackedCells::<GuidedRing, 2, C>::of_belt(GuidedRing, belt, by_hand)
}

/// The same for a ring that deflects from the curve `C` in D components (`ALE`).
#[must_use]
pub fn deflecting_equations<const D: usize, C: MeshCurve>(belt: &Belt, by_hand: bool) -> Box<dyn Assembly> {
    PackedCells::<DeflectingRing<D>, D, C>::of_belt(DeflectingRing, belt, by_hand)
}

/// Equations of a belt with a ring of this kind in D components, on a mesh of the curve `C`. Derivatives are computed by
/// forward differentiation of the ring's functions.
#[must_use]
pub fn eulerian_equations<K: RingKind<D, C>, const D: usize, C: MeshCurve>(kind: K, belt: &Belt) -> Box<dyn Assembly> {
    PackedCells::<K, D, C>::of_belt(kind, belt, false)
}

/// Adds the loads of a pack on the pulleys.
fn add_loads(loads: &mut PerPulley<PulleyLoad<Lanes>>, pack: &Pack, b: &CellBalance<Lanes>) {
    for pulley in Pulley::BOTH {
        loads[pulley].add(&b.pulley, pack.group.on[pulley]);
    }
}
