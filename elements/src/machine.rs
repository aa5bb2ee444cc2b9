//! A belt of single elements on two pulleys, and its step in time.
//!
//! A step is linearly implicit, in three sets of equations along the belt: speeds w of the steel (tridiagonal), V of the
//! elements along the belt (tridiagonal), U across it (the beam's five diagonals). Contact, dampings, oil and friction are linear in the
//! speeds after the step; each pair of bodies gets the same force.

use crate::cyclic::{Pentadiagonal, Tridiagonal};
use crate::flanks::{Flanks, Load};
use crate::frames::{Chords, Frames, close};
use crate::law::Law;
use crate::pulleys::{Cone, Pulley, Shaft};
use crate::ring::Ring;
use crate::stack::Stack;
use pushbelt::contact::energy_density;
use pushbelt::scalar::Real as _;
use pushbelt::variator::settings::Parameters;
use pushbelt_archive::Archive;

/// Works and losses since the start, J, in the order of [`Ledger::NAMES`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger(pub [f64; Ledger::NAMES.len()]);

impl Ledger {
    /// Names of the entries. The first four are works from outside; all others are losses.
    pub const NAMES: [&str; 16] = [
        "work.secondary",
        "work.primary",
        "work.secondaryCone",
        "work.primaryCone",
        "loss.secondarySheaves",
        "loss.primarySheaves",
        "loss.flankDamping",
        "loss.ring",
        "loss.oil",
        "loss.pushDamping",
        "loss.ringDamping",
        "loss.ringBending",
        "loss.secondaryDrag",
        "loss.primaryDrag",
        "loss.cones",
        "loss.tilt",
    ];

    /// Sum of the works from outside.
    #[must_use]
    pub fn work(&self) -> f64 {
        self.0[..4].iter().sum()
    }

    /// Sum of the losses.
    #[must_use]
    pub fn losses(&self) -> f64 {
        self.0[4..].iter().sum()
    }

    /// What has been added since an earlier one.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        Self(std::array::from_fn(|k| self.0[k] - before.0[k]))
    }
}

/// Why a run can't go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("element {element} at {time:.6} s: {cause}")]
pub struct Fault {
    /// The element, 1 to N.
    pub element: usize,
    /// Time, s.
    pub time: f64,
    /// What happened.
    pub cause: String,
}

/// Speed across the belt at which an element counts as lost, m/s.
const LOST: f64 = 20.0;

/// The machine.
#[derive(Clone, Debug)]
pub struct Machine {
    /// Constants.
    pub law: Law,
    /// Parameters of the pulleys, secondary and primary.
    pub parameters: Parameters,
    /// Step, s.
    pub dt: f64,
    /// Time, s.
    pub time: f64,
    /// Rocking edges, m.
    pub x: Vec<f64>,
    /// y.
    pub y: Vec<f64>,
    /// Speeds of the elements along t and o, m/s.
    pub v: Vec<f64>,
    /// Along o.
    pub u: Vec<f64>,
    /// Speed of the steel, m/s.
    pub w: Vec<f64>,
    /// Place of the nodes in the steel, m.
    pub s: Vec<f64>,
    /// Frames.
    pub frames: Frames,
    /// Chords between rocking edges.
    pub chords: Chords,
    /// Forces of the ring.
    pub ring: Ring,
    /// Forces of the gaps.
    pub stack: Stack,
    /// Forces of the flanks.
    pub flanks: Flanks,
    /// Secondary and primary pulley.
    pub pulleys: [Pulley; 2],
    /// What acts on them.
    pub drive: [(Shaft, Cone); 2],
    /// Loads of the belt on them in the last step.
    pub loads: [Load; 2],
    /// Closing forces in the last step, N.
    pub closing: [f64; 2],
    /// Works and losses.
    pub ledger: Ledger,
    changes: [Vec<f64>; 3],
    rows: [Vec<f64>; 3],
    three: Tridiagonal,
    five: Pentadiagonal,
}

