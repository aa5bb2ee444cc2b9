//! The largest torque of a clamping force, and loads that seem to be in another unit.

use super::parameters::{Axial, Cylinder, Drive, Parameters};
use super::signals::Inputs;
use super::table::range_of;
use super::{MOST_OVER_FULL_SLIP, RUPTURE, WRONG_UNIT};
use crate::contact::full_slip_torque;
use crate::pulley::{PerPulley, Pulley};

/// The torque that the belt transmits at given inputs while it does not slip through, and that
/// which a clamping force can transmit.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TorqueDemand {
    /// The pulley whose force it is.
    pulley: Pulley,
    /// External torques on the shafts, N·m.
    torques: PerPulley<f64>,
    /// Given clamping force, N.
    given: f64,
    /// Force of clamp and cylinder, N, and the name of its variable.
    force: f64,
    name: &'static str,
    ratio: f64,
    /// Torque of the belt on the primary pulley, N·m.
    torque: f64,
    /// Torque of full slip, at the primary pulley, N·m for each N.
    capacity_per_force: f64,
    /// Drag of both shafts, reduced to the primary one, N·m.
    drag: f64,
}

impl TorqueDemand {
    /// The demand on the force of a pulley at a ratio and a primary speed, rad/s; none without a
    /// given torque or a belt that closes.
    pub fn new(
        parameters: &Parameters,
        inputs: &Inputs,
        pulley: Pulley,
        ratio: f64,
        speed: f64,
    ) -> Option<Self> {
        let (p, s) = (&parameters.primary, &parameters.secondary);
        let torques = PerPulley::from_fn(|j| inputs.pulley(j).torque);
        let torque = parameters.steady_torque(torques, ratio)?;
        let radius = parameters.pitch_radii(ratio)?.primary;
        let cos_beta = parameters.geometry.wedge_angle.cos();
        let force = parameters.total_clamping_forces(inputs, ratio, speed)[pulley];
        let drag = |of: &crate::shaft::ShaftDrag, speed: f64| of.loads(speed.abs(), [force, 0.0]).torque;
        Some(Self {
            pulley,
            torques,
            given: inputs.pulley(pulley).clamping_force,
            force,
            name: parameters.clamping_variable(pulley),
            ratio,
            torque,
            capacity_per_force: full_slip_torque(&parameters.friction, cos_beta, 1.0, radius),
            drag: drag(&p.drag, speed) + drag(&s.drag, speed / ratio) / ratio,
        })
    }

    fn capacity(&self) -> f64 {
        self.capacity_per_force * self.force
    }

    /// Torque of the belt on the primary pulley as a fraction of the capacity; 0 without torque.
    pub fn utilisation(&self) -> f64 {
        if self.torque == 0.0 {
            0.0
        } else {
            self.torque / self.capacity()
        }
    }

    /// Whether a fraction of the torque is beyond what the force can carry.
    pub fn is_beyond(&self, fraction: f64) -> bool {
        fraction * self.torque.abs() > MOST_OVER_FULL_SLIP * self.capacity() + self.drag
    }

    /// Whether the torque is far beyond the capacity, and a factor of 1000 explains it.
    pub fn seems_another_unit(&self) -> bool {
        let (capacity, torque) = (self.capacity(), self.torque.abs());
        self.given > 0.0
            && torque > WRONG_UNIT * capacity + self.drag
            && 1.0e-3 * torque <= MOST_OVER_FULL_SLIP * capacity
    }

    /// The wrong unit: of the force where loads are smaller than those of the default start, else
    /// of the torques.
    fn other_unit(&self) -> String {
        let (force, torque, pulley) = (self.force, self.torque.abs(), self.pulley.name());
        let usual = Inputs::default().primary;
        if force * torque < usual.clamping_force * usual.torque {
            let capacity = short(1.0e3 * self.capacity());
            return format!("is {pulley}.clampingForce in kN? {force} kN carry {capacity} N·m");
        }
        let [torque, in_newton_metres] = [torque, 1.0e-3 * torque].map(short);
        format!("are the torques in N·mm? {torque} N·mm are {in_newton_metres} N·m")
    }
}

