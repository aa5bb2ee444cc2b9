//! Boundary conditions at the pulleys: loads and set points, how they change with time, and the pulleys' own rows:
//!
//! - axial: m_z z̈ = F − ∫p_ax − d_z ż + stop force; z closes the pulley, 0 at ratio 1,
//! - tilt of one sheave: k (ψ + τ ψ̇) = ∫p_ax ϱ (cos θ, sin θ). Its shape is Sattler's trigonometric law with the
//!   amplitude from moment balance: |ψ| = aΔ tan β, a = (1 + cos²β)/sin 2β, gives the same spread of radius,
//! - rotation: J ω̇ = T + belt torque, or τ_ω ω̇ = ω_set − ω in speed drive.

use super::layout::Global;
use super::mesh::{P, S};
use super::parameters::SPEED_LAG;
use super::system::{HOLD, VariatorSystem};
use crate::solver::View;
use crate::solver::arrow::Arrow;
use crate::tape::Tape;

/// How a sheave's axial position is determined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SheaveMode {
    /// By the clamping force, N.
    Force(f64),
    /// It stands still.
    Held,
    /// It goes where Θ takes the value `theta`: the clamping force is `force` + [`RATIO_STIFFNESS`]·(`theta` − Θ), and
    /// whoever solves for a steady state moves `force` to the reaction.
    Ratio {
        /// Θ to go to.
        theta: f64,
        /// Force at `theta`, N.
        force: f64,
    },
}

/// Stiffness with which a steady solution is drawn to its ratio, N per unit of Θ.
pub const RATIO_STIFFNESS: f64 = 2.0e7;

/// How a pulley's speed is determined.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SpeedMode {
    /// By the external torque, N·m.
    Torque(f64),
    /// It follows the set point with a lag, rad/s.
    Setpoint(f64),
    /// It stays what it is.
    Fixed,
    /// Secondary only: both speeds change in proportion, ω̇_S/ω_S = ω̇_P/ω_P, under the two external torques, N·m.
    Balanced(f64, f64),
    /// Secondary only: it goes where the belt takes the given torque from the primary shaft, N·m.
    Transmit(f64),
}

/// Boundary conditions, over pulleys [`S`], [`P`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Boundary {
    /// Sheaves.
    pub sheave: [SheaveMode; 2],
    /// Shafts.
    pub speed: [SpeedMode; 2],
}

impl Boundary {
    fn pass(&mut self, tape: &mut Tape<'_>) {
        for sheave in &mut self.sheave {
            if let SheaveMode::Force(force) = sheave {
                tape.real(force);
            }
        }
        for speed in &mut self.speed {
            if let SpeedMode::Torque(load) | SpeedMode::Setpoint(load) = speed {
                tape.real(load);
            }
        }
    }
}

/// How fast the loads of a [`Boundary`] change, over pulleys [`S`], [`P`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LoadRates {
    /// Of clamping forces, N/s.
    pub force: [f64; 2],
    /// Of external torques, N·m/s, or of speed set points, rad/s².
    pub speed: [f64; 2],
}

/// Loads that change in proportion to time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    /// Time at which the loads are those of `start`, s.
    from: f64,
    start: Boundary,
    rates: LoadRates,
}

impl Course {
    fn at(&self, time: f64) -> Boundary {
        let after = time - self.from;
        let mut boundary = self.start;
        for j in [S, P] {
            if let SheaveMode::Force(force) = &mut boundary.sheave[j] {
                // A falling force ends at zero: sheaves are pushed, never pulled.
                *force = (*force + after * self.rates.force[j]).max(0.0);
            }
            if let SpeedMode::Torque(load) | SpeedMode::Setpoint(load) = &mut boundary.speed[j] {
                *load += after * self.rates.speed[j];
            }
        }
        boundary
    }
}

