//! Cells on an Eulerian mesh: residual, Jacobian and samples, pack by pack.

use crate::archive::Archive;
use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::{COORDINATES, MeshCurve, ReferenceCurve};
use crate::scalar::Lanes;
use crate::solver::Factors;
use crate::solver::arrow::Arrow;
use crate::solver::{State, View};
use crate::stack::Transport;
use crate::variator::assembly::derivatives::{Columns, Derivatives, UpdateWork};
use crate::variator::assembly::jacobian::{Frames, differentiate};
use crate::variator::assembly::kinds::{RingKind, frame, pack_balance, rows};
use crate::variator::assembly::pack::{FluxEntries, Pack, flux_entries, packs};
use crate::variator::assembly::transports::{RELAXATION_RATE, Transports};
use crate::variator::belt::equations::{Assembly, InForce};
use crate::variator::belt::sums::{PulleyLoad, ResultantDerivatives};
use crate::variator::belt::{Belt, CellUnknowns, THETA_PER_METRE};
use crate::variator::cell::degrees::{DeflectingRing, GuidedRing, MOST};
use crate::variator::cell::sample::{AtStation, Sample};
use crate::variator::law::arguments::{CellBalance, StateComponent};
use crate::variator::rings::ring::{EulerianRing, RingForces};
use num_traits::Zero;
use std::marker::PhantomData;

/// Derivatives are reused while 1/(hγ) has changed by less than this factor. Beyond it Newton's
/// method takes up to ten times as many Jacobians: a factor of 3 costs a third more time under
/// rough loads.
const RESCALED: f64 = 1.5;
/// Factors before the first Jacobian.
const NO_FACTORS: Factors = Factors {
    alpha: f64::NAN,
    beta: f64::NAN,
};

/// Rotation of the ring up to which its geometry is reused, rad. Half of it renews a sixth more
/// geometry and twice of it a tenth less, with the same number of Jacobians within noise.
const ROTATED: f64 = 1.2e-2;
/// Change of Θ up to which it is reused. Twice of it costs a tenth more Jacobians in macro-slip,
/// without a bound they are twice as many.
const SHIFTED: f64 = 3.0e-3;

/// Where all derivatives were evaluated: state, and factors of ẏ and q; NaN where they were not.
#[derive(Clone, Debug)]
struct Origin {
    factors: Factors,
    state: State,
}

impl Origin {
    fn set(&mut self, view: View<'_>, factors: Factors) {
        self.factors = factors;
        self.state.y.copy_from_slice(view.y);
        self.state.y_dot.copy_from_slice(view.y_dot);
        self.state.q.copy_from_slice(view.q);
    }
}

/// Cells with a ring of kind `K` in D components, on a mesh of the curve `C`.
///
/// Where the belt slips or a gap closes, a Jacobian is needed in nearly every stage, but the
/// geometry hardly changes from one to the next. Then the constitutive tangents alone are updated,
/// which is accurate enough for a simplified Newton method.
#[derive(Clone, Debug)]
pub(crate) struct PackedCells<K, const D: usize, C> {
    packs: Vec<Pack>,
    /// Derivatives of each pack.
    derivatives: Vec<Derivatives>,
    origin: Origin,
    /// Number of evaluations of all derivatives, and of constitutive tangents alone.
    differentiations: [u64; 2],
    transports: Transports,
    /// Derivatives of `transports` in the directions of the cells.
    d_transports: Vec<Transport<[f64; MOST]>>,
    flux_entries: Vec<FluxEntries>,
    /// Working memory.
    work: UpdateWork,
    kind: K,
    by_hand: bool,
    curve: PhantomData<C>,
}

impl<K: RingKind<D, C>, const D: usize, C: MeshCurve> PackedCells<K, D, C> {
    /// The cells of a belt, with derivatives by hand, of a ring that has them, if `by_hand`.
    fn of_belt(kind: K, belt: &Belt, by_hand: bool) -> Box<dyn Assembly> {
        let cells = belt.mesh.cells.len();
        let packs = packs::<K>(belt);
        let origin = Origin {
            factors: NO_FACTORS,
            state: State::zero(belt.layout.len()),
        };
        Box::new(Self {
            derivatives: vec![Derivatives::new::<K, D>(belt.mesh.points, by_hand); packs.len()],
            packs,
            origin,
            differentiations: [0; 2],
            transports: Transports::new(cells),
            d_transports: vec![Transport::default().map(|()| [0.0; MOST]); cells],
            flux_entries: flux_entries::<K>(belt),
            work: UpdateWork::new::<K>(),
            kind,
            by_hand,
            curve: PhantomData,
        })
    }

