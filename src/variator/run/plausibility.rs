//! Warnings: parameters, loads and speeds that can hardly be intended, each once in a run, slip at
//! its start, strands that would buckle.

use super::simulation::Simulation;
use super::tuning::{BALANCED, FASTEST, MESSAGE_TIME};
use crate::archive::Archive;
use crate::pulley::{PerPulley, Pulley};
use crate::reference_curve::ratio_of_theta;
use crate::variator::settings::Drive;
use crate::variator::settings::capacity::{TorqueDemand, clamped, given_speed, short};
use crate::variator::settings::validation::Steel;
use crate::variator::steady::solve::geometric_ratio;
use std::f64::consts::PI;

#[derive(Clone, Debug)]
pub(super) struct PlausibilityWarnings {
    fast: bool,
    unit: bool,
    opens: bool,
    /// Those of pressures without effect, which a start gives first: it may fail because of them.
    pub idle: PerPulley<bool>,
    /// Since when a load has seemed to be in another unit, s; ∞ if none does.
    doubtful_since: f64,
    /// Last time at which a strand was in net compression, s; −∞ before.
    buckled: f64,
}

/// A warning, unless it was given before.
fn once(said: &mut bool, find: impl FnOnce() -> Option<String>) -> Option<String> {
    let found = if *said { None } else { find() };
    *said |= found.is_some();
    found
}

impl PlausibilityWarnings {
    pub const NONE: Self = Self {
        fast: false,
        unit: false,
        opens: false,
        idle: PerPulley {
            secondary: false,
            primary: false,
        },
        doubtful_since: f64::INFINITY,
        buckled: f64::NEG_INFINITY,
    };

    /// Warnings for the present state that were not given before. `starts`: the run starts from it.
    pub fn new_warnings(
        &mut self,
        simulation: &Simulation,
        starts: bool,
    ) -> impl Iterator<Item = String> + use<> {
        let at_start = |find: fn(&Simulation) -> Option<String>| if starts { find(simulation) } else { None };
        [
            at_start(other_layers),
            at_start(slipping),
            (!starts).then(|| buckling(simulation, &mut self.buckled)).flatten(),
            once(&mut self.fast, || fast_belt(simulation, starts)),
            once(&mut self.unit, || wrong_unit(simulation, &mut self.doubtful_since)),
            once(&mut self.opens, || opening_pressure(simulation)),
            simulation.system.parameters.idle_pressures(
                &simulation.inputs(),
                &mut self.idle,
                simulation.time,
            ),
            at_start(same_sign),
        ]
        .into_iter()
        .flatten()
    }

    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let of_all = [&mut self.fast, &mut self.unit, &mut self.opens];
        of_all
            .into_iter()
            .chain(self.idle.each_mut())
            .for_each(|said| archive.flag(said));
        for time in [&mut self.doubtful_since, &mut self.buckled] {
            archive.bounded_real(time, f64::NEG_INFINITY, f64::INFINITY);
        }
    }
}

fn other_layers(simulation: &Simulation) -> Option<String> {
    let Steel { modulus, density } = simulation.system.parameters.steel_of_other_layers()?;
    Some(format!(
        "ring.axialStiffness, ring.bendingStiffness and ring.massPerLength do not follow from ring.layers, ring.layerThickness and \
         ring.layerWidth: steel of {:.0} GPa and {density:.0} kg/m3; set them together",
        1e-9 * modulus
    ))
}

fn slipping(simulation: &Simulation) -> Option<String> {
    let Simulation { system, state, .. } = simulation;
    let speeds = system.belt.shaft_speeds(state.view());
    simulation.slips(false).then(|| {
        format!(
            "the belt slips through (macro-slip) in the state that the run starts from: {:.4} rad/s at the primary pulley, {:.4} rad/s at \
             the secondary, geometric ratio {:.4}",
            speeds.primary,
            speeds.secondary,
            geometric_ratio(system, state.view())
        )
    })
}

