//! Sensitivity of thrust ratio and slip to uncertain parameters, around the laboratory variator at
//! 50 N·m, 2000 rpm and three ratios; then to the roughness of the elements' faces and the film
//! between them; then that of the thrust ratio without torque and of the peak of traction. Prints
//! Markdown tables; `docs/notebook/figures.md` has what decides:
//!
//! `cargo run --release --example sensitivity`

use std::error::Error;

use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Axial, Drive, Parameters};
use pushbelt::variator::settings::{Inputs, StartState};

/// A working point.
#[derive(Clone, Copy)]
struct Case {
    name: &'static str,
    /// r_S/r_P.
    ratio: f64,
    /// N·m.
    torque: f64,
    /// Secondary clamping force: 1.3 times that of full slip, at least 6 kN, N.
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
/// Cases in which the roughness of the faces has the largest effect.
const TOUCH_CASES: [Case; 3] = [
    case("underdrive, 100 N·m", 7.0 / 3.0, 100.0, 21_562.0),
    case("medium, 50 N·m", 1.0, 50.0, 6_174.0),
    case("overdrive, 30 N·m", 3.0 / 7.0, 30.0, 6_000.0),
];
/// Roughness of the elements' faces, m.
const ROUGHNESSES: [f64; 9] = [5e-8, 7e-8, 1e-7, 1.4e-7, 2e-7, 3e-7, 4e-7, 6e-7, 1e-6];
/// Cases in which slip depends on the roughness without damping by oil.
const DAMPED: [Case; 2] = [
    case("50 N·m", 7.0 / 3.0, 50.0, 10_781.0),
    case("100 N·m", 7.0 / 3.0, 100.0, 21_562.0),
];
/// Dampings by oil of the third table, as shares of the default.
const DAMPINGS: [f64; 4] = [0.0, 0.3, 1.0, 3.0];
/// Ratio and force without torque, –, N.
const UNLOADED: [(f64, f64); 4] = [(2.25, 10e3), (2.25, 20e3), (1.0 / 2.25, 10e3), (1.0 / 2.25, 20e3)];
const SLIPS: [f64; 6] = [0.007, 0.01, 0.015, 0.02, 0.03, 0.04];
const SPEED: f64 = 209.44;

type Change = (&'static str, fn(&mut Parameters));

const UNLOADED_CHANGES: [Change; 4] = [
    ("nothing", |_| {}),
    ("contact stiffness k_c × 2", |p| p.contact.stiffness *= 2.0),
    ("contact stiffness k_c × 20", |p| p.contact.stiffness *= 20.0),
    ("ring friction μ_r = 0", |p| p.friction.ring = 0.0),
];
const TRACTION_CHANGES: [Change; 3] = [
    ("nothing", |_| {}),
    ("ring friction μ_r = 0", |p| p.friction.ring = 0.0),
    ("fall of friction = 0", |p| p.friction.fall = 0.0),
];

const CHANGES: [Change; 39] = [
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
    ("suction × 0.5", |p| p.belt.suction *= 0.5),
    ("suction × 2", |p| p.belt.suction *= 2.0),
    ("film thickness × 0.5", |p| p.belt.film_thickness *= 0.5),
    ("film thickness × 2", |p| p.belt.film_thickness *= 2.0),
    ("film damping = 0", |p| p.belt.film_damping = 0.0),
    ("squeezed oil = 0", |p| p.belt.squeeze_damping = 0.0),
    ("squeezed oil × 0.5", |p| p.belt.squeeze_damping *= 0.5),
    ("squeezed oil × 2", |p| p.belt.squeeze_damping *= 2.0),
    ("all damping by oil = 0", |p| damp(p, 0.0)),
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
    ("that of the ring × 0.1", |p| p.friction.ring_velocity *= 0.1),
    ("that of the ring × 2", |p| p.friction.ring_velocity *= 2.0),
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

/// A variator that starts at a ratio, held by the primary sheave, and a primary speed, rad/s; its
/// secondary shaft follows a set point.
fn held(parameters: &Parameters, ratio: f64, speed: f64) -> Parameters {
    let mut p = parameters.clone();
    p.initial.ratio = ratio;
    p.initial.primary_speed = speed;
    p.primary.axial = Axial::Held;
    p.secondary.drive = Drive::Speed;
    p
}

/// Begins the row of a change; the changed parameters.
fn begin_row(base: &Parameters, name: &str, change: fn(&mut Parameters)) -> Parameters {
    print!("| {name} |");
    let mut parameters = base.clone();
    change(&mut parameters);
    parameters
}

/// Thrust ratio and slip of the steady state; none where the belt can't transmit the torque.
fn steady(parameters: &Parameters, case: &Case) -> Result<Option<(f64, f64)>, Box<dyn Error>> {
    let p = held(parameters, case.ratio, SPEED);
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

/// The fifth table: sensitivity of the thrust ratio without torque.
fn without_torque(base: &Parameters) -> Result<(), Box<dyn Error>> {
    print!("| changed |");
    for (ratio, force) in UNLOADED {
        print!(" ratio {ratio:.2}, {:.0} kN |", 1e-3 * force);
    }
    println!("\n|---|{}", "---|".repeat(UNLOADED.len()));
    for (name, change) in UNLOADED_CHANGES {
        let parameters = begin_row(base, name, change);
        for (ratio, force) in UNLOADED {
            match steady(&parameters, &case("", ratio, 0.0, force))? {
                Some((thrust, _)) => print!(" {thrust:.3} |"),
                None => print!(" – |"),
            }
        }
        println!();
    }
    Ok(())
}

/// The sixth table: differences between the peaks of traction over slip at 10 and 30 kN, 1000 and
/// 4000 rpm.
fn traction(base: &Parameters) -> Result<(), Box<dyn Error>> {
    println!("| changed | ratio 1: peaks apart | ratio 0.5: peaks apart |\n|---|---|---|");
    for (name, change) in TRACTION_CHANGES {
        let parameters = begin_row(base, name, change);
        for ratio in [1.0, 0.5] {
            let mut peaks = Vec::new();
            for force in [10e3, 30e3] {
                for speed in [SPEED / 2.0, 2.0 * SPEED] {
                    peaks.push(peak(&parameters, ratio, force, speed)?);
                }
            }
            let least = peaks.iter().copied().fold(f64::INFINITY, f64::min);
            let most = peaks.iter().copied().fold(0.0, f64::max);
            print!(" {:.1} % |", 100.0 * (most / least - 1.0));
        }
        println!();
    }
    Ok(())
}

/// Largest traction over slip.
fn peak(parameters: &Parameters, ratio: f64, force: f64, speed: f64) -> Result<f64, Box<dyn Error>> {
    let mut largest: f64 = 0.0;
    for slip in SLIPS {
        let mut p = held(parameters, ratio, speed);
        p.primary.drive = Drive::Speed;
        let mut inputs = Inputs::default();
        inputs.primary.speed_setpoint = speed;
        inputs.secondary.speed_setpoint = speed / ratio * (1.0 - slip);
        inputs.secondary.clamping_force = force;
        let mut variator = Variator::new(p)?;
        variator.initialise(0.0, &inputs)?;
        largest = largest.max(variator.outputs().torque_utilisation);
    }
    Ok(largest)
}

/// Prints a cell with the slip of a steady state.
fn slip(parameters: &Parameters, case: &Case) -> Result<(), Box<dyn Error>> {
    match steady(parameters, case)? {
        Some((_, slip)) => print!(" {:.2} % |", 100.0 * slip),
        None => print!(" slips |"),
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let base = Parameters::default();
    changes(&base)?;
    println!();
    roughness(&base)?;
    println!();
    damping(&base)?;
    println!();
    println!();
    without_torque(&base)?;
    println!();
    traction(&base)
}

/// The first table: one parameter at a time.
fn changes(base: &Parameters) -> Result<(), Box<dyn Error>> {
    let mut reference = [(0.0, 0.0); 3];
    heading("changed", &CASES);
    print!("| nothing |");
    for (case, reference) in CASES.iter().zip(&mut reference) {
        *reference = steady(base, case)?.ok_or("no steady state at default parameters")?;
        print!(" {:.4} | {:.2} % |", reference.0, 100.0 * reference.1);
    }
    println!();
    for (name, change) in CHANGES {
        let parameters = begin_row(base, name, change);
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
    Ok(())
}

/// The second table: the roughness alone.
fn roughness(base: &Parameters) -> Result<(), Box<dyn Error>> {
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
    Ok(())
}

/// Multiplies the damping by oil by a share.
fn damp(parameters: &mut Parameters, share: f64) {
    parameters.belt.film_damping *= share;
    parameters.belt.squeeze_damping *= share;
}

/// The third table: roughness and damping by oil.
fn damping(base: &Parameters) -> Result<(), Box<dyn Error>> {
    print!("| roughness, µm |");
    for case in &DAMPED {
        for damping in DAMPINGS {
            print!(" {}: slip at {damping} |", case.name);
        }
    }
    println!("\n|---|{}", "---|".repeat(DAMPED.len() * DAMPINGS.len()));
    for roughness in ROUGHNESSES {
        print!("| {:.2} |", 1e6 * roughness);
        for case in &DAMPED {
            for damping in DAMPINGS {
                let mut parameters = base.clone();
                parameters.belt.roughness = roughness;
                damp(&mut parameters, damping);
                slip(&parameters, case)?;
            }
        }
        println!();
    }
    Ok(())
}