    /// Whether the geometry of the derivatives is still valid in a state with these factors.
    fn is_valid(&self, belt: &Belt, view: View<'_>, factors: Factors) -> bool {
        let Origin { factors: then, state } = &self.origin;
        self.by_hand
            && (1.0 / RESCALED..RESCALED).contains(&(factors.alpha / then.alpha))
            && is_near(belt, &state.q, view.q)
    }

    /// Evaluates derivatives in a state, all or the tangents alone where the others are valid. Adds
    /// them to the matrix and to those of the resultants.
    fn differentiate(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        factors: Factors,
        mut out: Option<(&mut Arrow, &mut ResultantDerivatives)>,
    ) -> PerPulley<PulleyLoad<Lanes>> {
        let belt = acting.belt;
        let update = self.is_valid(belt, view, factors);
        self.differentiations[usize::from(update)] += 1;
        if !update {
            self.origin.set(view, factors);
        }
        let frames = Frames::<C>::new::<K>(&belt.curve, belt.path(view), factors, [update, self.by_hand]);
        let mut unknowns = [[Lanes::zero(); MOST]; 3];
        let mut loads = PerPulley::<PulleyLoad<Lanes>>::default();
        for (pack, derivatives) in self.packs.iter().zip(&mut self.derivatives) {
            pack.gather::<K>(view, &mut unknowns);
            let columns = Columns {
                cells: pack.cells(),
                derivatives: &mut *derivatives,
                transports: &mut self.d_transports,
            };
            let b = differentiate(acting, (&self.kind, pack), &frames, &unknowns, columns);
            if let Some((matrix, resultants)) = &mut out {
                let block = derivatives.current::<K>(&mut self.work);
                pack.add_derivatives(block, K::DEGREES.count, matrix);
                pack.add_shared::<K>(block, belt, (matrix, resultants));
            }
            add_loads(&mut loads, pack, &b);
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        }
        loads
    }

    /// Adds the derivatives of the balance of the content. The fluxes do not depend on the pulleys.
    fn add_flux_derivatives(&mut self, belt: &Belt, alpha: f64, out: &mut Arrow) {
        if belt.law.is_pull_chain() {
            for i in belt.cells_at.iter().flat_map(CellUnknowns::to_array) {
                out.add(i, i, alpha + RELAXATION_RATE);
            }
            return;
        }
        for face in self.transports.faces(belt) {
            let [before, cell] = face.cells;
            let row = face.contents[1];
            out.add(row, row, alpha);
            for ((side, of), entries) in [(1, cell), (0, before)].into_iter().zip(&self.flux_entries[cell]) {
                let derivatives = face.derivatives(side, &self.d_transports[of]);
                for (entries, derivative) in entries.iter().zip(derivatives).take(K::DEGREES.sheave) {
                    for (entry, value) in entries.iter().zip([derivative, -derivative]) {
                        if let Some(entry) = entry {
                            out.add_at(*entry, value);
                        }
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
        let shared = K::DEGREES.drift..K::DEGREES.sheave;
        let mut sums = [Lanes::zero(); 1 + COORDINATES];
        let mut loads = PerPulley::<PulleyLoad<Lanes>>::default();
        let add = |pack: &Pack, b: &CellBalance<Lanes>, ring: &RingForces<Lanes, D>| {
            let rows = rows::<_, K, D>(b, ring);
            pack.scatter::<K, D>(&rows, out);
            for (sum, row) in sums.iter_mut().zip(&rows[shared.clone()]) {
                *sum += *row * pack.group.in_use();
            }
            add_loads(&mut loads, pack, b);
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        };
        evaluate::<K, D, C>(acting, (&self.kind, &self.packs), view, |_| (), add);
        for (at, sum) in self.packs[0].at[shared].iter().zip(sums) {
            out[at[0]] += sum.sum();
        }
        self.transports.add_fluxes(belt, view, out);
        loads.map(|of| of.map(Lanes::sum))
    }

    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        factors: Factors,
        (out, resultants): (&mut Arrow, &mut ResultantDerivatives),
    ) -> PerPulley<PulleyLoad> {
        let loads = self.differentiate(acting, view, factors, Some((&mut *out, resultants)));
        self.add_flux_derivatives(acting.belt, factors.alpha, out);
        loads.map(|of| of.map(Lanes::sum))
    }

    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]) {
        let mut places = out.iter_mut();
        let record =
            |at: &AtStation<'_, Lanes, D>| *places.next().expect("a sample for each station") = at.sample();
        evaluate::<K, D, C>(acting, (&self.kind, &self.packs), view, record, |_, _, _| ());
    }

    fn forget_derivatives(&mut self) {
        self.origin.factors = NO_FACTORS;
    }

    fn serialize_derivatives(&mut self, acting: InForce<'_>, archive: &mut Archive<'_>) {
        let Origin { factors, state } = &mut self.origin;
        archive.any_real(&mut factors.alpha);
        archive.any_real(&mut factors.beta);
        state.serialize(archive);
        if archive.is_reading() {
            let Origin { factors, state } = self.origin.clone();
            self.forget_derivatives();
            if !factors.alpha.is_nan() {
                self.differentiate(acting, state.view(), factors, None);
            }
        }
    }

    fn differentiations(&self) -> [u64; 2] {
        self.differentiations
    }
}

/// Equations of a belt whose ring follows the curve `C` (`ALE0`), with derivatives by hand or by
/// forward differentiation alone.
#[must_use]
pub fn guided_equations<C: MeshCurve>(belt: &Belt, by_hand: bool) -> Box<dyn Assembly> {
    PackedCells::<GuidedRing, 2, C>::of_belt(GuidedRing, belt, by_hand)
}

/// The same for a ring that deflects from the curve `C` in D components (`ALE`).
#[must_use]
pub fn deflecting_equations<const D: usize, C: MeshCurve>(belt: &Belt, by_hand: bool) -> Box<dyn Assembly> {
    PackedCells::<DeflectingRing<D>, D, C>::of_belt(DeflectingRing, belt, by_hand)
}

/// Equations of a belt with a ring of this kind in D components, on a mesh of the curve `C`.
/// Derivatives are computed by forward differentiation of the ring's functions.
#[must_use]
pub fn eulerian_equations<K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    kind: K,
    belt: &Belt,
) -> Box<dyn Assembly> {
    PackedCells::<K, D, C>::of_belt(kind, belt, false)
}

