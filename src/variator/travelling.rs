//! A Lagrangian ring under the cells: `ANCF` and `RCM` in the variator.
//!
//! The stations of chain and contact stand in space. The ring passes under them: a station at ξ sees the particle
//! x̄ = ξ − s (1). The ring's own forces are balanced on its own elements
//! ([`LagrangianRing`]); what chain and contact do at a station goes to the nodes of the element that is there.
//!
//! s and Θ only say where the mesh of the stations lies, so they repeat motions of the ring, as in `ALE`, and as there
//! two conditions with multipliers hold them: the reference curve R follows the ring as least squares would have it,
//!
//! ∮ (ḋ + d/τ)·G dξ = 0, d = r − R, with G = R' for s and G = ∂R/∂Θ for Θ.
//!
//! With δr|_η = δr − r' δw, δw = δs − (∂ξ/∂Θ) δΘ, every virtual motion of the mesh has its row, so the power of chain
//! and contact arrives at the ring without remainder. The multipliers are small: they carry what the pitch line's
//! reference curvature (λ = |r'| − e κ_ref) leaves of a change of s alone.

use super::cell::{CellBalance, CellMotion, Place, SLOTS, balance};
use super::layout::{Global, Layout};
use super::parameters::{Parameters, RingModel};
use super::ring::{Action, CellRing, RingDensity};
use super::sample::{NoProbe, Probe, Sample, Sampler};
use super::system::{HOLD, VariatorSystem};
use crate::chain::{self, Transport};
use crate::reference_curve::{Jet, ReferenceCurve, ReferencePoint, TwoPulley, TwoPulleyFrame};
use crate::ring::ancf::Ancf;
use crate::ring::beam;
use crate::ring::kinematics::{Load, Motion, ReferenceMotion, RingPoint};
use crate::ring::lagrangian::{LagrangianElement, LagrangianRing};
use crate::ring::model::{Coordinates, DIRECTIONS, Energy, NODAL, RingModel as _};
use crate::ring::particle::{Particle, ParticleLoad};
use crate::ring::rcm::Rcm;
use crate::scalar::{Lanes, Real, Tangent};
use crate::solver::View;
use crate::solver::arrow::Arrow;
use std::ops::Mul;

/// Time τ in which the reference curve is drawn to the ring where it is off, s: some passes of an element.
const FOLLOWING_TIME: f64 = 0.02;

/// Directions of a cell: unknowns of the elements under its slots, V, V, N, then s, Θ, z, ψ_x, ψ_y, ω and two
/// multipliers.
const MOST: usize = NODAL * SLOTS + OTHERS;
const OTHERS: usize = 11;
/// Place of the amount among the others; its row is the flux.
const AMOUNT: usize = 2;
/// Places of s, Θ and the first multiplier among the others.
const DRIFT: usize = 3;
const THETA: usize = 4;
const GAUGE: usize = 9;

/// Directions differentiated in one pass over a cell.
const PASS: usize = 4;
type Slopes = Tangent<PASS, f64>;

/// The ring models that travel with their mesh.
#[derive(Clone, Debug)]
pub enum TravellingRing {
    /// Absolute nodal coordinates.
    Ancf(Ancf<TwoPulley>),
    /// Co-rotational elements.
    Rcm(Rcm<TwoPulley>),
}

/// Does something with the ring, whichever it is.
macro_rules! with_ring {
    ($travelling:expr, $ring:ident => $do:expr) => {
        match $travelling {
            $crate::variator::travelling::TravellingRing::Ancf($ring) => $do,
            $crate::variator::travelling::TravellingRing::Rcm($ring) => $do,
        }
    };
}
pub(super) use with_ring;

impl TravellingRing {
    /// The ring that the parameters ask for, if it travels.
    #[must_use]
    pub fn new(parameters: &Parameters, curve: &TwoPulley) -> Option<Self> {
        let elements = parameters.travelling_elements()?;
        let (ring, curve) = (parameters.ring.clone(), curve.clone());
        match parameters.ring_model {
            RingModel::Ancf => Some(Self::Ancf(Ancf::new(ring, curve, elements, 3))),
            RingModel::Rcm => Some(Self::Rcm(Rcm::new(ring, curve, elements, 5))),
            RingModel::Ale0 | RingModel::Ale => None,
        }
    }

