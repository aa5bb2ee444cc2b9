//! Torques, losses and shift rate of a state.
//!
//! The state is ω_P, ω_S and ℓ = ln i, with i = r_S/r_P of the pitch radii. The sliding speed v = r_P ω_P − r_S ω_S gives the slip
//! s = v/q with q = √((r_P ω_P)² + v_0²), and the table of the traction the utilisation u(s). The torque of the primary shaft on the belt
//! is T_P = u 2μ r_P F_S/cosβ, positive where it drives. Beyond the slip s_c at capacity u_c
//!
//! u = u_c (1 − fall (1 − e^(−(|v| − |s_c| q)/v_f))),
//!
//! and the belt slips through. The torque of the belt on the secondary shaft is T_S = i (T_P − tanh(ω_P/ω_0) T_l), with ω_0 of the
//! [drag](pushbelt::shaft), so the belt loses T_P ω_P − T_S ω_S = s T_P ω_P + (1 − s) tanh(ω_P/ω_0) T_l ω_P at running speed. A growing
//! primary force closes the primary pulley, so ℓ' = −|ω_P| G(ln(F_P/(κ F_S))), with G of the sign of its argument.
//!
//! F_P and F_S are those of clamps and [cylinders](pushbelt::cylinder). Seals act on the shift alone, in the quotient of the forces.
//!
//! Reverse running is the mirror image: ω, v and T change their signs, and the tables are those at the slip −s. With b = r_P ω_P/q,
//! which is ±1 except near standstill, u = (1+b)/2 U(s) − (1−b)/2 U(−s); other quantities are means with these weights.

use std::f64::consts::TAU;
use std::sync::Arc;

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::reference_curve::TwoPulley;
use pushbelt::shaft::{Drag, SPEED_SMOOTHING};
use pushbelt::variator::settings::{Axial, Friction, Inputs, Parameters, bisected};

use crate::settings::Settings;
use crate::tables::{Even, Place, Tables};
use crate::tuning::{BEYOND_STOPS, LEAST_FORCE, RADII, SLIP_SPEED};

/// Radii over the ratio, between the end stops.
#[derive(Clone, Debug)]
pub struct Radii {
    /// Places over ln i.
    places: Even,
    primary: Vec<f64>,
    /// Pitch radius at ratio 1, m.
    at_one: f64,
    /// Way of a sheave per change of its radius.
    way: f64,
    /// Least and greatest ln i, at the end stops.
    pub stops: [f64; 2],
}

impl Radii {
    /// The radii of a variator with these parameters.
    ///
    /// # Errors
    /// The radii at the end stops allow no range of ratios.
    pub fn new(parameters: &Parameters) -> Result<Self, String> {
        let (least, most) = parameters.ratio_range();
        // The end stops limit the ratio of the ring's centre line. The pitch line runs at a distance inside it, and is a curve around two
        // pulleys too.
        let stop = |reference| {
            parameters
                .pitch_radii(reference)
                .map(|(primary, secondary)| (secondary / primary).ln())
        };
        let (true, Some(least), Some(most)) = (least < most, stop(least), stop(most)) else {
            return Err("the radii at the end stops leave no range of ratios".to_owned());
        };
        let geometry = &parameters.geometry;
        let length = geometry.belt_length - TAU * parameters.belt.pitch_offset;
        let curve = TwoPulley::new(geometry.center_distance, length);
        let radius = |log_ratio: f64| curve.radii(log_ratio.exp()).map(|(primary, _)| primary);
        let places = Even::between(least - BEYOND_STOPS, most + BEYOND_STOPS, RADII);
        let primary = places.places().map(radius).collect::<Result<_, _>>();
        Ok(Self {
            places,
            primary: primary.map_err(|error| error.to_string())?,
            at_one: radius(0.0).map_err(|error| error.to_string())?,
            way: 2.0 * geometry.wedge_angle.tan(),
            stops: [least, most],
        })
    }

    /// Pitch radii at ln i, m, and their derivatives.
    #[must_use]
    pub fn at(&self, log_ratio: f64) -> PerPulley<(f64, f64)> {
        let (k, t) = self.places.find(log_ratio);
        let step = self.primary[k + 1] - self.primary[k];
        let (radius, slope) = (self.primary[k] + t * step, step * self.places.per_step);
        let ratio = log_ratio.exp();
        PerPulley {
            primary: (radius, slope),
            secondary: (ratio * radius, ratio * (radius + slope)),
        }
    }
}

/// A state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Speeds of the shafts, rad/s.
    pub speeds: PerPulley<f64>,
    /// ln i.
    pub log_ratio: f64,
}

