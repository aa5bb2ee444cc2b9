//! The film between the elements and what it does to gaps, slip and traction: for `examples/film.rs` and tests.

use std::error::Error;

use pushbelt::contact::full_slip_torque;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Axial, Drive, Inputs, Outputs, Parameters, RingModel, ShaftDrag, StartState};

use crate::inside::stations;

/// The oil between the elements: `belt.suction`, N, `belt.filmThickness`, m, `belt.roughness`, m, `belt.filmDamping`, N·s, and
/// `belt.squeezeDamping`, N·s.
pub fn film(p: &mut Parameters) -> [&mut f64; 5] {
    let belt = &mut p.belt;
    [
        &mut belt.suction,
        &mut belt.film_thickness,
        &mut belt.roughness,
        &mut belt.film_damping,
        &mut belt.squeeze_damping,
    ]
}

pub const RATIOS: [(&str, f64); 3] = [("LOW", 2.25), ("medium", 1.0), ("OD", 1.0 / 2.25)];
/// Torques as shares of full slip's.
pub const SHARES: [f64; 3] = [0.4, 0.6, 0.8];
pub const SPEED: f64 = 209.44;
pub const SLOW: f64 = 52.36;
/// Share of the peak of traction at which slip is read, and the slips at which traction is.
pub const NEAR_PEAK: f64 = 0.95;
pub const SLIPS: [f64; 18] = [
    0.004, 0.006, 0.008, 0.01, 0.012, 0.014, 0.016, 0.018, 0.02, 0.0225, 0.025, 0.0275, 0.03, 0.035, 0.04, 0.05, 0.06,
    0.08,
];

/// Variators without drag of the shafts and friction of layers, as in the continuum theory.
pub struct FilmBench {
    pub parameters: Parameters,
}

/// How the shafts are loaded.
#[derive(Clone, Copy)]
pub enum Load {
    /// Torque at the primary pulley as a share of full slip's.
    Share(f64),
    /// Slip between shafts that are both held at their speeds.
    Slip(f64),
}

impl FilmBench {
    /// With the default film.
    pub fn new(ring: RingModel) -> Self {
        let mut parameters = Parameters {
            ring_model: ring,
            ..Parameters::default()
        };
        parameters.primary.axial = Axial::Held;
        parameters.secondary.drive = Drive::Speed;
        parameters.layers.friction = 0.0;
        for pulley in [&mut parameters.primary, &mut parameters.secondary] {
            pulley.drag = ShaftDrag::default();
        }
        Self { parameters }
    }

    /// The steady variator; none where there is no steady state.
    pub fn steady(&self, ratio: f64, speed: f64, force: f64, load: Load) -> Result<Option<Variator>, Box<dyn Error>> {
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

    pub fn outputs(&self, ratio: f64, force: f64, load: Load) -> Result<Option<Outputs>, Box<dyn Error>> {
        Ok(self.steady(ratio, SPEED, force, load)?.map(|mut v| v.outputs().clone()))
    }

    /// Least push force anywhere, N: 2 kN, no torque, at low speed; the least of the three ratios.
    pub fn least_push(&self) -> Result<f64, Box<dyn Error>> {
        let mut least = f64::INFINITY;
        for (_, ratio) in RATIOS {
            let Some(variator) = self.steady(ratio, SLOW, 2e3, Load::Share(0.0))? else {
                return Ok(f64::NAN);
            };
            let stations = stations(&variator, variator.state());
            least = stations.iter().map(|s| s.push).fold(least, f64::min);
        }
        Ok(least)
    }

    /// Idle arc of the primary pulley as a share of its wrap.
    pub fn onset(&self, share: f64) -> Result<f64, Box<dyn Error>> {
        let Some(mut variator) = self.steady(1.0, SPEED, 15e3, Load::Share(share))? else {
            return Ok(f64::NAN);
        };
        let stations = stations(&variator, variator.state());
        let arcs = stations.iter().filter(|s| s.on_arc());
        let wrap: f64 = arcs.map(|s| 0.5 * s.curvature[0] * s.weight).sum();
        Ok(variator.outputs().primary.idle_arc / wrap)
    }

    /// Slip at 12 kN and half the torque of full slip, in LOW.
    pub fn slip(&self, play: f64) -> Result<f64, Box<dyn Error>> {
        let mut other = Self {
            parameters: self.parameters.clone(),
        };
        other.parameters.belt.play = play;
        let outputs = other.outputs(RATIOS[0].1, 12e3, Load::Share(0.5))?;
        Ok(outputs.map_or(f64::NAN, |o| o.slip))
    }

    /// Slip at a share of the peak of traction, and the peak as a share of full slip.
    pub fn near_peak(&self, ratio: f64) -> Result<[f64; 2], Box<dyn Error>> {
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
