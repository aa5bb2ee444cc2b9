use super::*;
use nalgebra::DVector;

const RING: Ring = Ring {
    mass_per_length: 0.24,
    axial_stiffness: 5.57e6,
    bending_stiffness: 0.0159,
    lateral_bending_stiffness: 37.6,
    damping: 2.0e-5,
};
const LAYERS: Layers = Layers {
    count: 9,
    thickness: 1.85e-4,
    friction: 0.05,
    width: 9.0e-3,
    residual_curvature: 9.0,
};
const SPEED: f64 = 15.0;
/// In overdrive, where the layers slip on the secondary pulley.
const RADII: PerPulley<f64> = PerPulley {
    secondary: 0.033,
    primary: 0.077,
};
const WRAPS: PerPulley<f64> = PerPulley {
    secondary: 2.6,
    primary: std::f64::consts::TAU - 2.6,
};
/// Number of parts of half the secondary arc, of a strand, and of the primary arc.
const COUNTS: [usize; 3] = [40, 10, 120];

/// The loop with a `tension` by pulley and angle; strands continue the arc before them.
fn parts_with(tension: impl Fn(Pulley, f64) -> f64) -> Vec<RingPart> {
    let PerPulley { secondary, primary } = WRAPS;
    let [halves, strands, arcs] = COUNTS;
    // Pulley, number of parts, turning, and the angle at the start.
    let sections = [
        (Pulley::Secondary, halves, 0.5 * secondary, 0.5 * secondary),
        (Pulley::Secondary, strands, 0.0, secondary),
        (Pulley::Primary, arcs, primary, 0.0),
        (Pulley::Primary, strands, 0.0, primary),
        (Pulley::Secondary, halves, 0.5 * secondary, 0.0),
    ];
    let section = |(pulley, count, turning, start): (Pulley, usize, f64, f64)| {
        let turning = turning / count as f64;
        let on_arc = turning * (RADII[pulley] + 1e-3);
        let length = if turning > 0.0 { on_arc } else { 0.16 / count as f64 };
        let part = |k: usize| RingPart {
            xi: 0.0,
            length,
            tension: tension(pulley, start + turning * (k as f64 + 0.5)),
            curvature: turning / length,
            turning,
            pulley,
        };
        (0..count).map(part).collect::<Vec<_>>()
    };
    sections.into_iter().flat_map(section).collect()
}

/// A tension that falls on the secondary pulley and returns on the primary one.
fn usual() -> Vec<RingPart> {
    parts_with(|pulley, angle| {
        3.0e3
            - 100.0
                * match pulley {
                    Pulley::Secondary => angle,
                    Pulley::Primary => WRAPS.secondary * (1.0 - angle / WRAPS.primary),
                }
    })
}

fn tensions(layers: &Layers, speed: f64, radii: PerPulley<f64>, parts: &[RingPart]) -> Vec<[f64; 2]> {
    let mut outer = vec![0.0; parts.len()];
    outer_tension(&RING, layers, speed, radii, parts, &mut outer);
    let loaded = parts.iter().zip(outer);
    loaded
        .map(|(part, outer)| layer_tensions(part.tension, outer, layers.count))
        .collect()
}

fn mean(parts: &[RingPart], value: impl Fn(usize) -> f64) -> f64 {
    let weighted = parts.iter().enumerate().map(|(k, part)| value(k) * part.length);
    weighted.sum::<f64>() / parts.iter().map(|part| part.length).sum::<f64>()
}

/// A number that is another up to rounding.
#[track_caller]
fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} {expected}");
}

/// The part at the middle of a strand: 0 follows the secondary arc.
fn strand(number: usize) -> usize {
    let [halves, strands, arcs] = COUNTS;
    halves + strands / 2 + number * (strands + arcs)
}

#[test]
fn the_layers_carry_the_tension_and_are_stretched_alike() {
    let parts = usual();
    for friction in [0.0, 0.02, 0.1] {
        let all = tensions(&Layers { friction, ..LAYERS }, SPEED, RADII, &parts);
        for (part, [inner, outer]) in parts.iter().zip(&all) {
            close(inner + 8.0 * outer, part.tension);
            if friction == 0.0 {
                close(*outer, mean(&parts, |k| parts[k].tension) / 9.0);
            }
        }
        close(mean(&parts, |k| all[k][0]), mean(&parts, |k| all[k][1]));
    }
}

