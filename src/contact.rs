//! Wedge contact between element flank and conical sheave, with two-dimensional friction: a law
//! without state. Equations: `docs/theory.md`, section 5.
//!
//! - e_r = (cos θ, −sin θ) outward from the pulley axis, e_t = (e_r,y, −e_r,x) clockwise like ω,
//!   pitch radius ϱ = |r − O| − e,
//! - axial penetration of a flank g = z/2 − (ϱ − r₀) tan β − w, elastic opening of the sheave w = ϱ
//!   (ψ_x cos θ + ψ_y sin θ),
//! - its rate along an element's path Dg/Dt = ż/2 − ∂w/∂t − (tan β + ∂w/∂ϱ) v_r −
//!   (∂w/∂θ)(v_t,abs/ϱ),
//! - normal force per flank and pitch-line length p = k_c cos β (⟨g⟩₊ + d_c H Dg/Dt), along the
//!   gradient of g, H the derivative of ⟨g⟩₊ = ρ ln(1 + e^{g/ρ}) with the roughness ρ (Greenwood
//!   and Williamson 1966),
//! - sliding: tangential v_t = v_p·e_t − ωϱ; along the flank v_f = v_e·e_r cos β + u sin β, with u
//!   = ż/2 − (∂w/∂t + ω ∂w/∂θ),
//! - friction −μ(v) p_el (v_t, v_f)/√(v² + v₀²), v² = v_t² + v_f², with μ(v) = μ (1 − f v²/(v² +
//!   v_c²)), p_el ≥ 0 the elastic part of p and f < 1, so friction always dissipates.
//!
//! An element that is δ out of the middle of its pulley, towards the movable sheave, has the
//! penetration g + δ on that sheave and g − δ on the other; δ̇ enters rates in the same way.

use crate::scalar::{PositivePart, Real, Tangent, soft_plus_energy_at};

/// Parameters of the contact between element flank and sheave.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Contact {
    /// Stiffness k_c per flank and pitch-line length, N/m².
    pub stiffness: f64,
    /// Damping time of the penetration, s.
    pub damping: f64,
    /// Roughness ρ of flank and sheave, m.
    pub roughness: f64,
}

/// Friction coefficients and their regularisation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Friction {
    /// Coefficient μ between element flank and sheave.
    pub pulley: f64,
    /// Coefficient μ_r between ring and element saddle.
    pub ring: f64,
    /// Regularisation speed v_0, m/s. Micro-slip is 2 to 40 mm/s, so at most 1 mm/s.
    pub velocity: f64,
    /// Regularisation speed of the ring's friction, m/s. In both end ratios the ring slides at some
    /// 0.1 m/s.
    pub ring_velocity: f64,
    /// Relative decrease f of μ in fast sliding; 0 is Coulomb's law.
    pub fall: f64,
    /// Sliding speed v_c at which the decrease is f/2, m/s.
    pub fall_speed: f64,
}

/// Motion of a flank relative to its sheave.
#[derive(Clone, Copy, Debug, Default)]
pub struct FlankMotion<T> {
    /// g, m.
    pub penetration: T,
    /// Dg/Dt along the element's path, m/s.
    pub penetration_rate: T,
    /// v_t, m/s.
    pub tangential: T,
    /// v_f, m/s.
    pub along_flank: T,
}

impl<T: Real> FlankMotion<T> {
    /// Applies `f` to each component.
    #[inline(always)]
    pub fn map<U>(&self, f: impl Fn(T) -> U) -> FlankMotion<U> {
        FlankMotion {
            penetration: f(self.penetration),
            penetration_rate: f(self.penetration_rate),
            tangential: f(self.tangential),
            along_flank: f(self.along_flank),
        }
    }

    /// Motion of a flank whose element is `offset`, m, out of the middle towards it, and moves
    /// towards it at `speed`, m/s. For the other flank both have the opposite sign.
    #[inline(always)]
    #[must_use]
    pub fn shifted(&self, offset: T, speed: T, sin_beta: f64) -> Self {
        Self {
            penetration: self.penetration + offset,
            penetration_rate: self.penetration_rate + speed,
            tangential: self.tangential,
            along_flank: self.along_flank + speed * sin_beta,
        }
    }
}

/// Forces on the element per flank and pitch-line length, N/m.
#[derive(Clone, Copy, Debug)]
pub struct FlankForce<T> {
    /// p, normal to the flank, damping included.
    pub normal: T,
    /// Damping part of p.
    pub viscous: T,
    /// Friction along e_t.
    pub tangential: T,
    /// Friction up the flank (radially outward).
    pub along_flank: T,
    /// ⟨g⟩₊, m, to which the elastic part of p is proportional.
    pub depth: T,
}

impl<T: Real> FlankForce<T> {
    /// Elastic part of p.
    #[inline(always)]
    #[must_use]
    pub fn elastic(&self) -> T {
        self.normal - self.viscous
    }
}

/// Forces on an element whose flank has this `motion`.
#[inline(always)]
pub fn flank_force<T: Real>(
    contact: &Contact,
    friction: &Friction,
    cos_beta: f64,
    motion: &FlankMotion<T>,
) -> FlankForce<T> {
    let PositivePart {
        value: depth,
        slope: touching,
        ..
    } = motion.penetration.soft_plus(contact.roughness);
    let k = contact.stiffness * cos_beta;
    let elastic = depth * k;
    let viscous = touching * motion.penetration_rate * (k * contact.damping);
    let square = motion.tangential * motion.tangential + motion.along_flank * motion.along_flank;
    let (_, inverse_speed) = (square + friction.velocity * friction.velocity).root_and_inverse();
    let drag = -(elastic * (coefficient(friction, square) * inverse_speed));
    FlankForce {
        normal: elastic + viscous,
        viscous,
        tangential: drag * motion.tangential,
        along_flank: drag * motion.along_flank,
        depth,
    }
}

/// −∂f_t/∂v_t of the friction f_t along e_t at constant normal force, N·s/m²: negative where faster
/// sliding transmits less.
#[inline(always)]
#[must_use]
pub fn traction_slope<L>(contact: &Contact, friction: &Friction, cos_beta: f64, motion: &FlankMotion<L>) -> L
where
    L: Real<Constant = L>,
    Tangent<1, L>: Real<Constant = L>,
{
    let mut varied = motion.map(Tangent::<1, L>::constant);
    varied.tangential = Tangent::seed(motion.tangential, 0, 1.0);
    -flank_force(contact, friction, cos_beta, &varied).tangential.eps[0]
}

/// μ(v) at the square of the sliding speed, m²/s².
#[inline(always)]
fn coefficient<T: Real>(friction: &Friction, square: T) -> T {
    let corner = friction.fall_speed * friction.fall_speed;
    let lost = square * (square + corner).recip();
    lost * (-friction.pulley * friction.fall) + friction.pulley
}

/// Torque at which the belt slips tangentially on the whole arc, N·m: 2 μ F r/cos β, with the axial
/// force F of the sheaves, N, and the pitch radius r, m.
#[must_use]
pub fn full_slip_torque(friction: &Friction, cos_beta: f64, force: f64, radius: f64) -> f64 {
    2.0 * friction.pulley * force * radius / cos_beta
}

/// Elastic energy of a flank per pitch-line length, J/m, where ⟨g⟩₊ is `depth`, m.
#[inline(always)]
#[must_use]
pub fn energy_density<T: Real>(contact: &Contact, cos_beta: f64, penetration: T, depth: T) -> T {
    let stiffness = contact.stiffness * cos_beta * cos_beta;
    soft_plus_energy_at(penetration, depth, contact.roughness) * stiffness
}
