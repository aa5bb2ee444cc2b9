//! The kinematic state that runs and steady solutions start from: belt on the reference curve, no
//! stretch, no push force, penetrations that balance the clamping forces. The closed form of a belt
//! whose arcs transmit evenly (strand forces, uniform stretch, push force) needs as many Newton
//! iterations.

use crate::pulley::{PerPulley, Pulley, Wedge};
use crate::reference_curve::{CurvePlace, GeometryError, TwoPulley, TwoPulleyFrame, ratio_of_theta};
use crate::solver::State;
use crate::variator::belt::Belt;
use crate::variator::mesh::belt_mesh::{Cell, Station};
use std::f64::consts::TAU;

/// Ratio, speed and clamping forces of a kinematic state.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Geometric ratio.
    pub ratio: f64,
    /// ω_P, rad/s.
    pub primary_speed: f64,
    /// Forces that close the pulleys, N.
    pub clamping: PerPulley<f64>,
}

/// The kinematic state.
///
/// # Errors
/// The belt does not close at this ratio.
pub fn kinematic_state(belt: &Belt, start: &Start) -> Result<State, GeometryError> {
    let layout = &belt.layout;
    let mut state = State::zero(layout.len());
    let law = &belt.law;
    let e = law.stack.pitch_offset;
    let ratio = reference_ratio(&belt.curve, e, start.ratio)?;
    let radii = belt.curve.radii(ratio)?;
    let theta = ratio_of_theta(ratio);
    let frame = belt.curve.frame::<f64>(theta);
    let Wedge { cos, tan, .. } = law.wedge;
    let pitch = radii.map(|radius| radius - e);
    let wrap = PerPulley {
        secondary: 2.0 * frame.phi.v,
        primary: TAU - 2.0 * frame.phi.v,
    };
    let speed = start.primary_speed * pitch.primary;
    state.q[layout.theta()] = theta;
    state.y[layout.drift()] = speed * radii.primary / pitch.primary;
    for j in Pulley::BOTH {
        let depth = start.clamping[j].max(0.0) / (law.contact.stiffness * cos * cos * pitch[j] * wrap[j]);
        state.q[layout.sheave(j)] = 2.0 * ((pitch[j] - law.r0) * tan + depth);
        state.y[layout.shaft_speed(j)] = speed / pitch[j];
    }
    let length = belt.curve.length() - TAU * e;
    let density = 1.0 - law.stack.play / length;
    // The pins of a chain have no unknowns of their own.
    let cells: &[Cell] = if law.is_pull_chain() { &[] } else { &belt.mesh.cells };
    for (i, cell) in cells.iter().enumerate() {
        let ring = belt.element_length(&frame, cell.element) / layout.cells_per_element as f64;
        state.y[layout.content(i)] = density * ring * (1.0 - e * mean_curvature(belt, &frame, cell));
        state.y[layout.belt_speed(i)] = speed;
    }
    if layout.is_spatial() {
        lead_across(belt, &frame, &mut state);
    }
    Ok(state)
}

/// Places the ring in space between the planes of the two pulleys: across a strand it is a cubic
/// that is tangential to the planes.
fn lead_across(belt: &Belt, frame: &TwoPulleyFrame<f64>, state: &mut State) {
    let layout = &belt.layout;
    let middle = belt.middles(state.view());
    let rise = middle.primary - middle.secondary;
    for (node, element) in belt.mesh.elements.iter().enumerate() {
        let CurvePlace { segment, fraction: x } = frame.place(element.segment, element.start);
        let (w, slope) = match segment {
            1 | 3 => {
                let fraction = if segment == 1 { x } else { 1.0 - x };
                let length = frame.segment_length(segment).v;
                let sign = if segment == 1 { 1.0 } else { -1.0 };
                (
                    middle.secondary + rise * fraction * fraction * (3.0 - 2.0 * fraction),
                    sign * rise * 6.0 * fraction * (1.0 - fraction) / length,
                )
            }
            2 => (middle.primary, 0.0),
            _ => (middle.secondary, 0.0),
        };
        state.q[layout.node(node, 4)] = w;
        state.q[layout.node(node, 5)] = slope;
    }
}

/// Mean reference curvature over the stations of a cell, 1/m.
fn mean_curvature(belt: &Belt, frame: &TwoPulleyFrame<f64>, cell: &Cell) -> f64 {
    let of = |station: &Station| {
        let CurvePlace { segment, fraction } =
            frame.place(belt.mesh.elements[cell.element].segment, station.fraction);
        frame.point(segment, fraction).kappa
    };
    let first = of(&cell.stations[0]);
    let weight: f64 = cell.stations.iter().map(|station| station.weight).sum();
    let others = cell.stations.iter().map(|s| s.weight * (of(s) - first));
    first + others.sum::<f64>() / weight
}

/// The ratio of the reference curve at which the pitch radii have the quotient `ratio`.
fn reference_ratio(curve: &TwoPulley, e: f64, ratio: f64) -> Result<f64, GeometryError> {
    let mut reference = ratio;
    for _ in 0..30 {
        let radii = curve.radii(reference)?;
        reference *= ratio * (radii.primary - e) / (radii.secondary - e);
    }
    Ok(reference)
}
