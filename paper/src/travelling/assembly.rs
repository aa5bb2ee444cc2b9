//! Equations of the belt with a travelling ring.

use crate::reference_curve::{TwoPulley, TwoPulleyFrame};
use crate::ring::lagrangian::{LagrangianElement, LagrangianRing};
use crate::ring::model::{DIRECTIONS, Energy, NODAL, RingFormulation as _};
use crate::scalar::{Lanes, Tangent};
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::travelling::evaluation::{
    Differentiated, Evaluation, MeanTension, Moving, PASS, Still, Values, coordinates, values,
};
use crate::travelling::order::{Order, nodal};
use crate::travelling::passing::{CONTENT, CellOver, DRIFT, GAUGE, MOST, THETA};
use pushbelt::pulley::PerPulley;
use pushbelt::solver::Factors;
use pushbelt::variator::ring_models::{
    Assembly, Belt, InForce, Layout, PulleyLoad, ResultantDerivatives, RingEnergy, Sample, Transport,
    Transports,
};

/// Derivatives of the transport quantities of a cell in the directions `at`.
#[derive(Clone, Copy, Debug)]
struct CellDerivatives {
    at: [usize; MOST],
    count: usize,
    transport: Transport<[f64; MOST]>,
}

impl Default for CellDerivatives {
    fn default() -> Self {
        Self {
            at: [0; MOST],
            count: 0,
            transport: Transport::default().map(|()| [0.0; MOST]),
        }
    }
}

/// Cells over a travelling ring of elements `E`.
#[derive(Clone, Debug)]
pub(crate) struct TravellingCells<E: LagrangianElement> {
    ring: LagrangianRing<E, TwoPulley>,
    mean_tensions: Vec<MeanTension>,
    derivatives: Vec<CellDerivatives>,
    transports: Transports,
    order: Order,
}

impl<E: LagrangianElement> TravellingCells<E> {
    /// Cells of a belt over this ring.
    pub fn new(belt: &Belt, ring: LagrangianRing<E, TwoPulley>) -> Self {
        let cells = belt.mesh.cells.len();
        Self {
            mean_tensions: vec![MeanTension::default(); ring.elements()],
            derivatives: vec![CellDerivatives::default(); cells],
            transports: Transports::new(cells),
            order: Order::default(),
            ring,
        }
    }

    /// Adds the balance of the ring's own elements.
    fn add_ring(&self, layout: &Layout, view: View<'_>, out: &mut [f64]) {
        for element in 0..self.ring.elements() {
            let rows = self.ring.balance(&(), element, &values(layout, view, element));
            for (k, row) in rows[..NODAL].iter().enumerate() {
                out[nodal(layout, element, k)] += row;
            }
        }
    }

    /// Adds the derivatives of the ring's own elements, and computes those of their mean tensions.
    fn add_ring_derivatives(&mut self, layout: &Layout, view: View<'_>, factors: Factors, out: &mut Arrow) {
        for element in 0..self.ring.elements() {
            let seed = Tangent::<NODAL, f64>::seed;
            let motion = coordinates(layout, view, element, factors, seed);
            let rows: [_; DIRECTIONS] = self.ring.balance(&(), element, &motion);
            let at: [usize; NODAL] = std::array::from_fn(|k| nodal(layout, element, k));
            for (&i, row) in at.iter().zip(&rows) {
                for (&j, derivative) in at.iter().zip(row.eps) {
                    out.add(i, j, derivative);
                }
            }
            if E::MEAN_STRAIN {
                let tension = self.ring.mean_tension(&motion);
                let mean = &mut self.mean_tensions[element];
                (mean.value, mean.derivatives) = (tension.re, tension.eps);
            }
        }
    }

    /// Adds the derivatives of the balance of the contents: fluxes through the left faces.
    fn add_flux_derivatives(&mut self, belt: &Belt, alpha: f64, out: &mut Arrow) {
        for face in self.transports.faces() {
            let contents = face.cells.map(|cell| belt.cells_at[cell].content);
            out.add(contents[1], contents[1], alpha);
            for (side, cell) in face.cells.into_iter().enumerate() {
                let (of, by) = (&self.derivatives[cell], face.by[side]);
                for (k, &column) in of.at[..of.count].iter().enumerate() {
                    let derivative = by.flow * of.transport.flow[k] + by.density * of.transport.density[k];
                    for (row, derivative) in contents.into_iter().zip([derivative, -derivative]) {
                        if let Some(index) = out.index(row, column) {
                            out.add_at(index, derivative);
                        }
                    }
                }
            }
        }
    }
}