/// T_j − m_j ṡ² falls by the factor e^(−μα) on the smaller radius, in the direction of travel.
#[test]
fn tension_of_the_outer_layers_falls_as_a_rope_on_a_capstan() {
    let parts = usual();
    let centrifugal = RING.mass_per_length * SPEED.powi(2) / 9.0;
    let pressing = |speed, number| tensions(&LAYERS, speed, RADII, &parts)[strand(number)][1] - centrifugal;
    let factor = (-LAYERS.friction * WRAPS.secondary).exp();
    for (speed, [low, high]) in [(SPEED, [0, 1]), (-SPEED, [1, 0])] {
        let found = pressing(speed, low) / pressing(speed, high);
        assert!((found / factor - 1.0).abs() < 1e-3, "{found} {factor}");
    }
}

/// A ring that slips on its elements as its layers do.
#[test]
fn with_the_same_friction_everywhere_all_layers_are_equal() {
    let centrifugal = RING.mass_per_length * SPEED.powi(2);
    let rate = LAYERS.friction;
    let end = (-rate * WRAPS.secondary).exp();
    let parts = parts_with(|pulley, angle| {
        let shape = match pulley {
            Pulley::Secondary => (-rate * angle).exp(),
            Pulley::Primary => end + (1.0 - end) * angle / WRAPS.primary,
        };
        centrifugal + 3.0e3 * shape
    });
    for (part, [inner, outer]) in parts.iter().zip(tensions(&LAYERS, SPEED, RADII, &parts)) {
        close(inner, part.tension / 9.0);
        close(outer, part.tension / 9.0);
    }
}

/// At ratio 1 and at a standstill, as far as their friction bears the changes of the tension.
#[test]
fn layers_that_stick_share_the_tension() {
    let parts = usual();
    let even = PerPulley::from_fn(|_| 0.058);
    for (speed, radii) in [(SPEED, even), (0.0, RADII)] {
        for [inner, outer] in tensions(&LAYERS, speed, radii, &parts) {
            close(inner, outer);
        }
    }
    let slippery = Layers {
        friction: 1e-3,
        ..LAYERS
    };
    let outer = tensions(&slippery, SPEED, even, &parts)
        .into_iter()
        .map(|[_, outer]| outer);
    let outer = DVector::from_iterator(parts.len(), outer);
    let pressing = mean(&parts, |k| parts[k].tension) - RING.mass_per_length * SPEED.powi(2);
    close(9.0 * (outer.max() - outer.min()), 1e-3 * pressing * WRAPS.secondary);
}

fn stress(layers: &Layers, parts: &[RingPart]) -> (RingStress, DVector<f64>) {
    let mut along = DVector::zeros(parts.len());
    let found = ring_stress(&RING, layers, SPEED, RADII, parts, along.as_mut_slice());
    (found, along)
}

/// One layer under constant tension: E t κ/2 on the arcs, half of it is the amplitude.
#[test]
fn bending_alone() {
    let parts = parts_with(|_, _| 1.8e3);
    let single = Layers {
        count: 1,
        residual_curvature: 0.0,
        ..LAYERS
    };
    let area = 2.0 * 9.0e-3 * 1.85e-4;
    let bending = RADII.map(|radius| 0.5 * 1.85e-4 * RING.axial_stiffness / area / (radius + 1e-3));
    let (found, along) = stress(&single, &parts);
    let tension = 1.8e3 / area;
    close(found.max, tension + bending.secondary);
    close(along[strand(0)], tension);
    for pulley in Pulley::BOTH {
        close(found.amplitude[pulley], 0.5 * bending[pulley]);
        close(found.mean[pulley], tension + 0.5 * bending[pulley]);
    }
    // Bent far beyond the pulleys: the inner face on the strands is the worst.
    let bent = Layers {
        residual_curvature: 60.0,
        ..single
    };
    let most = 0.5 * 1.85e-4 * RING.axial_stiffness / area * bent.residual_curvature;
    let (bent, along) = stress(&bent, &parts);
    close(bent.max, tension + most);
    close(along[strand(0)], bent.max);
    close(bent.amplitude.secondary, 0.5 * bending.secondary);
    close(bent.mean.secondary, bent.max - 0.5 * bending.secondary);
}

/// The largest and the smallest stress of the loop are one cycle, the other peak and valley the
/// other.
#[test]
fn cycles_are_those_of_rainflow_counting() {
    let parts = usual();
    let (found, along) = stress(&LAYERS, &parts);
    let (low, high) = (along.min(), along.max());
    assert_eq!(found.max, high);
    assert!((found.amplitude.secondary - 0.5 * (high - low)).abs() < 1.0);
    assert!((found.mean.secondary - 0.5 * (high + low)).abs() < 1.0);
    let valley = along[strand(0)].max(along[strand(1)]);
    assert!(valley > low);
    assert!((found.mean.primary - found.amplitude.primary - valley).abs() < 1.0);
}