    /// Number of elements, and of unknowns of each.
    #[must_use]
    pub fn size(&self) -> (usize, usize) {
        fn size<E: LagrangianElement>(ring: &LagrangianRing<E, TwoPulley>) -> (usize, usize) {
            (ring.elements(), E::BLOCK)
        }
        with_ring!(self, ring => size(ring))
    }

    /// Whether unknown `k` of a node is a length; otherwise it is an angle or a slope.
    #[must_use]
    pub fn is_length(&self, k: usize) -> bool {
        with_ring!(self, ring => ring.is_length(k))
    }
}

/// Elements under the slots of a cell.
#[derive(Clone, Copy, Debug)]
struct Under {
    /// Each element once.
    elements: [usize; SLOTS],
    count: usize,
    /// Which of them is under a slot.
    of_slot: [usize; SLOTS],
    /// Its number counted on over turns.
    turn: [f64; SLOTS],
}

impl Under {
    fn new(layout: &Layout, places: &[f64]) -> Self {
        let mut under = Self {
            elements: [0; SLOTS],
            count: 0,
            of_slot: [0; SLOTS],
            turn: [0.0; SLOTS],
        };
        let Some(travelling) = &layout.travelling else {
            return under;
        };
        for (slot, &place) in places.iter().enumerate() {
            let (element, count) = travelling.element(place);
            under.turn[slot] = count;
            let known = under.elements[..under.count].iter().position(|&e| e == element);
            under.of_slot[slot] = known.unwrap_or_else(|| {
                under.elements[under.count] = element;
                under.count += 1;
                under.count - 1
            });
        }
        under
    }

    /// Directions of the elements.
    fn nodal(&self) -> usize {
        NODAL * self.count
    }

    /// Unknowns of the directions of a cell.
    fn directions(&self, layout: &Layout, cell: usize, pulley: usize, out: &mut [usize; MOST]) -> usize {
        for (m, &element) in self.elements[..self.count].iter().enumerate() {
            for k in 0..NODAL {
                out[NODAL * m + k] = layout.nodal(element, k);
            }
        }
        let global = |global, offset| layout.global(global, offset);
        let others: [usize; OTHERS] = [
            layout.speed(cell),
            layout.speed(cell + 1),
            layout.amount(cell),
            global(Global::Drift, 0),
            global(Global::Theta, 0),
            global(Global::Sheave, pulley),
            global(Global::Tilt, 2 * pulley),
            global(Global::Tilt, 2 * pulley + 1),
            global(Global::Speed, pulley),
            global(Global::Gauge, 0),
            global(Global::Gauge, 1),
        ];
        out[self.nodal()..self.nodal() + OTHERS].copy_from_slice(&others);
        self.nodal() + OTHERS
    }
}

/// The ring at a slot.
struct Seen<T: Real, W: Real, E: LagrangianElement> {
    motion: E::Motion<T>,
    shape: E::Shape<W>,
    particle: Particle<T>,
    tension: T,
}

/// Generalised forces of a cell on the ring and on the mesh (inertia − forces).
struct PassingForces<T> {
    /// Conjugates of the unknowns of the element under each slot.
    nodal: [[T; NODAL]; SLOTS],
    drift: T,
    theta: T,
    /// The two conditions.
    gauge: [T; 2],
}

/// The ring that passes under a cell. `W` is the scalar of places on the ring: a plain number where nothing moves the
/// mesh.
struct Passing<'a, T: Real, W: Real, E: LagrangianElement> {
    slots: [Option<Seen<T, W, E>>; SLOTS],
    motion: &'a ReferenceMotion<T>,
    multipliers: [T; 2],
    forces: PassingForces<T>,
}

