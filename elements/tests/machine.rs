//! The model of single elements by itself: a ring that turns alone, one pulley, energy, the step,
//! stored states, bad input.

use pushbelt::variator::settings::{Parameters, RIGID_TILT_STIFFNESS};
use pushbelt_archive::Archive;
use pushbelt_elements::{Case, Cone, Law, Machine, Options, Row, Run, Shaft, Vector};

fn short(name: &str, duration: f64) -> Case {
    let mut case = Case::named(name).unwrap();
    case.options.duration = Some(duration);
    case
}

#[track_caller]
fn near(found: f64, expected: f64, within: f64) {
    assert!((found / expected - 1.0).abs() < within, "{found} instead of {expected}");
}

/// T θ = Ω² (m_e R_p + m_r R_c): a ring with its elements on a circle, without pulleys.
#[test]
fn a_ring_turns_alone() {
    let law = Law::new(&Parameters::default(), &Options::default()).unwrap();
    let (n, offset) = (law.count, law.parameters.belt.pitch_offset);
    let length = law.parameters.geometry.belt_length;
    let mass = law.parameters.ring.mass_per_length * length / n as f64;
    let angle = std::f64::consts::TAU / n as f64;
    let (outer, omega) = (length / std::f64::consts::TAU, 200.0);
    let radius = outer - offset;
    let points = (0..n).map(|i| -Vector::from_polar(radius, -angle * i as f64));
    let mut machine = Machine::new(law, 1.0e-6, points);
    for pulley in &mut machine.pulleys {
        pulley.z = -1.0;
    }
    machine.belt.v.fill((omega * radius).into());
    machine.belt.w.fill(omega * outer);
    machine.belt.turn.fill(omega * machine.dt);
    for _ in 0..10_000 {
        machine.step();
    }
    machine.check().unwrap();
    let (law, belt) = (&machine.law, &machine.belt);
    let mut momentum = 0.0;
    for i in 1..=n {
        let (distance, v) = (belt.p[i].norm(), belt.v[i].re);
        momentum += law.mass * v * distance + mass * belt.w[i] * (distance + offset);
        let turning = v / distance;
        let expected = turning * turning * (law.mass * distance + mass * (distance + offset)) / angle;
        near(machine.ring.tension[i], expected, 1e-3);
    }
    let start = omega * (law.mass * radius * radius + mass * outer * outer);
    near(momentum, n as f64 * start, 1e-5);
}

/// F = T − Q − (m_e V² + m_r w²)/h grows by e^{μ Δθ/sin β} along a pulley that slips through.
#[test]
fn a_pulley_that_slips_is_a_rope_in_a_wedge() {
    let mut case = short("low-0", 0.1);
    case.parameters.friction.fall = 0.0;
    case.parameters.primary.tilt.stiffness = RIGID_TILT_STIFFNESS;
    case.parameters.secondary.tilt.stiffness = RIGID_TILT_STIFFNESS;
    case.options.step = Some(2.0e-6);
    let mut machine = case.start().unwrap();
    while machine.time < 0.015 {
        case.drive(&mut machine);
        machine.step();
    }
    // Both cones are held, and the primary shaft turns by 4 m/s faster than the belt.
    machine.drive = [(Shaft::Speed, Cone::Held); 2];
    machine.pulleys[1].omega *= 1.3;
    let [mut logarithm, mut count] = [0.0; 2];
    while machine.time < 0.03 {
        machine.step();
        if machine.time < 0.025 {
            continue;
        }
        let (law, belt) = (&machine.law, &machine.belt);
        // From the outward direction, clockwise.
        let angle = |i: &usize| (belt.p[*i] - law.axes[1]).conj().arg();
        let force = |i: usize| {
            let (v, w) = (belt.v[i].re, belt.w[i]);
            let speed = v * v * law.mass / belt.length[i] + w * w * law.parameters.ring.mass_per_length;
            machine.ring.tension[i] - machine.stacks[0].push[i] - speed
        };
        // Mean of ln F over two windows of the arc, each 0.3 rad wide, 1.5 rad apart.
        let [before, behind] = [-0.75, 0.75].map(|middle| {
            let window = (1..=law.count).filter(|i| (angle(i) - middle).abs() <= 0.15);
            window.clone().map(|i| force(i).ln()).sum::<f64>() / window.count() as f64
        });
        logarithm += behind - before;
        count += 1.0;
    }
    machine.check().unwrap();
    let expected = case.parameters.friction.pulley / machine.law.wedge.sin * 1.5;
    near(f64::abs(logarithm) / count, expected, 0.01);
}

/// Work is loss and stored energy, to 0.05 % of what passes and 2 % of the losses; half the step
/// changes little.
#[test]
fn energy_closes_and_half_the_step_changes_little() {
    let run = |step: f64, pitch: bool| {
        let mut case = short("medium-0.4", 0.024);
        (case.options.step, case.options.pitch) = (Some(step), pitch);
        let mut run = Run::new(case).unwrap();
        run.advance(u64::MAX).unwrap();
        // At this time the ratio's controller still works.
        let fault = run.check_steady().unwrap_err().to_string();
        assert!(fault.contains("no steady state: the thrust ratio changes"), "{fault}");
        Row::mean(&run.rows[16..])
    };
    let [whole, half] = [2.0e-6, 1.0e-6].map(|step| run(step, false));
    for row in [whole, half] {
        assert!(row.residual().abs() < 5e-4, "{}", row.residual());
        assert!(row.residual().abs() * row.ledger.0[1] < 0.02 * row.ledger.losses());
    }
    let row = run(2.0e-6, true);
    assert!(row.residual().abs() < 1e-3, "{}", row.residual());
    near(whole.thrust_ratio(), half.thrust_ratio(), 3e-3);
    near(whole.slip(), half.slip(), 0.03);
    // The transient at this time; a steady state takes 0.15 s.
    assert!((1.2..1.4).contains(&whole.thrust_ratio()) && (1e-3..5e-3).contains(&whole.slip()));
}

#[test]
fn a_stored_run_goes_on_with_the_same_bits() {
    let mut run = Run::new(short("medium-0.4", 4.0e-3)).unwrap();
    run.advance(1200).unwrap();
    let mut archive = Archive::writer();
    run.serialize(&mut archive);
    let bytes = archive.into_bytes();
    let mut again = Run::new(run.case.clone()).unwrap();
    let mut archive = Archive::reader(&bytes);
    again.serialize(&mut archive);
    archive.finish().unwrap();
    for run in [&mut run, &mut again] {
        run.advance(u64::MAX).unwrap();
    }
    assert_eq!(run.rows_csv(), again.rows_csv());
    assert_eq!(run.machine.belt.p, again.machine.belt.p);
    assert!(run.rows.len() == 4);
}

#[test]
fn an_element_that_leaves_the_belt_is_named() {
    let mut machine = short("medium-0.4", 0.01).start().unwrap();
    machine.check().unwrap();
    machine.belt.v[123].im = 30.0;
    let fault = machine.check().unwrap_err();
    assert_eq!(fault.element, 123);
    assert!(fault.to_string().contains("leaves the belt at 30.0 m/s"), "{fault}");
    machine.belt.v[123].im = 0.0;
    machine.belt.length[77] *= 2.5;
    assert_eq!(machine.check().unwrap_err().element, 77);
    machine.belt.length[77] /= 2.5;
    machine.pulleys[1].z = 1.0;
    let fault = machine.check().unwrap_err().to_string();
    assert!(fault.contains("the primary sheaves reach their stop"), "{fault}");
}
