//! How thrust ratio and slip move with the parameters that nobody knows exactly, around the laboratory variator at 50 N·m,
//! 2000 rpm and three ratios. Prints the Markdown table of `docs/sensitivity.md`:
//!
//! `cargo run --release --example sensitivity`

use std::error::Error;

use pushbelt::variator::instance::Variator;
use pushbelt::variator::parameters::{Axial, Drive, Parameters};
use pushbelt::variator::signals::Inputs;

/// Name, r_S/r_P, secondary clamping force (1.3 times what full slip needs), N.
const CASES: [(&str, f64, f64); 3] = [
    ("underdrive", 7.0 / 3.0, 10_781.0),
    ("medium", 1.0, 6_174.0),
    ("overdrive", 3.0 / 7.0, 6_000.0),
];
const TORQUE: f64 = 50.0;
const SPEED: f64 = 209.44;

type Change = (&'static str, fn(&mut Parameters));

const CHANGES: [Change; 20] = [
    ("contact stiffness k_c × 0.5", |p| p.contact.stiffness *= 0.5),
    ("contact stiffness k_c × 2", |p| p.contact.stiffness *= 2.0),
    ("push stiffness k_e × 0.5", |p| p.belt.push_stiffness *= 0.5),
    ("push stiffness k_e × 2", |p| p.belt.push_stiffness *= 2.0),
    ("tilt stiffness k_tilt × 0.5", |p| tilt(p, 0.5)),
    ("tilt stiffness k_tilt × 2", |p| tilt(p, 2.0)),
    ("sheave friction μ − 0.01", |p| p.friction.pulley -= 0.01),
    ("sheave friction μ + 0.01", |p| p.friction.pulley += 0.01),
    ("sheave friction μ + 0.02", |p| p.friction.pulley += 0.02),
    ("ring friction μ_r = 0", |p| p.friction.ring = 0.0),
    ("ring friction μ_r × 2", |p| p.friction.ring *= 2.0),
    ("play = 0", |p| p.belt.play = 0.0),
    ("play × 2", |p| p.belt.play *= 2.0),
    ("contact strain × 1/3", |p| p.belt.contact_strain /= 3.0),
    ("contact strain × 2", |p| p.belt.contact_strain *= 2.0),
    ("friction velocity v_0 × 0.5", |p| p.friction.velocity *= 0.5),
    ("friction velocity v_0 × 2", |p| p.friction.velocity *= 2.0),
    ("mesh × 0.5", |p| mesh(p, 1, 2)),
    ("mesh × 2", |p| mesh(p, 2, 1)),
    ("mesh × 4", |p| mesh(p, 4, 1)),
];

fn tilt(p: &mut Parameters, factor: f64) {
    p.primary.tilt_stiffness *= factor;
    p.secondary.tilt_stiffness *= factor;
}

fn mesh(p: &mut Parameters, times: i32, over: i32) {
    for count in [&mut p.mesh.primary_arc, &mut p.mesh.secondary_arc, &mut p.mesh.strand] {
        *count = *count * times / over;
    }
}

/// Thrust ratio and slip of the steady state; none where the belt does not carry the torque.
fn steady(parameters: &Parameters, case: usize) -> Result<Option<(f64, f64)>, Box<dyn Error>> {
    let (_, ratio, force) = CASES[case];
    let mut p = parameters.clone();
    p.initial.ratio = ratio;
    p.initial.primary_speed = SPEED;
    p.primary.axial = Axial::Held;
    p.secondary.drive = Drive::Speed;
    let mut inputs = Inputs::default();
    inputs.primary.torque = TORQUE;
    inputs.secondary.clamping_force = force;
    inputs.secondary.speed_setpoint = SPEED / ratio;
    let mut variator = Variator::new(p)?;
    variator.initialise(0.0, &inputs)?;
    if variator.take_messages().iter().any(|m| m.warning) {
        return Ok(None);
    }
    let outputs = variator.outputs();
    Ok(Some((outputs.thrust_ratio, outputs.slip)))
}

fn main() -> Result<(), Box<dyn Error>> {
    let base = Parameters::default();
    let mut reference = [(0.0, 0.0); 3];
    print!("| changed |");
    for (name, _, _) in CASES {
        print!(" {name}: thrust ratio | slip |");
    }
    println!("\n|---|{}", "---|---|".repeat(CASES.len()));
    print!("| nothing |");
    for (case, reference) in reference.iter_mut().enumerate() {
        *reference = steady(&base, case)?.ok_or("no steady state at default parameters")?;
        print!(" {:.4} | {:.2} % |", reference.0, 100.0 * reference.1);
    }
    println!();
    for (name, change) in CHANGES {
        let mut parameters = base.clone();
        change(&mut parameters);
        print!("| {name} |");
        for (case, reference) in reference.iter().enumerate() {
            match steady(&parameters, case)? {
                Some((thrust, slip)) => print!(
                    " {:+.1} % | {:.2} % |",
                    100.0 * (thrust / reference.0 - 1.0),
                    100.0 * slip
                ),
                None => print!(" slips | – |"),
            }
        }
        println!();
    }
    Ok(())
}