impl Machine {
    /// A machine whose elements are at the points of a closed line, in the order of travel, at rest; `s` of the nodes such that the steel
    /// has the same strain everywhere.
    #[must_use]
    pub fn new(law: Law, parameters: Parameters, dt: f64, points: &[[f64; 2]]) -> Self {
        let n = law.count;
        let zero = || vec![0.0; n + 2];
        let mut machine = Self {
            parameters,
            dt,
            time: 0.0,
            x: zero(),
            y: zero(),
            v: zero(),
            u: zero(),
            w: zero(),
            s: zero(),
            frames: Frames::new(n),
            chords: Chords::new(n),
            ring: Ring::new(n),
            stack: Stack::new(n),
            flanks: Flanks::new(n),
            pulleys: [Pulley::default(); 2],
            drive: [(Shaft::Torque(0.0), Cone::Held); 2],
            loads: [Load::default(); 2],
            closing: [0.0; 2],
            ledger: Ledger::default(),
            changes: [zero(), zero(), zero()],
            rows: [vec![0.0; n], vec![0.0; n], vec![0.0; n]],
            three: Tridiagonal::new(n),
            five: Pentadiagonal::new(n),
            law,
        };
        for (i, [x, y]) in points.iter().enumerate().take(n) {
            (machine.x[i + 1], machine.y[i + 1]) = (*x, *y);
        }
        machine.place();
        machine.frames.turn.fill(0.0);
        machine
            .ring
            .place(&machine.law, &machine.frames, [&machine.x, &machine.y]);
        let length = &machine.ring.chords.length;
        let per_chord = machine.law.ring.length / length[1..=n].iter().sum::<f64>();
        let mut place = 0.0;
        for (place_of, length) in machine.s[1..=n].iter_mut().zip(&length[1..]) {
            *place_of = place;
            place += length * per_chord;
        }
        machine
    }

    /// Copies, chords and frames.
    fn place(&mut self) {
        close(&mut self.x);
        close(&mut self.y);
        self.chords.evaluate(&self.x, &self.y);
        self.frames.evaluate(&self.chords);
    }

    /// One step.
    pub fn step(&mut self) {
        let (n, dt) = (self.law.count, self.dt);
        let per_step = 1.0 / dt;
        self.place();
        for speeds in [&mut self.v, &mut self.u, &mut self.w] {
            close(speeds);
        }
        (self.s[0], self.s[n + 1]) = (self.s[n] - self.law.ring.length, self.s[1] + self.law.ring.length);
        let law = &self.law;
        self.ring.place(law, &self.frames, [&self.x, &self.y]);
        self.stack
            .evaluate(law, dt, &self.chords, &self.frames, [&self.v, &self.u]);
        self.ring
            .evaluate(law, dt, &self.frames, [&self.v, &self.u, &self.w, &self.s]);
        self.flanks
            .evaluate(law, &self.pulleys, &self.frames, [&self.x, &self.y, &self.v, &self.u]);

        let [dw, dv, du] = &mut self.changes;
        let [diagonal, off, right] = &mut self.rows;
        self.ring.rows(
            law,
            dt,
            &self.frames,
            [&self.v, &self.u, &self.w],
            [diagonal, off, right],
        );
        self.three.solve(diagonal, off, right);
        spread(right, dw, &mut self.w);
        self.ring.correct(law, dt, &self.frames, [&self.v, &self.w, dw]);

        let couple = 0.5 * law.ring.lever / law.thickness;
        let all = n + 2;
        let (tx, ty, turn) = (&self.frames.tx[..all], &self.frames.ty[..all], &self.frames.turn[..all]);
        let (cx, cy) = (&self.chords.x[..all], &self.chords.y[..all]);
        let (flank, drag) = (&self.flanks.slope[..all], &self.ring.drag[..all]);
        let (along, across) = (&self.flanks.along[..all], &self.flanks.across[..all]);
        {
            let u = &self.u[..all];
            let (diagonal, right) = (&mut diagonal[..n], &mut right[..n]);
            for k in 0..n {
                let i = k + 1;
                diagonal[k] = law.mass * per_step + flank[i][0];
                // o of a neighbour has a component along t.
                let bend = |a: usize| ty[a] * tx[a + 1] - tx[a] * ty[a + 1];
                let turned = couple * (drag[k] * bend(k) + drag[i + 1] * bend(i));
                right[k] = along[i] + drag[i] + turned - law.mass * u[i] * turn[i] * per_step;
            }
        }
        self.stack.rows(law, &self.chords, &self.frames, [diagonal, off, right]);
        self.three.solve(diagonal, off, right);
        spread(right, dv, &mut self.v);
        self.stack.correct(dv);

        {
            let (push, v, w, dv) = (&self.stack.push[..all], &self.v[..all], &self.w[..all], &dv[..all]);
            let (ring, mass, ring_turn) = (&self.ring.across[..all], &self.ring.mass[..all], &self.ring.turn[..all]);
            let (diagonal, right) = (&mut diagonal[..n], &mut right[..n]);
            for k in 0..n {
                let i = k + 1;
                let pushed = |c: usize| push[c] * (cy[c] * tx[i] - cx[c] * ty[i]);
                let [_, mixed, own] = flank[i];
                diagonal[k] = (law.mass + mass[i]) * per_step + own;
                right[k] = pushed(k) - pushed(i) + ring[i] + across[i] - mixed * dv[i]
                    + couple * (drag[i + 1] - drag[k])
                    + law.mass * v[i] * turn[i] * per_step
                    + mass[i] * w[i] * ring_turn[i];
            }
        }
        let bending = (dt + law.ring.curvature_damping) * law.ring.bending_stiffness / law.thickness.powi(3);
        self.five.solve(diagonal, bending, right);
        spread(right, du, &mut self.u);

        self.loads = self.flanks.loads(law, dt, [dv, du]);
        self.book();
        self.advance();
    }

