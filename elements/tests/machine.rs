//! The model of single elements by itself: a ring that turns alone, one pulley, energy, the step, stored states, bad input.

use pushbelt::variator::settings::{Parameters, RIGID_TILT_STIFFNESS};
use pushbelt_archive::Archive;
use pushbelt_elements::case::Case;
use pushbelt_elements::law::{Law, Options};
use pushbelt_elements::machine::Machine;
use pushbelt_elements::pulleys::{Cone, Shaft};
use pushbelt_elements::run::{Row, Run};

fn short(name: &str, duration: f64) -> Case {
    Case {
        duration: Some(duration),
        ..Case::named(name).unwrap()
    }
}

/// T θ = Ω² (m_e R_p + m_r R_c): a ring with its elements on a circle, without pulleys.
#[test]
fn a_ring_turns_alone() {
    let law = Law::new(&Parameters::default(), &Options::default()).unwrap();
    let n = law.count;
    let angle = std::f64::consts::TAU / n as f64;
    let radius = law.ring.length / std::f64::consts::TAU - law.ring.offset;
    let points: Vec<_> = (0..n)
        .map(|i| (i as f64 * angle).sin_cos())
        .map(|(sin, cos)| [-radius * cos, radius * sin])
        .collect();
    let mut machine = Machine::new(law, Parameters::default(), 1.0e-6, &points);
    for pulley in &mut machine.pulleys {
        pulley.z = -1.0;
    }
    let omega = 200.0;
    machine.v.fill(omega * radius);
    machine.w.fill(omega * (radius + machine.law.ring.offset));
    machine.frames.turn.fill(omega * machine.dt);
    for _ in 0..10_000 {
        machine.step();
    }
    machine.check().unwrap();
    let law = &machine.law;
    let mass = law.ring.mass_per_length * law.ring.length / n as f64;
    let mut momentum = 0.0;
    for i in 1..=n {
        let distance = machine.x[i].hypot(machine.y[i]);
        let turning = machine.v[i] / distance;
        momentum += law.mass * machine.v[i] * distance + mass * machine.w[i] * (distance + law.ring.offset);
        let expected = turning * turning * (law.mass * distance + mass * (distance + law.ring.offset)) / angle;
        let tension = machine.ring.tension[i];
        assert!((tension / expected - 1.0).abs() < 1e-3, "{i}: {tension} {expected}");
    }
    let outer = radius + law.ring.offset;
    let start = n as f64 * omega * (law.mass * radius * radius + mass * outer * outer);
    assert!((momentum / start - 1.0).abs() < 1e-5, "{momentum} {start}");
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
    machine.drive = [(Shaft::Speed, Cone::Held), (Shaft::Speed, Cone::Held)];
    machine.pulleys[1].omega *= 1.3;
    let [mut logarithm, mut count] = [0.0; 2];
    let end = machine.time + 0.015;
    let radius = machine.loads[1].weight[1] / machine.loads[1].weight[0];
    while machine.time < end {
        machine.step();
        if machine.time < end - 0.005 {
            continue;
        }
        let law = &machine.law;
        // Mean of ln F over two windows of the arc, each 0.3 rad wide, 1.5 rad apart.
        let mut sums = [[0.0; 2]; 2];
        for i in 1..=law.count {
            let angle = machine.y[i].atan2(law.axes[1] - machine.x[i]);
            let window = usize::from(angle < 0.0);
            if machine.x[i] < law.axes[1] || (angle.abs() - std::f64::consts::PI + 0.75).abs() > 0.15 {
                continue;
            }
            let speed = machine.v[i] * machine.v[i] * law.mass / machine.chords.length[i]
                + machine.w[i] * machine.w[i] * law.ring.mass_per_length;
            sums[window][0] += (machine.ring.tension[i] - machine.stack.push[i] - speed).ln();
            sums[window][1] += 1.0;
        }
        logarithm += sums[1][0] / sums[1][1] - sums[0][0] / sums[0][1];
        count += 1.0;
    }
    machine.check().unwrap();
    let exponent = logarithm.abs() / count;
    let expected = case.parameters.friction.pulley / machine.law.wedge[0] * 1.5;
    assert!(
        (exponent / expected - 1.0).abs() < 0.01,
        "{exponent} {expected}, radius {radius}"
    );
}

