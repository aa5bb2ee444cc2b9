//! The error norm of time integration, its longest step, and the energy balance of a run.

use super::belt::{BeltDiagnostics, BeltSums};
use crate::archive::Archive;
use crate::pulley::Pulley;
use crate::solver::arrow::{Arrow, Shape};
use crate::solver::sdirk::Evolution;
use crate::solver::{System, View};
use crate::variator::pulleys::loads::{Boundary, ShaftMode};
use crate::variator::system::VariatorSystem;
use std::array::from_fn;

/// Energies since the start, J, and the belt at the end of the last accepted step.
#[derive(Clone, Debug, Default)]
pub struct EnergyBalance {
    /// Energy supplied from outside.
    pub supplied: f64,
    /// Energy lost.
    pub lost: f64,
    /// Energy stored at the start.
    initial: f64,
    /// ∫ of the sum of absolute powers over shafts and sheaves: the scale of the balance.
    pub moved: f64,
    /// The belt at the end of the last step.
    pub last: BeltDiagnostics,
}

/// The initial value problem of a run: the equations, with the energy balance.
#[derive(Debug)]
pub struct Problem<'a> {
    /// Equations of the variator.
    pub system: &'a mut VariatorSystem,
    /// Energy balance of the run.
    pub energy: &'a mut EnergyBalance,
}

impl System for Problem<'_> {
    fn shape(&self) -> Shape {
        self.system.shape()
    }

    fn has_position(&self) -> &[bool] {
        self.system.has_position()
    }

    fn residual(&mut self, time: f64, view: View<'_>, out: &mut [f64]) {
        self.system.residual(time, view, out);
    }

    fn jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        self.system.jacobian(time, view, alpha, beta, out);
    }

    fn renew_jacobian(&mut self, time: f64, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) -> f64 {
        self.system.renew_jacobian(time, view, alpha, beta, out)
    }

    fn newton_scale(&self, beta: f64, out: &mut [f64]) {
        self.system.newton_scale(beta, out);
    }
}

impl Evolution for Problem<'_> {
    /// Errors relative to the working range of each quantity: Θ (0.01), sheave positions (1 mm),
    /// displaced centres (5 mm; their turn 5e-3), tilt (2 mrad), speeds (10 rad/s and a tenth of
    /// the speed); and as a mean over the belt: belt speed and sliding (m/s), element contents (5
    /// mm: push force), ring positions (10 mm: tension, radial deviation).
    fn error_norm(&self, view: View<'_>, y_error: &[f64], q_error: &[f64]) -> f64 {
        let belt = &*self.system.belt;
        let layout = &belt.layout;
        let tolerance = self.system.parameters.solver.tolerance;
        let (mut norm, mut is_finite) = (0.0_f64, true);
        let mut take = |error: f64| {
            // The maximum of numbers ignores NaN.
            is_finite &= error.is_finite();
            norm = norm.max(error.abs());
        };
        take(q_error[layout.theta()] / (0.01 * tolerance));
        for pulley in Pulley::BOTH {
            let (z, omega) = (layout.sheave(pulley), layout.shaft_speed(pulley));
            take(q_error[z] / (1.0e-3 * tolerance));
            take(y_error[omega] / (tolerance * (10.0 + 0.1 * view.y[omega].abs())));
            for axis in 0..2 {
                take(y_error[layout.tilt(pulley, axis)] / (2.0e-3 * tolerance));
            }
        }
        // Sharper near standstill, where there is little energy.
        let speed = view.y[layout.belt_speed(0)].abs();
        let running = speed / (0.1 + speed);
        let speed_scale = tolerance * (1.0 + speed + 8.5 * running);
        let position_scale = 1.0e-2 * tolerance * (0.02 + 0.9 * running);
        let mut local = 0.0;
        for cell in &belt.cells_at {
            let speed = y_error[cell.speed] / speed_scale;
            let content = y_error[cell.content] / (5.0e-3 * tolerance);
            local += speed * speed + content * content;
        }
        for of in layout.node_unknowns().filter(|of| of.is_length) {
            let x = q_error[of.index] / position_scale;
            local += x * x;
        }
        for centre in layout.centres() {
            take(q_error[centre] / (5.0e-3 * tolerance));
        }
        take((local / layout.len() as f64).sqrt());
        if is_finite { norm } else { f64::MAX }
    }

    fn longest_step(&self, view: View<'_>) -> f64 {
        let belt = &self.system.belt;
        belt.material_mesh
            .as_ref()
            .map_or(f64::INFINITY, |of| of.longest_drift / view.y[belt.layout.drift()].abs())
    }

    fn accumulate(&mut self, before: View<'_>, after: View<'_>, end: f64, h: f64) {
        let [at_start, in_middle, at_end] =
            [end - h, end - 0.5 * h, end].map(|time| self.system.boundary(time));
        let first = powers(self.system, &at_start, before, &self.energy.last.sums);
        self.energy.last.update(self.system, after);
        let second = powers(self.system, &at_end, after, &self.energy.last.sums);
        let forces = [&at_start, &in_middle, &at_end].map(Boundary::clamping_forces);
        let [mut supplied, mut lost, mut moved] = from_fn(|k| 0.5 * h * (first[k] + second[k]));
        for pulley in Pulley::BOTH {
            let [work, damped] =
                self.sheave_work(pulley, before, after, h, forces.map(|force| force[pulley]));
            supplied += work;
            moved += work.abs();
            lost += damped
                + self
                    .system
                    .pulleys()
                    .tilt_loss_beyond_trapezoid(pulley, before, after, h);
            supplied += self.work_on_set_point(pulley, &at_end, before, after);
        }
        self.energy.supplied += supplied;
        self.energy.lost += lost;
        self.energy.moved += moved;
    }
}

