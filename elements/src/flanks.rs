//! Contact of the elements with the sheaves: the law of [`pushbelt::contact`], at each element.
//!
//! An element has the length h of its thickness on each of its two flanks, at its rocking edge:
//! penetration g = z/2 − (ϱ − r_0) tan β − w, opening by tilt w = ϱ (ψ_x cos θ + ψ_y sin θ),
//! penetration rate ġ, sliding v_t = v·e_t − ω ϱ and v_f = v·e_r cos β + (ż/2 − ẇ − ω ∂w/∂θ) sin β,
//! as there; N and friction f from that law times h. In polar directions
//!
//! F_r = 2 [N cos β (tan β + ∂w/∂ϱ) + f_f cos β], F_t = 2 [N cos β ∂w/∂θ/ϱ + f_t];
//!
//! on the pulley: axial force N cos β − f_f sin β on each sheave, its moment ϱ (cos θ, sin θ),
//! torque −2 ϱ (f_t + f_f sin β ∂w/∂θ/ϱ).
//!
//! With free [`pitch`](crate::pitch) a flank touches at two heights y, at p + y b, of the speed
//! v + y Π a, where ϱ − y takes the place of ϱ in g.
//!
//! In a step N is linear in ġ, with its damping, and friction is −c (v_t, v_f) with the secant c of
//! the step before. What belt and pulley get are the forces at the speeds after the step.

use crate::belt::{add, dot};
use crate::{Belt, Law, Load, Pulley, Vector};
use pushbelt::contact::{FlankMotion, flank_force};
use pushbelt::scalar::{LANES, Lanes, Real as _};

/// Clearance in roughnesses from which a flank doesn't touch: e^−40.
const APART: f64 = 40.0;
/// Sliding below which the secant of the friction is that at rest, m/s.
const AT_REST: f64 = 1.0e-9;

/// An element that touches its sheaves.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Touch {
    element: usize,
    pulley: usize,
    /// Its motion with Π, along t and o, m.
    lever: Vector,
    /// Height above the rocking edge, m, and share of the flank.
    height: f64,
    pub(crate) share: f64,
    /// e_r·t and e_r·o.
    turned: Vector,
    /// cos θ, sin θ.
    around: Vector,
    rho: f64,
    /// tan β + ∂w/∂ϱ, ∂w/∂θ/ϱ.
    slopes: [f64; 2],
    /// Closing and sliding without the element's own speed; with it they are what counts.
    pub(crate) motion: FlankMotion<f64>,
    /// Elastic normal force of a flank, N.
    elastic: f64,
    /// ∂N/∂g, N/m.
    stiffness: f64,
    /// ∂N/∂ġ, N·s/m.
    damping: f64,
    /// c, N·s/m.
    drag: f64,
}

/// Force of an element on its flanks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flank {
    /// Along t and o, N.
    pub force: Vector,
    /// Its fall with V and U: tt, to, oo, N·s/m.
    pub slope: [f64; 3],
    /// Couple about the rocking edge, N·m.
    pub moment: f64,
    /// Fall with Π: of both forces, N·s, and of the couple, N·m·s.
    pub spin: [f64; 3],
    /// Normal force of a flank, N.
    pub normal: f64,
    /// Sliding speed, m/s.
    pub sliding: f64,
}

/// Forces of the flanks.
#[derive(Clone, Debug, Default)]
pub struct Flanks {
    pub(crate) touches: Vec<Touch>,
    /// Of each element.
    pub of: Vec<Flank>,
}

