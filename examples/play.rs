//! Distribution of the belt's play with and without oil between the elements: at a fifth of
//! capacity near ratio 1, and with a coasting engine in overdrive. Prints slip and work over half a
//! second of each, also on other meshes, without play and without ring friction, with the
//! fastest-growing mode of the steady state. Draws the gaps along the belt over time
//! (`target/play.svg`). Then counts the working points at which slip oscillates:
//!
//! `cargo run --release --example play`

use std::error::Error;

use plotters::prelude::*;
use pushbelt::variator::linear::modes;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::Inputs;
use pushbelt::variator::settings::{Axial, Drive, Parameters};
use pushbelt_support::steady::stations;

/// A working point: the primary sheave is held, the secondary shaft has a constant speed.
#[derive(Clone, Copy)]
struct Point {
    ratio: f64,
    /// ω_P, rad/s.
    speed: f64,
    /// On both pulleys, N.
    clamping: f64,
    /// At the primary pulley, and what is added to it from 0.1 to 0.3 s, N·m.
    torque: f64,
    jolt: f64,
}

const LITTLE_LOAD: Point = Point {
    ratio: 1.06,
    speed: 159.0,
    clamping: 4e3,
    torque: 8.0,
    jolt: 10.0,
};
const COASTING: Point = Point {
    ratio: 0.45,
    speed: 200.0,
    clamping: 12e3,
    torque: -67.0,
    jolt: -1.3,
};
const STEP: f64 = 1e-3;
/// The evaluated last part of the run.
const END: f64 = 1.2;
const WATCHED: f64 = 0.5;

