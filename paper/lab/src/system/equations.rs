//! The equations of a free ring for the solver.

use super::free_ring::RingSystem;
use super::packs::shape;
use pushbelt::scalar::{Lanes, Tangent};
use pushbelt::solver::arrow::{Arrow, Shape};
use pushbelt::solver::sdirk::Evolution;
use pushbelt::solver::{System, View};
use pushbelt_paper::ring::model::RingFormulation;
use std::f64::consts::TAU;

/// Tolerance of Newton's method for a change of the shape, in units of the length L. For thin rings
/// it cannot be smaller: rounding in the tension bends them by 1e-16·EA L²/EI.
const NEWTON_ACCURACY: f64 = 1.0e-9;

impl<M: RingFormulation<D, N>, const D: usize, const N: usize> System for RingSystem<M, D, N> {
    fn shape(&self) -> Shape {
        shape(&self.model)
    }

    fn has_position(&self) -> &[bool] {
        &self.has_position
    }

    fn residual(&mut self, _time: f64, view: View<'_>, out: &mut [f64]) {
        out.fill(0.0);
        let frame = self.frame(view);
        for pack in &self.packs {
            if let Some(rows) = self
                .model
                .balance_of_many(&pack.motion(view, [0.0; 2], |value, _, _| value))
            {
                let rows = rows.map(Lanes::to_array);
                for (lane, at) in pack.elements.iter().enumerate() {
                    at.iter().zip(&rows).for_each(|(&i, row)| out[i] += row[lane]);
                }
                continue;
            }
            for (element, at) in (pack.first..).zip(&pack.elements) {
                let rows = self.model.balance(&frame, element, &self.values(view, element));
                at.iter().zip(rows).for_each(|(&i, row)| out[i] += row);
            }
        }
        for &i in &self.held {
            out[i] = view.y[i];
        }
    }

    fn jacobian(&mut self, _time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        out.clear();
        let slopes = [alpha, beta];
        let seed = Tangent::<N, f64>::seed;
        let frame = self.model.frame(seed(view.q[self.theta()], N - 1, beta));
        for pack in &self.packs {
            if pack.add_slopes(&self.model, view, slopes, out) {
                continue;
            }
            for (element, entries) in (pack.first..).zip(&pack.entries) {
                let motion = self.motion(view, element, slopes, seed);
                let rows = self.model.balance(&frame, element, &motion);
                for (entries, row) in entries.iter().zip(&rows) {
                    for (&entry, slope) in entries.iter().zip(row.eps) {
                        out.add_at(entry, slope);
                    }
                }
            }
        }
        for &i in &self.held {
            out.set_unit_row(i, 1.0);
        }
    }

    fn newton_scale(&self, beta: f64, out: &mut [f64]) {
        let length = self.model.length();
        let ring = self.model.ring();
        // Velocity errors accumulate over many short steps, so their scale is the slowest bending
        // wave, not the step.
        let wave = (ring.bending_stiffness / ring.mass_per_length).sqrt() * (TAU / length).powi(2);
        let rate = if wave > 0.0 { wave.min(1.0 / beta) } else { 1.0 / beta };
        for (i, scale) in out.iter_mut().enumerate() {
            let size = if self.is_length(i) { length } else { 1.0 };
            *scale = NEWTON_ACCURACY * size * rate;
        }
    }
}

impl<M: RingFormulation<D, N>, const D: usize, const N: usize> Evolution for RingSystem<M, D, N> {
    fn error_norm(&self, _view: View<'_>, _y_error: &[f64], q_error: &[f64]) -> f64 {
        let length = self.model.length();
        let sum: f64 = q_error
            .iter()
            .enumerate()
            .map(|(i, error)| if self.is_length(i) { error / length } else { *error })
            .map(|error| error * error)
            .sum();
        (sum / q_error.len() as f64).sqrt() / self.tolerance
    }

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, _end: f64, length: f64) {
        if self.model.ring().damping != 0.0 {
            for view in [before, after] {
                self.dissipated += 0.5 * length * self.dissipation(view);
            }
        }
    }
}
