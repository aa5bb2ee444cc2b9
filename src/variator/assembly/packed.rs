//! Cells on an Eulerian mesh: residual, Jacobian and samples, pack by pack.

use super::derivatives::{Derivatives, UpdateWork};
use super::evaluation::{Frames, Scope, differentiate, frame, pack_balance};
use super::pack::{FluxEntries, Pack, flux_entries, packs};
use super::rows::rows;
use super::transports::{RELAXATION_RATE, Transports};
use crate::archive::Archive;
use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::COORDINATES;
use crate::scalar::{Lanes, Real};
use crate::solver::arrow::Arrow;
use crate::solver::{Factors, State, View};
use crate::stack::Transport;
use crate::variator::belt::equations::{Assembly, InForce, PulleyLoad, ResultantDerivatives, RingEnergy};
use crate::variator::belt::{Belt, THETA_PER_METRE};
use crate::variator::cell::sample::{AtStation, Sample};
use crate::variator::law::arguments::{CellBalance, StateComponent};
use crate::variator::rings::{CellRing, MOST, RingForces, RingKind};
use num_traits::Zero;

/// Derivatives are reused while 1/(hγ) has changed by less than this factor. Beyond it Newton's
/// method takes up to ten times as many Jacobians: a factor of 3 costs a third more time under
/// rough loads.
const RESCALED: f64 = 1.5;
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

/// Cells with a ring of kind `K` in D components.
///
/// Where the belt slips or a gap closes, a Jacobian is needed in nearly every stage, but the
/// geometry hardly changes. Then the constitutive tangents alone are updated.
#[derive(Clone, Debug)]
pub(crate) struct PackedCells<K, const D: usize> {
    packs: Vec<Pack>,
    derivatives: Vec<Derivatives>,
    origin: Origin,
    differentiations: u64,
    transports: Transports,
    flux_entries: Vec<FluxEntries>,
    work: UpdateWork,
    kind: K,
    /// Of a complete evaluation.
    complete: Scope,
}

impl<K: RingKind<D>, const D: usize> PackedCells<K, D> {
    /// Whether the geometry of the derivatives is still valid in a state with these factors.
    fn is_valid(&self, belt: &Belt, view: View<'_>, factors: Factors) -> bool {
        let Origin { factors: then, state } = &self.origin;
        self.complete == Scope::ByHand
            && (1.0 / RESCALED..RESCALED).contains(&(factors.alpha / then.alpha))
            && is_near(belt, &state.q, view.q)
    }

    /// Evaluates derivatives in a state, all or the tangents alone where the others are valid. Calls
    /// `add` with each pack and its current derivatives.
    fn differentiate(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        factors: Factors,
        mut add: impl FnMut(&Pack, &Derivatives, &mut UpdateWork),
    ) -> PerPulley<PulleyLoad<Lanes>> {
        let belt = acting.belt;
        let scope = if self.is_valid(belt, view, factors) {
            Scope::Tangents
        } else {
            self.differentiations += 1;
            let Origin { factors: of, state } = &mut self.origin;
            *of = factors;
            state.y.copy_from_slice(view.y);
            state.y_dot.copy_from_slice(view.y_dot);
            state.q.copy_from_slice(view.q);
            self.complete
        };
        let frames = Frames::new::<K, D>(&belt.curve, belt.path(view), factors, scope);
        let mut unknowns = [[Lanes::zero(); MOST]; 3];
        let mut loads = PerPulley::<PulleyLoad<Lanes>>::default();
        for (pack, derivatives) in self.packs.iter().zip(&mut self.derivatives) {
            pack.gather(&K::DEGREES, view, &mut unknowns);
            let b = differentiate(acting, &self.kind, pack, &frames, &unknowns, derivatives);
            add(pack, derivatives, &mut self.work);
            add_loads(&mut loads, pack, &b);
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        }
        loads
    }

