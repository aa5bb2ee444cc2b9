//! Equations of motion of the pulleys (`docs/theory.md`, (6.1) to (6.4)): z closes the pulley, 0 at
//! ratio 1.

use super::loads::{Boundary, FORCE_TIME, PSEUDO_INERTIA, RATIO_STIFFNESS, ShaftMode, SheaveMode};
use crate::pulley::{PerPulley, Pulley, StopForce, Travel};
use crate::scalar::{Real, Tangent};
use crate::shaft::Drag;
use crate::solver::arrow::Arrow;
use crate::solver::{Factors, View};
use crate::tilt::Tilt;
use crate::variator::belt::equations::{PulleyLoad, ResultantDerivatives};
use crate::variator::belt::{Belt, CONSTRAINT_SCALE};
use crate::variator::mesh::layout::Layout;
use crate::variator::settings::{Parameters, PulleyParameters, SPEED_LAG};

/// The two pulleys with their shafts.
#[derive(Clone, Copy, Debug)]
pub struct Pulleys<'a> {
    parameters: &'a Parameters,
    belt: &'a Belt,
    /// Whether they are those of a steady solution.
    is_steady: bool,
}

/// Sign of the change of Θ when a pulley closes: the primary raises r_P, and Θ with it.
pub(crate) const CLOSING_SIGN: PerPulley<f64> = PerPulley {
    secondary: -1.0,
    primary: 1.0,
};

/// What acts on a pulley from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct External {
    /// External torque at the shaft, or the reaction in speed drive, N·m.
    pub torque: f64,
    /// Force of clamp and cylinder on the movable sheave, or the reaction where it is held, N.
    pub clamping: f64,
}

/// Motion on which the equation of a sheave depends.
struct SheaveMotion<T> {
    /// Position, speed and acceleration of the sheave.
    z: T,
    z_dot: T,
    z_ddot: T,
    /// Speed of its shaft.
    omega: T,
    theta: T,
}

/// An end stop of a movable sheave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stop {
    /// At the smallest pitch radius.
    Opening,
    /// At the largest.
    Closing,
}

impl Stop {
    /// Its name in a message.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Opening => "opening",
            Self::Closing => "closing",
        }
    }
}

impl<'a> Pulleys<'a> {
    /// The pulleys of a belt, in a run or in a steady solution.
    pub(crate) fn new(parameters: &'a Parameters, belt: &'a Belt, is_steady: bool) -> Self {
        Self {
            parameters,
            belt,
            is_steady,
        }
    }

    fn inertia_factor(&self) -> f64 {
        if self.is_steady { PSEUDO_INERTIA } else { 1.0 }
    }

    fn layout(&self) -> &Layout {
        &self.belt.layout
    }

    fn of(&self, pulley: Pulley) -> &PulleyParameters {
        self.parameters.pulley(pulley)
    }

    fn speed(&self, pulley: Pulley, view: View<'_>) -> f64 {
        view.y[self.layout().shaft_speed(pulley)]
    }

    fn travel(&self, pulley: Pulley) -> Travel {
        let (law, of) = (&self.belt.law, self.of(pulley));
        Travel::new(of.min_radius..=of.max_radius, law.r0, &law.wedge)
    }

    /// Force of the end stops on a sheave, and its damping part.
    fn stop(&self, pulley: Pulley, view: View<'_>) -> StopForce<f64> {
        let z = self.layout().sheave(pulley);
        self.travel(pulley).stop_force(view.q[z], view.y[z])
    }

    /// The end stop that a sheave has reached, from the start of its compression on.
    pub fn stop_reached(&self, pulley: Pulley, view: View<'_>) -> Option<Stop> {
        let (z, travel) = (view.q[self.layout().sheave(pulley)], self.travel(pulley));
        let closed = (z >= travel.closed).then_some(Stop::Closing);
        closed.or_else(|| (z <= travel.open).then_some(Stop::Opening))
    }

    /// Force of the end stops on a sheave, N.
    pub fn stop_force(&self, pulley: Pulley, view: View<'_>) -> f64 {
        self.stop(pulley, view).force
    }