impl Flanks {
    /// The law at these places and speeds.
    pub fn evaluate(&mut self, law: &Law, pulleys: &[Pulley; 2], belt: &Belt) {
        self.of.clear();
        self.of.resize(law.count + 2, Flank::default());
        self.touches.clear();
        self.find(law, pulleys, belt);
        let (contact, friction, cos_beta) =
            (&law.parameters.contact, &law.parameters.friction, law.wedge.cos);
        for pack in self.touches.chunks_mut(LANES) {
            let last = pack.len() - 1;
            let motions: [_; LANES] = std::array::from_fn(|k| pack[k.min(last)].motion);
            let motion = FlankMotion {
                penetration: Lanes::new(motions.map(|m| m.penetration)),
                // With unit damping, the viscous force is ∂N/∂g.
                penetration_rate: Lanes::from(1.0),
                tangential: Lanes::new(motions.map(|m| m.tangential)),
                along_flank: Lanes::new(motions.map(|m| m.along_flank)),
            };
            let force = flank_force(&law.unit_damped, friction, cos_beta, &motion);
            let square = motion.tangential * motion.tangential + motion.along_flank * motion.along_flank;
            let at_rest = force.depth * (contact.stiffness * cos_beta * friction.pulley / friction.velocity);
            let power = force.tangential * motion.tangential + force.along_flank * motion.along_flank;
            let moving = -power * (square + f64::MIN_POSITIVE).recip();
            let drag = (square - AT_REST * AT_REST).if_positive(moving, at_rest) * law.thickness;
            let elastic = force.depth * (contact.stiffness * cos_beta * law.thickness);
            let stiffness = force.viscous * law.thickness;
            let sliding = square.sqrt().to_array();
            let [drag, elastic, stiffness] = [drag, elastic, stiffness].map(Lanes::to_array);
            for (k, touch) in pack.iter_mut().enumerate() {
                let share = touch.share;
                (touch.drag, touch.elastic) = (share * drag[k], share * elastic[k]);
                touch.stiffness = share * stiffness[k];
                touch.damping = touch.stiffness * contact.damping;
                let (of, force) = (&mut self.of[touch.element], touch.forces(cos_beta, &touch.motion).0);
                let ([tt, to, oo], Vector { re: along, im: across }) = (touch.fall(cos_beta), touch.lever);
                let spin = [tt * along + to * across, to * along + oo * across];
                of.force += force;
                of.moment += dot(force, touch.lever);
                of.normal += touch.elastic;
                of.sliding = sliding[k];
                add(&mut of.slope, [tt, to, oo]);
                let couple = spin[0] * along + spin[1] * across;
                add(&mut of.spin, [spin[0], spin[1], couple]);
            }
        }
    }

    /// The elements that touch, and how they move on their sheaves.
    fn find(&mut self, law: &Law, pulleys: &[Pulley; 2], belt: &Belt) {
        let (sin_beta, cos_beta, tan_beta) = (law.wedge.sin, law.wedge.cos, law.wedge.tan);
        let middle = 0.5 * (law.axes[0] + law.axes[1]);
        let apart = -APART * law.unit_damped.roughness;
        let places = (1..=law.count).flat_map(|i| law.heights.iter().map(move |height| (i, *height)));
        for (i, (height, share)) in places {
            // It moves by height × a where the element turns.
            let turning = height * belt.axis[i] * belt.t[i].conj();
            let place = belt.p[i] + Vector::i() * turning * belt.t[i];
            let j = usize::from(place.re > middle);
            let p = &pulleys[j];
            let arm = place - law.axes[j];
            let square = arm.norm_sqr();
            let inverse = 1.0 / square.sqrt();
            let rho = square * inverse;
            let around = (arm * inverse).conj();
            let (cos, sin) = (around.re, around.im);
            let opening = p.tilt[0] * cos + p.tilt[1] * sin;
            let penetration = 0.5 * p.z - (rho - height - law.r0) * tan_beta - rho * opening;
            if penetration < apart {
                continue;
            }
            let slope = p.tilt[1] * cos - p.tilt[0] * sin;
            let surface = 0.5 * p.z_dot - rho * (p.tilt_rate[0] * cos + p.tilt_rate[1] * sin);
            let turned = (belt.t[i] * around).conj();
            let slopes = [tan_beta + opening, slope];
            let Vector { re: v_r, im: v_t } = polar(turned, belt.v[i] + turning * belt.spin[i]);
            let motion = FlankMotion {
                penetration,
                penetration_rate: surface - slopes[0] * v_r - slope * v_t,
                tangential: v_t - p.omega * rho,
                along_flank: v_r * cos_beta + (surface - p.omega * rho * slope) * sin_beta,
            };
            let mut touch = Touch::default();
            (touch.element, touch.pulley, touch.turned, touch.around) = (i, j, turned, around);
            (touch.lever, touch.height, touch.share) = (turning, height, share);
            (touch.rho, touch.slopes, touch.motion) = (rho, slopes, motion);
            self.touches.push(touch);
        }
    }

