//! The equations of a free ring for the solver.

use super::free_ring::RingSystem;
use super::packs::shape;
use crate::ring::model::RingFormulation;
use crate::scalar::Lanes;
use crate::solver::arrow::{Arrow, Shape as MatrixShape};
use crate::solver::sdirk::{Evolution, Interval};
use crate::solver::{System, View};
use nalgebra::SVector;
use num_dual::{Derivative, DualSVec64};
use std::f64::consts::TAU;

/// Change of the shape that does not matter to Newton's method, in units of the length L. Thin rings leave no smaller
/// one: rounding in the tension bends them by 1e-16·EA L²/EI.
const NEWTON_ACCURACY: f64 = 1.0e-9;

impl<M: RingFormulation<D, N>, const D: usize, const N: usize> System for RingSystem<M, D, N> {
    fn shape(&self) -> MatrixShape {
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
        let seed = |value: f64, direction: usize, slope: f64| {
            let mut eps = SVector::<f64, N>::zeros();
            eps[direction] = slope;
            DualSVec64::new(value, Derivative::some(eps))
        };
        let frame = self.model.frame(seed(view.q[self.theta()], N - 1, beta));
        for pack in &self.packs {
            if pack.add_slopes(&self.model, view, slopes, out) {
                continue;
            }
            for (element, entries) in (pack.first..).zip(&pack.entries) {
                let motion = self.motion(view, element, slopes, seed);
                let rows = self.model.balance(&frame, element, &motion);
                for (entries, row) in entries.iter().zip(&rows) {
                    for (&entry, &slope) in entries.iter().zip(row.eps.0.iter().flatten()) {
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
        // Errors of velocity add up over many short steps: their measure is the slowest bending wave, not the step.
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

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, interval: Interval) {
        if self.model.ring().damping != 0.0 {
            for view in [before, after] {
                self.dissipated += 0.5 * interval.length * self.dissipation(view);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference_curve::TwoPulley;
    use crate::ring::Ring;
    use crate::ring::ale_ring::{AleRing, Directions};
    use crate::ring::ancf::Ancf;
    use crate::ring::mesh::RingMesh;
    use crate::ring::rcm::Rcm;
    use crate::solver::differences::compare;
    use pushbelt_lab::noise;

    fn jacobian_matches_differences<const D: usize, const N: usize>(model: impl RingFormulation<D, N>) {
        let mut system = RingSystem::new(model);
        let mut state = system.rest(0.2);
        let n = state.y.len();
        let mut random = noise(3);
        for i in 0..n {
            let size = if i < system.drift() && system.is_length(i) {
                0.004
            } else {
                0.02
            };
            state.q[i] += size * random();
            state.y[i] = 3.0 * random();
            state.y_dot[i] = 100.0 * random();
        }
        compare(
            &mut system,
            0.0,
            &state,
            [300.0, 0.01],
            |_| 1.0e-4,
            |entry| {
                assert!(
                    (entry.difference - entry.exact).abs() < 1e-6 * entry.largest,
                    "row {}: {entry:?}",
                    entry.row
                );
            },
        );
    }

    /// A soft ring, so that no stiffness drowns the rest.
    fn ring() -> Ring {
        Ring {
            mass_per_length: 0.24,
            axial_stiffness: 5.57e3,
            bending_stiffness: 0.0159,
            lateral_bending_stiffness: 0.031,
            damping: 2.0e-4,
        }
    }

    #[test]
    fn jacobians_match_differences() {
        let ring = ring();
        let curve = TwoPulley::new(0.168, 0.703);
        let mesh = RingMesh::even(&[1, 1, 2, 1, 1], 3);
        for directions in [Directions::Fixed, Directions::Reference] {
            let mut planar = AleRing::flexible(ring.clone(), curve.clone(), mesh.clone());
            planar.directions = directions;
            jacobian_matches_differences(planar);
            let mut spatial = AleRing::spatial(ring.clone(), curve.clone(), mesh.clone());
            spatial.directions = directions;
            jacobian_matches_differences(spatial);
        }
        jacobian_matches_differences(Ancf::new(ring.clone(), curve.clone(), 8, 3));
        jacobian_matches_differences(Rcm::new(ring, curve, 9, 5));
    }

    /// Elements that don't fill the last pack.
    #[test]
    fn packs_are_the_sum_of_their_elements() {
        let mut system = RingSystem::new(Ancf::new(ring(), TwoPulley::new(0.168, 0.703), 11, 3));
        let mut state = system.rest(0.2);
        let mut random = noise(4);
        for i in 0..state.y.len() {
            state.q[i] += 0.01 * random();
            state.y[i] = random();
            state.y_dot[i] = random();
        }
        let (mut packed, mut summed) = (vec![0.0; state.y.len()], vec![0.0; state.y.len()]);
        system.residual(0.0, state.view(), &mut packed);
        for element in 0..11 {
            let rows = system
                .model
                .balance(&(), element, &system.values(state.view(), element));
            for (i, row) in system.model.directions(element).into_iter().zip(rows) {
                summed[i] += row;
            }
        }
        let largest = summed.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        for (i, (a, b)) in packed.iter().zip(&summed).enumerate() {
            assert!(
                system.held.contains(&i) || (a - b).abs() < 1e-12 * largest,
                "row {i}: {a}, {b}"
            );
        }
    }
}