    /// Force of clamp and pressure under which a sheave stands still, N: the belt's `axial` force
    /// on it, less those of an end stop, of spring and rotating oil.
    pub fn holding_force(&self, pulley: Pulley, view: View<'_>, axial: f64) -> f64 {
        axial - self.stop(pulley, view).force - self.passive_force(pulley, view)
    }

    /// Force of spring and rotating oil on a sheave, N.
    pub fn passive_force(&self, pulley: Pulley, view: View<'_>) -> f64 {
        let z = view.q[self.layout().sheave(pulley)];
        self.of(pulley).cylinder.passive_force(z, self.speed(pulley, view))
    }

    /// Force of a cylinder on its sheave beside that of its pressure, N.
    fn cylinder(&self, pulley: Pulley, view: View<'_>) -> f64 {
        let z_dot = view.y[self.layout().sheave(pulley)];
        self.passive_force(pulley, view) - self.parameters.seal_friction(pulley, z_dot)
    }

    /// Loss by the friction of a pulley's seals at the speed `z_dot` of its sheave, m/s; W.
    pub fn seal_loss(&self, pulley: Pulley, z_dot: f64) -> f64 {
        self.parameters.seal_friction(pulley, z_dot) * z_dot
    }

    /// Adds to the rates `y_dot` the jumps from a jump of the loads, which act on the pulleys' own
    /// inertia alone. The integrator's error estimate needs them.
    pub fn jump(&self, before: &Boundary, after: &Boundary, y_dot: &mut [f64]) {
        for pulley in Pulley::BOTH {
            let of = self.of(pulley);
            if let (SheaveMode::Force(old), SheaveMode::Force(new)) =
                (before.sheave[pulley], after.sheave[pulley])
            {
                y_dot[self.layout().sheave(pulley)] += (new - old) / of.sheave_mass;
            }
            let omega = self.layout().shaft_speed(pulley);
            match (before.shaft[pulley], after.shaft[pulley]) {
                (ShaftMode::Torque(old), ShaftMode::Torque(new)) => y_dot[omega] += (new - old) / of.inertia,
                (ShaftMode::Setpoint(old), ShaftMode::Setpoint(new)) => {
                    y_dot[omega] += (new - old) / SPEED_LAG
                }
                _ => {}
            }
        }
    }

    /// J_S ω_S/(J_P ω_P): ratio of the secondary's unbalanced torque to the primary's at which both
    /// speeds change in proportion.
    fn balanced_factor(&self, view: View<'_>) -> f64 {
        let [secondary, primary] = Pulley::BOTH.map(|j| self.of(j).inertia * self.speed(j, view));
        if primary == 0.0 { 0.0 } else { secondary / primary }
    }

    /// Drag of a shaft under this resultant of the contact forces on the belt, N.
    fn drag(&self, pulley: Pulley, view: View<'_>, resultant: [f64; 2]) -> Drag {
        self.of(pulley).drag.loads(self.speed(pulley, view), resultant)
    }

    /// Drag torques of the shafts, N·m, under these resultants of the contact forces on the belt,
    /// N.
    pub fn drag_torques(&self, view: View<'_>, resultants: PerPulley<[f64; 2]>) -> PerPulley<f64> {
        PerPulley::from_fn(|pulley| self.drag(pulley, view, resultants[pulley]).torque)
    }

    /// Torques of belt and drag on the shafts, N·m.
    fn shaft_torques(&self, loads: &PerPulley<PulleyLoad>, view: View<'_>) -> PerPulley<f64> {
        let drags = self.drag_torques(view, loads.map(|load| load.resultant));
        PerPulley::from_fn(|pulley| loads[pulley].torque - drags[pulley])
    }

    pub(crate) fn residual(
        &self,
        boundary: &Boundary,
        loads: &PerPulley<PulleyLoad>,
        view: View<'_>,
        out: &mut [f64],
    ) {
        let torques = self.shaft_torques(loads, view);
        for pulley in Pulley::BOTH {
            let z = self.layout().sheave(pulley);
            let motion = self.sheave_motion(pulley, view);
            let row = self.sheave_row(pulley, boundary.sheave[pulley], motion, loads[pulley].axial);
            out[z] = row.unwrap_or(CONSTRAINT_SCALE * view.y[z]);
            self.tilt_rows(pulley, &loads[pulley], view, out);
            let i = self.layout().shaft_speed(pulley);
            let mode = boundary.shaft[pulley];
            out[i] = self.shaft_row(pulley, mode, torques, view);
        }
    }

