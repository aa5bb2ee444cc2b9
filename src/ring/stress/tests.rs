use super::*;

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
/// In overdrive, where the layers slip on the secondary pulley.
const MOTION: RingMotion = RingMotion {
    speed: 15.0,
    radii: [0.033, 0.077],
};
const WRAPS: [f64; 2] = [2.6, std::f64::consts::TAU - 2.6];
const STRAND: f64 = 0.16;
/// Parts of half the secondary arc, of a strand and of the primary arc.
const PARTS: [usize; 3] = [40, 10, 120];

/// The loop with a tension that is a function of pulley and angle; strands continue the arc before them.
fn parts_with(tension: impl Fn(usize, f64) -> f64) -> Vec<RingPart> {
    let [half, strand, arc] = PARTS;
    let [secondary, primary] = WRAPS;
    // Pulley, number of parts, turning, and the angle at the start.
    let sections = [
        (0, half, 0.5 * secondary, 0.5 * secondary),
        (0, strand, 0.0, secondary),
        (1, arc, primary, 0.0),
        (1, strand, 0.0, primary),
        (0, half, 0.5 * secondary, 0.0),
    ];
    let (mut parts, mut xi) = (Vec::new(), 0.0);
    for (number, count, turning, start) in sections {
        let turning = turning / count as f64;
        let on_strand = STRAND / count as f64;
        let length = if turning > 0.0 {
            turning * (MOTION.radii[number] + 1e-3)
        } else {
            on_strand
        };
        for k in 0..count {
            parts.push(RingPart {
                xi: xi + 0.5 * length,
                length,
                tension: tension(number, start + turning * (k as f64 + 0.5)),
                curvature: turning / length,
                turning,
                number,
            });
            xi += length;
        }
    }
    parts
}

/// A tension that falls on the secondary pulley and returns on the primary one.
fn usual() -> Vec<RingPart> {
    parts_with(|pulley, angle| {
        if pulley == 0 {
            3.0e3 - 100.0 * angle
        } else {
            3.0e3 - 100.0 * WRAPS[0] * (1.0 - angle / WRAPS[1])
        }
    })
}

fn tensions(layers: &Layers, motion: &RingMotion, parts: &[RingPart]) -> Vec<[f64; 2]> {
    let mut shapes = vec![0.0; parts.len()];
    let layered = LayerTension::new(&RING, layers, motion, parts, &mut shapes);
    let tensions = parts.iter().zip(shapes);
    tensions.map(|(part, shape)| layered.at(part.tension, shape)).collect()
}

fn integral(parts: &[RingPart], of: impl Fn(usize) -> f64) -> f64 {
    parts.iter().enumerate().map(|(k, part)| of(k) * part.length).sum()
}

fn with(friction: f64) -> Layers {
    Layers { friction, ..LAYERS }
}

/// The part at the middle of a strand: 0 follows the secondary arc.
fn strand(number: usize) -> usize {
    let [half, strand, arc] = PARTS;
    half + strand / 2 + number * (strand + arc)
}

#[test]
fn the_layers_carry_the_tension_and_are_stretched_alike() {
    let parts = usual();
    for friction in [0.0, 0.02, 0.1] {
        let all = tensions(&with(friction), &MOTION, &parts);
        for (part, [inner, outer]) in parts.iter().zip(&all) {
            assert!((inner + 8.0 * outer - part.tension).abs() < 1e-9 * part.tension);
        }
        let [inner, outer] = [0, 1].map(|layer| integral(&parts, |k| all[k][layer]));
        assert!((inner / outer - 1.0).abs() < 1e-12, "{inner} {outer}");
    }
}

#[test]
fn without_friction_the_innermost_layer_alone_has_the_friction_of_the_saddle() {
    let parts = usual();
    let all = tensions(&with(0.0), &MOTION, &parts);
    let mean = integral(&parts, |k| parts[k].tension) / integral(&parts, |_| 1.0);
    for (part, [inner, outer]) in parts.iter().zip(&all) {
        assert!((outer - mean / 9.0).abs() < 1e-9 * mean, "{outer}");
        assert!((inner - outer - (part.tension - mean)).abs() < 1e-9 * mean, "{inner}");
    }
}

/// T_j − m_j ṡ² falls by the factor e^(−μα) on the pulley with the smaller radius, in the direction of travel.
#[test]
fn tension_of_the_outer_layers_falls_as_a_rope_on_a_capstan() {
    let parts = usual();
    let centrifugal = RING.mass_per_length * MOTION.speed.powi(2) / 9.0;
    let pressing = |motion: &RingMotion, number| tensions(&LAYERS, motion, &parts)[strand(number)][1] - centrifugal;
    let factor = (-0.05 * WRAPS[0]).exp();
    let found = pressing(&MOTION, 0) / pressing(&MOTION, 1);
    assert!((found / factor - 1.0).abs() < 1e-3, "{found} {factor}");
    let reverse = RingMotion {
        speed: -MOTION.speed,
        ..MOTION
    };
    let found = pressing(&reverse, 1) / pressing(&reverse, 0);
    assert!((found / factor - 1.0).abs() < 1e-3, "{found} {factor}");
}

