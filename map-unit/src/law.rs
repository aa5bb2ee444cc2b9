//! Torques, losses and shift rate of a state.
//!
//! The state is ω_P, ω_S and ℓ = ln i, with i = r_S/r_P of the pitch radii. The sliding speed v =
//! r_P ω_P − r_S ω_S gives the slip s = v/q with q = √((r_P ω_P)² + v_0²), and the table of the
//! traction the utilisation u(s). The torque of the primary shaft on the belt is T_P = u 2μ r_P
//! F_S/cosβ, positive where it drives. Beyond the slip s_c at capacity u_c
//!
//! u = u_c (1 − fall (1 − e^(−(|v| − |s_c| q)/v_f))),
//!
//! and the belt slips through. The torque of the belt on the secondary shaft is T_S = i (T_P −
//! tanh(ω_P/ω_0) T_l), with ω_0 of the
//! [drag](pushbelt::shaft), so the belt loses T_P ω_P − T_S ω_S = s T_P ω_P + (1 − s) tanh(ω_P/ω_0) T_l ω_P at running speed. A growing
//! primary force closes the primary pulley, so ℓ' = −|ω_P| G(ln(F_P/(κ F_S))), with G of the sign
//! of its argument.
//!
//! F_P and F_S are those of clamps and [cylinders](pushbelt::cylinder). Seals act on the shift
//! alone, in the quotient of the forces.
//!
//! Reverse running is the mirror image: ω, v and T change their signs, and the tables are those at
//! the slip −s. With b = r_P ω_P/q, which is ±1 except near standstill, u = (1+b)/2 U(s) − (1−b)/2
//! U(−s); other quantities are means with these weights.

use std::f64::consts::TAU;
use std::sync::Arc;

use pushbelt::contact::full_slip_torque;
use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::reference_curve::TwoPulley;
use pushbelt::shaft::{Drag, SPEED_SMOOTHING};
use pushbelt::variator::settings::{Axial, Friction, Inputs, Parameters, ParametersInForce, bisected};

use crate::settings::Settings;
use crate::tables::{GridPosition, Tables, UniformAxis};
use crate::tuning::{BEYOND_STOPS, LEAST_FORCE, RADII, SLIP_SPEED};

/// A state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Speeds of the shafts, rad/s.
    pub speeds: PerPulley<f64>,
    /// ln i.
    pub log_ratio: f64,
    /// Thrust ratio of the last step, from which a held secondary sheave gets its force.
    pub thrust_ratio: f64,
}

/// What acts in a state, and what the tables give there.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    /// Place in the tables.
    pub place: GridPosition,
    /// Speeds of the shafts, rad/s, and the sliding speed v, m/s.
    speeds: PerPulley<f64>,
    pub sliding: f64,
    /// Pitch radius on the primary pulley, m.
    pub radius: f64,
    /// Ratio.
    pub ratio: f64,
    /// Positions of the sheaves, m, and their ways per change of ln i, m.
    pub positions: PerPulley<f64>,
    pub ways: PerPulley<f64>,
    /// Forces of clamps and cylinders that close the pulleys, without their seals, N.
    pub clamping: PerPulley<f64>,
    /// Secondary force: of clamp and cylinder, or with a held sheave what the primary force
    /// requires, without seals, N.
    pub force: f64,
    /// Torque of full slip, at utilisation 1, N·m.
    pub full_slip: f64,
    /// Speed q by which the sliding speed is divided, m/s.
    pub speed: f64,
    /// Share of forward running: 1, or 0 for reverse running, and between them near standstill.
    ahead: f64,
    /// Utilisations and slips at capacity: of each, where the secondary and where the primary
    /// pulley drives.
    limits: [f64; 4],
    /// Utilisation u and ∂u/∂v, s/m.
    pub traction: [f64; 2],
    /// Utilisation as of forward running.
    forward: f64,
    /// Thrust ratio κ, and ∂κ/∂u.
    pub thrust_ratio: f64,
    thrust_slope: f64,
    /// Torque loss of the belt at the primary pulley, N·m.
    pub torque_loss: f64,
    /// Resultant of the belt's contact forces on a pulley, N.
    bearing_load: f64,
}

impl Point {
    /// The sliding speed at other speeds of the shafts, m/s.
    pub fn sliding_at(&self, speeds: PerPulley<f64>) -> f64 {
        self.radius * (speeds.primary - self.ratio * speeds.secondary)
    }

    /// Torque T_P of the primary shaft on the belt, N·m.
    pub fn torque(&self) -> f64 {
        self.full_slip * self.traction[0]
    }