    /// Equation of motion of a sheave that is not held, under the force `axial` of the belt, N.
    fn sheave_row<T: Real>(
        &self,
        pulley: Pulley,
        mode: SheaveMode,
        motion: SheaveMotion<T>,
        axial: f64,
    ) -> Option<T> {
        let of = self.of(pulley);
        let force = match mode {
            SheaveMode::Force(force) => T::from(force),
            SheaveMode::Ratio { theta: set, force } => {
                (-motion.theta + set) * (CLOSING_SIGN[pulley] * RATIO_STIFFNESS) + force
            }
            SheaveMode::Held => return None,
        };
        let cylinder = of.cylinder.passive_force(motion.z, motion.omega)
            - of.cylinder.drag(motion.z_dot, self.parameters.friction.velocity);
        let stop = self.travel(pulley).stop_force(motion.z, motion.z_dot).force;
        Some(
            motion.z_ddot * of.sheave_mass + motion.z_dot * of.sheave_damping - (force + cylinder) + axial
                - stop,
        )
    }

    fn sheave_motion(&self, pulley: Pulley, view: View<'_>) -> SheaveMotion<f64> {
        let z = self.layout().sheave(pulley);
        SheaveMotion {
            z: view.q[z],
            z_dot: view.y[z],
            z_ddot: view.y_dot[z],
            omega: self.speed(pulley, view),
            theta: view.q[self.layout().theta()],
        }
    }

    fn tilt_law(&self, pulley: Pulley) -> Tilt {
        let own = self.of(pulley).tilt;
        let time = if self.is_steady { FORCE_TIME } else { own.time };
        Tilt { time, ..own }
    }

    fn tilt_rows(&self, pulley: Pulley, load: &PulleyLoad, view: View<'_>, out: &mut [f64]) {
        let law = self.tilt_law(pulley);
        let [psi, rate] = self.tilt(pulley, view);
        let moment = law.moment(psi, rate);
        for axis in 0..2 {
            let i = self.layout().tilt(pulley, axis);
            out[i] = if law.is_rigid() {
                CONSTRAINT_SCALE * psi[axis]
            } else {
                moment[axis] - load.tilting[axis]
            };
        }
    }

    /// Equation of motion of a shaft; `torques` are those of belt and drag on the shafts, N·m.
    fn shaft_row(&self, pulley: Pulley, mode: ShaftMode, torques: PerPulley<f64>, view: View<'_>) -> f64 {
        let of = self.of(pulley);
        let i = self.layout().shaft_speed(pulley);
        let inertia = self.inertia_factor() * of.inertia * view.y_dot[i];
        match mode {
            ShaftMode::Torque(torque) => inertia - torque - torques[pulley],
            ShaftMode::Setpoint(set) => {
                inertia - self.inertia_factor() * of.inertia * (set - view.y[i]) / SPEED_LAG
            }
            ShaftMode::Fixed => inertia,
            ShaftMode::Balanced { own, primary } => {
                inertia - own - torques[pulley] + self.balanced_factor(view) * (primary + torques.primary)
            }
        }
    }

    /// Adds the derivatives of the pulleys' rows, with the factors α of ẏ and β of q. `out` already
    /// has the derivatives of the belt's loads, and `resultants` those of the resultants of its
    /// contact forces.
    pub(crate) fn jacobian(
        &self,
        boundary: &Boundary,
        loads: &PerPulley<PulleyLoad>,
        resultants: &ResultantDerivatives,
        view: View<'_>,
        factors: Factors,
        out: &mut Arrow,
    ) {
        for pulley in Pulley::BOTH {
            self.sheave_jacobian(pulley, boundary.sheave[pulley], view, factors, out);
            self.tilt_jacobian(pulley, view, factors.alpha, out);
            self.add_drag_jacobian(pulley, loads, resultants, view, out);
        }
        if let ShaftMode::Balanced { primary, .. } = boundary.shaft.secondary {
            let torque = primary + self.shaft_torques(loads, view).primary;
            self.balance_secondary(torque, view, out);
        }
        for pulley in Pulley::BOTH {
            let i = self.layout().shaft_speed(pulley);
            let inertia = self.inertia_factor() * self.of(pulley).inertia;
            let alpha = factors.alpha;
            match boundary.shaft[pulley] {
                ShaftMode::Setpoint(_) => out.set_unit_row(i, inertia * (alpha + 1.0 / SPEED_LAG)),
                ShaftMode::Fixed => out.set_unit_row(i, inertia * alpha.max(1.0)),
                _ => out.add(i, i, inertia * alpha),
            }
        }
    }

