//! Gaps, slip and traction over the oil between the elements: the film force, its thickness, roughness and damping. Prints the
//! Markdown table of `docs/sensitivity.md`:
//!
//! `cargo run --release --example film`
//!
//! Values in the order of [`Film`] give one row of the first table, `ALE0` behind them uses that ring:
//! `cargo run --release --example film -- 5 1.5e-6 1e-7 1 900`

use std::error::Error;

use pushbelt::contact::full_slip_torque;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Axial, Drive, Inputs, Outputs, Parameters, RingModel, StartState};
use pushbelt_lab::inside::stations;

/// The oil between the elements.
#[derive(Clone, Copy, Debug)]
struct Film {
    /// `belt.filmForce`, N.
    force: f64,
    /// `belt.filmThickness`, m.
    thickness: f64,
    /// `belt.roughness`, m.
    roughness: f64,
    /// `belt.filmDamping`, N·s.
    damping: f64,
    /// `belt.squeezeDamping`, N·s.
    squeeze: f64,
}

impl Film {
    fn of(parameters: &Parameters) -> Self {
        let belt = &parameters.belt;
        Self {
            force: belt.film_force,
            thickness: belt.film_thickness,
            roughness: belt.roughness,
            damping: belt.film_damping,
            squeeze: belt.squeeze_damping,
        }
    }

    fn put(self, parameters: &mut Parameters) {
        let belt = &mut parameters.belt;
        belt.film_force = self.force;
        belt.film_thickness = self.thickness;
        belt.roughness = self.roughness;
        belt.film_damping = self.damping;
        belt.squeeze_damping = self.squeeze;
    }
}

const RATIOS: [(&str, f64); 3] = [("LOW", 2.25), ("medium", 1.0), ("OD", 1.0 / 2.25)];
/// Torques as shares of full slip's.
const SHARES: [f64; 3] = [0.4, 0.6, 0.8];
const SPEED: f64 = 209.44;
const SLOW: f64 = 52.36;
/// Share of the peak of traction at which slip is read, and the slips at which traction is.
const NEAR_PEAK: f64 = 0.95;
const SLIPS: [f64; 18] = [
    0.004, 0.006, 0.008, 0.01, 0.012, 0.014, 0.016, 0.018, 0.02, 0.0225, 0.025, 0.0275, 0.03, 0.035, 0.04, 0.05, 0.06,
    0.08,
];

/// Force, thickness, roughness and the two dampings of the rows: the earlier default, the default, and changes of it.
const TRIED: [[f64; 5]; 14] = [
    [100.0, 1.5e-6, 1e-7, 3.0, 900.0],
    [5.0, 1.5e-6, 1e-7, 2.0, 2700.0],
    [10.0, 1.5e-6, 1e-7, 2.0, 2700.0],
    [1.0, 1.5e-6, 1e-7, 2.0, 2700.0],
    [5.0, 1e-6, 1e-7, 2.0, 2700.0],
    [5.0, 3e-6, 1e-7, 2.0, 2700.0],
    [5.0, 1.5e-6, 5e-8, 2.0, 2700.0],
    [5.0, 1.5e-6, 2e-7, 2.0, 2700.0],
    [5.0, 1.5e-6, 1e-7, 0.3, 2700.0],
    [5.0, 1.5e-6, 1e-7, 5.0, 2700.0],
    [5.0, 1.5e-6, 1e-7, 2.0, 300.0],
    [5.0, 1.5e-6, 1e-7, 1.0, 900.0],
    [5.0, 1.5e-6, 1e-7, 3.0, 5400.0],
    [0.0, 1.5e-6, 1e-7, 0.0, 0.0],
];

/// Variators without drag of the shafts and friction of layers, as in the continuum theory.
struct Bench {
    parameters: Parameters,
}

/// How the shafts are loaded.
#[derive(Clone, Copy)]
enum Load {
    /// Torque at the primary pulley as a share of full slip's.
    Share(f64),
    /// Slip between shafts that are both held at their speeds.
    Slip(f64),
}