/// The capacity of the force, the demand of the torques, and a force that would suffice: the reason
/// why there is no steady state.
impl std::fmt::Display for TorqueDemand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (pulley, name, force) = (self.pulley.name(), self.name, self.force);
        let [capacity, ratio, torque] = [self.capacity(), self.ratio, self.torque.abs()].map(short);
        let PerPulley { primary, secondary } = self.torques.map(short);
        write!(
            f,
            "{pulley}.{name} = {force} N carries at most {capacity} N·m at ratio {ratio}, and the torques (primary {primary}, \
             secondary {secondary} N·m) load the belt with {torque} N·m: "
        )?;
        let least = (self.torque.abs() / self.capacity_per_force).ceil();
        if !self.is_beyond(1.0) {
            f.write_str("a larger force, or another ratio, may have one")?;
        } else if range_of("primary.clampingForce").is_some_and(|range| least <= *range.end()) {
            write!(f, "at least {least} N")?;
        } else {
            f.write_str("no admissible force does")?;
        }
        if self.seems_another_unit() {
            write!(f, "; {}", self.other_unit())?;
        }
        Ok(())
    }
}

impl Parameters {
    /// Torque of the belt on the primary pulley, N·m, under which the free shafts accelerate
    /// together with these other torques; none where both speeds are given.
    #[must_use]
    pub fn steady_torque(&self, torques: PerPulley<f64>, ratio: f64) -> Option<f64> {
        let (p, s) = (&self.primary, &self.secondary);
        match (p.drive, s.drive) {
            // Speeds in proportion: J_P ω̇_P = T_P + M, J_S ω̇_P/i = T_S − i M.
            (Drive::Torque, Drive::Torque) => {
                let own = p.inertia * ratio * torques.secondary;
                Some((own - s.inertia * torques.primary) / (s.inertia + ratio * ratio * p.inertia))
            }
            (Drive::Torque, Drive::Speed) => Some(-torques.primary),
            (Drive::Speed, Drive::Torque) => Some(torques.secondary / ratio),
            (Drive::Speed, Drive::Speed) => None,
        }
    }

    /// Friction of the seals of a cylinder at the speed `z_dot` of its sheave, m/s; N.
    #[must_use]
    pub fn seal_friction(&self, pulley: Pulley, z_dot: f64) -> f64 {
        self.pulley(pulley).cylinder.drag(z_dot, self.friction.velocity)
    }

    /// Forces of clamps and cylinders without seals on sheaves at these positions, m, and speeds,
    /// rad/s; N.
    #[inline]
    #[must_use]
    pub fn total_clamping_forces_at(
        &self,
        inputs: &Inputs,
        position: PerPulley<f64>,
        speed: PerPulley<f64>,
    ) -> PerPulley<f64> {
        PerPulley::from_fn(|j| {
            let cylinder = &self.pulley(j).cylinder;
            inputs.pulley(j).force(cylinder) + cylinder.passive_force(position[j], speed[j])
        })
    }

    /// The same at a ratio and a primary speed, rad/s.
    pub(crate) fn total_clamping_forces(&self, inputs: &Inputs, ratio: f64, speed: f64) -> PerPulley<f64> {
        let [at_one, here] = [1.0, ratio].map(|ratio| self.pitch_radii(ratio).unwrap_or_default());
        let way = 2.0 * self.geometry.wedge_angle.tan();
        let positions = PerPulley::from_fn(|j| way * (here[j] - at_one[j]));
        let speeds = PerPulley {
            primary: speed,
            secondary: speed / ratio,
        };
        self.total_clamping_forces_at(inputs, positions, speeds)
    }