    /// Tilt of the sheaves of a pulley, rad, and its rate, rad/s.
    fn tilt(&self, pulley: Pulley, view: View<'_>) -> [[f64; 2]; 2] {
        let unknowns = [0, 1].map(|axis| self.layout().tilt(pulley, axis));
        [view.y, view.y_dot].map(|of| unknowns.map(|i| of[i]))
    }

    fn tilt_jacobian(&self, pulley: Pulley, view: View<'_>, alpha: f64, out: &mut Arrow) {
        let law = self.tilt_law(pulley);
        let unknowns = [0, 1].map(|axis| self.layout().tilt(pulley, axis));
        if law.is_rigid() {
            unknowns.iter().for_each(|&i| out.set_unit_row(i, CONSTRAINT_SCALE));
            return;
        }
        let [psi, rate] = self.tilt(pulley, view);
        let seeded = |tilt: [f64; 2], slope| {
            std::array::from_fn(|axis| Tangent::<2, f64>::seed(tilt[axis], axis, slope))
        };
        let moments = law.moment(seeded(psi, 1.0), seeded(rate, alpha));
        for (row, moment) in unknowns.into_iter().zip(moments) {
            for (column, slope) in unknowns.into_iter().zip(moment.eps) {
                out.add(row, column, slope);
            }
        }
    }

    fn add_drag_jacobian(
        &self,
        pulley: Pulley,
        loads: &PerPulley<PulleyLoad>,
        resultants: &ResultantDerivatives,
        view: View<'_>,
        out: &mut Arrow,
    ) {
        let row = self.layout().shaft_speed(pulley);
        let drag = self.drag(pulley, view, loads[pulley].resultant);
        out.add(row, row, drag.by_speed);
        if drag.by_resultant != [0.0; 2] {
            out.add_to_border_row(row, resultants.along(pulley, drag.by_resultant));
        }
    }

    fn sheave_jacobian(
        &self,
        pulley: Pulley,
        mode: SheaveMode,
        view: View<'_>,
        Factors { alpha, beta }: Factors,
        out: &mut Arrow,
    ) {
        let motion = self.sheave_motion(pulley, view);
        let layout = self.layout();
        let z = layout.sheave(pulley);
        let unknowns = [z, layout.shaft_speed(pulley), layout.theta()];
        let seed = Tangent::<3, f64>::seed;
        let seeded = SheaveMotion {
            z: seed(motion.z, 0, beta),
            z_dot: seed(motion.z_dot, 0, 1.0),
            z_ddot: seed(motion.z_ddot, 0, alpha),
            omega: seed(motion.omega, 1, 1.0),
            theta: seed(motion.theta, 2, beta),
        };
        match self.sheave_row(pulley, mode, seeded, 0.0) {
            Some(row) => unknowns
                .into_iter()
                .zip(row.eps)
                .for_each(|(unknown, slope)| out.add(z, unknown, slope)),
            None => out.set_unit_row(z, CONSTRAINT_SCALE),
        }
    }

    /// Derivatives of the row of a secondary shaft that is balanced against the primary one;
    /// `unbalanced` is the total torque on the latter, N·m.
    fn balance_secondary(&self, unbalanced: f64, view: View<'_>, out: &mut Arrow) {
        let [s, p] = [Pulley::Secondary, Pulley::Primary].map(|pulley| self.layout().shaft_speed(pulley));
        out.add_row(s, p, -self.balanced_factor(view));
        let omega = view.y[p];
        if omega != 0.0 {
            let inertias = self.parameters.primary.inertia * omega;
            out.add(s, s, unbalanced * self.parameters.secondary.inertia / inertias);
        }
    }

