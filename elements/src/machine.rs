//! A belt of single elements on two pulleys, and its step in time.
//!
//! A step is linearly implicit, in three sets of equations along the belt: speeds w of the steel
//! (tridiagonal), V of the elements along the belt (tridiagonal), U across it (the beam's five
//! diagonals). Contact, dampings, oil and friction are linear in the speeds after the step; each
//! pair of bodies gets the same force.

use crate::belt::{add, close, cross, dot};
use crate::cyclic::{Pentadiagonal, Tridiagonal};
use crate::{Belt, Cone, Law, Load, Pulley, Shaft, Vector};
use crate::{flanks::Flanks, pitch::Pitch, ring::Ring, stack::Stack};
use pushbelt::contact::energy_density;
use pushbelt::pulley::Travel;
use pushbelt::scalar::Real as _;
use pushbelt_archive::Archive;

/// Works and losses since the start, J, in the order of [`Ledger::NAMES`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger(pub [f64; 16]);

impl Ledger {
    /// Names of the entries. The first four are works from outside; all others are losses.
    pub const NAMES: &str = "work.secondary,work.primary,work.secondaryCone,work.primaryCone,\
        loss.secondarySheaves,loss.primarySheaves,loss.flankDamping,loss.ring,loss.oil,\
        loss.pushDamping,loss.ringDamping,loss.ringBending,loss.secondaryDrag,loss.primaryDrag,\
        loss.cones,loss.tilt";

    /// Sum of the works from outside.
    pub fn work(&self) -> f64 {
        self.0[..4].iter().sum()
    }

    /// Sum of the losses.
    pub fn losses(&self) -> f64 {
        self.0[4..].iter().sum()
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
    /// Step, s.
    pub dt: f64,
    /// Time, s.
    pub time: f64,
    /// Elements, and the steel at them.
    pub belt: Belt,
    /// Forces of the ring.
    pub ring: Ring,
    /// Forces of the gaps at rocking edges and at heads.
    pub stacks: [Stack; 2],
    /// Pegs and turning elements.
    pub pitch: Pitch,
    /// Forces of the flanks.
    pub flanks: Flanks,
    /// Secondary and primary pulley.
    pub pulleys: [Pulley; 2],
    /// What acts on them.
    pub drive: [(Shaft, Cone); 2],
    /// Loads of the belt on them in the last step.
    pub loads: [Load; 2],
    /// Works and losses.
    pub ledger: Ledger,
    /// Changes of w and of V + iU in the last step.
    changes: (Vec<f64>, Vec<Vector>),
    rows: [Vec<f64>; 3],
    three: Tridiagonal,
    five: Pentadiagonal,
}

impl Machine {
    /// A machine whose elements are at the points of a closed line, in the order of travel, at
    /// rest; `s` of the nodes such that the steel has the same strain everywhere.
    pub fn new(law: Law, dt: f64, points: impl Iterator<Item = Vector>) -> Self {
        let n = law.count;
        let mut machine = Self {
            dt,
            time: 0.0,
            belt: Belt::new(n),
            ring: Ring::new(n),
            stacks: [Stack::new(n), Stack::new(n)],
            pitch: Pitch::new(n),
            flanks: Flanks::default(),
            pulleys: [Pulley::default(); 2],
            drive: [(Shaft::Torque(0.0), Cone::Held); 2],
            loads: [Load::default(); 2],
            ledger: Ledger::default(),
            changes: (vec![0.0; n + 2], vec![Vector::default(); n + 2]),
            rows: [vec![0.0; n], vec![0.0; n], vec![0.0; n]],
            three: Tridiagonal::new(n),
            five: Pentadiagonal::new(n),
            law,
        };
        let (law, belt, ring) = (&machine.law, &mut machine.belt, &mut machine.ring);
        belt.p[1..=n].iter_mut().zip(points).for_each(|(p, point)| *p = point);
        belt.place(law.options.pitch);
        belt.turn.fill(0.0);
        ring.place(law, belt);
        let per_chord = law.parameters.geometry.belt_length / ring.length[1..=n].iter().sum::<f64>();
        for i in 1..n {
            belt.s[i + 1] = belt.s[i] + ring.length[i] * per_chord;
        }
        machine
    }