impl Bench {
    fn new(film: Film, ring: RingModel) -> Self {
        let mut parameters = Parameters {
            ring_model: ring,
            ..Parameters::default()
        };
        film.put(&mut parameters);
        parameters.primary.axial = Axial::Held;
        parameters.secondary.drive = Drive::Speed;
        parameters.layers.friction = 0.0;
        for pulley in [&mut parameters.primary, &mut parameters.secondary] {
            pulley.drag.constant = 0.0;
            pulley.drag.viscous = 0.0;
            pulley.drag.bearing_friction = 0.0;
        }
        Self { parameters }
    }

    /// The steady variator; none where there is no steady state.
    fn steady(&self, ratio: f64, speed: f64, force: f64, load: Load) -> Result<Option<Variator>, Box<dyn Error>> {
        let mut p = self.parameters.clone();
        p.initial.ratio = ratio;
        p.initial.primary_speed = speed;
        let mut inputs = Inputs::default();
        inputs.secondary.clamping_force = force;
        inputs.primary.speed_setpoint = speed;
        inputs.secondary.speed_setpoint = speed / ratio;
        match load {
            Load::Share(share) => {
                let radius = running_radius(&p, ratio);
                inputs.primary.torque =
                    share * full_slip_torque(&p.friction, p.geometry.wedge_angle.cos(), force, radius);
            }
            Load::Slip(slip) => {
                p.primary.drive = Drive::Speed;
                inputs.secondary.speed_setpoint *= 1.0 - slip;
            }
        }
        let mut variator = Variator::new(p)?;
        variator.initialise(0.0, &inputs)?;
        let outputs = variator.outputs();
        let carried =
            outputs.start_state == StartState::Steady && !(outputs.macro_slip && matches!(load, Load::Share(_)));
        Ok(carried.then_some(variator))
    }

    fn outputs(&self, ratio: f64, force: f64, load: Load) -> Result<Option<Outputs>, Box<dyn Error>> {
        Ok(self.steady(ratio, SPEED, force, load)?.map(|mut v| v.outputs().clone()))
    }

    /// Least push force anywhere, N: 2 kN, no torque, at low speed; the least of the three ratios.
    fn least_push(&self) -> Result<f64, Box<dyn Error>> {
        let mut least = f64::INFINITY;
        for (_, ratio) in RATIOS {
            let Some(variator) = self.steady(ratio, SLOW, 2e3, Load::Share(0.0))? else {
                return Ok(f64::NAN);
            };
            least = stations(&variator, variator.state())
                .iter()
                .map(|s| s.push)
                .fold(least, f64::min);
        }
        Ok(least)
    }

    /// Idle arc of the primary pulley as a share of its wrap.
    fn onset(&self, share: f64) -> Result<f64, Box<dyn Error>> {
        let Some(mut variator) = self.steady(1.0, SPEED, 15e3, Load::Share(share))? else {
            return Ok(f64::NAN);
        };
        let wrap: f64 = stations(&variator, variator.state())
            .iter()
            .filter(|s| s.on_arc())
            .map(|s| 0.5 * s.curvature[0] * s.weight)
            .sum();
        Ok(variator.outputs().primary.idle_arc / wrap)
    }

    /// Slip at 12 kN and half the torque of full slip, in LOW.
    fn slip(&self, play: f64) -> Result<f64, Box<dyn Error>> {
        let mut other = Self {
            parameters: self.parameters.clone(),
        };
        other.parameters.belt.play = play;
        let outputs = other.outputs(RATIOS[0].1, 12e3, Load::Share(0.5))?;
        Ok(outputs.map_or(f64::NAN, |o| o.slip))
    }