    /// Moves elements, nodes and pulleys by the speeds after the step.
    fn advance(&mut self) {
        let (n, dt, e) = (self.law.count, self.dt, self.law.ring.offset);
        let per_step = 1.0 / dt;
        let all = n + 2;
        let [v, u, w] = [&self.v, &self.u, &self.w].map(|row| &row[..all]);
        let [tx, ty, turn] = [&self.frames.tx, &self.frames.ty, &self.frames.turn].map(|row| &row[..all]);
        let [length, steel] = [&self.ring.chords.length, &self.ring.steel].map(|row| &row[..all]);
        let (x, y, s) = (&mut self.x[..all], &mut self.y[..all], &mut self.s[..all]);
        for i in 1..=n {
            let half = 0.5 * turn[i];
            let cos = 1.0 - 0.5 * half * half;
            // t' = t cos − o sin, o' = o cos + t sin.
            let (along, across) = (v[i] * cos + u[i] * half, u[i] * cos - v[i] * half);
            x[i] += dt * (along * tx[i] - across * ty[i]);
            y[i] += dt * (along * ty[i] + across * tx[i]);
            let shrink = (steel[i] + steel[i - 1]) / (length[i] + length[i - 1]);
            s[i] += dt * (v[i] + e * turn[i] * per_step - w[i]) * shrink;
        }
        let parameters = [&self.parameters.secondary, &self.parameters.primary];
        for (j, parameters) in parameters.into_iter().enumerate() {
            let (work, closing) = self.pulleys[j].step(parameters, &self.loads[j], self.drive[j], dt);
            self.closing[j] = closing;
            self.ledger.0[j] += work.shaft;
            self.ledger.0[2 + j] += work.cone;
            self.ledger.0[12 + j] += work.drag;
            self.ledger.0[14] += work.damping;
            self.ledger.0[15] += work.tilt;
        }
        self.time += dt;
    }

    /// Adds the losses of the step.
    fn book(&mut self) {
        let (n, law) = (self.law.count, &self.law);
        let (all, ring) = (self.law.count + 1, &self.ring);
        let [friction, rubbed, stretched, steel] =
            [&ring.friction, &ring.drag, &ring.rate, &ring.steel].map(|row| &row[..all]);
        let [angle_rate, mass] = [&ring.angle_rate, &ring.mass].map(|row| &row[..all]);
        let [closing, oiled, damped] = [&self.stack.rate, &self.stack.oil, &self.stack.damping].map(|row| &row[..all]);
        let (mut drag, mut oil, mut push, mut stretch, mut bend) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for i in 1..=n {
            drag += rubbed[i] * rubbed[i] / friction[i].max(f64::MIN_POSITIVE);
            let square = closing[i] * closing[i];
            oil += oiled[i] * square;
            push += damped[i] * square;
            stretch += stretched[i] * stretched[i] / steel[i];
            bend += angle_rate[i] * angle_rate[i] / mass[i];
        }
        let ring = &law.ring;
        stretch *= ring.axial_stiffness * ring.damping;
        bend *= ring.bending_stiffness * ring.curvature_damping * ring.mass_per_length;
        let viscous = self.loads[0].viscous + self.loads[1].viscous;
        let powers = [
            self.loads[0].friction,
            self.loads[1].friction,
            viscous,
            drag,
            oil,
            push,
            stretch,
            bend,
        ];
        for (entry, power) in self.ledger.0[4..12].iter_mut().zip(powers) {
            *entry += self.dt * power;
        }
    }