/// A strand under net compression, as at the time `last`, s.
fn buckling(simulation: &Simulation, last: &mut f64) -> Option<String> {
    let (time, force) = (simulation.time, simulation.energy.last.sums.strand_force);
    if force >= 0.0 {
        return None;
    }
    let real = if simulation.system.belt.law.is_pull_chain() {
        "chain would be slack"
    } else {
        "push strand would buckle"
    };
    let is_new = time - std::mem::replace(last, time) > MESSAGE_TIME;
    is_new.then(|| {
        format!(
            "at {time} s the net force in a strand is {force:.0} N: a real {real} (repeated only after {MESSAGE_TIME} s without)"
        )
    })
}

/// A force or torque that has seemed to be in another unit for some time, from `since` on, s.
fn wrong_unit(simulation: &Simulation, since: &mut f64) -> Option<String> {
    let (parameters, inputs) = (&simulation.system.parameters, simulation.inputs());
    let found = clamped(parameters).find_map(|pulley| {
        let (belt, view) = (&simulation.system.belt, simulation.state.view());
        let (ratio, speed) = (ratio_of_theta(belt.theta(view)), belt.shaft_speeds(view).primary);
        TorqueDemand::new(parameters, &inputs, pulley, ratio, speed).filter(TorqueDemand::seems_another_unit)
    });
    *since = if found.is_some() {
        since.min(simulation.time)
    } else {
        f64::INFINITY
    };
    let lasting = found.filter(|_| simulation.time - *since >= MESSAGE_TIME);
    lasting.map(|demand| format!("at {} s: {demand}", simulation.time))
}

fn fast_belt(simulation: &Simulation, starts: bool) -> Option<String> {
    let belt = &simulation.system.belt;
    let speed = simulation.state.y[belt.layout.drift()].abs();
    if speed <= FASTEST {
        return None;
    }
    let (parameters, inputs) = (&simulation.system.parameters, simulation.inputs());
    let led = parameters.primary.drive == Drive::Speed || parameters.secondary.drive == Drive::Speed;
    let cause = if led || starts {
        let (name, value) = given_speed(parameters, &inputs);
        format!("is {name} in rpm? {value} rpm are {} rad/s", short(value * PI / 30.0))
    } else {
        format!(
            "primary.torque = {} N·m and secondary.torque = {} N·m accelerate it; a load's torque is negative",
            inputs.primary.torque, inputs.secondary.torque
        )
    };
    Some(format!(
        "at {} s the belt runs at {} m/s, faster than belts of cars do (up to {FASTEST} m/s): {cause}",
        simulation.time,
        short(speed)
    ))
}

fn opening_pressure(simulation: &Simulation) -> Option<String> {
    let (parameters, inputs) = (&simulation.system.parameters, simulation.inputs());
    let (pulleys, view) = (simulation.system.pulleys(), simulation.state.view());
    let clamping =
        |j: Pulley| inputs.pulley(j).force(&parameters.pulley(j).cylinder) + pulleys.passive_force(j, view);
    parameters.opening_pressure(&inputs, PerPulley::from_fn(clamping), simulation.time)
}

/// Torques of a steady start that would balance if one of them had the other sign.
fn same_sign(simulation: &Simulation) -> Option<String> {
    let (parameters, inputs) = (&simulation.system.parameters, simulation.inputs());
    let [primary, secondary] = [inputs.primary.torque, inputs.secondary.torque];
    let speed = simulation.system.belt.shaft_speeds(simulation.state.view()).primary;
    let steady = parameters.initial.steady && speed.abs() > 1.0;
    let free = parameters.primary.drive == Drive::Torque && parameters.secondary.drive == Drive::Torque;
    let balancing = parameters.initial.ratio * primary;
    let found = steady
        && free
        && primary * secondary > 0.0
        && (secondary - balancing).abs() < BALANCED * balancing.abs();
    found.then(|| {
        format!(
            "primary.torque = {primary} N·m and secondary.torque = {secondary} N·m have the same sign, so that they change the speed \
             together: against a drive a load has the other sign, {} N·m",
            -secondary
        )
    })
}