    /// Losses of sheave dampers, tilt relaxation and end stops, W.
    pub fn losses(&self, view: View<'_>) -> f64 {
        let mut loss = 0.0;
        for pulley in Pulley::BOTH {
            let of = self.of(pulley);
            let rate = view.y[self.layout().sheave(pulley)];
            loss += of.sheave_damping * rate * rate - self.stop(pulley, view).viscous * rate;
            if !of.tilt.is_rigid() {
                let [psi, rate] = self.tilt(pulley, view);
                loss += 2.0 * of.tilt.loss(psi, rate);
            }
        }
        loss
    }

    /// Loss of the tilt relaxation in a step of length `h`, s, beyond the trapezoidal rule, J: a
    /// sheave closes its clearance within a step.
    pub fn tilt_loss_beyond_trapezoid(
        &self,
        pulley: Pulley,
        before: View<'_>,
        after: View<'_>,
        h: f64,
    ) -> f64 {
        let law = &self.of(pulley).tilt;
        if law.is_rigid() {
            return 0.0;
        }
        let [start, end] = [before, after].map(|view| self.tilt(pulley, view));
        let [first, second] = [start, end].map(|[psi, rate]| law.moment(psi, rate));
        let work: f64 = (0..2)
            .map(|axis| 0.5 * (first[axis] + second[axis]) * (end[0][axis] - start[0][axis]))
            .sum();
        let lost = work - (law.energy(end[0]) - law.energy(start[0]));
        let trapezoid = 0.5 * h * (law.loss(start[0], start[1]) + law.loss(end[0], end[1]));
        // Both sheaves.
        2.0 * (lost - trapezoid)
    }

    /// Energy of rotation, axial motion, tilt, end stops and springs, J.
    pub fn energy(&self, view: View<'_>) -> f64 {
        let mut energy = 0.0;
        for pulley in Pulley::BOTH {
            let of = self.of(pulley);
            let z = self.layout().sheave(pulley);
            let omega = self.speed(pulley, view);
            energy += 0.5 * of.inertia * omega * omega
                + 0.5 * of.sheave_mass * view.y[z] * view.y[z]
                + self.travel(pulley).energy(view.q[z])
                + of.cylinder.energy(view.q[z]);
            if !of.tilt.is_rigid() {
                energy += 2.0 * of.tilt.energy(self.tilt(pulley, view)[0]);
            }
        }
        energy
    }

    /// External torque at a shaft, N·m, without the torque that accelerates it towards a set point;
    /// `torque` is that of belt and drag.
    fn torque_supplied(mode: ShaftMode, torque: f64) -> f64 {
        match mode {
            ShaftMode::Torque(external) | ShaftMode::Balanced { own: external, .. } => external,
            ShaftMode::Setpoint(_) | ShaftMode::Fixed => -torque,
        }
    }

    /// Loads from outside, where `torques` are those of belt and drag on the shafts, N·m, and
    /// `axial` the belt's forces on the sheaves, N.
    pub fn external(
        &self,
        boundary: &Boundary,
        view: View<'_>,
        torques: PerPulley<f64>,
        axial: PerPulley<f64>,
    ) -> PerPulley<External> {
        PerPulley::from_fn(|pulley| {
            let accelerating = match boundary.shaft[pulley] {
                ShaftMode::Setpoint(set) => {
                    self.of(pulley).inertia * (set - self.speed(pulley, view)) / SPEED_LAG
                }
                _ => 0.0,
            };
            External {
                torque: Self::torque_supplied(boundary.shaft[pulley], torques[pulley]) + accelerating,
                clamping: match boundary.sheave[pulley] {
                    SheaveMode::Force(force) => force + self.cylinder(pulley, view),
                    SheaveMode::Held | SheaveMode::Ratio { .. } => {
                        axial[pulley] - self.stop(pulley, view).force
                    }
                },
            }
        })
    }

    /// Power supplied at the shafts, W, without the power that accelerates a pulley in speed drive;
    /// `torques` are those of belt and drag.
    pub fn shaft_power(&self, boundary: &Boundary, view: View<'_>, torques: PerPulley<f64>) -> f64 {
        let power = |j| Self::torque_supplied(boundary.shaft[j], torques[j]) * self.speed(j, view);
        Pulley::BOTH.map(power).iter().sum()
    }
}
