//! How thrust ratio and slip move with the parameters that nobody knows exactly, around the laboratory variator at 50
//! N·m, 2000 rpm and three ratios; then with the roughness over which neighbouring elements touch, and with that and
//! the damping of the film between them. Prints the Markdown tables of `docs/sensitivity.md`:
//!
//! `cargo run --release --example sensitivity`

use std::error::Error;

use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Axial, Drive, Parameters};
use pushbelt::variator::settings::{Inputs, StartState};

/// A working point.
struct Case {
    name: &'static str,
    /// r_S/r_P.
    ratio: f64,
    /// N·m.
    torque: f64,
    /// Secondary clamping force: 1.3 times what full slip needs, 6 kN at least, N.
    force: f64,
}

const fn case(name: &'static str, ratio: f64, torque: f64, force: f64) -> Case {
    Case {
        name,
        ratio,
        torque,
        force,
    }
}

const CASES: [Case; 3] = [
    case("underdrive", 7.0 / 3.0, 50.0, 10_781.0),
    case("medium", 1.0, 50.0, 6_174.0),
    case("overdrive", 3.0 / 7.0, 50.0, 6_000.0),
];
/// Where the first touch matters most.
const TOUCH_CASES: [Case; 3] = [
    case("underdrive, 100 N·m", 7.0 / 3.0, 100.0, 21_562.0),
    case("medium, 50 N·m", 1.0, 50.0, 6_174.0),
    case("overdrive, 30 N·m", 3.0 / 7.0, 30.0, 6_000.0),
];
/// Roughness of the elements' faces, m.
const ROUGHNESSES: [f64; 9] = [5e-8, 7e-8, 1e-7, 1.4e-7, 2e-7, 3e-7, 4e-7, 6e-7, 1e-6];
/// Where slip depends on the roughness without film damping.
const DAMPED: Case = case("underdrive, 50 N·m", 7.0 / 3.0, 50.0, 11_200.0);
/// Film dampings of the third table, N·s.
const DAMPINGS: [f64; 3] = [0.0, 1.0, 3.0];
const SPEED: f64 = 209.44;

type Change = (&'static str, fn(&mut Parameters));

const CHANGES: [Change; 33] = [
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
    ("roughness of the elements × 0.5", |p| p.belt.roughness *= 0.5),
    ("roughness of the elements × 2", |p| p.belt.roughness *= 2.0),
    ("film force × 0.5", |p| p.belt.film_force *= 0.5),
    ("film force × 2", |p| p.belt.film_force *= 2.0),
    ("film thickness × 0.5", |p| p.belt.film_thickness *= 0.5),
    ("film thickness × 2", |p| p.belt.film_thickness *= 2.0),
    ("film damping = 0", |p| p.belt.film_damping = 0.0),
    ("film damping × 0.5", |p| p.belt.film_damping *= 0.5),
    ("film damping × 2", |p| p.belt.film_damping *= 2.0),
    ("roughness of the flanks × 0.5", |p| p.contact.roughness *= 0.5),
    ("roughness of the flanks × 2", |p| p.contact.roughness *= 2.0),
    ("tilt clearance × 0.5", |p| clearance(p, 0.5)),
    ("tilt clearance × 2", |p| clearance(p, 2.0)),
    ("fall of friction = 0", |p| p.friction.fall = 0.0),
    ("fall of friction × 2", |p| p.friction.fall *= 2.0),
    ("friction velocity v_0 × 0.5", |p| p.friction.velocity *= 0.5),
    ("friction velocity v_0 × 2", |p| p.friction.velocity *= 2.0),
    ("mesh × 0.5", |p| mesh(p, 1, 2)),
    ("mesh × 2", |p| mesh(p, 2, 1)),
    ("mesh × 4", |p| mesh(p, 4, 1)),
];

fn tilt(p: &mut Parameters, factor: f64) {
    p.primary.tilt.stiffness *= factor;
    p.secondary.tilt.stiffness *= factor;
}

fn clearance(p: &mut Parameters, factor: f64) {
    p.primary.tilt.clearance *= factor;
    p.secondary.tilt.clearance *= factor;
}

fn mesh(p: &mut Parameters, times: i32, over: i32) {
    for count in [&mut p.mesh.primary_arc, &mut p.mesh.secondary_arc, &mut p.mesh.strand] {
        *count = *count * times / over;
    }
}

/// Thrust ratio and slip of the steady state; none where the belt does not carry the torque.
fn steady(parameters: &Parameters, case: &Case) -> Result<Option<(f64, f64)>, Box<dyn Error>> {
    let mut p = parameters.clone();
    p.initial.ratio = case.ratio;
    p.initial.primary_speed = SPEED;
    p.primary.axial = Axial::Held;
    p.secondary.drive = Drive::Speed;
    let mut inputs = Inputs::default();
    inputs.primary.torque = case.torque;
    inputs.secondary.clamping_force = case.force;
    inputs.secondary.speed_setpoint = SPEED / case.ratio;
    let mut variator = Variator::new(p)?;
    variator.initialise(0.0, &inputs)?;
    let outputs = variator.outputs();
    if outputs.start_state != StartState::Steady || outputs.macro_slip {
        return Ok(None);
    }
    Ok(Some((outputs.thrust_ratio, outputs.slip)))
}

fn heading(first: &str, cases: &[Case]) {
    print!("| {first} |");
    for case in cases {
        print!(" {}: thrust ratio | slip |", case.name);
    }
    println!("\n|---|{}", "---|---|".repeat(cases.len()));
}

fn main() -> Result<(), Box<dyn Error>> {
    let base = Parameters::default();
    let mut reference = [(0.0, 0.0); 3];
    heading("changed", &CASES);
    print!("| nothing |");
    for (case, reference) in CASES.iter().zip(&mut reference) {
        *reference = steady(&base, case)?.ok_or("no steady state at default parameters")?;
        print!(" {:.4} | {:.2} % |", reference.0, 100.0 * reference.1);
    }
    println!();
    for (name, change) in CHANGES {
        let mut parameters = base.clone();
        change(&mut parameters);
        print!("| {name} |");
        for (case, reference) in CASES.iter().zip(&reference) {
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
    println!();
    heading("roughness, µm", &TOUCH_CASES);
    for roughness in ROUGHNESSES {
        let mut parameters = base.clone();
        parameters.belt.roughness = roughness;
        print!("| {:.2} |", 1e6 * roughness);
        for case in &TOUCH_CASES {
            match steady(&parameters, case)? {
                Some((thrust, slip)) => print!(" {thrust:.3} | {:.2} % |", 100.0 * slip),
                None => print!(" slips | – |"),
            }
        }
        println!();
    }
    println!();
    print!("| roughness, µm |");
    for damping in DAMPINGS {
        print!(" slip at film damping {damping:.0} N·s |");
    }
    println!("\n|---|{}", "---|".repeat(DAMPINGS.len()));
    for roughness in ROUGHNESSES {
        print!("| {:.2} |", 1e6 * roughness);
        for damping in DAMPINGS {
            let mut parameters = base.clone();
            parameters.belt.roughness = roughness;
            parameters.belt.film_damping = damping;
            match steady(&parameters, &DAMPED)? {
                Some((_, slip)) => print!(" {:.2} % |", 100.0 * slip),
                None => print!(" – |"),
            }
        }
        println!();
    }
    Ok(())
}