impl Problem<'_> {
    /// Work on the inertia of a pulley in speed drive, which follows its set point in less than a
    /// step. Else zero.
    fn work_on_set_point(
        &self,
        pulley: Pulley,
        boundary: &Boundary,
        before: View<'_>,
        after: View<'_>,
    ) -> f64 {
        let ShaftMode::Setpoint(_) = boundary.shaft[pulley] else {
            return 0.0;
        };
        let omega = self.system.belt.layout.shaft_speed(pulley);
        let change = after.y[omega].powi(2) - before.y[omega].powi(2);
        0.5 * self.system.parameters.pulley(pulley).inertia * change
    }

    /// Work of clamp, pressure and rotating oil in a step, and the loss of damper and seals beyond
    /// the trapezoidal rule, J. By Simpson's rule with ż in the middle from the change of z, since a
    /// sheave's step response is shorter than a step: under a constant force the work is exact.
    /// `forces` of clamp and pressure are those at the start, in the middle and at the end.
    fn sheave_work(
        &self,
        pulley: Pulley,
        before: View<'_>,
        after: View<'_>,
        h: f64,
        forces: [f64; 3],
    ) -> [f64; 2] {
        let z = self.system.belt.layout.sheave(pulley);
        let simpson = |[first, middle, last]: [f64; 3]| h / 6.0 * (first + 4.0 * middle + last);
        let (start, end) = (before.y[z], after.y[z]);
        let middle = 1.5 * (after.q[z] - before.q[z]) / h - 0.25 * (start + end);
        let square = simpson([start * start, middle * middle, end * end]);
        let pulleys = self.system.pulleys();
        let of = self.system.parameters.pulley(pulley);
        let omega = self.system.belt.layout.shaft_speed(pulley);
        let speeds = [
            before.y[omega],
            0.5 * (before.y[omega] + after.y[omega]),
            after.y[omega],
        ];
        let force = |k: usize| forces[k] + of.cylinder.centrifugal * speeds[k] * speeds[k];
        let rubbed = [start, middle, end].map(|z_dot| pulleys.seal_loss(pulley, z_dot));
        [
            simpson([force(0) * start, force(1) * middle, force(2) * end]),
            of.sheave_damping * (square - 0.5 * h * (start * start + end * end))
                + (simpson(rubbed) - 0.5 * h * (rubbed[0] + rubbed[2])),
        ]
    }
}

/// Powers supplied, lost and over the shafts, W, without those of the clamping forces and of the
/// acceleration of a pulley in speed drive.
fn powers(system: &VariatorSystem, boundary: &Boundary, view: View<'_>, sums: &BeltSums) -> [f64; 3] {
    let speeds = system.belt.shaft_speeds(view);
    let mut moved = 0.0;
    for pulley in Pulley::BOTH {
        moved += (sums.torque[pulley] * speeds[pulley]).abs();
    }
    [
        system.pulleys().shaft_power(boundary, view, sums.shaft_torque),
        sums.losses.total() + system.pulleys().losses(view),
        moved,
    ]
}

impl EnergyBalance {
    /// The energy balance of a run that starts at a state.
    #[must_use]
    pub fn open(system: &VariatorSystem, view: View<'_>) -> Self {
        let last = BeltDiagnostics::new(system, view);
        Self {
            initial: last.belt_energy(&system.belt) + system.pulleys().energy(view),
            last,
            ..Self::default()
        }
    }

    /// Energy that is not accounted for where `stored` is stored, J.
    pub(crate) fn residual(&self, stored: f64) -> f64 {
        self.supplied - self.lost - (stored - self.initial)
    }

    pub(crate) fn serialize(&mut self, archive: &mut Archive<'_>) {
        for value in [&mut self.supplied, &mut self.lost, &mut self.initial, &mut self.moved] {
            archive.real(value);
        }
    }
}