/// Frames of the curve without derivatives, and with those in a direction of a pass.
struct PassFrames {
    still: TwoPulleyFrame<Differentiated>,
    moving: [TwoPulleyFrame<Differentiated>; PASS],
}

/// Where the derivatives of a cell go.
struct Entries<'a> {
    of_cell: &'a mut CellDerivatives,
    transports: &'a mut Transports,
    matrix: &'a mut Arrow,
    resultants: &'a mut ResultantDerivatives,
}

/// Adds the derivatives of a cell's rows to the matrix, and records those of its transport
/// quantities.
fn add_cell_derivatives<E: LagrangianElement>(
    evaluation: &Evaluation<'_, E>,
    over: &CellOver,
    frames: &PassFrames,
    factors: Factors,
    entries: &mut Entries<'_>,
) -> PulleyLoad {
    let Entries {
        of_cell,
        transports,
        matrix,
        resultants,
    } = entries;
    let at = over.unknowns();
    let pulley = evaluation.acting.belt.mesh.cells[over.cell].pulley;
    let (own, count) = (over.nodal(), at.len());
    of_cell.at[..count].copy_from_slice(at);
    of_cell.count = count;
    let mut load = PulleyLoad::default();
    for first in (0..count).step_by(PASS) {
        let still = Still { first, factors };
        let theta = (own + THETA).wrapping_sub(first);
        let still_here = first + PASS <= own + DRIFT || first > own + THETA;
        let rows = if still_here {
            evaluation.cell(over, &frames.still, still, |_| ())
        } else {
            let frame = frames.moving.get(theta).unwrap_or(&frames.still);
            evaluation.cell(over, frame, Moving(still), |_| ())
        };
        let columns = &at[first..(first + PASS).min(count)];
        let mut add = |row: usize, value: &Differentiated| {
            for (&column, &derivative) in columns.iter().zip(&value.eps) {
                if let Some(index) = matrix.index(row, column) {
                    matrix.add_at(index, derivative);
                }
            }
        };
        for (number, nodal) in rows.ring.nodal.iter().enumerate().skip(1) {
            for (k, row) in nodal.iter().enumerate() {
                add(at[over.first(number) + k], row);
            }
        }
        for (k, row) in rows.others().iter().enumerate().filter(|(k, _)| *k != CONTENT) {
            add(at[own + k], row);
        }
        for (axis, force) in rows.balance.pulley.resultant.iter().enumerate() {
            for (&column, &derivative) in columns.iter().zip(&force.eps) {
                resultants.of(pulley, axis)[column] += derivative;
            }
        }
        transports.set(over.cell, &rows.balance.transport.map(|of| of.re));
        for (derivatives, of) in of_cell
            .transport
            .as_mut_array()
            .into_iter()
            .zip(rows.balance.transport.as_array())
        {
            derivatives[first..][..columns.len()].copy_from_slice(&of.eps[..columns.len()]);
        }
        load = rows.balance.pulley.map(|of| of.re);
    }
    load
}

impl<E: LagrangianElement> Assembly for TravellingCells<E> {
    fn boxed(&self) -> Box<dyn Assembly> {
        Box::new(self.clone())
    }