    /// One step.
    pub fn step(&mut self) {
        let (n, dt, law, belt) = (self.law.count, self.dt, &self.law, &mut self.belt);
        let (per_step, steel) = (1.0 / dt, law.parameters.geometry.belt_length);
        let free = law.options.pitch;
        belt.place(free);
        if !free {
            let turning = belt.turn.iter().map(|turn| turn * per_step);
            belt.spin.iter_mut().zip(turning).for_each(|(spin, rate)| *spin = rate);
        }
        close(&mut belt.v);
        close(&mut belt.w);
        (belt.s[0], belt.s[n + 1]) = (belt.s[n] - steel, belt.s[1] + steel);
        self.ring.place(law, belt);
        self.stacks[0].evaluate(law, dt, belt, 0.0);
        self.ring.evaluate(law, dt, belt);
        self.flanks.evaluate(law, &self.pulleys, belt);

        let (dw, dv) = (&mut self.changes.0[..n + 2], &mut self.changes.1[..n + 2]);
        let [diagonal, off, right] = self.rows.each_mut().map(|row| &mut row[..n]);
        self.ring.rows(law, dt, belt, [diagonal, off, right]);
        self.three.solve(diagonal, off, right);
        dw[1..=n].copy_from_slice(right);
        close(dw);
        add(&mut belt.w, dw.iter().copied());
        self.ring.correct(law, belt, dw);

        if free {
            self.stacks[1].evaluate(law, dt, belt, law.options.head);
            self.pitch.evaluate(law, dt, belt);
            let of = (&self.stacks, &self.ring, &self.flanks.of[..]);
            self.pitch.rows(law, dt, belt, of, [diagonal, off, right]);
            self.three.solve(diagonal, off, right);
            self.pitch.correct(law, belt, &mut self.stacks, right);
        }
        let arm = 0.5 / law.thickness;
        let (flank, ring_turn) = (&self.flanks.of[..n + 2], &self.ring.turn[..n + 2]);
        cut!(n + 2; self.pitch => peg, spun);
        cut!(n + 2; belt => v, w, t, turn, normal);
        cut!(n + 2; self.ring => drag, couple, force, mass);
        for k in 0..n {
            let i = k + 1;
            (diagonal[k], off[k]) = (law.mass * per_step + flank[i].slope[0], 0.0);
            // o of a neighbour has a component along t.
            let bend = |a: usize| cross(t[a + 1], t[a]);
            let turned = arm * (couple[k] * bend(k) + couple[i + 1] * bend(i));
            let pegs = peg[i] * cross(t[i], normal[i]) - peg[k] * cross(t[i], normal[k]);
            right[k] = flank[i].force.re + drag[i] + turned + pegs
                - law.mass * v[i].im * turn[i] * per_step
                - flank[i].spin[0] * spun[i];
        }
        for stack in &self.stacks {
            stack.rows(law, belt, [diagonal, off, right]);
        }
        self.three.solve(diagonal, off, right);
        for (dv, change) in dv[1..=n].iter_mut().zip(&*right) {
            dv.re = *change;
        }
        close(dv);
        self.stacks.iter_mut().for_each(|stack| stack.correct(dv));

        let [edges, heads] = self.stacks.each_ref().map(|stack| &stack.push[..n + 2]);
        for k in 0..n {
            let i = k + 1;
            let pushed =
                |c: usize| (edges[c] + heads[c]) * cross(t[i], normal[c]) + peg[c] * dot(t[i], normal[c]);
            let [_, mixed, own] = flank[i].slope;
            diagonal[k] = (law.mass + mass[i]) * per_step + own;
            right[k] = pushed(k) - pushed(i) + force[i].im + flank[i].force.im
                - mixed * dv[i].re
                - flank[i].spin[1] * spun[i]
                + arm * (couple[i + 1] - couple[k])
                + law.mass * (v[i].re + dv[i].re) * turn[i] * per_step
                + mass[i] * w[i] * ring_turn[i];
        }
        self.five.solve(diagonal, law.bending_slope(dt), right);
        for (dv, change) in dv[1..=n].iter_mut().zip(&*right) {
            dv.im = *change;
        }
        close(dv);
        belt.v.iter_mut().zip(&*dv).for_each(|(v, change)| *v += change);

        self.loads = self.flanks.loads(law, dt, dv, &self.pitch.spun);
        self.add_losses();
        self.advance();
    }