type Change = (&'static str, fn(&mut Parameters));

const CHANGES: [Change; 7] = [
    ("as it is", |_| ()),
    ("loose", undamp),
    ("loose, one cell an element", |p| {
        undamp(p);
        p.mesh.cells_per_element = 1;
    }),
    ("loose, twice the elements", |p| {
        undamp(p);
        p.mesh = p.mesh.refined(2);
    }),
    ("loose, a tenth of the tolerance", |p| {
        undamp(p);
        p.solver.tolerance *= 0.1;
    }),
    ("loose, no play", |p| {
        undamp(p);
        p.belt.play = 0.0;
    }),
    ("loose, no ring friction", |p| {
        undamp(p);
        p.friction.ring = 0.0;
    }),
];

const CALMED: [Change; 10] = [
    ("as it is", |_| ()),
    ("a third of the damping by oil", |p| {
        p.belt.film_damping /= 3.0;
        p.belt.squeeze_damping /= 3.0;
    }),
    ("loose", undamp),
    ("loose, `primary.inertia` 0.05", |p| {
        undamp(p);
        p.primary.inertia = 0.05;
    }),
    ("loose, `primary.inertia` 0.1", |p| {
        undamp(p);
        p.primary.inertia = 0.1;
    }),
    ("loose, `belt.play` 1e-4", |p| {
        undamp(p);
        p.belt.play = 1e-4;
    }),
    ("loose, no ring friction", |p| {
        undamp(p);
        p.friction.ring = 0.0;
    }),
    ("loose, elements of a fifth of the mass", |p| {
        undamp(p);
        p.belt.mass_per_length *= 0.2;
    }),
    ("loose, a stack five times as stiff", |p| {
        undamp(p);
        p.belt.push_stiffness *= 5.0;
    }),
    ("loose, twice the elements", |p| {
        undamp(p);
        p.mesh = p.mesh.refined(2);
    }),
];
/// The case whose gaps are drawn.
const DRAWN: usize = 2;

/// No damping by oil.
fn undamp(parameters: &mut Parameters) {
    parameters.belt.film_damping = 0.0;
    parameters.belt.squeeze_damping = 0.0;
}

/// Ratios, clamping forces of both pulleys, N, and torques as shares of full slip's, of the counted
/// working points.
const RATIOS: [f64; 8] = [0.43, 0.5, 0.8, 0.95, 1.0, 1.06, 1.3, 2.0];
const FORCES: [f64; 2] = [4e3, 10e3];
/// Torque of full slip at ratio 1, N·m; it is proportional to the radius.
const FULL_SLIP: f64 = 43.0;
const SHARES: [f64; 11] = [-0.6, -0.45, -0.3, -0.1, 0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.5];
/// Range of slip over half a second that counts as an oscillation.
const SWING: f64 = 5e-4;
/// Highest frequency of the modes, Hz.
const FASTEST: f64 = 1e4;

/// At stations: time, s, ξ, m, ring length of the station, m, 1 − ν.
type Gaps = Vec<[f64; 4]>;
/// Steps between two samples.
const LOOK: u32 = 2;

fn main() -> Result<(), Box<dyn Error>> {
    println!("{HEADER}");
    for (name, change) in CHANGES {
        run(&LITTLE_LOAD, name, change)?;
    }
    println!("\n{HEADER}");
    for (k, (name, change)) in CALMED.iter().enumerate() {
        let gaps = run(&COASTING, name, *change)?;
        if k == DRAWN {
            draw(&gaps)?;
        }
    }
    println!("\ndrawn in target/play.svg\n");
    survey("as it is", |_| ())?;
    survey("loose", undamp)?;
    Ok(())
}

/// Results of the last part of a run.
struct Swing {
    /// Least and most slip.
    slip: [f64; 2],
    steps: u64,
    jacobians: u64,
    gaps: Gaps,
    /// Growth of the fastest-growing mode of the start state, 1/s and Hz; none if that is not
    /// steady.
    mode: Option<[f64; 2]>,
}

/// A run at a held ratio, with one pulse of torque.
fn swing(change: fn(&mut Parameters), point: &Point) -> Result<Swing, Box<dyn Error>> {
    let Point {
        ratio,
        speed,
        clamping,
        torque,
        jolt,
    } = *point;
    let mut parameters = Parameters::default();
    parameters.primary.axial = Axial::Held;
    parameters.secondary.drive = Drive::Speed;
    parameters.initial.ratio = ratio;
    parameters.initial.primary_speed = speed;
    change(&mut parameters);
    let mut inputs = Inputs::default();
    inputs.primary.torque = torque;
    inputs.primary.clamping_force = clamping;
    inputs.secondary.clamping_force = clamping;
    inputs.secondary.speed_setpoint = speed / ratio;
    let mode = modes(&parameters, &inputs, FASTEST).ok().map(|modes| modes[0]);
    let mut variator = Variator::new(parameters)?;
    variator.initialise(0.0, &inputs)?;
    let (mut least, mut most, mut gaps) = (f64::INFINITY, f64::NEG_INFINITY, Gaps::new());
    let mut before = variator.counts();
    let steps = (END / STEP).round() as u32;
    for k in 0..steps {
        let time = f64::from(k) * STEP;
        let jolted = (0.1..0.3).contains(&time);
        inputs.primary.torque = torque + if jolted { jolt } else { 0.0 };
        variator.advance(f64::from(k + 1) * STEP, &inputs)?;
        if time < END - WATCHED {
            before = variator.counts();
            continue;
        }
        let slip = variator.outputs().slip;
        (least, most) = (least.min(slip), most.max(slip));
        if k % LOOK == 0 {
            let stations = stations(variator.system(), variator.state());
            let samples = stations.iter().map(|at| &at.sample);
            gaps.extend(samples.map(|s| [time, s.xi, s.weight, 1.0 - s.density]));
        }
    }
    let counts = variator.counts();
    Ok(Swing {
        slip: [least, most],
        steps: counts.steps - before.steps,
        jacobians: counts.factorizations - before.factorizations,
        gaps,
        mode: mode.map(|[growth, turn]| [growth, turn / std::f64::consts::TAU]),
    })
}

const HEADER: &str =
    "| changed | slip, least | most | steps | Jacobians | fastest growth |\n|---|---|---|---|---|---|";

fn run(point: &Point, name: &str, change: fn(&mut Parameters)) -> Result<Gaps, Box<dyn Error>> {
    let found = swing(change, point)?;
    let [least, most] = found.slip.map(|slip| 1e2 * slip);
    let mode = found.mode.map_or("–".to_string(), |[growth, frequency]| {
        format!("{growth:.2} 1/s at {frequency:.0} Hz")
    });
    println!(
        "| {name} | {least:.2} % | {most:.2} % | {} | {} | {mode} |",
        found.steps, found.jacobians
    );
    Ok(found.gaps)
}

/// Over ratios, clamping forces and torques: the points at which slip oscillates, and the Jacobians
/// of all runs.
fn survey(name: &str, change: fn(&mut Parameters)) -> Result<(), Box<dyn Error>> {
    let (mut points, mut formed, mut growing, mut swinging) = (0, 0, 0, Vec::new());
    for ratio in RATIOS {
        for force in FORCES {
            for share in SHARES {
                // A pulse in proportion to the torque.
                let more = 2.0 / (1.0 + ratio) * force / LITTLE_LOAD.clamping;
                let torque = share * FULL_SLIP * more;
                let point = Point {
                    ratio,
                    clamping: force,
                    torque,
                    jolt: LITTLE_LOAD.jolt * more,
                    ..LITTLE_LOAD
                };
                let found = swing(change, &point)?;
                points += 1;
                formed += found.jacobians;
                growing += u32::from(found.mode.is_some_and(|[growth, _]| growth > 0.0));
                let range = found.slip[1] - found.slip[0];
                if range > SWING {
                    let mode = found.mode.map_or(f64::NAN, |[growth, _]| growth);
                    swinging.push(format!(
                        "{ratio} at {torque:.0} N·m, {:.2} % ({mode:.2} 1/s)",
                        1e2 * range
                    ));
                }
            }
        }
    }
    println!(
        "{name}: slip swings by more than {} % at {} of {points} points, a mode grows at {growing}, {formed} Jacobians in all",
        1e2 * SWING,
        swinging.len()
    );
    println!("  ratio {}", swinging.join("; ratio "));
    Ok(())
}

fn draw(gaps: &Gaps) -> Result<(), Box<dyn Error>> {
    let sheet = SVGBackend::new("target/play.svg", (760, 460)).into_drawing_area();
    sheet.fill(&WHITE)?;
    let length = Parameters::default().geometry.belt_length;
    let mut chart = ChartBuilder::on(&sheet)
        .caption("Gaps of more than 0.05 % along the belt", ("sans-serif", 16))
        .margin(12)
        .x_label_area_size(36)
        .y_label_area_size(56)
        .build_cartesian_2d(END - WATCHED..END, 0.0..length)?;
    chart
        .configure_mesh()
        .disable_mesh()
        .x_desc("time, s")
        .y_desc("place along the belt, m")
        .draw()?;
    let wide = gaps.iter().filter(|[.., gap]| *gap > 5e-4);
    chart.draw_series(wide.map(|&[time, xi, width, gap]| {
        let shade = (gap / 5e-3).min(1.0);
        Rectangle::new(
            [
                (time, xi - 0.5 * width),
                (time + f64::from(LOOK) * STEP, xi + 0.5 * width),
            ],
            RGBColor(196, 78, 30).mix(0.2 + 0.8 * shade).filled(),
        )
    }))?;
    sheet.present()?;
    Ok(())
}