impl VariatorSystem {
    /// Puts boundary conditions in force that hold at time `from` and whose loads change at `rates`, as they are at
    /// `time`. Loads act on the pulleys' own inertia alone, so the rates `y_dot` that jump with them are known; the
    /// integrator's error estimate needs them.
    pub fn change_loads(&mut self, from: f64, boundary: Boundary, rates: LoadRates, time: f64, y_dot: &mut [f64]) {
        let course = Course {
            from,
            start: boundary,
            rates,
        };
        self.course = (rates != LoadRates::default()).then_some(course);
        self.change_boundary(self.course.map_or(boundary, |course| course.at(time)), y_dot);
    }

    /// Passes by a tape the loads and how they change. To read, boundary conditions of the same kinds must be in force.
    pub fn pass_loads(&mut self, tape: &mut Tape<'_>) {
        self.boundary.pass(tape);
        let mut changes = self.course.is_some();
        tape.flag(&mut changes);
        if changes {
            let course = self.course.get_or_insert(Course {
                from: 0.0,
                start: self.boundary,
                rates: LoadRates::default(),
            });
            tape.real(&mut course.from);
            course.start.pass(tape);
            tape.reals(&mut course.rates.force);
            tape.reals(&mut course.rates.speed);
        } else {
            self.course = None;
        }
    }

    /// Moves loads that change with time on, or back, to `time`.
    pub fn move_loads(&mut self, time: f64) {
        if let Some(course) = &self.course {
            self.boundary = course.at(time);
        }
    }

    /// Puts `boundary` in force, and makes the rates jump that jump with the loads.
    fn change_boundary(&mut self, boundary: Boundary, y_dot: &mut [f64]) {
        for j in [S, P] {
            let pulley = self.pulley(j);
            if let (SheaveMode::Force(old), SheaveMode::Force(new)) = (self.boundary.sheave[j], boundary.sheave[j]) {
                y_dot[self.layout.global(Global::Sheave, j)] += (new - old) / pulley.sheave_mass;
            }
            let omega = self.layout.global(Global::Speed, j);
            match (self.boundary.speed[j], boundary.speed[j]) {
                (SpeedMode::Torque(old), SpeedMode::Torque(new)) => y_dot[omega] += (new - old) / pulley.inertia,
                (SpeedMode::Setpoint(old), SpeedMode::Setpoint(new)) => y_dot[omega] += (new - old) / SPEED_LAG,
                _ => {}
            }
        }
        self.boundary = boundary;
    }

    /// Clamping force under which a sheave stands still, N: the belt's `axial` force on it, less what an end stop
    /// gives.
    #[must_use]
    pub fn holding_force(&self, j: usize, view: View<'_>, axial: f64) -> f64 {
        let z = self.layout.global(Global::Sheave, j);
        axial - self.travel[j].stop_force(view.q[z], view.y[z]).force
    }

    fn balanced_factor(&self, view: View<'_>) -> f64 {
        let omega = |j| view.y[self.layout.global(Global::Speed, j)];
        let primary = self.pulley(P).inertia * omega(P);
        if primary == 0.0 {
            0.0
        } else {
            self.pulley(S).inertia * omega(S) / primary
        }
    }