    /// Moves elements, nodes and pulleys by the speeds after the step.
    fn advance(&mut self) {
        let (n, dt, e) = (self.law.count, self.dt, self.law.parameters.belt.pitch_offset);
        let per_step = 1.0 / dt;
        cut!(n + 1; self.belt => v, w, t, turn, spin);
        cut!(n + 1; mut self.belt => p, s, pitch);
        cut!(n + 1; self.ring => length, steel);
        for i in 1..=n {
            let half = 0.5 * turn[i];
            // t' = t cos − o sin, o' = o cos + t sin.
            let turned = v[i] * Vector::new(1.0 - 0.5 * half * half, -half);
            p[i] += dt * (turned * t[i]);
            let shrink = (steel[i] + steel[i - 1]) / (length[i] + length[i - 1]);
            pitch[i] += dt * spin[i];
            s[i] += dt * (v[i].re + e * turn[i] * per_step - w[i]) * shrink;
        }
        for (j, of) in self.law.pulleys().into_iter().enumerate() {
            let work = self.pulleys[j].step(of, &self.loads[j], self.drive[j], dt);
            for (entry, energy) in [j, 2 + j, 12 + j, 14, 15].into_iter().zip(work) {
                self.ledger.0[entry] += energy;
            }
        }
        self.time += dt;
    }

    /// Adds the losses of the step.
    fn add_losses(&mut self) {
        let (n, of) = (self.law.count, &self.law.parameters.ring);
        cut!(n + 1; self.ring => friction, drag, steel, angle_rate, mass);
        let stretched = &self.ring.rate[..n + 1];
        let [mut rubbed, mut stretch, mut bend] = [0.0; 3];
        for i in 1..=n {
            rubbed += drag[i] * drag[i] / friction[i].max(f64::MIN_POSITIVE);
            stretch += stretched[i] * stretched[i] / steel[i];
            bend += angle_rate[i] * angle_rate[i] / mass[i];
        }
        stretch *= of.axial_stiffness * of.damping;
        bend *= of.bending_stiffness * self.law.options.curvature_damping * of.mass_per_length;
        let [s, p] = &self.loads;
        let viscous = s.viscous + p.viscous;
        let [edges, heads] = self.stacks.each_ref().map(Stack::losses);
        let (oiled, damped) = (edges[0] + heads[0], edges[1] + heads[1] + self.pitch.loss());
        let powers = [s.friction, p.friction, viscous, rubbed, oiled, damped, stretch, bend];
        add(&mut self.ledger.0[4..12], powers.map(|power| self.dt * power));
    }

