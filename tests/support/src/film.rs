//! The film between the elements and what it does to gaps, slip and traction: for
//! `examples/film.rs` and tests. The variators are those of [`film_variator`], as they are or
//! changed.

use crate::steady::stations;
use crate::variators::{SPEED, variator};
use pushbelt::contact::full_slip_torque;
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{
    Axial, Drive, Inputs, Outputs, Parameters, RingModel, ShaftDrag, StartState,
};
use std::error::Error;

/// The oil between the elements: `belt.suction`, N, `belt.filmThickness`, m, `belt.roughness`, m,
/// `belt.filmDamping`, N·s, and `belt.squeezeDamping`, N·s.
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

/// LOW, medium, OD.
pub const RATIOS: [f64; 3] = [2.25, 1.0, 1.0 / 2.25];
/// Torques as shares of full slip's.
pub const SHARES: [f64; 3] = [0.4, 0.6, 0.8];
const SLOW: f64 = 52.36;
/// Share of the peak of traction at which slip is read, and the slips at which traction is.
const NEAR_PEAK: f64 = 0.95;
const SLIPS: [f64; 18] = [
    0.004, 0.006, 0.008, 0.01, 0.012, 0.014, 0.016, 0.018, 0.02, 0.0225, 0.025, 0.0275, 0.03, 0.035, 0.04,
    0.05, 0.06, 0.08,
];

#[derive(Clone, Copy)]
pub enum Load {
    /// Torque at the primary pulley as a share of full slip's.
    Share(f64),
    /// Slip between shafts that are both held at their speeds.
    Slip(f64),
}

type Found<T> = Result<T, Box<dyn Error>>;

/// With the default film, without drag of the shafts and friction of layers, as in the continuum
/// theory.
pub fn film_variator(ring: RingModel) -> Parameters {
    let mut parameters = variator(ring);
    parameters.primary.axial = Axial::Held;
    parameters.secondary.drive = Drive::Speed;
    parameters.layers.friction = 0.0;
    for pulley in [&mut parameters.primary, &mut parameters.secondary] {
        pulley.drag = ShaftDrag::default();
    }
    parameters
}

/// The steady variator; none where there is no steady state.
pub fn steady(
    parameters: &Parameters,
    ratio: f64,
    speed: f64,
    force: f64,
    load: Load,
) -> Found<Option<Variator>> {
    let mut p = parameters.clone();
    p.initial.ratio = ratio;
    p.initial.primary_speed = speed;
    let mut inputs = Inputs::default();
    inputs.secondary.clamping_force = force;
    inputs.primary.speed_setpoint = speed;
    inputs.secondary.speed_setpoint = speed / ratio;
    match load {
        Load::Share(share) => {
            let radius = running_radius(&p);
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

pub fn outputs(parameters: &Parameters, ratio: f64, force: f64, load: Load) -> Found<Option<Outputs>> {
    Ok(steady(parameters, ratio, SPEED, force, load)?.map(|mut v| v.outputs().clone()))
}

/// The least push force anywhere, N.
pub fn lowest_push(variator: &Variator) -> f64 {
    let stations = stations(variator.system(), variator.state());
    stations.iter().map(|at| at.sample.push).fold(f64::INFINITY, f64::min)
}

/// The same with 2 kN and no torque, at low speed: the least of the three ratios.
pub fn least_push(parameters: &Parameters) -> Found<f64> {
    let mut least = f64::INFINITY;
    for ratio in RATIOS {
        let Some(variator) = steady(parameters, ratio, SLOW, 2e3, Load::Share(0.0))? else {
            return Ok(f64::NAN);
        };
        least = least.min(lowest_push(&variator));
    }
    Ok(least)
}

/// Idle arc of the primary pulley as a share of its wrap.
pub fn onset(parameters: &Parameters, share: f64) -> Found<f64> {
    let Some(mut variator) = steady(parameters, 1.0, SPEED, 15e3, Load::Share(share))? else {
        return Ok(f64::NAN);
    };
    let stations = stations(variator.system(), variator.state());
    let on_arcs = stations.iter().map(|at| &at.sample).filter(|s| s.on_arc());
    let wrap: f64 = on_arcs.map(|s| 0.5 * s.curvature * s.weight).sum();
    Ok(variator.outputs().primary.idle_arc / wrap)
}

/// Slip at 12 kN and half the torque of full slip, in LOW.
pub fn slip(parameters: &Parameters, play: f64) -> Found<f64> {
    let mut other = parameters.clone();
    other.belt.play = play;
    let outputs = outputs(&other, RATIOS[0], 12e3, Load::Share(0.5))?;
    Ok(outputs.map_or(f64::NAN, |o| o.slip))
}

/// Slip at a share of the peak of traction, and the peak as a share of full slip.
pub fn near_peak(parameters: &Parameters, ratio: f64) -> Found<[f64; 2]> {
    let mut curve = vec![[0.0, 0.0]];
    for slip in SLIPS {
        if let Some(outputs) = outputs(parameters, ratio, 15e3, Load::Slip(slip))? {
            curve.push([outputs.slip, outputs.torque_utilisation]);
        }
    }
    let peak = curve.iter().map(|c| c[1]).fold(0.0, f64::max);
    let above = curve.iter().position(|c| c[1] >= NEAR_PEAK * peak).unwrap_or(1).max(1);
    let [[s0, u0], [s1, u1]] = [curve[above - 1], curve[above]];
    Ok([s0 + (s1 - s0) * (NEAR_PEAK * peak - u0) / (u1 - u0), peak])
}

/// Pitch radius of the primary pulley in the state without load, m.
fn running_radius(parameters: &Parameters) -> f64 {
    let mut p = parameters.clone();
    p.initial.steady = false;
    let mut variator = Variator::new(p).expect("parameters are valid");
    variator.initialise(0.0, &Inputs::default()).expect("the geometry fits");
    variator.outputs().primary.radius
}
