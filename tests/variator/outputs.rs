//! Each scalar output of a steady state against a second formula: from other outputs, from the
//! stations, from what was given.

use pushbelt::pulley::{PerPulley, Pulley, Wedge};
use pushbelt::variator::cell::sample::Sample;
use pushbelt::variator::settings::Cylinder;
use pushbelt_support::steady::{At, transmitting};
use pushbelt_support::variators::{MODELS, SPEED, variator};

/// Angle from the entry to where the push force is off that of the strand before the arc by a tenth
/// of the difference of the strands, linear between stations; the angle between these, rad.
fn idle_arc(stations: &[At], pulley: Pulley) -> [f64; 2] {
    let of = |k: usize| stations.iter().filter(move |at| at.segment == k).map(|at| at.sample);
    let mean = |k| of(k).map(|s| s.push * s.weight).sum::<f64>() / of(k).map(|s| s.weight).sum::<f64>();
    let (arc, strands) = [(&[4, 0][..], [3, 1]), (&[2], [1, 3])][pulley as usize];
    let ([entry, exit], mut angle, mut course) = (strands.map(mean), 0.0, vec![[0.0; 2]]);
    for s in arc.iter().flat_map(|&k| of(k)) {
        let wrap = s.curvature * s.weight;
        course.push([angle + 0.5 * wrap, ((s.push - entry) / (exit - entry)).abs()]);
        angle += wrap;
    }
    let active = course.iter().position(|[_, change]| *change > 0.1);
    let active = active.expect("an active arc");
    let ([a, before], [b, after]) = (course[active - 1], course[active]);
    [a + (0.1 - before) / (after - before) * (b - a), b - a]
}

/// In underdrive and overdrive, with pulleys that differ, so that one instead of the other shows.
#[test]
#[rustfmt::skip]
fn outputs_follow_from_others_from_stations_and_from_what_is_given() {
    for (model, ratio) in MODELS.into_iter().flat_map(|model| [(model, 0.5), (model, 2.0)]) {
        let mut p = variator(model);
        (p.secondary.inertia, p.secondary.drag.constant) = (0.1, 0.3);
        p.secondary.tilt.stiffness *= 1.5;
        let (area, spring_force, spring_stiffness) = (0.01, 400.0, 1.5e4);
        p.primary.cylinder = Cylinder { area, spring_force, spring_stiffness, centrifugal: 0.01, seal: 9.0 };
        p.secondary.cylinder = Cylinder { spring_force: 300.0, ..p.primary.cylinder };
        let state = transmitting(&p, ratio, 12e3, 60.0, SPEED);
        let (o, stations, law) = (&state.outputs, state.stations(), &state.system.belt.law);
        let (a, b) = (&o.primary, &o.secondary);
        let (e, Wedge { cos, tan, .. }) = (p.belt.pitch_offset, law.wedge);
        let sum = |of: &dyn Fn(&At) -> f64| stations.iter().map(|at| of(at) * at.sample.weight).sum::<f64>();
        let whole = |value: fn(&Sample) -> f64| sum(&|at| value(&at.sample));
        let i = (b.radius + e) / (a.radius + e);
        let PerPulley { primary, secondary } = p.pitch_radii(i).expect("the belt closes");
        let mut rows = Vec::new();
        let drags = PerPulley::from_fn(|j| {
            let (of, closed) = if j == Pulley::Primary { (a, primary) } else { (b, secondary) };
            let on = |of: &dyn Fn(&Sample) -> f64| sum(&|at| f64::from(at.pulley == j) * of(&at.sample));
            let psi = [0, 1].map(|axis| state.state.y[state.system.belt.layout.tilt(j, axis)]);
            let arm = |s: &Sample| [s.r[0] - law.axes[j], s.r[1]];
            let moment = [0, 1].map(|k| on(&|s| s.axial * arm(s)[k] / (1.0 + e / s.pitch_radius)));
            let drag = p.pulley(j).drag.loads(of.speed, [0, 1].map(|k| on(&|s| s.resultant[k]))).torque;
            let depth = of.axial_force / (p.contact.stiffness * cos * cos * of.radius * state.wrap()[j]);
            let arc = stations.iter().filter(|at| at.pulley == j && at.sample.on_arc());
            let radii: Vec<f64> = arc.map(|at| at.sample.pitch_radius).collect();
            let [least, most] = [f64::min, f64::max].map(|of| radii.iter().copied().fold(radii[0], of));
            let [idle, station] = idle_arc(&stations, j);
            rows.extend([
                ("clamping force", of.clamping_force_total, of.axial_force, 1e-5),
                ("radius", of.radius, on(&|s| s.axial * s.pitch_radius) / on(&|s| s.axial), 1e-9),
                ("radius of a closed belt", of.radius, closed, 5e-3),
                ("position", of.position, 2.0 * ((of.radius - law.r0) * tan + depth), 0.03),
                ("external torque", of.external_torque, drag - on(&|s| s.torque), 1e-5),
                ("power", of.power, (of.external_torque - drag) * of.speed, 1e-5),
                ("tilt", of.tilt * p.pulley(j).tilt.secant(psi), moment[0].hypot(moment[1]), 1e-5),
                ("idle arc", of.idle_arc, idle, 0.2 * station / idle),
                // The ends of the arc are beyond its stations.
                ("spiral", of.spiral, 1.03 * (most - least), 0.028),
            ]);
            drag
        });
        let tensions = (0..state.system.belt.mesh.elements.len()).map(|k| {
            let of = |value: fn(&Sample) -> f64| sum(&|at| f64::from(at.element == k) * value(&at.sample));
            of(|s| s.tension) / of(|_| 1.0)
        });
        let push = stations.iter().map(|at| at.sample.push);
        let belt_speed = whole(|s| s.speed * s.lambda) / whole(|s| s.lambda);
        let supplied = [a, b].map(|of| of.external_torque * of.speed);
        let capacity = 2.0 * p.friction.pulley * b.axial_force * a.radius / cos;
        rows.extend([
            ("ratio of speeds", o.ratio_speed, a.speed / b.speed, 1e-9),
            ("theta", o.reference_theta, (1.0 - i) / (1.0 + i), 0.01),
            ("slip", o.slip, 1.0 - b.speed * b.radius / (a.speed * a.radius), 1e-9),
            ("thrust ratio", o.thrust_ratio, a.axial_force / b.axial_force, 1e-9),
            ("belt speed", o.belt_speed, belt_speed, 1e-9),
            ("ring speed", o.ring_speed, belt_speed * (1.0 + p.saddle_offset() / a.radius.min(b.radius)), 0.01),
            ("utilisation", o.torque_utilisation, a.shaft_torque.abs() / capacity, 1e-9),
            ("belt efficiency", o.belt_efficiency, -b.power / a.power, 1e-9),
            ("efficiency", o.efficiency, -supplied[1] / supplied[0], 1e-5),
            ("loss", o.losses.total(), supplied[0] + supplied[1], 0.01),
            ("loss of shafts", o.losses.shafts, drags.primary * a.speed + drags.secondary * b.speed, 1e-9),
            ("push force", o.push_force_max, push.fold(0.0, f64::max), 1e-9),
            ("most tension", o.ring_tension_max, tensions.clone().fold(0.0, f64::max), 1e-9),
            ("least tension", o.ring_tension_min, tensions.fold(f64::INFINITY, f64::min), 1e-9),
        ]);
        for (name, found, expected, bound) in rows {
            let is_near = (found - expected).abs() <= bound * expected.abs();
            assert!(is_near, "{model:?} {ratio} {name}: {found}, not {expected}");
        }
    }
}