/// What acts on a variator.
#[derive(Clone, Copy, Debug)]
pub struct Acting {
    /// Inputs.
    pub inputs: Inputs,
    /// Thrust ratio from which a held secondary sheave gets its force.
    pub thrust_ratio: f64,
}

/// Utilisation at a sliding speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Traction {
    /// Utilisation u.
    pub value: f64,
    /// ∂u/∂v, s/m.
    pub slope: f64,
    /// Whether the slip is beyond that at capacity: the belt slips through.
    pub macro_slip: bool,
}

impl Traction {
    /// Adds the traction of a direction of running with its share.
    fn add(&mut self, (sign, share): (f64, f64), one: Self) {
        self.value += sign * share * one.value;
        self.slope += share * one.slope;
        self.macro_slip |= one.macro_slip && share >= 0.5;
    }
}

/// What the tables give at a sliding speed.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    /// The traction.
    pub traction: Traction,
    /// Utilisation as of forward running.
    forward: f64,
    /// Thrust ratio κ, and ∂κ/∂u.
    pub thrust_ratio: f64,
    thrust_slope: f64,
    /// Torque loss of the belt at the primary pulley, N·m.
    pub torque_loss: f64,
    /// Resultant of the belt's contact forces on a pulley, N.
    pub bearing_load: f64,
}

/// The place of a state in the tables, and what the traction needs there.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Place in the tables.
    pub place: Place,
    /// Speed of the primary pulley, rad/s.
    primary: f64,
    /// Pitch radius on the primary pulley, m.
    pub radius: f64,
    /// Ratio.
    pub ratio: f64,
    /// Ways of the sheaves per change of ln i, m.
    pub ways: PerPulley<f64>,
    /// Forces of clamps and cylinders that close the pulleys, without their seals, N.
    pub closing: PerPulley<f64>,
    /// Secondary force: of clamp and cylinder, or with a held sheave what the primary force requires, without seals, N.
    pub force: f64,
    /// Torque at utilisation 1, N·m.
    pub torque: f64,
    /// Speed q by which the sliding speed is divided, m/s.
    pub speed: f64,
    /// Share of forward running: 1, or 0 for reverse running, and between them near standstill.
    forward: f64,
    /// Utilisations and slips at capacity.
    limits: [f64; 4],
}

impl Frame {
    /// The sliding speed v, m/s.
    #[must_use]
    pub fn sliding(&self, speeds: PerPulley<f64>) -> f64 {
        self.radius * (speeds.primary - self.ratio * speeds.secondary)
    }

    /// Signs of the directions of running with their shares. Reverse running is forward running at −v.
    #[inline(always)]
    fn directions(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let both = [(1.0, self.forward), (-1.0, 1.0 - self.forward)];
        both.into_iter().filter(|(_, share)| *share > 0.0)
    }
}

/// The laws of a variator: tables, radii and parameters.
#[derive(Clone, Debug)]
pub struct Law {
    pub(crate) tables: Arc<Tables>,
    pub(crate) radii: Arc<Radii>,
    /// Parameters.
    pub parameters: Parameters,
}

impl Law {
    /// The laws of these settings.
    ///
    /// # Errors
    /// There are no tables, or no range of ratios.
    pub fn new(settings: &Settings) -> Result<Self, String> {
        Ok(Self {
            tables: settings.own.clone().ok_or("the unit has no tables")?,
            radii: Arc::new(Radii::new(&settings.parameters)?),
            parameters: settings.parameters.clone(),
        })
    }

    /// The frame of a state.
    #[must_use]
    pub fn frame(&self, state: &State, acting: &Acting) -> Frame {
        let radii = self.radii.at(state.log_ratio);
        let (radius, _) = radii.primary;
        let positions = radii.map(|(radius, _)| self.radii.way * (radius - self.radii.at_one));
        let Parameters { friction, geometry, .. } = &self.parameters;
        let closing = self.parameters.closing(&acting.inputs, positions, state.speeds);
        let force = match self.parameters.secondary.axial {
            Axial::Held => closing.primary / acting.thrust_ratio,
            Axial::Force => closing.secondary,
        };
        let primary = state.speeds.primary;
        let place = self.tables.place(force.max(0.0), primary.abs(), state.log_ratio);
        let around = radius * primary;
        let speed = (around * around + SLIP_SPEED * SLIP_SPEED).sqrt();
        // Slightly steeper than b, so that only one direction is evaluated at running speeds.
        let direction = (1.001 * around / speed).clamp(-1.0, 1.0);
        Frame {
            place,
            primary,
            radius,
            ratio: state.log_ratio.exp(),
            ways: radii.map(|(_, slope)| self.radii.way * slope),
            closing,
            force,
            torque: 2.0 * friction.pulley * radius * force.max(0.0) / geometry.wedge_angle.cos(),
            speed,
            forward: 0.5 * (1.0 + direction),
            limits: self.tables.limits(&place),
        }
    }