    /// Adds the derivatives of the balance of the content. The fluxes do not depend on the pulleys.
    fn add_flux_derivatives(&mut self, belt: &Belt, alpha: f64, out: &mut Arrow) {
        if belt.law.is_pull_chain() {
            for i in belt.cells_at.iter().flat_map(|at| [at.speed, at.content]) {
                out.add(i, i, alpha + RELAXATION_RATE);
            }
            return;
        }
        for face in self.transports.faces() {
            let [before, cell] = face.cells;
            let row = belt.cells_at[cell].content;
            out.add(row, row, alpha);
            for ((side, of), entries) in [(1, cell), (0, before)].into_iter().zip(&self.flux_entries[cell]) {
                let place = &belt.mesh.cells[of];
                let Transport { flow, density } = &self.derivatives[place.group].transport;
                let quantities = flow.iter().zip(density).take(K::DEGREES.sheave);
                for (entries, (flow, density)) in entries.iter().zip(quantities) {
                    let [flow, density] = [flow, density].map(|by| by.lane(place.lane));
                    let derivative = face.by[side].flow * flow + face.by[side].density * density;
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

impl<K: RingKind<D>, const D: usize> Assembly for PackedCells<K, D> {
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
            pack.scatter::<D>(&K::DEGREES, &rows, out);
            for (sum, row) in sums.iter_mut().zip(&rows[shared.clone()]) {
                *sum += *row * pack.group.in_use();
            }
            add_loads(&mut loads, pack, b);
            self.transports.set_pack(pack.group.cells[0], &b.transport);
        };
        evaluate(acting, &self.kind, &self.packs, view, |_| (), add);
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
        matrix: &mut Arrow,
        resultants: &mut ResultantDerivatives,
    ) -> PerPulley<PulleyLoad> {
        let loads = self.differentiate(acting, view, factors, |pack, derivatives, work| {
            let block = derivatives.current::<K, D>(work);
            pack.add_derivatives(block, K::DEGREES.count, matrix);
            pack.add_shared(&K::DEGREES, block, acting.belt, matrix, resultants);
        });
        self.add_flux_derivatives(acting.belt, factors.alpha, matrix);
        loads.map(|of| of.map(Lanes::sum))
    }

    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]) -> RingEnergy {
        let mut places = out.iter_mut();
        let record =
            |at: &AtStation<'_, Lanes, D>| *places.next().expect("a sample for each station") = at.sample();
        evaluate(acting, &self.kind, &self.packs, view, record, |_, _, _| ());
        RingEnergy::default()
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
                self.differentiate(acting, state.view(), factors, |_, _, _| ());
            }
        }
    }

    fn differentiations(&self) -> u64 {
        self.differentiations
    }
}

/// Equations of a belt with a ring of this kind, whose derivatives are `by_hand` or those of forward
/// differentiation. A kind without [`RingKind::by_hand`] has the latter only.
#[must_use]
pub fn eulerian_equations<K: RingKind<D>, const D: usize>(
    kind: K,
    belt: &Belt,
    by_hand: bool,
) -> Box<dyn Assembly> {
    let cells = belt.mesh.cells.len();
    let packs = packs(belt, &K::DEGREES);
    let origin = Origin {
        factors: NO_FACTORS,
        state: State::zero(belt.layout.len()),
    };
    Box::new(PackedCells {
        derivatives: vec![Derivatives::new(&K::DEGREES, belt.mesh.points * D + 1); packs.len()],
        packs,
        origin,
        differentiations: 0,
        transports: Transports::new(cells),
        flux_entries: flux_entries(belt, &K::DEGREES),
        work: UpdateWork::new(&K::DEGREES),
        kind,
        complete: if by_hand { Scope::ByHand } else { Scope::Forward },
    })
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
fn evaluate<K: RingKind<D>, const D: usize>(
    acting: InForce<'_>,
    kind: &K,
    packs: &[Pack],
    view: View<'_>,
    mut observe: impl FnMut(&AtStation<'_, Lanes, D>),
    mut take: impl FnMut(&Pack, &CellBalance<Lanes>, &RingForces<Lanes, D>),
) {
    let path = acting.belt.path(view).map(|of| of.map(Lanes::from));
    let frame = frame::<_, K, D>(&acting.belt.curve, &path);
    let mut unknowns = [[Lanes::zero(); MOST]; 3];
    for pack in packs {
        pack.gather(&K::DEGREES, view, &mut unknowns);
        let unknown = |component: StateComponent, k: usize| unknowns[component as usize][k];
        let (b, ring) =
            pack_balance::<_, K, D, _>(acting, kind, pack, &frame, unknown, &mut observe, |ring, _, _, _| {
                ring.forces()
            });
        take(pack, &b, &ring);
    }
}

fn add_loads(loads: &mut PerPulley<PulleyLoad<Lanes>>, pack: &Pack, b: &CellBalance<Lanes>) {
    for pulley in Pulley::BOTH {
        loads[pulley].add(&b.pulley, pack.group.on[pulley]);
    }
}
