//! Stress in the layers of the ring, from tension and curvature along the belt: a law without
//! state. Equations: `docs/theory.md`, (3.12) and (3.13).
//!
//! Two ring sets of n layers share the tension T. On one pulley all layers slip backwards, each
//! against the one below ([`layers`](super::layers)); with θ the angle of travel on that arc, the
//! tension T_j outside interface j follows dT_j/dθ = −μ_l (T_j − m_j ṡ²). It returns on the other
//! pulley, where the layers stick, taken as linear in the angle. With equal ∮T_j dξ per layer, one
//! other than the innermost has T_o/n,
//!
//! T_o = m_r ṡ² + A g(θ), with g the decay and the return, and A from ∮T_o dξ = ∮T dξ.
//!
//! The innermost, which rubs on the elements, has the rest, T_o/n + T − T_o.
//!
//! Near ratio 1 and at a standstill the layers stick on both pulleys. They then share the changes
//! of T alike, as far as their friction bears it on the shorter arc: T_o = T̄ + c (T − T̄) with c =
//! min(1, μ_l (T̄ − m_r ṡ²) α/(T_max − T_min)), T̄ the mean. In between, T_o passes from one to the
//! other as the loss does.
//!
//! A layer of width w and thickness t has the stress T/(2 w t) ± ½ E t (κ − κ₀) at its outer and at
//! its inner face. A revolution has two cycles, one on each pulley; rainflow counting combines the
//! higher peak with the lower valley, and the other two. The peaks of an outer face are on the
//! arcs, those of an inner face on the strands.

use super::Ring;
use super::layers::{Layers, slip};
use crate::pulley::{PerPulley, Pulley};

/// Ring sets, side by side on the elements.
const SETS: f64 = 2.0;

/// An element of the ring, in the order of ξ around the loop from the middle of the secondary arc.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RingPart {
    /// Middle, m.
    pub xi: f64,
    /// Length dξ, m.
    pub length: f64,
    /// Mean tension T, N.
    pub tension: f64,
    /// Mean curvature κ of the deflected ring, 1/m.
    pub curvature: f64,
    /// Angle by which the reference curve turns within it, rad: 0 on a strand.
    pub turning: f64,
    /// Pulley of an arc; of a strand, that whose arc it follows in ξ.
    pub pulley: Pulley,
}

/// Writes the tension T_o in each part to `along`, N.
fn outer_tension(
    ring: &Ring,
    layers: &Layers,
    speed: f64,
    radii: PerPulley<f64>,
    parts: &[RingPart],
    along: &mut [f64],
) {
    let (mut length, mut sum, mut wraps) = (0.0, 0.0, PerPulley::<f64>::default());
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for part in parts {
        length += part.length;
        sum += part.tension * part.length;
        low = low.min(part.tension);
        high = high.max(part.tension);
        if part.turning > 0.0 {
            wraps[part.pulley] += part.turning;
        }
    }
    let centrifugal = ring.mass_per_length * speed * speed;
    let mean = sum / length;
    let PerPulley { secondary, primary } = wraps;
    let (slips, slipping) = slip(radii, speed);
    let rate = layers.friction * speed.signum();
    // Shape g after an angle on the arc of a pulley.
    let shape = |pulley: Pulley, turned: f64| {
        if pulley == slips {
            return (-rate * turned).exp();
        }
        let end = (-rate * wraps[slips]).exp();
        end + (1.0 - end) * turned / wraps[pulley]
    };
    // The loop begins in the middle of the secondary arc. A strand is at the end of the arc before
    // it.
    let (mut angle, mut mean_shape) = (0.5 * secondary, 0.0);
    for (part, shape_there) in parts.iter().zip(&mut *along) {
        let middle = angle + 0.5 * part.turning;
        angle += part.turning;
        *shape_there = if middle <= secondary {
            shape(Pulley::Secondary, middle)
        } else if middle <= secondary + primary {
            shape(Pulley::Primary, middle - secondary)
        } else {
            shape(Pulley::Secondary, middle - secondary - primary)
        };
        mean_shape += *shape_there * part.length;
    }
    mean_shape /= length;
    let borne = layers.friction * (mean - centrifugal).max(0.0) * secondary.min(primary);
    let fraction = if borne < high - low { borne / (high - low) } else { 1.0 };
    for (part, along) in parts.iter().zip(along) {
        let slipped = centrifugal + (mean - centrifugal) * *along / mean_shape;
        let stuck = mean + fraction * (part.tension - mean);
        *along = stuck + slipping * (slipped - stuck);
    }
}