    /// Slip at a share of the peak of traction, and the peak as a share of full slip.
    fn near_peak(&self, ratio: f64) -> Result<[f64; 2], Box<dyn Error>> {
        let mut curve = vec![[0.0, 0.0]];
        for slip in SLIPS {
            if let Some(outputs) = self.outputs(ratio, 15e3, Load::Slip(slip))? {
                curve.push([outputs.slip, outputs.torque_utilisation]);
            }
        }
        let peak = curve.iter().map(|c| c[1]).fold(0.0, f64::max);
        let above = curve.iter().position(|c| c[1] >= NEAR_PEAK * peak).unwrap_or(1).max(1);
        let [[s0, u0], [s1, u1]] = [curve[above - 1], curve[above]];
        Ok([s0 + (s1 - s0) * (NEAR_PEAK * peak - u0) / (u1 - u0), peak])
    }
}

/// Pitch radius of the primary pulley in the state without load, m.
fn running_radius(parameters: &Parameters, ratio: f64) -> f64 {
    let mut p = parameters.clone();
    p.initial.ratio = ratio;
    p.initial.steady = false;
    let mut variator = Variator::new(p).expect("parameters are valid");
    variator.initialise(0.0, &Inputs::default()).expect("the geometry fits");
    variator.outputs().primary.radius
}

fn heading() {
    println!(
        "| ring | film force, N | thickness, µm | roughness, µm | film damping, N·s | squeeze damping, N·s | least push force, N | idle arc at r = 0.4 | 0.6 | 0.8 \
         | slip at 0.2 mm of play | added at 0.4 mm | slip at 95 % of the peak, LOW | medium | OD | peaks | thrust ratio at r = 0.6, LOW | medium | OD | OD, r = 0 |"
    );
    println!("|---|{}", "---|".repeat(19));
}

fn row(film: Film, ring: RingModel) -> Result<(), Box<dyn Error>> {
    let bench = Bench::new(film, ring);
    let Film {
        force,
        thickness,
        roughness,
        damping,
        squeeze,
    } = film;
    print!(
        "| {} | {force} | {:.3} | {:.3} | {damping} | {squeeze} | {:.1} |",
        if ring == RingModel::Ale0 { "`ALE0`" } else { "`ALE`" },
        1e6 * thickness,
        1e6 * roughness,
        bench.least_push()?
    );
    for share in SHARES {
        print!(" {:.2} |", bench.onset(share)?);
    }
    let slips = [bench.slip(2e-4)?, bench.slip(4e-4)?];
    print!(" {:.2} % | {:+.2} |", 1e2 * slips[0], 1e2 * (slips[1] - slips[0]));
    let mut peaks = String::new();
    for (_, ratio) in RATIOS {
        let [slip, peak] = bench.near_peak(ratio)?;
        print!(" {:.2} % |", 1e2 * slip);
        peaks += &format!(" {peak:.3}");
    }
    print!("{peaks} |");
    for (_, ratio) in RATIOS {
        let outputs = bench.outputs(ratio, 15e3, Load::Share(0.6))?;
        print!(" {:.3} |", outputs.map_or(f64::NAN, |o| o.thrust_ratio));
    }
    let outputs = bench.outputs(RATIOS[2].1, 15e3, Load::Share(0.0))?;
    println!(" {:.3} |", outputs.map_or(f64::NAN, |o| o.thrust_ratio));
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let default = Film::of(&Parameters::default());
    if arguments.is_empty() {
        heading();
        for [force, thickness, roughness, damping, squeeze] in TRIED {
            let film = Film {
                force,
                thickness,
                roughness,
                damping,
                squeeze,
            };
            row(film, RingModel::Ale)?;
            row(film, RingModel::Ale0)?;
        }
        return Ok(());
    }
    let number = |k: usize, or: f64| arguments.get(k).map_or(Ok(or), |text| text.parse::<f64>());
    let film = Film {
        force: number(0, default.force)?,
        thickness: number(1, default.thickness)?,
        roughness: number(2, default.roughness)?,
        damping: number(3, default.damping)?,
        squeeze: number(4, default.squeeze)?,
    };
    let ring = if arguments.get(5).is_some_and(|name| name == "ALE0") {
        RingModel::Ale0
    } else {
        RingModel::Ale
    };
    row(film, ring)
}