    /// Stored energy by part, J: motion of elements and ring, stack, stretch, bending, flanks, pulleys.
    #[must_use]
    pub fn energies(&self) -> [f64; 6] {
        let (n, law) = (self.law.count, &self.law);
        let mut parts = [0.0; 6];
        for i in 1..=n {
            let (v, u, w) = (self.v[i], self.u[i], self.w[i]);
            parts[0] += 0.5 * (law.mass * (v * v + u * u) + self.ring.mass[i] * (w * w + u * u));
            parts[1] += Stack::energy(law, self.chords.length[i]);
            let strain = self.ring.chords.length[i] / self.ring.steel[i] - 1.0;
            parts[2] += 0.5 * law.ring.axial_stiffness * strain * strain * self.ring.steel[i];
            parts[3] += 0.5 * law.ring.bending_stiffness * self.ring.angle[i].powi(2) * law.ring.mass_per_length
                / self.ring.mass[i];
        }
        for penetration in self.flanks.penetrations() {
            let [depth, ..] = penetration.soft_plus(law.contact.roughness);
            parts[4] += 2.0 * law.thickness * energy_density(&law.contact, law.wedge[1], penetration, depth);
        }
        let of = [&self.parameters.secondary, &self.parameters.primary];
        for (j, of) in of.into_iter().enumerate() {
            parts[5] += self.pulleys[j].energy(of, self.drive[j].0);
        }
        parts
    }

    /// Checks the state.
    ///
    /// # Errors
    /// An element has left the belt, a gap is wider than an element is thick, the step was too large, or a cone is at its stop.
    pub fn check(&self) -> Result<(), Fault> {
        let fault = |element: usize, cause: String| Fault {
            element,
            time: self.time,
            cause,
        };
        for i in 1..=self.law.count {
            let state = [self.x[i], self.y[i], self.v[i], self.u[i], self.w[i], self.s[i]];
            if state.iter().any(|value| !value.is_finite()) {
                let cause = format!("its state is no number; a step smaller than {} s may do", self.dt);
                return Err(fault(i, cause));
            }
            if self.u[i].abs() > LOST {
                let cause = format!(
                    "it leaves the belt at {:.1} m/s; a step smaller than {} s may hold it",
                    self.u[i], self.dt
                );
                return Err(fault(i, cause));
            }
            if self.chords.length[i] > 2.0 * self.law.thickness || self.chords.length[i] < 0.9 * self.law.thickness {
                let gap = 1e3 * (self.chords.length[i] - self.law.thickness);
                return Err(fault(
                    i,
                    format!("the gap behind it is {gap:.3} mm: the belt is torn or the step too large"),
                ));
            }
        }
        let of = [&self.parameters.secondary, &self.parameters.primary];
        for (j, name) in ["secondary", "primary"].into_iter().enumerate() {
            if self.pulleys[j].is_at_stop(of[j], self.law.r0, self.law.wedge[2]) && self.drive[j].1 != Cone::Held {
                let most = |i: &usize, k: &usize| self.x[*i].total_cmp(&self.x[*k]);
                let elements = 1..=self.law.count;
                let at = if j == 0 {
                    elements.min_by(most)
                } else {
                    elements.max_by(most)
                };
                return Err(fault(
                    at.unwrap_or(1),
                    format!("the {name} sheaves reach their stop: no steady state"),
                ));
            }
        }
        Ok(())
    }

    /// Writes what changes in a run to an archive, or reads it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.time);
        archive.real(&mut self.dt);
        let (ring, frames) = (&mut self.ring, &mut self.frames);
        for values in [
            &mut self.x,
            &mut self.y,
            &mut self.v,
            &mut self.u,
            &mut self.w,
            &mut self.s,
            &mut frames.tx,
            &mut frames.ty,
            &mut ring.contact,
        ] {
            archive.reals(values);
        }
        for p in &mut self.pulleys {
            for value in [&mut p.omega, &mut p.z, &mut p.z_dot]
                .into_iter()
                .chain(&mut p.tilt)
                .chain(&mut p.tilt_rate)
            {
                archive.real(value);
            }
        }
        for load in &mut self.loads {
            archive.reals(&mut load.weight);
        }
        archive.reals(&mut self.ledger.0);
    }
}

/// Adds a solution to the speeds, and keeps it with its copies.
fn spread(solution: &[f64], change: &mut [f64], speeds: &mut [f64]) {
    let n = solution.len();
    change[1..=n].copy_from_slice(solution);
    close(change);
    for (speed, change) in speeds.iter_mut().zip(change.iter()) {
        *speed += change;
    }
}