    /// Adds the pulleys' own terms to the residual; `sums` hold the belt's.
    pub(super) fn global_residual(&self, view: View<'_>, out: &mut [f64]) {
        for j in [S, P] {
            let pulley = self.pulley(j);
            let sum = &self.sums[j];
            let z = self.layout.global(Global::Sheave, j);
            out[z] = match self.boundary.sheave[j] {
                SheaveMode::Force(force) => {
                    pulley.sheave_mass * view.y_dot[z] + pulley.sheave_damping * view.y[z] - force + sum.axial
                        - self.travel[j].stop_force(view.q[z], view.y[z]).force
                }
                SheaveMode::Held => HOLD * view.y[z],
                SheaveMode::Ratio { theta, force } => {
                    let off = theta - view.q[self.layout.global(Global::Theta, 0)];
                    let sign = if j == P { 1.0 } else { -1.0 };
                    pulley.sheave_mass * view.y_dot[z] + pulley.sheave_damping * view.y[z] + sum.axial
                        - force
                        - sign * RATIO_STIFFNESS * off
                        - self.travel[j].stop_force(view.q[z], view.y[z]).force
                }
            };
            for k in 0..2 {
                let i = self.layout.global(Global::Tilt, 2 * j + k);
                out[i] = if self.rigid(j) {
                    HOLD * view.y[i]
                } else {
                    pulley.tilt_stiffness * (view.y[i] + pulley.tilt_time * view.y_dot[i]) - sum.tilting[k]
                };
            }
            let i = self.layout.global(Global::Speed, j);
            let inertia = self.inertia_factor * pulley.inertia * view.y_dot[i];
            out[i] = match self.boundary.speed[j] {
                SpeedMode::Torque(torque) => inertia - torque - sum.torque,
                SpeedMode::Setpoint(set) => {
                    inertia - self.inertia_factor * pulley.inertia * (set - view.y[i]) / SPEED_LAG
                }
                SpeedMode::Fixed => inertia,
                SpeedMode::Balanced(own, primary) => {
                    inertia - own - sum.torque + self.balanced_factor(view) * (primary + self.sums[P].torque)
                }
                SpeedMode::Transmit(primary) => inertia + primary + self.sums[P].torque,
            };
        }
    }

    pub(super) fn global_jacobian(&self, view: View<'_>, alpha: f64, beta: f64, out: &mut Arrow) {
        use num_dual::Dual64;
        for j in [S, P] {
            let pulley = self.pulley(j);
            let z = self.layout.global(Global::Sheave, j);
            match self.boundary.sheave[j] {
                SheaveMode::Force(_) | SheaveMode::Ratio { .. } => {
                    let stop = self.travel[j]
                        .stop_force(Dual64::new(view.q[z], beta), Dual64::new(view.y[z], 1.0))
                        .force
                        .eps;
                    out.add(z, z, pulley.sheave_mass * alpha + pulley.sheave_damping - stop);
                    if let SheaveMode::Ratio { .. } = self.boundary.sheave[j] {
                        let sign = if j == P { 1.0 } else { -1.0 };
                        out.add(z, self.layout.global(Global::Theta, 0), sign * RATIO_STIFFNESS * beta);
                    }
                }
                SheaveMode::Held => out.set_unit_row(z, HOLD),
            }
            for k in 0..2 {
                let i = self.layout.global(Global::Tilt, 2 * j + k);
                if self.rigid(j) {
                    out.set_unit_row(i, HOLD);
                } else {
                    out.add(i, i, pulley.tilt_stiffness * (1.0 + pulley.tilt_time * alpha));
                }
            }
        }
        // Secondary first: its row may need the primary's before that is overwritten.
        let (s, p) = (
            self.layout.global(Global::Speed, S),
            self.layout.global(Global::Speed, P),
        );
        match self.boundary.speed[S] {
            SpeedMode::Balanced(_, primary) => {
                let factor = self.balanced_factor(view);
                out.add_row(s, p, -factor);
                let unbalanced = primary + self.sums[P].torque;
                let omega = view.y[p];
                if omega != 0.0 {
                    out.add(
                        s,
                        s,
                        unbalanced * self.pulley(S).inertia / (self.pulley(P).inertia * omega),
                    );
                }
            }
            SpeedMode::Transmit(_) => {
                out.set_unit_row(s, 0.0);
                out.add_row(s, p, -1.0);
            }
            _ => {}
        }
        for j in [S, P] {
            let i = self.layout.global(Global::Speed, j);
            let inertia = self.inertia_factor * self.pulley(j).inertia;
            match self.boundary.speed[j] {
                SpeedMode::Setpoint(_) => out.set_unit_row(i, inertia * (alpha + 1.0 / SPEED_LAG)),
                SpeedMode::Fixed => out.set_unit_row(i, inertia * alpha.max(1.0)),
                _ => out.add(i, i, inertia * alpha),
            }
        }
    }
}
