//! A case: a belt in a steady state, held at a ratio under a force of the secondary pulley and a
//! share of the torque of full slip.

use crate::{Cone, Law, Machine, Options, Shaft, Vector};
use pushbelt::contact::full_slip_torque;
use pushbelt::variator::settings::{ParameterError, Parameters};

/// What a run is about.
#[derive(Clone, Debug)]
pub struct Case {
    /// Its name, of files too.
    pub name: String,
    /// Geometric ratio r_S/r_P that the primary cone holds.
    pub ratio: f64,
    /// Torque of the load over that of full slip, 2 μ F r_S/cos β.
    pub share: f64,
    /// Parameters of the FMU.
    pub parameters: Parameters,
    /// Loads, and what this model has beside the parameters.
    pub options: Options,
    /// Force on the primary cone after the step of a shift, N; before it the cone holds the ratio.
    pub primary_force: Option<f64>,
}

/// Speed with which the controller of the ratio settles, 1/s.
const RATIO_RATE: f64 = 20.0;
/// Duration of a shift, s, as in the validation of the FMU.
pub const SHIFT: f64 = 0.12;
/// Times over which force and torque rise at the start, s.
const FORCE_RISE: f64 = 0.01;
const TORQUE_RISE: f64 = 0.02;
/// Step, s, at 200 rad/s.
const STEP: f64 = 2.0e-6;
const STEP_SPEED: f64 = 200.0;
/// Shares of the torque of full slip that are tried: beyond 1 no belt holds.
const MOST: f64 = 0.95;

impl Case {
    /// A case by its name: a ratio and a share, as `medium-0.4`, `od-0`; a ratio may be a number,
    /// as `1.02-0`.
    ///
    /// # Errors
    /// The name is none of these.
    pub fn named(name: &str) -> Result<Self, ParameterError> {
        let range = "RATIO-SHARE, as medium-0.4; ratios: low, under, medium, over, od or a number";
        let error = || ParameterError::new("CASE", name, range);
        let (ratio, share) = name.split_once('-').ok_or_else(error)?;
        let ratio = match ratio {
            "low" => 2.25,
            "under" => 1.5,
            "medium" => 1.0,
            "over" => 0.667,
            "od" => 0.444,
            number => number.parse().map_err(|_| error())?,
        };
        Ok(Self {
            name: name.to_owned(),
            ratio,
            share: share.parse().map_err(|_| error())?,
            parameters: Parameters::default(),
            options: Options::default(),
            primary_force: None,
        })
    }

    /// Checks the values.
    ///
    /// # Errors
    /// A value is out of its range.
    pub fn check(&self) -> Result<(), ParameterError> {
        let (of, (lowest, highest)) = (&self.options, self.parameters.ratio_range().into_inner());
        let inertia = self.parameters.belt.element_inertia;
        let least_inertia = if of.pitch { 1.0e-12 } else { 0.0 };
        let of_case = [
            ("ratio", self.ratio, [lowest, highest]),
            ("start-ratio", self.started(), [lowest, highest]),
            ("share", self.share, [-MOST, MOST]),
            ("shift", of.shift.unwrap_or(0.0), [-1.0, 1.0]),
            ("duration", self.duration(), [1.0e-4, 100.0]),
            ("step", self.step(), [1.0e-9, 1.0e-4]),
            ("belt.elementInertia", inertia, [least_inertia, 1.0e-4]),
        ];
        for (name, value, [least, most]) in of_case.into_iter().chain(of.ranges()) {
            if !(least..=most).contains(&value) {
                let range = format!("{} to {}", short(least), short(most));
                return Err(ParameterError::new(name.replace('_', "-"), value, range));
            }
        }
        Ok(())
    }

    fn started(&self) -> f64 {
        self.options.start_ratio.unwrap_or(self.ratio)
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        let slow = !(0.6..=1.6).contains(&self.ratio) || self.options.speed < 100.0;
        let held = self.options.duration.unwrap_or(if slow { 0.5 } else { 0.3 });
        held + self.primary_force.map_or(0.0, |_| SHIFT)
    }

    /// Time step, s.
    pub fn step(&self) -> f64 {
        let usual = STEP * STEP_SPEED / self.options.speed.max(0.5 * STEP_SPEED);
        self.options.step.unwrap_or(usual)
    }

    /// Torque of the load on the secondary shaft, N·m.
    pub fn torque(&self) -> f64 {
        let (of, cos_beta) = (&self.parameters, self.parameters.geometry.wedge_angle.cos());
        let radius = of.pitch_radii(self.ratio).map_or(f64::NAN, |radii| radii.secondary);
        self.share * full_slip_torque(&of.friction, cos_beta, self.options.force, radius)
    }

