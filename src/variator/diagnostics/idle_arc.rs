//! Idle arcs: in the idle part of an arc, from its entry on, the elements move with the pulley and
//! the push force is still that of the strand before (Kobayashi et al., SAE 980822).

use super::{IDLE_CHANGE, NO_DIFFERENCE};
use crate::pulley::{PerPulley, Pulley};
use crate::variator::cell::sample::Sample;
use crate::variator::mesh::belt_mesh::BeltMesh;

/// Mean push forces, N, of the strand from S to P and of the strand from P to S, in the direction
/// of ξ.
fn strand_forces(stations: &[Sample], length: f64) -> [f64; 2] {
    let (mut sums, mut lengths) = ([0.0; 2], [0.0; 2]);
    for sample in stations.iter().filter(|sample| !sample.on_arc()) {
        let strand = usize::from(sample.xi > 0.5 * length);
        sums[strand] += sample.push * sample.weight;
        lengths[strand] += sample.weight;
    }
    [0, 1].map(|k| sums[k] / lengths[k])
}

/// The idle arc of each pulley, rad, of a belt of this `length`, m, that travels along ξ, or
/// against it if `reverse`.
pub(super) fn idle_arcs(mesh: &BeltMesh, stations: &[Sample], length: f64, reverse: bool) -> PerPulley<f64> {
    let strands = strand_forces(stations, length);
    let difference = (strands[1] - strands[0]).abs();
    let limit = IDLE_CHANGE * difference;
    let count = stations.len();
    PerPulley::from_fn(|pulley| {
        // The loop is followed from the middle of the other arc.
        let first = if pulley == Pulley::Primary { 0 } else { count / 2 };
        let entry = strands[usize::from((pulley == Pulley::Secondary) != reverse)];
        let (mut angle, mut before) = (0.0, 0.0);
        for k in 0..count {
            let k = (first + if reverse { count - 1 - k } else { k }) % count;
            let sample = &stations[k];
            if !sample.on_arc() || mesh.cells[k / mesh.points].pulley != pulley {
                continue;
            }
            let wrap = sample.curvature * sample.weight;
            let change = (sample.push - entry).abs();
            if difference >= NO_DIFFERENCE && change > limit {
                let fraction = ((limit - before) / (change - before)).clamp(0.0, 1.0);
                // Between the last station and this one, each in the middle of its weight.
                return (angle + wrap * (fraction - 0.5)).max(0.0);
            }
            (angle, before) = (angle + wrap, change);
        }
        angle
    })
}