    /// The pressure that opens a pulley at a time, s, under these [total clamping
    /// forces](Self::total_clamping_forces_at), N.
    #[must_use]
    pub fn opening_pressure(&self, inputs: &Inputs, clamping: PerPulley<f64>, time: f64) -> Option<String> {
        let opens = |j: &Pulley| clamping[*j] <= 0.0 && clamping[*j] < inputs.pulley(*j).clamping_force;
        let pulley = clamped(self).find(opens)?;
        let (name, given, total) = (pulley.name(), inputs.pulley(pulley), short(clamping[pulley]));
        Some(format!(
            "at {time} s {name}.pressure = {} Pa opens the {name} pulley: with clampingForce = {} N, spring and rotating oil the force on \
             its sheave is {total} N",
            given.pressure, given.clamping_force
        ))
    }

    /// The pressures at a time, s, that act on no area, of the pulleys that were not `said` before.
    pub fn idle_pressures(&self, inputs: &Inputs, said: &mut PerPulley<bool>, time: f64) -> Option<String> {
        let mut idle = String::new();
        for j in Pulley::BOTH {
            let (name, pressure) = (j.name(), inputs.pulley(j).pressure);
            if !said[j] && pressure != 0.0 && self.pulley(j).cylinder.area == 0.0 {
                said[j] = true;
                idle += &format!(
                    " {name}.pressure = {pressure} Pa has no effect, because {name}.cylinder.area is 0;"
                );
            }
        }
        (!idle.is_empty()).then(|| format!("at {time} s{idle} set the area of the piston"))
    }

    /// Name of the variable of a pulley that has this force.
    pub(crate) fn clamping_variable(&self, pulley: Pulley) -> &'static str {
        let is_plain = self.pulley(pulley).cylinder == Cylinder::default();
        if is_plain {
            "clampingForce"
        } else {
            "clampingForceTotal"
        }
    }
}

/// The variable that gives the speed of the start, and its value, rad/s.
pub(crate) fn given_speed(parameters: &Parameters, inputs: &Inputs) -> (&'static str, f64) {
    match (parameters.primary.drive, parameters.secondary.drive) {
        (Drive::Speed, _) => ("primary.speedSetpoint", inputs.primary.speed_setpoint),
        (_, Drive::Speed) => ("secondary.speedSetpoint", inputs.secondary.speed_setpoint),
        _ => ("initial.primarySpeed", parameters.initial.primary_speed),
    }
}

/// The reason why no belt bears the speed of the start, where the primary pulley turns at `speed`,
/// rad/s.
pub(crate) fn excessive_speed(
    parameters: &Parameters,
    inputs: &Inputs,
    ratio: f64,
    speed: f64,
) -> Option<String> {
    let radius = parameters.pitch_radii(ratio)?.primary;
    let belt = radius * speed.abs();
    let mass = parameters.belt.mass_per_length + parameters.ring.mass_per_length;
    let stretch = mass * belt * belt / parameters.ring.axial_stiffness;
    let (name, value) = given_speed(parameters, inputs);
    let slower = value.abs() * (RUPTURE / stretch).sqrt();
    let [belt, ratio, percent, slower] = [belt, ratio, 100.0 * stretch, slower].map(short);
    (stretch > RUPTURE).then(|| {
        format!(
            "{name} = {value} rad/s is a belt speed of {belt} m/s at ratio {ratio}, whose centrifugal tension stretches the ring by \
             {percent} %: below {slower} rad/s it stretches by less than {} %",
            100.0 * RUPTURE
        )
    })
}

/// A number to three digits.
pub(crate) fn short(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return value;
    }
    #[expect(clippy::cast_possible_truncation, reason = "within ±308")]
    let digits = 2 - value.abs().log10().floor() as i32;
    let factor = 10_f64.powi(digits.max(0));
    (value * factor).round() / factor
}

/// Pulleys whose clamping forces act, because their sheaves are not held.
pub(crate) fn clamped(parameters: &Parameters) -> impl Iterator<Item = Pulley> + '_ {
    Pulley::BOTH
        .into_iter()
        .filter(|pulley| parameters.pulley(*pulley).axial == Axial::Force)
}