/// Work is loss and stored energy, to 0.05 % of what passes and 2 % of the losses; half the step changes little.
#[test]
fn energy_closes_and_half_the_step_changes_little() {
    let run = |step: f64| {
        let mut case = short("medium-0.4", 0.024);
        case.options.step = Some(step);
        let mut run = Run::new(case).unwrap();
        run.advance(u64::MAX).unwrap();
        // At this time the ratio's controller still works.
        let fault = run.check_steady().unwrap_err().to_string();
        assert!(
            fault.contains("no steady state: the thrust ratio changes by"),
            "{fault}"
        );
        run
    };
    let [whole, half] = [2.0e-6, 1.0e-6].map(run);
    let [whole, half] = [whole, half].map(|run| Row::mean(&run.rows[16..]));
    for row in [whole, half] {
        assert!(row.residual().abs() < 5e-4, "{}", row.residual());
        assert!(row.residual_of_losses().abs() < 0.02, "{}", row.residual_of_losses());
    }
    assert!(
        (whole.thrust_ratio() / half.thrust_ratio() - 1.0).abs() < 3e-3,
        "{} {}",
        whole.thrust_ratio(),
        half.thrust_ratio()
    );
    assert!(
        (whole.slip() / half.slip() - 1.0).abs() < 0.03,
        "{} {}",
        whole.slip(),
        half.slip()
    );
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
    assert_eq!(run.machine.x, again.machine.x);
    assert!(run.rows.len() == 4);
}

#[test]
fn bad_input_gets_one_line() {
    for (change, expected) in [
        ((|case: &mut Case| case.share = 1.2) as fn(&mut Case), "share"),
        (|case| case.ratio = 9.0, "ratio"),
        (|case| case.force = f64::NAN, "force"),
        (|case| case.options.step = Some(1.0), "step"),
        (|case| case.options.lever = Some(-1e-4), "lever"),
        (|case| case.parameters.layers.count = 20, "lever"),
        (
            |case| case.parameters.belt.element_thickness = 0.09,
            "belt.elementThickness",
        ),
        (|case| case.parameters.friction.pulley = 0.5, "friction.pulley"),
    ] {
        let mut case = Case::named("medium-0.4").unwrap();
        change(&mut case);
        let message = case.start().unwrap_err().to_string();
        assert!(message.contains(expected) && !message.contains('\n'), "{message}");
    }
    assert!(Case::named("medium").is_err() && Case::named("wide-0.4").is_err());
}

#[test]
fn a_step_that_is_too_large_ends_with_element_time_and_cause() {
    let mut case = short("medium-0.4", 0.05);
    case.options.step = Some(5.0e-5);
    let mut run = Run::new(case).unwrap();
    let fault = run.advance(u64::MAX).unwrap_err();
    let text = fault.to_string();
    assert!(
        fault.element >= 1 && fault.time > 0.0 && text.contains("step"),
        "{text}"
    );
    assert!(run.rows_csv().lines().count() == 1 + run.rows.len());
}

#[test]
fn an_element_that_leaves_the_belt_is_named() {
    let mut machine = short("medium-0.4", 0.01).start().unwrap();
    machine.check().unwrap();
    machine.u[123] = 30.0;
    let fault = machine.check().unwrap_err();
    assert_eq!(fault.element, 123);
    assert!(fault.to_string().contains("leaves the belt at 30.0 m/s"), "{fault}");
    machine.u[123] = 0.0;
    machine.chords.length[77] *= 2.5;
    assert_eq!(machine.check().unwrap_err().element, 77);
    machine.chords.length[77] /= 2.5;
    machine.pulleys[1].z = 1.0;
    let fault = machine.check().unwrap_err().to_string();
    assert!(fault.contains("the primary sheaves reach their stop"), "{fault}");
}