    /// What the pulleys get after the speeds have changed by `change`.
    pub fn loads(&self, law: &Law, dt: f64, change: &[Vector], spun: &[f64]) -> [Load; 2] {
        let (sin_beta, cos_beta) = (law.wedge.sin, law.wedge.cos);
        let mut loads = [Load::default(); 2];
        for touch in &self.touches {
            let motion = touch.moved(cos_beta, change[touch.element] + touch.lever * spun[touch.element]);
            let (force, [normal, tangential, flank]) = touch.forces(cos_beta, &motion);
            let (load, around) = (&mut loads[touch.pulley], touch.around);
            let axial = normal * cos_beta - flank * sin_beta;
            load.axial += axial;
            load.torque -= 2.0 * touch.rho * (tangential + flank * sin_beta * touch.slopes[1]);
            load.tilting += around * (axial * touch.rho);
            let stiff = (touch.damping + touch.stiffness * dt) * cos_beta + touch.drag * sin_beta * sin_beta;
            let stiff = stiff * touch.rho * touch.rho;
            let squares = [around.re * around.re, around.re * around.im, around.im * around.im];
            add(&mut load.resistance, squares.map(|part| stiff * part));
            // e_r = (cos θ, −sin θ), e_t = (−sin θ, −cos θ).
            load.resultant += (polar(touch.turned, force) * around).conj();
            load.weight[0] += touch.elastic;
            load.weight[1] += touch.elastic * (touch.rho - touch.height);
            load.friction -= 2.0 * (tangential * motion.tangential + flank * motion.along_flank);
            load.viscous +=
                2.0 * touch.damping * cos_beta * motion.penetration_rate * motion.penetration_rate;
        }
        loads
    }
}

/// Components along e_r and e_t of a vector with components along t and o; the same function leads
/// back.
#[inline(always)]
fn polar(turned: Vector, vector: Vector) -> Vector {
    vector.conj() * turned
}

impl Touch {
    /// The motion after the element's speeds have changed.
    #[inline(always)]
    fn moved(&self, cos_beta: f64, change: Vector) -> FlankMotion<f64> {
        let Vector { re: r, im: t } = polar(self.turned, change);
        FlankMotion {
            penetration_rate: self.motion.penetration_rate - self.slopes[0] * r - self.slopes[1] * t,
            tangential: self.motion.tangential + t,
            along_flank: self.motion.along_flank + r * cos_beta,
            ..self.motion
        }
    }

    /// Fall of the forces along t and o with the speeds: tt, to, oo, N·s/m.
    #[inline(always)]
    fn fall(&self, cos_beta: f64) -> [f64; 3] {
        let damped = 2.0 * cos_beta * self.damping;
        let [radial, around] = self.slopes;
        let rr = damped * radial * radial + 2.0 * self.drag * cos_beta * cos_beta;
        let rt = damped * radial * around;
        let tt = damped * around * around + 2.0 * self.drag;
        let Vector { re: s, im: c } = self.turned;
        [
            rr * s * s + 2.0 * rt * s * c + tt * c * c,
            (rr - tt) * s * c + rt * (c * c - s * s),
            rr * c * c - 2.0 * rt * s * c + tt * s * s,
        ]
    }

    /// Forces along t and o, N; and N, f_t, f_f of a flank.
    #[inline(always)]
    fn forces(&self, cos_beta: f64, motion: &FlankMotion<f64>) -> (Vector, [f64; 3]) {
        let normal = self.elastic + self.damping * motion.penetration_rate;
        let (tangential, flank) = (-self.drag * motion.tangential, -self.drag * motion.along_flank);
        let radial = 2.0 * cos_beta * (normal * self.slopes[0] + flank);
        let around = 2.0 * (normal * cos_beta * self.slopes[1] + tangential);
        let force = polar(self.turned, Vector::new(radial, around));
        (force, [normal, tangential, flank])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The forces of a step are linear in the speeds, with the secant of friction.
    #[test]
    fn falls_of_forces_are_differences() {
        let cos_beta = 0.98;
        let mut touch = Touch::default();
        (touch.turned, touch.slopes) = (Vector::new(0.3, (1.0_f64 - 0.09).sqrt()), [0.2, -0.03]);
        (touch.elastic, touch.damping, touch.drag) = (70.0, 270.0, 1500.0);
        touch.motion.penetration_rate = 0.01;
        (touch.motion.tangential, touch.motion.along_flank) = (0.02, -0.01);
        let force = |change: Vector| touch.forces(cos_beta, &touch.moved(cos_beta, change)).0;
        let [tt, to, oo] = touch.fall(cos_beta);
        for (change, expected) in [(1.0e-3.into(), [tt, to]), (Vector::new(0.0, 1.0e-3), [to, oo])] {
            let found = (force(-change) - force(change)) / 2.0e-3;
            for (found, expected) in [found.re, found.im].into_iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6 * tt, "{found} {expected}");
            }
        }
    }
}