    /// Whether the slip is beyond that at capacity: the belt slips through.
    pub fn macro_slip(&self) -> bool {
        let sliding = if self.ahead >= 0.5 {
            self.sliding
        } else {
            -self.sliding
        };
        let [_, limit] = self.limits(sliding);
        (sliding / limit).abs() > 1.0
    }

    /// Utilisation and sliding speed at capacity of forward running, m/s.
    #[inline(always)]
    fn limits(&self, sliding: f64) -> [f64; 2] {
        let driving = usize::from(sliding >= 0.0);
        [self.limits[driving], self.limits[2 + driving].abs() * self.speed]
    }

    /// Signs of the directions of running with their shares. Reverse running is forward running at
    /// −v.
    #[inline(always)]
    fn directions(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let both = [(1.0, self.ahead), (-1.0, 1.0 - self.ahead)];
        both.into_iter().filter(|(_, fraction)| *fraction > 0.0)
    }
}

/// The laws of a variator.
#[derive(Clone, Debug)]
pub struct Law {
    pub tables: Arc<Tables>,
    pub parameters: ParametersInForce,
    /// Least and greatest ln i, at the end stops.
    pub stops: [f64; 2],
    /// Places over ln i, and the primary pitch radii there, m.
    places: UniformAxis,
    radii: Arc<[f64]>,
    /// Pitch radius at ratio 1, m.
    at_one: f64,
    /// Way of a sheave per change of its radius.
    way: f64,
}

impl Law {
    /// The laws of these settings, or why there are none.
    pub fn new(settings: &Settings) -> Result<Self, String> {
        let parameters = settings.parameters.in_force();
        let (least, most) = parameters.ratio_range();
        // The end stops limit the ratio of the ring's centre line. The pitch line runs at a
        // distance inside it, and is a curve around two pulleys too.
        let (true, [Some(low), Some(high)]) =
            (least < most, [least, most].map(|at| parameters.pitch_radii(at)))
        else {
            return Err("the radii at the end stops leave no range of ratios".to_owned());
        };
        let stops = [low, high].map(|(primary, secondary)| (secondary / primary).ln());
        let geometry = &parameters.geometry;
        let length = geometry.belt_length - TAU * parameters.belt.pitch_offset;
        let curve = TwoPulley::new(geometry.center_distance, length);
        let radius = |log_ratio: f64| match curve.radii(log_ratio.exp()) {
            Ok((primary, _)) => Ok(primary),
            Err(error) => Err(error.to_string()),
        };
        let places = UniformAxis::over(&[stops[0] - BEYOND_STOPS, stops[1] + BEYOND_STOPS], RADII);
        Ok(Self {
            tables: settings.own.clone().ok_or("the unit has no tables")?,
            stops,
            places,
            radii: places.places().map(radius).collect::<Result<_, _>>()?,
            at_one: radius(0.0)?,
            way: 2.0 * geometry.wedge_angle.tan(),
            parameters,
        })
    }

    /// Pitch radii at ln i, m, and their derivatives.
    pub fn radii(&self, log_ratio: f64) -> PerPulley<(f64, f64)> {
        let (k, t) = self.places.find(log_ratio);
        let step = self.radii[k + 1] - self.radii[k];
        let (radius, slope) = (self.radii[k] + t * step, step * self.places.per_step);
        let ratio = log_ratio.exp();
        PerPulley {
            primary: (radius, slope),
            secondary: (ratio * radius, ratio * (radius + slope)),
        }
    }

