//! The kinematic state that runs and steady solutions start from: belt on the reference curve, penetrations that
//! balance the clamping forces.

use super::layout::Global;
use super::mesh::{P, S};
use super::system::{State, VariatorSystem};
use crate::reference_curve::{GeometryError, ReferenceCurve, TwoPulley};
use std::f64::consts::{PI, TAU};

/// What the start state is built for.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Geometric ratio.
    pub ratio: f64,
    /// ω_P, rad/s.
    pub primary_speed: f64,
    /// Clamping forces over pulleys, N.
    pub clamping: [f64; 2],
}

/// The kinematic state.
///
/// # Errors
/// The belt does not close at this ratio.
pub fn kinematic_state(system: &VariatorSystem, start: &Start) -> Result<State, GeometryError> {
    let layout = system.layout;
    let n = layout.len();
    let mut state = State {
        y: vec![0.0; n],
        y_dot: vec![0.0; n],
        q: vec![0.0; n],
    };
    let parameters = &system.law.parameters;
    let e = parameters.belt.pitch_offset;
    // The ratio is that of the pitch radii: (r_S − e)/(r_P − e) = i, found by a few secant-free corrections.
    let mut reference_ratio = start.ratio;
    let mut radii = system.curve.radii(reference_ratio)?;
    for _ in 0..30 {
        let pitch = (radii.1 - e) / (radii.0 - e);
        reference_ratio *= start.ratio / pitch;
        radii = system.curve.radii(reference_ratio)?;
    }
    let theta = (1.0 - reference_ratio) / (1.0 + reference_ratio);
    let frame = system.curve.frame::<f64>(theta);
    let [sin_beta, cos_beta, tan_beta] = system.law.wedge;
    let pitch = [radii.1 - e, radii.0 - e];
    let wrap = [2.0 * frame.phi.v, TAU - 2.0 * frame.phi.v];
    let speed = start.primary_speed * pitch[P];
    state.q[layout.global(Global::Theta, 0)] = theta;
    state.y[layout.global(Global::Drift, 0)] = speed * radii.0 / pitch[P];
    for j in [S, P] {
        let depth = start.clamping[j]
            / (parameters.contact.stiffness * cos_beta * cos_beta * pitch[j] * wrap[j]);
        state.q[layout.global(Global::Sheave, j)] = 2.0 * ((pitch[j] - system.law.r0) * tan_beta + depth);
        state.y[layout.global(Global::Speed, j)] = speed / pitch[j];
    }
    let length = parameters.geometry.belt_length - TAU * e;
    let density = 1.0 - parameters.belt.play / length;
    for (i, cell) in system.mesh.cells.iter().enumerate() {
        let element = &system.mesh.elements[cell.element];
        let ring = TwoPulley::segment_length(&frame, element.segment).v * element.share
            / layout.cells_per_element as f64;
        let kappa = if cell.arc { 1.0 / frame.radius[cell.pulley].v } else { 0.0 };
        state.y[layout.amount(i)] = density * ring * (1.0 - e * kappa);
        state.y[layout.speed(i)] = speed;
        if !layout.flexible {
            // Belt force S 2 tan β/α, less exact on the pulley that slips less: a first guess.
            state.y[layout.tension(i)] = 2.0 * start.clamping[S] * sin_beta / cos_beta / wrap[S].max(PI / 2.0)
                + parameters.belt.mass_per_length * speed * speed;
        }
    }
    Ok(state)
}
