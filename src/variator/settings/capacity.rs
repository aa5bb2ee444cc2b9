//! What a clamping force carries at most, and loads that look like another unit's.

use crate::contact::full_slip_torque;
use crate::pulley::{PerPulley, Pulley};
use crate::variator::settings::parameters::{Axial, Cylinder, Drive, Parameters};
use crate::variator::settings::signals::Inputs;
use crate::variator::settings::table::range_of;
use crate::variator::settings::{BEYOND, BROKEN, FAR, PLAUSIBLE_FORCE, PLAUSIBLE_TORQUE};

/// The torque that the belt transmits at given inputs while it does not slip through, and what a clamping force carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Demand {
    /// The pulley whose force it is.
    pulley: Pulley,
    /// External torques on the primary and the secondary shaft, N·m.
    torques: [f64; 2],
    /// Whether another unit may be meant.
    doubtful: bool,
    /// Force of clamp and cylinder, N, and the name of its variable.
    force: f64,
    name: &'static str,
    ratio: f64,
    /// Torque of the belt on the primary pulley, N·m.
    torque: f64,
    /// Full slip of the pulley, seen from the primary one, N·m for each N.
    carried_per_force: f64,
    /// Drag of both shafts, seen from the primary one, N·m.
    drag: f64,
}

impl Demand {
    /// The demand on the force of a pulley at a ratio and a primary speed, rad/s; none where no torque is given or no belt closes.
    pub fn new(parameters: &Parameters, inputs: &Inputs, pulley: Pulley, at: [f64; 2]) -> Option<Self> {
        let [ratio, speed] = at;
        let (p, s) = (&parameters.primary, &parameters.secondary);
        let torque = match (p.drive, s.drive) {
            // Speeds in proportion: J_P ω̇_P = T_P + M, J_S ω̇_P/i = T_S − i M.
            (Drive::Torque, Drive::Torque) => {
                let (own, other) = (
                    p.inertia * ratio * inputs.secondary.torque,
                    s.inertia * inputs.primary.torque,
                );
                (own - other) / (s.inertia + ratio * ratio * p.inertia)
            }
            (Drive::Torque, Drive::Speed) => -inputs.primary.torque,
            (Drive::Speed, Drive::Torque) => inputs.secondary.torque / ratio,
            (Drive::Speed, Drive::Speed) => return None,
        };
        let (radius, _) = parameters.pitch_radii(ratio)?;
        let cos_beta = parameters.geometry.wedge_angle.cos();
        let force = parameters.closing_forces(inputs, at)[pulley];
        let drag = |of: &crate::shaft::ShaftDrag, speed: f64| of.at(speed.abs(), [force, 0.0]).torque;
        Some(Self {
            pulley,
            torques: [inputs.primary.torque, inputs.secondary.torque],
            doubtful: Self::may_be_another_unit(inputs, pulley),
            force,
            name: parameters.name_of_closing(pulley),
            ratio,
            torque,
            carried_per_force: full_slip_torque(&parameters.friction, cos_beta, 1.0, radius),
            drag: drag(&p.drag, speed) + drag(&s.drag, speed / ratio) / ratio,
        })
    }

    fn carried(&self) -> f64 {
        self.carried_per_force * self.force
    }

    /// Whether a share of the torque is beyond what the force can carry.
    pub fn is_beyond(&self, share: f64) -> bool {
        share * self.torque.abs() > BEYOND * self.carried() + self.drag
    }

    /// Whether a force is so small, or a torque so large, that another unit may be meant.
    pub fn may_be_another_unit(inputs: &Inputs, pulley: Pulley) -> bool {
        let force = inputs.pulley(pulley).clamping_force;
        let torque = inputs.primary.torque.abs().max(inputs.secondary.torque.abs());
        force > 0.0 && (force < PLAUSIBLE_FORCE || torque >= PLAUSIBLE_TORQUE)
    }

    /// Whether the torque is far beyond the capacity, and a factor of 1000 explains it.
    pub fn seems_another_unit(&self) -> bool {
        let (carried, torque) = (self.carried(), self.torque.abs());
        self.doubtful && torque > FAR * carried + self.drag && 1.0e-3 * torque <= BEYOND * carried
    }