impl<T: Real + Mul<W, Output = T>, W: Real, E: LagrangianElement> CellRing<T> for Passing<'_, T, W, E> {
    #[inline(always)]
    fn point(&self, slot: usize, reference: ReferencePoint<T>) -> RingPoint<T> {
        let seen = self.slots[slot].as_ref().expect("a slot of the cell");
        seen.particle.at_station(reference, self.motion)
    }

    #[inline(always)]
    fn own_load(&self, slot: usize, _point: &RingPoint<T>, _load: &mut Load<T>) -> T {
        self.slots[slot].as_ref().expect("a slot of the cell").tension
    }

    #[inline(always)]
    fn take(&mut self, slot: usize, point: &RingPoint<T>, action: &Action<T>) {
        let Some(seen) = &self.slots[slot] else { return };
        let reference = &point.reference;
        let weight = action.weight;
        // What the mesh point would have to do to follow s and Θ.
        let along = reference.t;
        let across = reference.r_theta - reference.t * reference.xi.d;
        let off = (point.r - reference.r) * T::from(FOLLOWING_TIME.recip()) + point.r_dot
            - reference.r_theta * self.motion.theta.rate;
        let pull = (along * self.multipliers[0] + across * self.multipliers[1]) * T::from(HOLD);
        let load = &action.load;
        let position = load.position + pull;
        let drift = load.drift - position.dot(&point.slope) - load.slope.dot(&point.bend);
        let forces = &mut self.forces;
        forces.drift += drift * weight;
        forces.theta += (load.theta - pull.dot(&reference.r_theta) - drift * reference.xi.d) * weight;
        forces.gauge[0] += off.dot(&along) * weight * HOLD;
        forces.gauge[1] += off.dot(&across) * weight * HOLD;
        let on_ring = ParticleLoad {
            position: position * weight,
            slope: load.slope * weight,
            bend: load.bend * weight,
        };
        let mut force = E::no_force();
        E::add(&seen.motion, &seen.shape, &on_ring, 1.0, &mut force);
        forces.nodal[slot] = E::conjugates(&seen.motion, &force);
    }

    fn density(&self, _point: &RingPoint<T>) -> RingDensity<T> {
        RingDensity {
            kinetic: T::zero(),
            elastic: T::zero(),
            viscous: T::zero(),
        }
    }
}

/// Tension of an element that carries its mean strain, N, and its slopes in the element's unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct MeanTension {
    value: f64,
    slopes: [f64; NODAL],
}

/// What a cell tells.
struct CellRows<T: Real> {
    balance: CellBalance<T>,
    ring: PassingForces<T>,
}

impl<T: Real> CellRows<T> {
    /// Rows of V, V and of the globals, in the order of the directions after the elements'.
    fn others(&self) -> [T; OTHERS] {
        let (b, ring) = (&self.balance, &self.ring);
        [
            b.speed[0],
            b.speed[1],
            T::zero(),
            ring.drift,
            ring.theta,
            b.axial,
            -b.tilting[0],
            -b.tilting[1],
            -b.torque,
            ring.gauge[0],
            ring.gauge[1],
        ]
    }
}