    /// The traction of forward running at a sliding speed, m/s.
    #[inline(always)]
    fn one_way(&self, frame: &Frame, sliding: f64) -> Traction {
        let driving = usize::from(sliding >= 0.0);
        let (capacity, limit) = (frame.limits[driving], frame.limits[2 + driving].abs() * frame.speed);
        let share = sliding / limit;
        if share.abs() <= 1.0 {
            let ([value], [slope]) = self.tables.traction.at(&frame.place, share);
            return Traction {
                value,
                slope: slope / limit,
                macro_slip: false,
            };
        }
        let Friction { fall, fall_speed, .. } = self.parameters.friction;
        let decay = (-(sliding.abs() - limit) / fall_speed).exp();
        Traction {
            value: capacity * (1.0 - fall * (1.0 - decay)),
            slope: -capacity * fall * decay / fall_speed * sliding.signum(),
            macro_slip: true,
        }
    }

    /// The traction at a sliding speed v, m/s.
    #[must_use]
    pub fn traction(&self, frame: &Frame, sliding: f64) -> Traction {
        let mut mean = Traction::default();
        for (sign, share) in frame.directions() {
            mean.add((sign, share), self.one_way(frame, sign * sliding));
        }
        mean
    }

    /// All that the tables give at a sliding speed v, m/s.
    #[must_use]
    pub fn point(&self, frame: &Frame, sliding: f64) -> Point {
        let mut mean = Point::default();
        let fading = (frame.primary / SPEED_SMOOTHING).tanh();
        for (sign, share) in frame.directions() {
            let traction = self.one_way(frame, sign * sliding);
            let ([thrust_ratio, torque_loss, bearing_load], [thrust_slope, ..]) =
                self.tables.belt.at(&frame.place, traction.value);
            mean.traction.add((sign, share), traction);
            mean.forward += share * traction.value;
            mean.thrust_ratio += share * thrust_ratio;
            mean.thrust_slope += share * sign * thrust_slope;
            mean.torque_loss += share * fading * torque_loss;
            mean.bearing_load += share * bearing_load;
        }
        mean
    }

    /// Drag of the shafts.
    #[must_use]
    pub fn drags(&self, speeds: PerPulley<f64>, point: &Point) -> PerPulley<Drag> {
        PerPulley::from_fn(|j| self.parameters.pulley(j).drag.at(speeds[j], [point.bearing_load, 0.0]))
    }

    /// Friction of the seals of both cylinders along the speeds of the sheaves, m/s; N.
    #[must_use]
    pub fn rubbing(&self, velocities: PerPulley<f64>) -> PerPulley<f64> {
        let velocity = self.parameters.friction.velocity;
        PerPulley::from_fn(|j| self.parameters.pulley(j).cylinder.drag(velocities[j], velocity))
    }

    /// ℓ' in a state, 1/s, and its slope over the utilisation by way of the thrust ratio; 0 with a held sheave.
    #[must_use]
    pub fn shift(&self, frame: &Frame, point: &Point) -> (f64, f64) {
        if self.parameters.holds_a_sheave() {
            return (0.0, 0.0);
        }
        let under = |rubbing: PerPulley<f64>| {
            let [secondary, primary] = Pulley::BOTH.map(|j| frame.closing[j] - rubbing[j]);
            let holding = point.thrust_ratio * secondary;
            let excess = (primary.max(LEAST_FORCE) / holding.max(LEAST_FORCE)).ln();
            let (rate, gain) = self.tables.shift_rate(&frame.place, point.forward, excess);
            let by_utilisation = gain * point.thrust_slope / point.thrust_ratio;
            (-frame.primary.abs() * rate, frame.primary.abs() * by_utilisation)
        };
        let free = under(PerPulley::default());
        if Pulley::BOTH.map(|j| self.parameters.pulley(j).cylinder.seal) == [0.0; 2] {
            return free;
        }
        let under = |rate: f64| under(self.rubbing(frame.ways.map(|way| way * rate)));
        // The friction falls with the rate that it causes: one root, between no motion and that without friction.
        let rate = bisected([free.0.min(0.0), free.0.max(0.0)], |rate| under(rate).0 > rate);
        let near = 1e-2 * self.parameters.friction.velocity / frame.ways.secondary.abs();
        let falls = (under(rate + near).0 - under(rate - near).0) / (2.0 * near);
        (rate, under(rate).1 / (1.0 - falls.min(0.0)))
    }
}
