//! Shafts, cones and their tilt.
//!
//! J ω̇ = T + torque of the belt − drag; m_z z̈ = F − axial force − d_z ż; tilt of a sheave
//! (M/a)(ψ + τ ψ̇) = moment, by [`pushbelt::tilt`]. The last is implicit in ψ̇, since the contact
//! is stiffer than the sheave. Both sheaves of a pulley tilt alike. Cylinders, seals and the
//! springs of end stops are not in this model: a cone that reaches an end stop ends the run.

use crate::belt::{Vector, add};
use pushbelt::variator::settings::PulleyParameters;

/// What the belt does to a pulley, and what it loses there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Load {
    /// Axial force on a sheave, N.
    pub axial: f64,
    /// Torque, N·m.
    pub torque: f64,
    /// Moment on a sheave, N·m.
    pub tilting: Vector,
    /// Its fall with ψ̇ in the step: xx, xy, yy, N·m·s.
    pub resistance: [f64; 3],
    /// Resultant on the belt, N.
    pub resultant: Vector,
    /// Sum of the normal forces of a flank, N, and of them times ϱ of their rocking edges, N·m.
    pub weight: [f64; 2],
    /// Power of friction, W.
    pub friction: f64,
    /// Power of damping, W.
    pub viscous: f64,
}

/// State of a pulley.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pulley {
    /// ω, rad/s.
    pub omega: f64,
    /// Closing z of the sheaves, m: 0 at ratio 1, unloaded.
    pub z: f64,
    /// ż, m/s.
    pub z_dot: f64,
    /// ψ_x, ψ_y, rad.
    pub tilt: [f64; 2],
    /// Their rates, rad/s.
    pub tilt_rate: [f64; 2],
}

/// What acts on a shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shaft {
    /// The speed stays.
    Speed,
    /// A torque, N·m.
    Torque(f64),
}

/// What acts on a cone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cone {
    /// It stands.
    Held,
    /// A clamping force, N.
    Force(f64),
    /// It moves at this speed, m/s, whatever force that takes.
    Speed(f64),
}

impl Pulley {
    /// A step under the belt's load. Returns works and losses, J: at the shaft, on the cone, by
    /// drag of the shaft, damping of the cone, relaxation of the tilt.
    pub fn step(&mut self, of: &PulleyParameters, load: &Load, drive: (Shaft, Cone), dt: f64) -> [f64; 5] {
        let drag = of.drag.loads(self.omega, [load.resultant.re, load.resultant.im]).torque;
        let before = self.omega;
        let torque = match drive.0 {
            Shaft::Speed => drag - load.torque,
            Shaft::Torque(torque) => {
                self.omega += dt / of.inertia * (torque + load.torque - drag);
                torque
            }
        };
        let omega = 0.5 * (before + self.omega);
        let before = self.z_dot;
        self.z_dot = match drive.1 {
            Cone::Held => 0.0,
            Cone::Speed(speed) => speed,
            Cone::Force(force) => {
                let inertia = of.sheave_mass / dt;
                (inertia * before + force - load.axial) / (inertia + of.sheave_damping)
            }
        };
        let damping = of.sheave_damping * self.z_dot;
        let closing = load.axial + damping + of.sheave_mass / dt * (self.z_dot - before);
        let middle = 0.5 * (before + self.z_dot);
        self.z += dt * self.z_dot;
        [
            dt * torque * omega,
            dt * closing * middle,
            dt * drag * omega,
            dt * of.sheave_damping * self.z_dot * middle,
            self.tilt_step(of, load, dt),
        ]
    }

    /// ψ̇ from s (ψ + (τ + Δt) ψ̇) + G (ψ̇ − ψ̇₀) = m. Returns the work lost, J.
    fn tilt_step(&mut self, of: &PulleyParameters, load: &Load, dt: f64) -> f64 {
        if of.tilt.is_rigid() {
            return 0.0;
        }
        let secant = of.tilt.secant(self.tilt);
        let [xx, xy, yy] = load.resistance;
        let old = self.tilt_rate;
        let right = [
            load.tilting.re - secant * self.tilt[0] + xx * old[0] + xy * old[1],
            load.tilting.im - secant * self.tilt[1] + xy * old[0] + yy * old[1],
        ];
        let own = secant * (of.tilt.time + dt);
        let (a, d) = (own + xx, own + yy);
        let determinant = a * d - xy * xy;
        self.tilt_rate = [
            (d * right[0] - xy * right[1]) / determinant,
            (a * right[1] - xy * right[0]) / determinant,
        ];
        add(&mut self.tilt, self.tilt_rate.map(|rate| dt * rate));
        2.0 * dt * of.tilt.loss(self.tilt, self.tilt_rate)
    }

    /// Stored energy, J, without that of a shaft whose speed is given.
    pub fn energy(&self, of: &PulleyParameters, shaft: Shaft) -> f64 {
        let inertia = if shaft == Shaft::Speed { 0.0 } else { of.inertia };
        let tilt = &of.tilt;
        let tilted = if tilt.is_rigid() { 0.0 } else { tilt.energy(self.tilt) };
        0.5 * inertia * self.omega * self.omega
            + 2.0 * tilted
            + 0.5 * of.sheave_mass * self.z_dot * self.z_dot
    }
}