/// Tension of the innermost of `count` layers and of each other one, of both sets together, N,
/// where T_o is `outer`.
fn layer_tensions(tension: f64, outer: f64, count: i32) -> [f64; 2] {
    let fraction = outer / f64::from(count);
    [fraction + tension - outer, fraction]
}

/// Stress of the face with the largest one over a revolution, Pa.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RingStress {
    /// Largest stress.
    pub max: f64,
    /// Amplitude of the cycle on each pulley.
    pub amplitude: PerPulley<f64>,
    /// Mean stress of the same cycle.
    pub mean: PerPulley<f64>,
}

/// Cycles of a face's stress by rainflow counting. `side` is +1 for an outer face, −1 for an inner
/// one; peaks and valleys are those of the stress times it.
fn cycles<'a>(side: f64, stresses: impl Iterator<Item = (&'a RingPart, f64)>) -> RingStress {
    let mut max = f64::NEG_INFINITY;
    let mut peaks = PerPulley::from_fn(|_| f64::NEG_INFINITY);
    let mut strands = PerPulley::from_fn(|_| f64::INFINITY);
    for (part, stress) in stresses {
        max = max.max(stress);
        if part.turning > 0.0 {
            peaks[part.pulley] = (side * stress).max(peaks[part.pulley]);
        } else {
            strands[part.pulley] = (side * stress).min(strands[part.pulley]);
        }
    }
    let PerPulley { secondary, primary } = strands;
    let (low, high) = (secondary.min(primary), secondary.max(primary));
    let (secondary, primary) = if peaks.primary > peaks.secondary {
        (high, low)
    } else {
        (low, high)
    };
    let valleys = PerPulley { secondary, primary };
    RingStress {
        max,
        amplitude: PerPulley::from_fn(|pulley| (0.5 * (peaks[pulley] - valleys[pulley])).max(0.0)),
        mean: PerPulley::from_fn(|pulley| 0.5 * side * (peaks[pulley] + valleys[pulley])),
    }
}

/// Stress of the face with the largest one over a revolution, where the ring moves along itself at
/// `speed`, m/s, on pitch radii, m. Writes its stress in each part to `along`, Pa. All are zero for
/// layers without thickness.
pub fn ring_stress(
    ring: &Ring,
    layers: &Layers,
    speed: f64,
    radii: PerPulley<f64>,
    parts: &[RingPart],
    along: &mut [f64],
) -> RingStress {
    let area = SETS * layers.width * layers.thickness;
    outer_tension(ring, layers, speed, radii, parts, along);
    let per_area = area.recip();
    let bending = 0.5 * layers.thickness * ring.axial_stiffness / (area * f64::from(layers.count));
    let stress = |(layer, side): (usize, f64), part: &RingPart, outer: f64| {
        layer_tensions(part.tension, outer, layers.count)[layer] * per_area
            + side * bending * (part.curvature - layers.residual_curvature)
    };
    // A ring of one layer has the innermost only.
    let last = usize::from(layers.count > 1);
    let faces = (0..=last).flat_map(|layer| [(layer, 1.0), (layer, -1.0)]);
    let stressed = faces.map(|face| {
        let stresses = parts.iter().zip(&*along);
        let stresses = stresses.map(|(part, &outer)| (part, stress(face, part, outer)));
        (face, cycles(face.1, stresses))
    });
    let worst = stressed.reduce(|worst, face| if face.1.max > worst.1.max { face } else { worst });
    let Some((face, found)) = worst.filter(|_| area > 0.0) else {
        along.fill(0.0);
        return RingStress::default();
    };
    for (part, along) in parts.iter().zip(along) {
        *along = stress(face, part, *along);
    }
    found
}

#[cfg(test)]
mod tests;