/// Whether the geometry has hardly changed between two positions.
fn is_near(belt: &Belt, then: &[f64], now: &[f64]) -> bool {
    let layout = &belt.layout;
    let moved = |i: usize| now[i] - then[i];
    let frame = belt.curve.frame(then[layout.theta()]);
    let rotated = |element: usize| {
        let length = belt.element_length(&frame, element);
        (0..layout.components).any(|k| {
            let [left, right] = [element, element + 1].map(|node| moved(layout.node(node, 2 * k)));
            let slope = moved(layout.node(element, 2 * k + 1));
            slope.abs().max((right - left).abs() / length) >= ROTATED
        })
    };
    moved(layout.theta()).abs() < SHIFTED
        && layout
            .centres()
            .all(|centre| moved(centre).abs() * THETA_PER_METRE < SHIFTED)
        && !(0..layout.elements).any(rotated)
}

/// Evaluates all packs without derivatives: calls `observe` at every station, and `take` with the
/// balance of each pack and the forces on its ring.
#[inline(always)]
fn evaluate<K: RingKind<D, C>, const D: usize, C: MeshCurve>(
    acting: InForce<'_>,
    (kind, packs): (&K, &[Pack]),
    view: View<'_>,
    mut observe: impl FnMut(&AtStation<'_, Lanes, D>),
    mut take: impl FnMut(&Pack, &CellBalance<Lanes>, &RingForces<Lanes, D>),
) {
    let frame = frame::<_, K, C>(&acting.belt.curve, acting.belt.path(view).map(|of| of.map(Lanes::from)));
    let mut unknowns = [[Lanes::zero(); MOST]; 3];
    for pack in packs {
        pack.gather::<K>(view, &mut unknowns);
        let unknown = |component: StateComponent, k: usize| unknowns[component as usize][k];
        let (b, ring) =
            pack_balance::<_, K, D, C, _>(acting, (kind, pack), &frame, unknown, &mut observe, |ring, _| {
                ring.forces()
            });
        take(pack, &b, &ring);
    }
}

/// Adds the loads of a pack on the pulleys.
fn add_loads(loads: &mut PerPulley<PulleyLoad<Lanes>>, pack: &Pack, b: &CellBalance<Lanes>) {
    for pulley in Pulley::BOTH {
        loads[pulley].add(&b.pulley, pack.group.on[pulley]);
    }
}