    /// Stored energy, J: motion of elements and ring, stack, stretch, bending, flanks, pulleys.
    pub fn energy(&self) -> f64 {
        let (law, belt, ring) = (&self.law, &self.belt, &self.ring);
        let (of, contact) = (&law.parameters.ring, &law.parameters.contact);
        let mut energy = 0.0;
        for i in 1..=law.count {
            let (v, u, w) = (belt.v[i].re, belt.v[i].im, belt.w[i]);
            energy += 0.5 * (law.mass * (v * v + u * u) + ring.mass[i] * (w * w + u * u));
            let strain = ring.length[i] / ring.steel[i] - 1.0;
            energy += 0.5 * of.axial_stiffness * strain * strain * ring.steel[i];
            let bent = 0.5 * of.bending_stiffness * ring.angle[i].powi(2);
            energy += bent * of.mass_per_length / ring.mass[i];
        }
        for touch in &self.flanks.touches {
            let penetration = touch.motion.penetration;
            let depth = penetration.soft_plus(contact.roughness).value;
            let density = energy_density(contact, law.wedge.cos, penetration, depth);
            energy += 2.0 * touch.share * law.thickness * density;
        }
        energy += Stack::energy(law, belt, 0.0);
        if law.options.pitch {
            energy += Stack::energy(law, belt, law.options.head) + Pitch::energy(law, belt);
        }
        let of = |j: usize| self.pulleys[j].energy(law.pulleys()[j], self.drive[j].0);
        energy + (of(0) + of(1))
    }

    /// Checks the state.
    ///
    /// # Errors
    /// An element has left the belt, a gap is wider than an element is thick, the step was too
    /// large, or a cone is at its stop.
    pub fn check(&self) -> Result<(), Fault> {
        let (law, belt, time, dt) = (&self.law, &self.belt, self.time, self.dt);
        let fault = |element, cause| Err(Fault { element, time, cause });
        for i in 1..=law.count {
            let (p, v, gap) = (belt.p[i], belt.v[i], belt.length[i] - law.thickness);
            let cause = if !(p + v + belt.w[i] + belt.s[i]).is_finite() {
                format!("its state is no number; a step smaller than {dt} s may do")
            } else if v.im.abs() > LOST {
                let speed = v.im;
                format!("it leaves the belt at {speed:.1} m/s; a step smaller than {dt} s may hold it")
            } else if !(-0.1 * law.thickness..=law.thickness).contains(&gap) {
                let gap = 1e3 * gap;
                format!("the gap behind it is {gap:.3} mm: the belt is torn or the step too large")
            } else {
                continue;
            };
            return fault(i, cause);
        }
        for (j, (name, of)) in ["secondary", "primary"].into_iter().zip(law.pulleys()).enumerate() {
            let travel = Travel::new(of.min_radius..=of.max_radius, law.r0, &law.wedge);
            let is_free = (travel.open..=travel.closed).contains(&self.pulleys[j].z);
            if !is_free && self.drive[j].1 != Cone::Held {
                // The element in the middle of the arc.
                let outward = |i: &usize| (2.0 * j as f64 - 1.0) * belt.p[*i].re;
                let at = (1..=law.count).max_by(|a, b| outward(a).total_cmp(&outward(b)));
                let cause = format!("the {name} sheaves reach their stop: no steady state");
                return fault(at.unwrap_or(1), cause);
            }
        }
        Ok(())
    }

    /// Writes what changes in a run to an archive, or reads it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let (belt, contact) = (&mut self.belt, &mut self.ring.contact);
        let vectors = [&mut belt.p, &mut belt.v, &mut belt.t].into_iter().flatten();
        for value in vectors.flat_map(|vector| [&mut vector.re, &mut vector.im]) {
            archive.real(value);
        }
        for row in [&mut belt.w, &mut belt.s, &mut belt.pitch, &mut belt.spin, contact] {
            archive.reals(row);
        }
        for (p, load) in self.pulleys.iter_mut().zip(&mut self.loads) {
            let speeds = [&mut p.omega, &mut p.z, &mut p.z_dot].into_iter();
            let pairs = [&mut p.tilt, &mut p.tilt_rate, &mut load.weight].into_iter();
            speeds.chain(pairs.flatten()).for_each(|value| archive.real(value));
        }
        archive.reals(&mut self.ledger.0);
        archive.real(&mut self.time);
        archive.real(&mut self.dt);
    }
}
