//! The kinematic state that runs and steady solutions start from: belt on the reference curve, no stretch, no push
//! force, penetrations that balance the clamping forces. A start with the closed form of a belt whose arcs transmit
//! evenly (strand forces, uniform stretch, push force) was tried: it needs as many Newton iterations.

use super::layout::Global;
use super::mesh::{Cell, P, S, Station};
use super::system::VariatorSystem;
use crate::reference_curve::{GeometryError, ReferenceCurve, TwoPulley, TwoPulleyFrame, ratio_of_theta};
use crate::solver::State;
use std::f64::consts::TAU;

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
    let mut state = State::zero(layout.len());
    let parameters = &system.law.parameters;
    let e = parameters.belt.pitch_offset;
    let (reference_ratio, radii) = radii_at_pitch_ratio(&system.curve, e, start.ratio)?;
    let theta = ratio_of_theta(reference_ratio);
    let frame = system.curve.frame::<f64>(theta);
    let [_, cos_beta, tan_beta] = system.law.wedge;
    let pitch = [radii.1 - e, radii.0 - e];
    let wrap = [2.0 * frame.phi.v, TAU - 2.0 * frame.phi.v];
    let speed = start.primary_speed * pitch[P];
    state.q[layout.global(Global::Theta, 0)] = theta;
    state.y[layout.global(Global::Drift, 0)] = speed * radii.0 / pitch[P];
    for j in [S, P] {
        let depth = start.clamping[j] / (parameters.contact.stiffness * cos_beta * cos_beta * pitch[j] * wrap[j]);
        state.q[layout.global(Global::Sheave, j)] = 2.0 * ((pitch[j] - system.law.r0) * tan_beta + depth);
        state.y[layout.global(Global::Speed, j)] = speed / pitch[j];
    }
    let length = parameters.geometry.belt_length - TAU * e;
    let density = 1.0 - parameters.belt.play / length;
    for (i, cell) in system.mesh.cells.iter().enumerate() {
        let ring = system.element_length(&frame, cell.element) / layout.cells_per_element as f64;
        state.y[layout.amount(i)] = density * ring * (1.0 - e * mean_curvature(system, &frame, cell));
        state.y[layout.speed(i)] = speed;
    }
    if layout.is_spatial() {
        let middle = system.middles(state.view());
        let rise = middle[P] - middle[S];
        for node in 0..layout.elements {
            let (segment, x) = system.mesh.start(&system.curve, &frame, node);
            // Across a strand along a cubic that leaves and arrives in the planes.
            let (w, slope) = match segment {
                1 | 3 => {
                    let share = if segment == 1 { x } else { 1.0 - x };
                    let length = TwoPulley::segment_length::<f64>(&frame, segment).v;
                    let sign = if segment == 1 { 1.0 } else { -1.0 };
                    (
                        middle[S] + rise * share * share * (3.0 - 2.0 * share),
                        sign * rise * 6.0 * share * (1.0 - share) / length,
                    )
                }
                2 => (middle[P], 0.0),
                _ => (middle[S], 0.0),
            };
            state.q[layout.node(node, 4)] = w;
            state.q[layout.node(node, 5)] = slope;
        }
    }
    Ok(state)
}

/// Mean reference curvature of a cell as its stations see it, 1/m.
fn mean_curvature(system: &VariatorSystem, frame: &TwoPulleyFrame<f64>, cell: &Cell) -> f64 {
    let of = |station: &Station| system.reference_point(frame, cell.element, station.fraction).kappa;
    let first = of(&cell.stations[0]);
    let weight: f64 = cell.stations.iter().map(|station| station.weight).sum();
    let others = cell.stations.iter().map(|s| s.weight * (of(s) - first));
    first + others.sum::<f64>() / weight
}

/// Reference ratio and radii (r_P, r_S) at which the pitch radii have the quotient `ratio`.
fn radii_at_pitch_ratio(curve: &TwoPulley, e: f64, ratio: f64) -> Result<(f64, (f64, f64)), GeometryError> {
    let mut reference = ratio;
    let mut radii = curve.radii(reference)?;
    for _ in 0..30 {
        reference *= ratio * (radii.0 - e) / (radii.1 - e);
        radii = curve.radii(reference)?;
    }
    Ok((reference, radii))
}