    /// The unit that is meant then.
    fn other_unit(&self) -> String {
        let (force, torque) = (self.force, self.torque.abs());
        if force < PLAUSIBLE_FORCE {
            let carried = short(1.0e3 * self.carried());
            return format!(
                "is {}.clampingForce in kN? {force} kN carry {carried} N·m",
                self.pulley.name()
            );
        }
        format!(
            "are the torques in N·mm? {0} N·mm are {1} N·m",
            short(torque),
            short(1.0e-3 * torque)
        )
    }
}

/// What the force carries, what the torques demand, and which force would do: the reason why there is no steady state.
impl std::fmt::Display for Demand {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{}.{} = {} N carries at most {} N·m at ratio {}, and the torques (primary {}, secondary {} N·m) load the belt \
             with {} N·m: ",
            self.pulley.name(),
            self.name,
            self.force,
            short(self.carried()),
            short(self.ratio),
            short(self.torques[0]),
            short(self.torques[1]),
            short(self.torque.abs()),
        )?;
        let least = (self.torque.abs() / self.carried_per_force).ceil();
        if !self.is_beyond(1.0) {
            f.write_str("a larger force, or another ratio, may have one")?;
        } else if range_of("primary.clampingForce").is_some_and(|(_, most)| least <= most) {
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
    /// Forces of spring and rotating oil on the sheaves, N, at a ratio and a primary speed, rad/s.
    pub(crate) fn pushes(&self, [ratio, speed]: [f64; 2]) -> PerPulley<f64> {
        let [at_one, here] = [1.0, ratio].map(|ratio| self.pitch_radii(ratio).unwrap_or_default());
        let place = 2.0 * self.geometry.wedge_angle.tan();
        PerPulley {
            secondary: self.secondary.cylinder.push(place * (here.1 - at_one.1), speed / ratio),
            primary: self.primary.cylinder.push(place * (here.0 - at_one.0), speed),
        }
    }

    /// Forces of clamp and cylinder on sheaves that stand still, N, at a ratio and a primary speed, rad/s.
    pub(crate) fn closing_forces(&self, inputs: &Inputs, at: [f64; 2]) -> PerPulley<f64> {
        let pushes = self.pushes(at);
        PerPulley::from_fn(|pulley| inputs.pulley(pulley).force(&self.pulley(pulley).cylinder) + pushes[pulley])
    }

    /// Name of the variable of a pulley that has this force.
    pub(crate) fn name_of_closing(&self, pulley: Pulley) -> &'static str {
        if self.pulley(pulley).cylinder == Cylinder::default() {
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

/// The reason why no belt bears the speed of the start, where the primary pulley turns at `speed`, rad/s.
pub(crate) fn excessive_speed(parameters: &Parameters, inputs: &Inputs, [ratio, speed]: [f64; 2]) -> Option<String> {
    let (radius, _) = parameters.pitch_radii(ratio)?;
    let belt = radius * speed.abs();
    let mass = parameters.belt.mass_per_length + parameters.ring.mass_per_length;
    let stretch = mass * belt * belt / parameters.ring.axial_stiffness;
    let (name, value) = given_speed(parameters, inputs);
    (stretch > BROKEN).then(|| {
        format!(
            "{name} = {value} rad/s is a belt speed of {} m/s at ratio {}, whose centrifugal tension stretches the ring by {} %: below {} \
             rad/s it stretches by less than {} %",
            short(belt),
            short(ratio),
            short(100.0 * stretch),
            short(value.abs() * (BROKEN / stretch).sqrt()),
            100.0 * BROKEN
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
    if digits > 0 {
        (value * 10_f64.powi(digits)).round() / 10_f64.powi(digits)
    } else {
        value.round()
    }
}

/// The clamping forces that act: of sheaves that are not held.
pub(crate) fn clamped(parameters: &Parameters) -> impl Iterator<Item = Pulley> + '_ {
    Pulley::BOTH
        .into_iter()
        .filter(|pulley| parameters.pulley(*pulley).axial == Axial::Force)
}
