//! A Lagrangian ring that passes under the cells: `ANCF` and `RCM` in the variator.
//!
//! The stations of stack and contact are fixed in space and the ring passes under them: the
//! particle at a station ξ is x̄ = ξ − s (1). The ring's own forces are assembled on its own
//! elements ([`LagrangianRing`](crate::ring::lagrangian::LagrangianRing)). The loads of stack and
//! contact at a station act on the nodes of the element under it.
//!
//! s and Θ only move the mesh of the stations. As in `ALE` they duplicate motions of the ring, and
//! two conditions with multipliers constrain them: the reference curve R follows the ring in the
//! least-squares sense,
//!
//! ∮ (ḋ + d/τ)·G dξ = 0, d = r − R, with G = R' for s and G = ∂R/∂Θ for Θ.
//!
//! With δr|_η = δr − r' δw, δw = δs − (∂ξ/∂Θ) δΘ, every virtual motion of the mesh has a row, so
//! the power between ring, stack and contact is balanced. The multipliers are small: they balance
//! the force on s alone that results from the reference curvature in the pitch line (λ = |r'| − e
//! κ_ref).

use crate::reference_curve::{ReferencePoint, TwoPulleyFrame};
use crate::ring::kinematics::{LineLoad, ReferenceMotion, RingPoint};
use crate::ring::lagrangian::LagrangianElement;
use crate::ring::model::NODAL;
use crate::ring::particle::{Particle, ParticleLoad};
use crate::scalar::Real;
use crate::travelling::order::{Passed, Travelling, nodal};
use pushbelt::variator::ring_models::{
    Belt, CELL_POINTS, CONSTRAINT_SCALE, CellBalance, CellRing, Layout, RingDensity, StationLoad,
};
use std::ops::Mul;

/// Time constant τ with which the reference curve follows the ring, s: some passes of an element.
const FOLLOWING_TIME: f64 = 0.02;

/// Directions of a cell: unknowns of the elements under its points, V, V, N, then s, Θ, z, ψ_x,
/// ψ_y, ω and two multipliers.
pub(super) const MOST: usize = NODAL * CELL_POINTS + OTHERS;
pub(super) const OTHERS: usize = 11;
/// Index of the content among the others. Its row is the balance of the fluxes.
pub(super) const CONTENT: usize = 2;
/// Indices of s, Θ and the first multiplier among the others.
pub(super) const DRIFT: usize = 3;
pub(super) const THETA: usize = 4;
pub(super) const GAUGE: usize = 9;

/// A cell and the elements of the ring under its points.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellOver {
    /// The cell.
    pub cell: usize,
    /// Each element once.
    elements: [usize; CELL_POINTS],
    count: usize,
    /// Index in `elements` of the element under each point.
    of_point: [usize; CELL_POINTS],
    /// Its number without wrapping.
    pub turn: [f64; CELL_POINTS],
    /// Unknowns of the directions.
    at: [usize; MOST],
}

impl CellOver {
    /// The cell over a ring that has drifted by `s`, m.
    pub fn new(belt: &Belt, frame: &TwoPulleyFrame<f64>, cell: usize, s: f64) -> Self {
        let of_mesh = &belt.mesh.cells[cell];
        let segment = belt.mesh.elements[of_mesh.element].segment;
        let mut over = Self {
            cell,
            elements: [0; CELL_POINTS],
            count: 0,
            of_point: [0; CELL_POINTS],
            turn: [0.0; CELL_POINTS],
            at: [0; MOST],
        };
        let travelling = Travelling::of(&belt.layout, &belt.curve);
        for (number, station) in std::iter::once(&of_mesh.face).chain(&of_mesh.stations).enumerate() {
            let place = frame.point(segment, station.fraction).xi.v - s;
            let Passed { element, count } = travelling.element(place);
            over.turn[number] = count;
            let known = over.elements[..over.count].iter().position(|&e| e == element);
            over.of_point[number] = known.unwrap_or_else(|| {
                over.elements[over.count] = element;
                over.count += 1;
                over.count - 1
            });
        }
        over.find_unknowns(belt);
        over
    }

    fn find_unknowns(&mut self, belt: &Belt) {
        let (layout, cell): (&Layout, usize) = (&belt.layout, self.cell);
        for (m, &element) in self.elements[..self.count].iter().enumerate() {
            for k in 0..NODAL {
                self.at[NODAL * m + k] = nodal(layout, element, k);
            }
        }
        let pulley = belt.mesh.cells[cell].pulley;
        let others: [usize; OTHERS] = [
            layout.belt_speed(cell),
            layout.belt_speed(cell + 1),
            layout.content(cell),
            layout.drift(),
            layout.theta(),
            layout.sheave(pulley),
            layout.tilt(pulley, 0),
            layout.tilt(pulley, 1),
            layout.shaft_speed(pulley),
            layout.gauge(0),
            layout.gauge(1),
        ];
        let own = self.nodal();
        self.at[own..own + OTHERS].copy_from_slice(&others);
    }

    /// Number of directions that belong to the elements.
    pub fn nodal(&self) -> usize {
        NODAL * self.count
    }

    /// Unknowns of all directions: those of the elements, then the others.
    pub fn unknowns(&self) -> &[usize] {
        &self.at[..self.nodal() + OTHERS]
    }