    /// What acts in a state under these inputs, and what the tables give there.
    pub fn point(&self, state: &State, inputs: &Inputs) -> Point {
        let Parameters {
            friction, geometry, ..
        } = &*self.parameters;
        let radii = self.radii(state.log_ratio);
        let (radius, _) = radii.primary;
        let positions = radii.map(|(radius, _)| self.way * (radius - self.at_one));
        let clamping = self
            .parameters
            .total_clamping_forces_at(inputs, positions, state.speeds);
        let force = match self.parameters.secondary.axial {
            Axial::Held => clamping.primary / state.thrust_ratio,
            Axial::Force => clamping.secondary,
        };
        let place = self
            .tables
            .place(force.max(0.0), state.speeds.primary.abs(), state.log_ratio);
        let around = radius * state.speeds.primary;
        let speed = (around * around + SLIP_SPEED * SLIP_SPEED).sqrt();
        // Slightly steeper than b, so that only one direction is evaluated at running speeds.
        let direction = (1.001 * around / speed).clamp(-1.0, 1.0);
        let mut point = Point {
            place,
            speeds: state.speeds,
            radius,
            ratio: state.log_ratio.exp(),
            positions,
            ways: radii.map(|(_, slope)| self.way * slope),
            clamping,
            force,
            full_slip: full_slip_torque(friction, geometry.wedge_angle.cos(), force.max(0.0), radius),
            speed,
            ahead: 0.5 * (1.0 + direction),
            limits: self.tables.limits.interpolate(&place, 0, 0.0).0,
            ..Point::default()
        };
        point.sliding = point.sliding_at(state.speeds);
        let fading = (state.speeds.primary / SPEED_SMOOTHING).tanh();
        for (sign, fraction) in point.directions() {
            let [utilisation, slope] = self.one_way(&point, sign * point.sliding);
            let ([thrust_ratio, torque_loss, bearing_load], [thrust_slope, ..]) =
                self.tables.belt.interpolate(&place, 0, utilisation);
            point.traction[0] += sign * fraction * utilisation;
            point.traction[1] += fraction * slope;
            point.forward += fraction * utilisation;
            point.thrust_ratio += fraction * thrust_ratio;
            point.thrust_slope += fraction * sign * thrust_slope;
            point.torque_loss += fraction * fading * torque_loss;
            point.bearing_load += fraction * bearing_load;
        }
        point
    }

    /// u and ∂u/∂v of forward running at a sliding speed, m/s.
    #[inline(always)]
    fn one_way(&self, point: &Point, sliding: f64) -> [f64; 2] {
        let [capacity, limit] = point.limits(sliding);
        let fraction = sliding / limit;
        if fraction.abs() <= 1.0 {
            let ([value], [slope]) = self.tables.traction.interpolate(&point.place, 0, fraction);
            return [value, slope / limit];
        }
        let Friction { fall, fall_speed, .. } = self.parameters.friction;
        let decay = (-(sliding.abs() - limit) / fall_speed).exp();
        let slope = -capacity * fall * decay / fall_speed * sliding.signum();
        [capacity * (1.0 - fall * (1.0 - decay)), slope]
    }

    /// u and ∂u/∂v at another sliding speed, m/s.
    pub fn traction(&self, point: &Point, sliding: f64) -> [f64; 2] {
        point.directions().fold([0.0; 2], |mean, (sign, fraction)| {
            let [value, slope] = self.one_way(point, sign * sliding);
            [mean[0] + sign * fraction * value, mean[1] + fraction * slope]
        })
    }

    /// Drag of the shafts.
    pub fn drags(&self, point: &Point) -> PerPulley<Drag> {
        let load = [point.bearing_load, 0.0];
        PerPulley::from_fn(|j| self.parameters.pulley(j).drag.loads(point.speeds[j], load))
    }

    /// ℓ' in a state, 1/s, and its slope over the utilisation by way of the thrust ratio; 0 with a
    /// held sheave.
    pub fn shift(&self, point: &Point) -> (f64, f64) {
        if self.parameters.holds_a_sheave() {
            return (0.0, 0.0);
        }
        let speed = point.speeds.primary.abs();
        let under = |seal_friction: PerPulley<f64>| {
            let [secondary, primary] = Pulley::BOTH.map(|j| point.clamping[j] - seal_friction[j]);
            let holding = point.thrust_ratio * secondary;
            let excess = (primary.max(LEAST_FORCE) / holding.max(LEAST_FORCE)).ln();
            let (rate, gain) = self.tables.shift_rate(&point.place, point.forward, excess);
            (-speed * rate, speed * (gain * point.thrust_slope / point.thrust_ratio))
        };
        let free = under(PerPulley::default());
        if Pulley::BOTH.map(|j| self.parameters.pulley(j).cylinder.seal) == [0.0; 2] {
            return free;
        }
        let under = |rate: f64| {
            under(PerPulley::from_fn(|j| {
                self.parameters.seal_friction(j, rate * point.ways[j])
            }))
        };
        // The friction falls with the rate that it causes: one root, between no motion and that
        // without friction.
        let rate = bisected([free.0.min(0.0), free.0.max(0.0)], |rate| under(rate).0 > rate);
        let near = 1e-2 * self.parameters.friction.velocity / point.ways.secondary.abs();
        let falls = (under(rate + near).0 - under(rate - near).0) / (2.0 * near);
        (rate, under(rate).1 / (1.0 - falls.min(0.0)))
    }
}
