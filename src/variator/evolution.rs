//! What time integration needs beyond the residual: which errors matter, and the books of energy.

use super::balance::{BeltSums, Survey};
use super::boundary::SpeedMode;
use super::layout::Global;
use super::mesh::{P, S};
use super::system::VariatorSystem;
use crate::solver::View;
use crate::solver::sdirk::{Evolution, Interval};

/// Energies since the start, J, and what the last accepted step showed.
#[derive(Clone, Debug, Default)]
pub struct Ledger {
    /// Supplied from outside.
    pub supplied: f64,
    /// Lost.
    pub lost: f64,
    /// ∫ of the sum of absolute powers over shafts and sheaves: the scale of the balance.
    pub moved: f64,
    /// The belt at the end of the last step.
    pub last: Survey,
}

/// Part of its elements by which a ring that travels moves on in a step. Twice as much takes more work: Newton's method
/// then needs twice the Jacobians. The thrust ratio differs by 3e-4 at four times as much, by 1e-4 at half.
const PASSING: f64 = 1.0 / 180.0;

impl Evolution for VariatorSystem {
    /// Errors that users see: ratio (Θ to 0.01 of the tolerance), sheave positions (1 mm), speeds (10 rad/s and a tenth of
    /// the speed); belt speed and sliding (m/s); element amounts (5 mm: push force); ring positions (10 mm: tension, radial
    /// deviation). Each relative to its own working range, the last three as a mean over the belt.
    fn error_norm(&self, view: View<'_>, y_error: &[f64], q_error: &[f64]) -> f64 {
        let layout = &self.layout;
        let tolerance = self.law.parameters.solver.tolerance;
        let theta = layout.global(Global::Theta, 0);
        let mut norm = (q_error[theta] / (0.01 * tolerance)).abs();
        for j in [S, P] {
            let (z, omega) = (layout.global(Global::Sheave, j), layout.global(Global::Speed, j));
            norm = norm
                .max((q_error[z] / (1.0e-3 * tolerance)).abs())
                .max((y_error[omega] / (tolerance * (10.0 + 0.1 * view.y[omega].abs()))).abs());
        }
        // Sharper near standstill, where there is little energy to be wrong about.
        let speed = view.y[layout.speed(0)].abs();
        let running = speed / (1.0 + speed);
        let speed_scale = tolerance * (2.0 + speed + 8.0 * running);
        let place_scale = 1.0e-2 * tolerance * (0.2 + 0.8 * running);
        let count = layout.len() as f64;
        let mut local = 0.0;
        for &[speed, amount] in &self.cells_at {
            let speed = y_error[speed] / speed_scale;
            let amount = y_error[amount] / (5.0e-3 * tolerance);
            local += speed * speed + amount * amount;
        }
        if layout.flexible {
            for node in 0..layout.elements {
                for k in (0..2 * layout.components).step_by(2) {
                    let x = q_error[layout.node(node, k)] / place_scale;
                    local += x * x;
                }
            }
        }
        if let (Some(t), Some(ring)) = (&layout.travelling, &self.travelling) {
            for k in (0..t.block).filter(|&k| ring.is_length(k)) {
                for node in 0..t.nodes {
                    let x = q_error[layout.node(node, k)] / place_scale;
                    local += x * x;
                }
            }
        }
        let norm = norm.max((local / count).sqrt());
        if norm.is_finite() { norm } else { f64::MAX }
    }

    /// Under a ring that travels the contact changes with every bit of an element that passes.
    fn longest_step(&self, view: View<'_>) -> f64 {
        let drift = view.y[self.layout.global(Global::Drift, 0)].abs();
        let way = self.layout.travelling.map_or(f64::INFINITY, |t| PASSING * t.length);
        way / drift
    }

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, Interval { end, length: h }: Interval) {
        self.move_loads(end - h);
        let first = self.rates(before, &self.ledger.last.sums);
        let first_force = self.external_forces();
        self.move_loads(end - 0.5 * h);
        let middle_force = self.external_forces();
        self.move_loads(end);
        self.take_stock(after);
        let second = self.rates(after, &self.ledger.last.sums);
        let last_force = self.external_forces();
        let half = 0.5 * h;
        let mut lost = half * (first.lost + second.lost);
        let mut supplied = half * (first.supplied + second.supplied);
        let mut moved = half * (first.moved + second.moved);
        // A sheave's step response is shorter than a step, so its force's work and its damper's loss take Simpson's
        // rule, with ż in the middle from the way: under a constant force the work is exact.
        let simpson = |[first, middle, last]: [f64; 3]| h / 6.0 * (first + 4.0 * middle + last);
        for j in [S, P] {
            let z = self.layout.global(Global::Sheave, j);
            let (start, end) = (before.y[z], after.y[z]);
            let middle = 1.5 * (after.q[z] - before.q[z]) / h - 0.25 * (start + end);
            let work = simpson([first_force[j] * start, middle_force[j] * middle, last_force[j] * end]);
            supplied += work;
            moved += work.abs();
            let square = simpson([start * start, middle * middle, end * end]);
            lost += self.pulley(j).sheave_damping * (square - half * (start * start + end * end));
            // So is that of a shaft to its set point. What accelerates the pulley's own inertia is known.
            if let SpeedMode::Setpoint(_) = self.boundary.speed[j] {
                let omega = self.layout.global(Global::Speed, j);
                let change = after.y[omega].powi(2) - before.y[omega].powi(2);
                supplied += 0.5 * self.pulley(j).inertia * change;
            }
        }
        let ledger = &mut self.ledger;
        ledger.supplied += supplied;
        ledger.lost += lost;
        ledger.moved += moved;
    }
}

/// Powers of a state, W; those of the clamping forces aside, and what accelerates a pulley in speed drive.
struct Rates {
    supplied: f64,
    lost: f64,
    moved: f64,
}

impl VariatorSystem {
    /// Opens the books at a state.
    pub fn open_ledger(&mut self, view: View<'_>) {
        self.ledger = Ledger {
            last: self.surveyed(view),
            ..Ledger::default()
        };
    }

    /// Surveys the belt at the state where the books stand.
    pub fn take_stock(&mut self, view: View<'_>) {
        let mut last = std::mem::take(&mut self.ledger.last);
        self.survey(view, &mut last);
        self.ledger.last = last;
    }

    /// Powers from the belt's sums at the same state, under the boundary conditions in force.
    fn rates(&self, view: View<'_>, sums: &BeltSums) -> Rates {
        let mut moved = 0.0;
        for j in [S, P] {
            let omega = view.y[self.layout.global(Global::Speed, j)];
            moved += (sums.torque[j] * omega).abs();
        }
        Rates {
            supplied: self.shaft_power(view, sums.torque),
            lost: sums.losses.total() + self.pulley_losses(view),
            moved,
        }
    }
}