    /// The element under a point.
    pub fn element(&self, number: usize) -> usize {
        self.elements[self.of_point[number]]
    }

    /// First direction of the element under a point.
    pub fn first(&self, number: usize) -> usize {
        NODAL * self.of_point[number]
    }
}

/// The ring at a point.
pub(super) struct RingAtPoint<T: Real, W: Real, E: LagrangianElement> {
    pub reference: ReferencePoint<T>,
    pub motion: E::Motion<T>,
    pub shape: E::ShapeFunctions<W>,
    pub particle: Particle<T>,
    pub tension: T,
}

/// Generalised forces of a cell on the ring and on the mesh (inertia − forces).
#[derive(Clone, Copy)]
pub(super) struct PassingForces<T> {
    /// Conjugates of the unknowns of the element under each point.
    pub nodal: [[T; NODAL]; CELL_POINTS],
    pub drift: T,
    pub theta: T,
    /// Residuals of the two conditions.
    pub gauge: [T; 2],
}

/// The ring that passes under a cell. `W` is the scalar of places on the ring: a plain number where
/// the mesh is fixed.
pub(super) struct Passing<'a, T: Real, W: Real, E: LagrangianElement> {
    points: [Option<RingAtPoint<T, W, E>>; CELL_POINTS],
    motion: &'a ReferenceMotion<T>,
    multipliers: [T; 2],
    forces: PassingForces<T>,
}

impl<'a, T: Real, W: Real, E: LagrangianElement> Passing<'a, T, W, E> {
    /// The ring at the points of a cell, with these `multipliers`.
    #[inline(always)]
    pub fn new(
        points: [Option<RingAtPoint<T, W, E>>; CELL_POINTS],
        motion: &'a ReferenceMotion<T>,
        multipliers: [T; 2],
    ) -> Self {
        Self {
            points,
            motion,
            multipliers,
            forces: PassingForces {
                nodal: [[T::zero(); NODAL]; CELL_POINTS],
                drift: T::zero(),
                theta: T::zero(),
                gauge: [T::zero(); 2],
            },
        }
    }
}

impl<T: Real + Mul<W, Output = T>, W: Real, E: LagrangianElement> CellRing<T> for Passing<'_, T, W, E> {
    type Forces = PassingForces<T>;

    #[inline(always)]
    fn point(&self, number: usize) -> RingPoint<T> {
        let at = self.points[number].as_ref().expect("a point of the cell");
        at.particle.at_station(at.reference, self.motion)
    }

    #[inline(always)]
    fn own_load(&self, number: usize, _point: &RingPoint<T>, _load: &mut LineLoad<T>) -> T {
        self.points[number].as_ref().expect("a point of the cell").tension
    }

    #[inline(always)]
    fn apply(&mut self, number: usize, point: &RingPoint<T>, station_load: &StationLoad<T>) {
        let Some(at) = &self.points[number] else { return };
        let reference = &point.reference;
        let weight = station_load.weight;
        // Virtual motion of the mesh point with s and Θ.
        let along = reference.t;
        let across = reference.r_theta - reference.t * reference.xi.d;
        let off = (point.r - reference.r) * T::from(FOLLOWING_TIME.recip()) + point.r_dot
            - reference.r_theta * self.motion.theta.rate;
        let pull = (along * self.multipliers[0] + across * self.multipliers[1]) * T::from(CONSTRAINT_SCALE);
        let load = &station_load.load;
        let position = load.position + pull;
        let drift = load.drift - position.dot(&point.slope) - load.slope.dot(&point.bend);
        let forces = &mut self.forces;
        forces.drift += drift * weight;
        forces.theta += (load.theta - pull.dot(&reference.r_theta) - drift * reference.xi.d) * weight;
        forces.gauge[0] += off.dot(&along) * weight * CONSTRAINT_SCALE;
        forces.gauge[1] += off.dot(&across) * weight * CONSTRAINT_SCALE;
        let on_ring = ParticleLoad {
            position: position * weight,
            slope: load.slope * weight,
            bend: load.bend * weight,
        };
        let mut force = E::no_force();
        E::add(&at.motion, &at.shape, &on_ring, 1.0, &mut force);
        forces.nodal[number] = E::conjugates(&at.motion, &force);
    }

    fn density(&self, _point: &RingPoint<T>) -> RingDensity<T> {
        RingDensity {
            kinetic: T::zero(),
            membrane: T::zero(),
            bending: T::zero(),
            viscous: T::zero(),
        }
    }

    fn forces(&self) -> PassingForces<T> {
        self.forces
    }
}

/// Rows of a cell.
pub(super) struct CellRows<T: Real> {
    pub balance: CellBalance<T>,
    pub ring: PassingForces<T>,
}

impl<T: Real> CellRows<T> {
    /// Rows of V, V and of the globals, in the order of the directions.
    pub fn others(&self) -> [T; OTHERS] {
        let (b, ring) = (&self.balance, &self.ring);
        [
            b.speed[0],
            b.speed[1],
            T::zero(),
            ring.drift,
            ring.theta,
            b.pulley.axial,
            -b.pulley.tilting[0],
            -b.pulley.tilting[1],
            -b.pulley.torque,
            ring.gauge[0],
            ring.gauge[1],
        ]
    }
}