    /// The unloaded machine at the start: elements with even gaps around arcs and strands, which
    /// turn without slip.
    ///
    /// # Errors
    /// A value is out of its range.
    pub fn start(&self) -> Result<Machine, ParameterError> {
        self.check()?;
        let law = Law::new(&self.parameters, &self.options)?;
        let ratio = self.started();
        let no_belt = || ParameterError::new("start-ratio", ratio, "one at which the belt closes");
        let radii = self.parameters.pitch_radii(ratio).ok_or_else(no_belt)?;
        let (primary, secondary) = (radii.primary, radii.secondary);
        let path = Path::new(law.axes[1], [secondary, primary]);
        let n = law.count;
        let mut thicker = 0.0;
        let points: Vec<_> = (0..n)
            .map(|i| {
                thicker += law.thicknesses[i] - law.thickness;
                path.at((i as f64 / n as f64 * path.length() + thicker).rem_euclid(path.length()))
            })
            .collect();
        let (r0, tan_beta) = (law.r0, law.wedge.tan);
        let ring_over_pitch = self.parameters.geometry.belt_length / path.length();
        let mut machine = Machine::new(law, self.step(), points.into_iter());
        let speed = self.options.speed * primary;
        machine.belt.v.fill(speed.into());
        machine.belt.w.fill(speed * ring_over_pitch);
        for (pulley, radius) in machine.pulleys.iter_mut().zip([secondary, primary]) {
            pulley.omega = speed / radius;
            pulley.z = 2.0 * (radius - r0) * tan_beta;
        }
        self.drive(&mut machine);
        Ok(machine)
    }

    /// Sets what acts on the pulleys at the machine's time: force and torque rise at the start, and
    /// the primary cone moves at 20 1/s of the error of r_P.
    pub fn drive(&self, machine: &mut Machine) {
        let rise = |over: f64| (0.1 + machine.time / over).min(1.0);
        let [secondary, primary] = machine.loads.map(|load| load.weight[1] / load.weight[0]);
        let speed = if machine.loads.iter().all(|load| load.weight[0] > 0.0) {
            RATIO_RATE * machine.law.wedge.tan * primary * (secondary / primary / self.ratio).ln()
        } else {
            0.0
        };
        let torque = -self.torque() * rise(TORQUE_RISE);
        let force = self.options.force * rise(FORCE_RISE);
        machine.drive = [
            (Shaft::Torque(torque), Cone::Force(force)),
            (Shaft::Speed, self.primary_force.map_or(Cone::Speed(speed), Cone::Force)),
        ];
    }
}

/// The pitch line of an unloaded belt: arcs and strands, from the leftmost point of S on,
/// clockwise.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    distance: f64,
    /// Radii of S and P, m.
    pub radii: [f64; 2],
    /// Half of the wrap of S, rad.
    phi: f64,
    strand: f64,
}

impl Path {
    /// Around pulleys at this distance, with the radii of S and P, m.
    pub fn new(distance: f64, radii: [f64; 2]) -> Self {
        let rise = radii[1] - radii[0];
        Self {
            distance,
            radii,
            phi: (rise / distance).acos(),
            strand: (distance * distance - rise * rise).sqrt(),
        }
    }

    /// Wrap angles of S and P, rad.
    pub fn wraps(&self) -> [f64; 2] {
        [2.0 * self.phi, 2.0 * (std::f64::consts::PI - self.phi)]
    }

    /// Length, m.
    pub fn length(&self) -> f64 {
        let [s, p] = self.wraps();
        2.0 * self.strand + s * self.radii[0] + p * self.radii[1]
    }

    /// The point at the place `xi`, m, from 0 to the length.
    pub fn at(&self, xi: f64) -> Vector {
        let half = 0.5 * self.length();
        if xi > half {
            return self.at(2.0 * half - xi).conj();
        }
        let [s, p] = self.radii;
        let behind = xi - s * self.phi;
        // Angles from the leftward direction, clockwise.
        let around = |radius: f64, angle: f64| Vector::from_polar(-radius, -angle);
        if behind <= 0.0 {
            around(s, xi / s)
        } else if behind <= self.strand {
            around(s, self.phi) + behind * Vector::new(self.phi.sin(), self.phi.cos())
        } else {
            self.distance + around(p, self.phi + (behind - self.strand) / p)
        }
    }

    /// The place ξ of a point near the line, m.
    pub fn place(&self, Vector { re: x, im: y }: Vector) -> f64 {
        let [s, p] = self.radii;
        let (sin, cos) = self.phi.sin_cos();
        let along = (x + s * cos) * sin + (y.abs() - s * sin) * cos;
        // Angles from the leftward direction, clockwise, of the upper half.
        let upper = if along <= 0.0 {
            s * y.abs().atan2(-x)
        } else if along <= self.strand {
            s * self.phi + along
        } else {
            s * self.phi + self.strand + p * (y.abs().atan2(self.distance - x) - self.phi)
        };
        if y < 0.0 { self.length() - upper } else { upper }
    }
}

/// Six digits.
pub(crate) fn short(value: f64) -> f64 {
    let digits = 5_i32.saturating_sub(value.abs().log10().floor() as i32);
    let digits = digits.clamp(0, 12) as usize;
    format!("{value:.digits$}").parse().unwrap_or(value)
}