/// A ring that slips on its elements as its layers on each other: all layers have the same tension.
#[test]
fn with_the_same_friction_everywhere_all_layers_are_equal() {
    let centrifugal = RING.mass_per_length * MOTION.speed.powi(2);
    let rate = LAYERS.friction;
    let end = (-rate * WRAPS[0]).exp();
    let parts = parts_with(|pulley, angle| {
        let shape = if pulley == 0 {
            (-rate * angle).exp()
        } else {
            end + (1.0 - end) * angle / WRAPS[1]
        };
        centrifugal + 3.0e3 * shape
    });
    for (part, [inner, outer]) in parts.iter().zip(tensions(&LAYERS, &MOTION, &parts)) {
        assert!((inner - part.tension / 9.0).abs() < 1e-9 * part.tension);
        assert!((outer - part.tension / 9.0).abs() < 1e-9 * part.tension);
    }
}

/// At ratio 1 and at a standstill the layers stick and share the changes of the tension, as far as their friction bears them.
#[test]
fn layers_that_stick_share_the_tension() {
    let parts = usual();
    let motion = RingMotion {
        radii: [0.058; 2],
        ..MOTION
    };
    let still = RingMotion { speed: 0.0, ..MOTION };
    for motion in [motion, still] {
        for (part, [inner, outer]) in parts.iter().zip(tensions(&LAYERS, &motion, &parts)) {
            assert!((inner - outer).abs() < 1e-9 * part.tension, "{inner} {outer}");
        }
    }
    let weak = with(1e-3);
    let all = tensions(&weak, &motion, &parts);
    let range = |of: &dyn Fn(usize) -> f64| {
        let values = || (0..parts.len()).map(of);
        values().fold(f64::NEG_INFINITY, f64::max) - values().fold(f64::INFINITY, f64::min)
    };
    let mean = integral(&parts, |k| parts[k].tension) / integral(&parts, |_| 1.0);
    let borne = 1e-3 * (mean - RING.mass_per_length * MOTION.speed.powi(2)) * WRAPS[0];
    let found = 9.0 * range(&|k| all[k][1]);
    assert!((found / borne - 1.0).abs() < 1e-9, "{found} {borne}");
}

fn stress(layers: &Layers, parts: &[RingPart]) -> (RingStress, Vec<f64>) {
    let mut along = vec![0.0; parts.len()];
    let found = ring_stress(&RING, layers, &MOTION, parts, &mut along);
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
    let bending = MOTION
        .radii
        .map(|radius| 0.5 * 1.85e-4 * RING.axial_stiffness / area / (radius + 1e-3));
    let (found, along) = stress(&single, &parts);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-6 * b.abs(), "{a} {b}");
    close(found.max, 1.8e3 / area + bending[0]);
    close(along[strand(0)], 1.8e3 / area);
    for (k, bending) in bending.into_iter().enumerate() {
        close(found.amplitude[k], 0.5 * bending);
        close(found.mean[k], 1.8e3 / area + 0.5 * bending);
    }
    // Bent far beyond the pulleys: the inner face on the strands is the worst.
    let (bent, along) = stress(
        &Layers {
            residual_curvature: 60.0,
            ..single
        },
        &parts,
    );
    close(
        bent.max,
        1.8e3 / area + 0.5 * 1.85e-4 * RING.axial_stiffness / area * 60.0,
    );
    close(along[strand(0)], bent.max);
    close(bent.amplitude[0], 0.5 * bending[0]);
    close(bent.mean[0], bent.max - 0.5 * bending[0]);
}

/// The largest and the smallest stress of the loop are one cycle; the other peak and valley are the other one.
#[test]
fn cycles_are_those_of_rainflow_counting() {
    let parts = usual();
    let (found, along) = stress(&LAYERS, &parts);
    let low = along.iter().copied().fold(f64::INFINITY, f64::min);
    let high = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    assert_eq!(found.max, high);
    assert!((found.amplitude[0] - 0.5 * (high - low)).abs() < 1.0);
    assert!((found.mean[0] - 0.5 * (high + low)).abs() < 1.0);
    let valley = along[strand(0)].max(along[strand(1)]);
    assert!(valley > low);
    assert!((found.mean[1] - found.amplitude[1] - valley).abs() < 1.0);
}