    fn residual(&mut self, acting: InForce<'_>, view: View<'_>, out: &mut [f64]) -> PerPulley<PulleyLoad> {
        let belt = acting.belt;
        let layout = &belt.layout;
        self.add_ring(layout, view, out);
        if E::MEAN_STRAIN {
            for (element, mean) in self.mean_tensions.iter_mut().enumerate() {
                mean.value = self.ring.mean_tension(&values(layout, view, element));
            }
        }
        let frame = belt.curve.frame(belt.theta(view));
        let s = view.q[layout.drift()];
        let mut loads = PerPulley::<PulleyLoad>::default();
        let evaluation = Evaluation {
            acting,
            view,
            ring: &self.ring,
            mean_tensions: &self.mean_tensions,
        };
        for cell in 0..belt.mesh.cells.len() {
            let over = CellOver::new(belt, &frame, cell, s);
            let at = over.unknowns();
            let rows = evaluation.cell(&over, &frame, Values, |_| ());
            for (number, nodal) in rows.ring.nodal.iter().enumerate().skip(1) {
                for (k, row) in nodal.iter().enumerate() {
                    out[at[over.first(number) + k]] += row;
                }
            }
            let own = &at[over.nodal()..];
            let b = &rows.balance;
            out[own[0]] += b.speed[0];
            out[own[1]] += b.speed[1];
            out[own[DRIFT]] += rows.ring.drift;
            out[own[THETA]] += rows.ring.theta;
            out[own[GAUGE]] += rows.ring.gauge[0];
            out[own[GAUGE + 1]] += rows.ring.gauge[1];
            loads[belt.mesh.cells[cell].pulley].add(&b.pulley, 1.0);
            self.transports.set(cell, &b.transport);
        }
        self.transports.add_fluxes(belt, view, out);
        for i in layout.free() {
            out[i] = view.y[i];
        }
        loads
    }

    fn jacobian(
        &mut self,
        acting: InForce<'_>,
        view: View<'_>,
        factors: Factors,
        out: &mut Arrow,
        resultants: &mut ResultantDerivatives,
    ) -> PerPulley<PulleyLoad> {
        let belt = acting.belt;
        let layout = &belt.layout;
        let Factors { alpha, beta } = factors;
        let s = view.q[layout.drift()];
        let theta = belt.theta(view);
        let frame = belt.curve.frame(theta);
        let frames = PassFrames {
            still: belt.curve.frame(Differentiated::from(theta)),
            moving: std::array::from_fn(|k| belt.curve.frame(Differentiated::seed(theta, k, beta))),
        };
        self.order.find(belt, &frame, s);
        out.reorder(&self.order.order);
        self.add_ring_derivatives(layout, view, factors, out);
        let evaluation = Evaluation {
            acting,
            view,
            ring: &self.ring,
            mean_tensions: &self.mean_tensions,
        };
        let mut loads = PerPulley::<PulleyLoad>::default();
        for (cell, of_cell) in self.derivatives.iter_mut().enumerate() {
            let over = CellOver::new(belt, &frame, cell, s);
            let mut entries = Entries {
                of_cell,
                transports: &mut self.transports,
                matrix: out,
                resultants,
            };
            let load = add_cell_derivatives(&evaluation, &over, &frames, factors, &mut entries);
            loads[belt.mesh.cells[cell].pulley].add(&load, 1.0);
        }
        self.add_flux_derivatives(belt, alpha, out);
        for i in layout.free() {
            out.add(i, i, 1.0);
        }
        loads
    }

    fn sample(&self, acting: InForce<'_>, view: View<'_>, out: &mut [Sample<Lanes>]) -> RingEnergy {
        let belt = acting.belt;
        let frame = belt.curve.frame(belt.theta(view));
        let s = view.q[belt.layout.drift()];
        let at_present = |element| MeanTension {
            value: self.ring.mean_tension(&values(&belt.layout, view, element)),
            ..MeanTension::default()
        };
        let mean_tensions: Vec<_> = (0..self.ring.elements()).map(at_present).collect();
        let evaluation = Evaluation {
            acting,
            view,
            ring: &self.ring,
            mean_tensions: &mean_tensions,
        };
        for (cell, place) in belt.mesh.cells.iter().enumerate() {
            let over = CellOver::new(belt, &frame, cell, s);
            let mut stations = out[place.group * belt.mesh.points..].iter_mut();
            evaluation.cell(&over, &frame, Values, |at| {
                let group = stations.next().expect("a place for each station");
                group.set(place.lane, &at.sample());
            });
        }
        let (mut energy, mut loss) = (Energy::default(), 0.0);
        for element in 0..self.ring.elements() {
            let values = values(&belt.layout, view, element);
            energy += self.ring.energy(&(), element, &values);
            loss += self.ring.dissipation(&(), element, &values);
        }
        RingEnergy {
            energy: energy.total(),
            loss,
        }
    }
}