impl VariatorSystem {
    /// Evaluates a cell; `seed` makes a scalar of a value, its direction and its slope, `place_of` one of a place on
    /// the ring.
    #[inline(always)]
    #[expect(
        clippy::too_many_arguments,
        reason = "the state, where to look, and three ways to look"
    )]
    fn passing<T, W, E, S>(
        &self,
        ring: &LagrangianRing<E, TwoPulley>,
        view: View<'_>,
        cell: usize,
        (under, at): (&Under, &[usize; MOST]),
        frame: &TwoPulleyFrame<T>,
        [alpha, beta]: [f64; 2],
        seed: impl Fn(f64, usize, f64) -> T,
        place_of: impl Fn(T) -> W,
        probe: &mut S,
    ) -> CellRows<T>
    where
        T: Real<Constant = f64> + Mul<W, Output = T>,
        W: Real,
        E: LagrangianElement,
        S: Probe<T>,
    {
        let value = |k: usize| seed(view.y[at[k]], k, 1.0);
        let rate = |k: usize| seed(view.y_dot[at[k]], k, alpha);
        let position = |k: usize| seed(view.q[at[k]], k, beta);
        let own = under.nodal();
        let motion = CellMotion::of_directions([own, own + DRIFT], position, value, rate);
        let of_mesh = &self.mesh.cells[cell];
        let element = &self.mesh.elements[of_mesh.element];
        let place = Place {
            // The mesh's own stations tell fractions of the segment.
            of_segment: [0.0, 1.0],
            face: &of_mesh.face,
            stations: &of_mesh.stations,
            axis: self.law.axes[of_mesh.pulley],
            plane: self.law.planes[of_mesh.pulley].constants(),
            length: Jet::constant(0.0).plus_scaled(TwoPulley::segment_length(frame, element.segment), element.share),
        };
        let references: [Option<ReferencePoint<T>>; SLOTS] = std::array::from_fn(|slot| {
            (slot <= of_mesh.stations.len()).then(|| TwoPulley::point(frame, element.segment, place.fraction(slot)))
        });
        let drift = position(own + DRIFT);
        let per_element = ring.element_length().recip();
        let slots = std::array::from_fn(|slot| {
            let reference = references[slot].as_ref()?;
            let first = NODAL * under.of_slot[slot];
            let unknowns: [Motion<T>; NODAL] = std::array::from_fn(|k| Motion {
                value: position(first + k),
                rate: value(first + k),
                acceleration: rate(first + k),
            });
            let x = ((reference.xi.v - drift) * per_element - under.turn[slot]) * 2.0 - 1.0;
            let motion = ring.motion(&unknowns);
            let shape = E::shape(place_of(x));
            let particle = E::particle(&motion, &shape);
            let tension = if E::MEAN_STRAIN && S::ACTIVE {
                let values = self.values(view, under.elements[under.of_slot[slot]]);
                T::from(ring.mean_tension(&values))
            } else if E::MEAN_STRAIN {
                let mean = &self.mean_tensions[under.elements[under.of_slot[slot]]];
                let slopes = mean.slopes.iter().enumerate();
                slopes.fold(T::from(mean.value), |sum, (k, &slope)| {
                    sum + seed(0.0, first + k, slope)
                })
            } else {
                beam::tension(ring.ring(), particle.strain(), particle.strain_rate())
            };
            Some(Seen {
                motion,
                shape,
                particle,
                tension,
            })
        });
        let mut passing = Passing::<T, W, E> {
            slots,
            motion: &motion.reference,
            multipliers: [value(own + GAUGE), value(own + GAUGE + 1)],
            forces: PassingForces {
                nodal: [[T::zero(); NODAL]; SLOTS],
                drift: T::zero(),
                theta: T::zero(),
                gauge: [T::zero(); 2],
            },
        };
        let reference = |slot: usize| references[slot].expect("a slot of the cell");
        let balance = balance(&self.law, &place, &motion, &mut passing, reference, probe);
        CellRows {
            balance,
            ring: passing.forces,
        }
    }

    /// Elements under the slots of a cell.
    fn under(&self, frame: &TwoPulleyFrame<f64>, cell: usize, s: f64) -> Under {
        let cell = &self.mesh.cells[cell];
        let segment = self.mesh.elements[cell.element].segment;
        let mut places = [0.0; SLOTS];
        let slots = std::iter::once(&cell.face).chain(&cell.stations);
        for (place, station) in places.iter_mut().zip(slots) {
            *place = TwoPulley::point::<f64>(frame, segment, station.fraction).xi.v - s;
        }
        Under::new(&self.layout, &places[..1 + cell.stations.len()])
    }

    /// Motion of the unknowns of an element; `seed` makes a scalar of a value, its direction and its slope.
    fn coordinates<T: Real>(
        &self,
        view: View<'_>,
        element: usize,
        [alpha, beta]: [f64; 2],
        seed: impl Fn(f64, usize, f64) -> T,
    ) -> Coordinates<T> {
        std::array::from_fn(|k| {
            if k >= NODAL {
                return Motion {
                    value: T::zero(),
                    rate: T::zero(),
                    acceleration: T::zero(),
                };
            }
            let at = self.layout.nodal(element, k);
            Motion {
                value: seed(view.q[at], k, beta),
                rate: seed(view.y[at], k, 1.0),
                acceleration: seed(view.y_dot[at], k, alpha),
            }
        })
    }

    fn values(&self, view: View<'_>, element: usize) -> Coordinates<f64> {
        self.coordinates(view, element, [0.0; 2], |value, _, _| value)
    }

    fn find_mean_tensions<E: LagrangianElement>(&mut self, ring: &LagrangianRing<E, TwoPulley>, view: View<'_>) {
        if E::MEAN_STRAIN {
            for element in 0..ring.elements() {
                self.mean_tensions[element].value = ring.mean_tension(&self.values(view, element));
            }
        }
    }

    /// Residual of ring, chain and contact, and the sums over pulleys.
    pub(super) fn travelling_residual<E: LagrangianElement>(
        &mut self,
        ring: &LagrangianRing<E, TwoPulley>,
        view: View<'_>,
        out: &mut [f64],
    ) {
        for element in 0..ring.elements() {
            let rows = ring.balance(&(), element, &self.values(view, element));
            for (k, row) in rows[..NODAL].iter().enumerate() {
                out[self.layout.nodal(element, k)] += row;
            }
        }
        self.find_mean_tensions(ring, view);
        let frame = self.curve.frame(self.theta(view));
        let s = view.q[self.layout.global(Global::Drift, 0)];
        let mut at = [0; MOST];
        for cell in 0..self.mesh.cells.len() {
            let pulley = self.mesh.cells[cell].pulley;
            let under = self.under(&frame, cell, s);
            under.directions(&self.layout, cell, pulley, &mut at);
            let seed = |value: f64, _: usize, _: f64| value;
            let rows = self.passing(
                ring,
                view,
                cell,
                (&under, &at),
                &frame,
                [0.0; 2],
                seed,
                |x| x,
                &mut NoProbe,
            );
            for (slot, nodal) in rows.ring.nodal.iter().enumerate().skip(1) {
                for (k, row) in nodal.iter().enumerate() {
                    out[at[NODAL * under.of_slot[slot] + k]] += row;
                }
            }
            let own = &at[under.nodal()..];
            let b = &rows.balance;
            out[own[0]] += b.speed[0];
            out[own[1]] += b.speed[1];
            out[own[DRIFT]] += rows.ring.drift;
            out[own[THETA]] += rows.ring.theta;
            out[own[GAUGE]] += rows.ring.gauge[0];
            out[own[GAUGE + 1]] += rows.ring.gauge[1];
            self.sums[pulley].add(b, 1.0);
            self.transports.set(cell, &b.transport);
        }
        self.add_fluxes(view, out);
        for i in self.layout.free() {
            out[i] = view.y[i];
        }
    }

    /// Jacobian of ring, chain and contact.
    pub(super) fn travelling_jacobian<E: LagrangianElement>(
        &mut self,
        ring: &LagrangianRing<E, TwoPulley>,
        view: View<'_>,
        alpha: f64,
        beta: f64,
        out: &mut Arrow,
    ) {
        let slopes = [alpha, beta];
        let s = view.q[self.layout.global(Global::Drift, 0)];
        let theta = self.theta(view);
        let shape = self.curve.shape(theta);
        let frame = shape.frame(0.0);
        let still = shape.frame(Slopes::from(0.0));
        let moving: [_; PASS] = std::array::from_fn(|k| shape.frame(Slopes::seed(0.0, k, beta)));
        self.order.find(&self.layout, &self.mesh, &frame, s);
        out.reorder(&self.order.order);
        for element in 0..ring.elements() {
            let seed = Tangent::<NODAL, f64>::seed;
            let motion = self.coordinates(view, element, slopes, seed);
            let rows: [_; DIRECTIONS] = ring.balance(&(), element, &motion);
            let at: [usize; NODAL] = std::array::from_fn(|k| self.layout.nodal(element, k));
            for (&i, row) in at.iter().zip(&rows) {
                for (&j, slope) in at.iter().zip(row.eps) {
                    out.add(i, j, slope);
                }
            }
            if E::MEAN_STRAIN {
                let tension = ring.mean_tension(&motion);
                let mean = &mut self.mean_tensions[element];
                (mean.value, mean.slopes) = (tension.re, tension.eps);
            }
        }
        let mut memory = std::mem::take(&mut self.passing_slopes);
        memory.resize(self.mesh.cells.len(), CellSlopes::default());
        for (cell, of_cell) in memory.iter_mut().enumerate() {
            let pulley = self.mesh.cells[cell].pulley;
            let under = self.under(&frame, cell, s);
            of_cell.count = under.directions(&self.layout, cell, pulley, &mut of_cell.at);
            let CellSlopes { at, count, transport } = of_cell;
            let (own, count) = (under.nodal(), *count);
            for first in (0..count).step_by(PASS) {
                let seed = |value: f64, direction: usize, slope: f64| {
                    Slopes::seed(value, direction.wrapping_sub(first), slope)
                };
                let (theta, cells) = ((own + THETA).wrapping_sub(first), (&under, &*at));
                let still_here = first + PASS <= own + DRIFT || first > own + THETA;
                let rows = if still_here {
                    self.passing(ring, view, cell, cells, &still, slopes, seed, |x| x.re, &mut NoProbe)
                } else {
                    let frame = moving.get(theta).unwrap_or(&still);
                    self.passing(ring, view, cell, cells, frame, slopes, seed, |x| x, &mut NoProbe)
                };
                let columns = &at[first..(first + PASS).min(count)];
                let mut add = |row: usize, value: &Slopes| {
                    for (&column, &slope) in columns.iter().zip(&value.eps) {
                        if let Some(index) = out.index(row, column) {
                            out.add_at(index, slope);
                        }
                    }
                };
                for (slot, nodal) in rows.ring.nodal.iter().enumerate().skip(1) {
                    for (k, row) in nodal.iter().enumerate() {
                        add(at[NODAL * under.of_slot[slot] + k], row);
                    }
                }
                for (k, row) in rows.others().iter().enumerate().filter(|(k, _)| *k != AMOUNT) {
                    add(at[own + k], row);
                }
                self.transports.set(cell, &rows.balance.transport.map(|of| of.re));
                for (slopes, of) in transport.each_mut().into_iter().zip(rows.balance.transport.each()) {
                    slopes[first..][..columns.len()].copy_from_slice(&of.eps[..columns.len()]);
                }
            }
        }
        let cells = self.mesh.cells.len();
        for cell in 0..cells {
            let before = (cell + cells - 1) % cells;
            let rows = [before, cell].map(|cell| self.cells_at[cell][1]);
            out.add(rows[1], rows[1], alpha);
            let (own, other) = (&memory[cell], &memory[before]);
            let slopes = chain::flux_slopes(&self.transports.get(before), &self.transports.get(cell));
            for (of, by) in [other, own].into_iter().zip(slopes) {
                for k in 0..of.count {
                    let slope = by.along(&of.transport, k);
                    for (row, value) in rows.into_iter().zip([slope, -slope]) {
                        if let Some(index) = out.index(row, of.at[k]) {
                            out.add_at(index, value);
                        }
                    }
                }
            }
        }
        self.passing_slopes = memory;
        for i in self.layout.free() {
            out.add(i, i, 1.0);
        }
    }

    /// Evaluates every station.
    pub(super) fn sample_travelling<E: LagrangianElement>(
        &self,
        ring: &LagrangianRing<E, TwoPulley>,
        view: View<'_>,
        out: &mut [Sample<Lanes>],
    ) {
        let frame = self.curve.frame(self.theta(view));
        let s = view.q[self.layout.global(Global::Drift, 0)];
        let mut at = [0; MOST];
        for (cell, place) in self.mesh.cells.iter().enumerate() {
            let under = self.under(&frame, cell, s);
            under.directions(&self.layout, cell, place.pulley, &mut at);
            let mut stations = out[place.group * self.mesh.points..].iter_mut();
            let mut take = |sample| {
                let group = stations.next().expect("a place for each station");
                group.set(place.lane, &sample);
            };
            let mut sampler = Sampler(&mut take);
            let seed = |value: f64, _: usize, _: f64| value;
            self.passing(
                ring,
                view,
                cell,
                (&under, &at),
                &frame,
                [0.0; 2],
                seed,
                |x| x,
                &mut sampler,
            );
        }
    }

    /// Energies of a ring that counts them on elements of its own, and the power that its damping takes, W.
    #[must_use]
    pub fn travelling_energy(&self, view: View<'_>) -> (Energy, f64) {
        let Some(travelling) = &self.travelling else {
            return (Energy::default(), 0.0);
        };
        with_ring!(&**travelling, ring => {
            let mut sum = (Energy::default(), 0.0);
            for element in 0..ring.elements() {
                let values = self.values(view, element);
                sum.0 += ring.energy(&(), element, &values);
                sum.1 += ring.dissipation(&(), element, &values);
            }
            sum
        })
    }
}

/// Slopes of what the balance of the amounts needs of a cell, in the directions `at`.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellSlopes {
    at: [usize; MOST],
    count: usize,
    transport: Transport<[f64; MOST]>,
}

impl Default for CellSlopes {
    fn default() -> Self {
        Self {
            at: [0; MOST],
            count: 0,
            transport: Transport::default().map(|()| [0.0; MOST]),
        }
    }
}
