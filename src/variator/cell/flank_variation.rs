//! Analytic derivatives of a flank's loads: forward differentiation of its law in its four arguments, and the chain
//! rule for everything else.

use crate::contact::{FlankForce, FlankMotion};
use crate::scalar::{Lanes, Real, Tangent};
use crate::variator::cell::laws::Forces;
use crate::variator::cell::state::CellInput;
use crate::variator::law::flanks::{Approach, FlankLoads};
use crate::variator::law::place::{CellLaw, PulleyMotion};
use nalgebra::Vector2;

/// Variation of the loads of a flank with this `force` where its place on the pulley and λ vary by `by`, and its forces by
/// `forces`.
#[inline(always)]
pub(crate) fn vary_loads(
    law: &CellLaw,
    (at, lambda, force): (&Approach<Lanes>, Lanes, &FlankForce<Lanes>),
    by: &FlankVariation,
    [normal, tangential, along_flank]: Forces,
) -> FlankLoads<Lanes> {
    let [sin_beta, cos_beta, tan_beta] = law.wedge;
    // Per ring length: forces times λ.
    let d_normal = normal * lambda + force.normal * by.lambda;
    let d_tangential = tangential * lambda + force.tangential * by.lambda;
    let d_along = along_flank * lambda + force.along_flank * by.lambda;
    let (axial_normal, d_axial_normal) = (force.normal * lambda * cos_beta, d_normal * cos_beta);
    let axial_friction = force.along_flank * lambda * sin_beta;
    let d_axial_friction = d_along * sin_beta;
    let around = force.tangential * lambda + axial_friction * at.opening_slope;
    let d_around = d_tangential + d_axial_friction * at.opening_slope + axial_friction * by.opening_slope;
    FlankLoads {
        radial: d_axial_normal * (at.opening + tan_beta) + axial_normal * by.opening + d_along * cos_beta,
        around: d_axial_normal * at.opening_slope + axial_normal * by.opening_slope + d_tangential,
        torque: -(d_around * at.rho + around * by.rho),
        axial: d_axial_normal - d_axial_friction,
        ..FlankLoads::default()
    }
}

/// Variation of an [`Approach`] and of λ: the place of a point of the belt on its pulley and the motion of its flanks.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct FlankVariation {
    /// Motion of a flank in the middle of the pulley.
    pub motion: FlankMotion<Lanes>,
    pub lambda: Lanes,
    pub rho: Lanes,
    pub opening: Lanes,
    pub opening_slope: Lanes,
    /// Angle by which e_r turns towards e_t.
    pub turn: Lanes,
    /// In space: offset from the middle and its rate.
    pub offset: [Lanes; 2],
}

impl FlankVariation {
    /// The variations with ż, ψ_x, ψ_y and ω at a point of the belt, whose place and velocities are `at`: forward
    /// differentiation of its approach. `alpha` and `beta` are the factors of acceleration and position.
    #[inline(always)]
    pub fn of_pulley(given: &CellInput<'_, Lanes>, at: [Vector2<Lanes>; 3], [alpha, beta]: [f64; 2]) -> [Self; 4] {
        let PulleyMotion {
            z,
            z_dot,
            psi: [x, y],
            psi_dot: [x_dot, y_dot],
            omega,
        } = given.motion.pulley;
        let seed = Tangent::<4>::seed;
        let pulley = PulleyMotion {
            z: seed(z, 0, beta),
            z_dot: seed(z_dot, 0, 1.0),
            psi: [seed(x, 1, 1.0), seed(y, 2, 1.0)],
            psi_dot: [seed(x_dot, 1, alpha), seed(y_dot, 2, alpha)],
            omega: seed(omega, 3, 1.0),
        };
        let at = at.map(|vector| vector.map(Tangent::constant));
        let approach = Approach::new(given.law, given.place.axis, &pulley, at);
        std::array::from_fn(|k| Self {
            motion: approach.flank.map(|of| of.eps[k]),
            opening: approach.opening.eps[k],
            opening_slope: approach.opening_slope.eps[k],
            offset: [pulley.z, pulley.z_dot].map(|of| of.eps[k] * 0.5),
            ..Self::default()
        })
    }
}
