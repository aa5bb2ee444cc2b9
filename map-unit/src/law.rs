//! Torques, losses and shift rate of a state.
//!
//! The state is ω_P, ω_S and ℓ = ln i, with i = r_S/r_P of the pitch radii. The sliding speed v =
//! r_P ω_P − r_S ω_S gives the slip s = v/q with q = √((r_P ω_P)² + v_0²), and the table of the
//! traction the utilisation u(s); beyond the slip s_c at capacity u_c
//!
//! u = u_c (1 − fall (1 − e^(−(|v| − |s_c| q)/v_f))).
//!
//! The torque of the primary shaft on the belt is T_P = u 2μ r_P F_S/cosβ, positive where it
//! drives, and that of the belt on the secondary shaft T_S = i (T_P − tanh(ω_P/ω_0) T_l), with ω_0
//! of the [drag](pushbelt::shaft). A growing primary force closes the primary pulley, so ℓ' =
//! −|ω_P| G(ln(F_P/(κ F_S))), with G of the sign of its argument; F_P and F_S are those of clamps
//! and [cylinders](pushbelt::cylinder), whose seals act on the shift alone. T_l and κ are tables
//! over u/u_c, because κ falls steeply near the capacity.
//!
//! Reverse running is the mirror image: with b = r_P ω_P/q, which is ±1 except near standstill, u =
//! (1+b)/2 U(s) − (1−b)/2 U(−s); other quantities are means with these weights.

use std::f64::consts::TAU;
use std::ops::RangeInclusive;
use std::sync::Arc;

use pushbelt::contact::full_slip_torque;
use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::reference_curve::TwoPulley;
use pushbelt::shaft::{Drag, SPEED_SMOOTHING};
use pushbelt::variator::settings::{Axial, Friction, Inputs, Parameters, ParametersInForce, bisected};

use crate::settings::Settings;
use crate::tables::{AxisPosition, GridPosition, Sloped, Tables, UniformAxis};
use crate::tuning::{BEYOND_STOPS, LEAST_FORCE, RADII, SLIP_SPEED};

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Speeds of the shafts, rad/s.
    pub speeds: PerPulley<f64>,
    /// ln i.
    pub log_ratio: f64,
    /// Thrust ratio of the last step, from which a held secondary sheave gets its force.
    pub thrust_ratio: f64,
}

/// Loads in a state, and values of the tables.
#[derive(Clone, Copy, Debug, Default)]
pub struct Point {
    pub position: GridPosition,
    /// Speeds of the shafts, rad/s, and the sliding speed v, m/s.
    speeds: PerPulley<f64>,
    pub sliding: f64,
    /// Pitch radius on the primary pulley, m.
    pub radius: f64,
    pub ratio: f64,
    /// Positions of the sheaves, m, and their change per change of ln i, m.
    pub positions: PerPulley<f64>,
    pub ways: PerPulley<f64>,
    /// Forces of clamps and cylinders that close the pulleys, without their seals, N.
    pub clamping: PerPulley<f64>,
    /// Secondary force without seals, N: of clamp and cylinder, or with a held sheave as the
    /// primary force requires.
    pub force: f64,
    /// Torque of full slip, at utilisation 1, N·m.
    pub full_slip: f64,
    /// Speed q by which the sliding speed is divided, m/s.
    pub speed: f64,
    /// Weight of forward running: 1, 0 in reverse running, between them near standstill.
    ahead: f64,
    /// Capacities of forward running where each pulley drives.
    capacities: PerPulley<Capacity>,
    /// Utilisation u and ∂u/∂v, s/m.
    pub traction: Sloped,
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
        self.full_slip * self.traction.value
    }

    /// Whether the slip is beyond that at capacity: the belt slips through.
    pub fn macro_slip(&self) -> bool {
        let sliding = if self.ahead >= 0.5 { self.sliding } else { -self.sliding };
        (sliding / self.capacity(sliding).sliding).abs() > 1.0
    }

    #[inline(always)]
    fn capacity(&self, direction: f64) -> Capacity {
        if direction >= 0.0 {
            self.capacities.primary
        } else {
            self.capacities.secondary
        }
    }

    /// The directions of running, 1 or −1, with their weights. Reverse running is forward running at
    /// −v.
    #[inline(always)]
    fn directions(&self) -> impl Iterator<Item = (f64, f64)> + use<> {
        let weighted = [(1.0, self.ahead), (-1.0, 1.0 - self.ahead)];
        weighted.into_iter().filter(|(_, weight)| *weight > 0.0)
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Capacity {
    utilisation: f64,
    sliding: f64,
}

#[derive(Clone, Debug)]
pub struct Law {
    pub tables: Arc<Tables>,
    pub parameters: ParametersInForce,
    /// ln i between the end stops.
    pub stops: RangeInclusive<f64>,
    /// Points over ln i, and the primary pitch radii there, m.
    points: UniformAxis,
    radii: Arc<[f64]>,
    /// Pitch radius at ratio 1, m.
    at_one: f64,
    /// Motion of a sheave per change of its radius.
    way: f64,
}

impl Law {
    /// The laws of these settings, or the reason why there are none.
    pub fn new(settings: &Settings) -> Result<Self, String> {
        let parameters = settings.parameters.in_force();
        let (least, most) = parameters.ratio_range().into_inner();
        // The end stops limit the ratio of the ring's centre line. The pitch line inside it is a
        // curve around two pulleys too.
        let (true, [Some(low), Some(high)]) =
            (least < most, [least, most].map(|ratio| parameters.pitch_radii(ratio)))
        else {
            return Err("the radii at the end stops leave no range of ratios".to_owned());
        };
        let [low, high] = [low, high].map(|radii| (radii.secondary / radii.primary).ln());
        let geometry = &parameters.geometry;
        let length = geometry.belt_length - TAU * parameters.belt.pitch_offset;
        let curve = TwoPulley::new(geometry.center_distance, length);
        let radius = |log_ratio: f64| {
            let radii = curve.radii(log_ratio.exp());
            radii.map(|radii| radii.primary).map_err(|error| error.to_string())
        };
        let points = UniformAxis::over(&[low - BEYOND_STOPS, high + BEYOND_STOPS], RADII);
        Ok(Self {
            tables: settings.own.clone().ok_or("the unit has no tables")?,
            stops: low..=high,
            points,
            radii: points.points().map(radius).collect::<Result<_, _>>()?,
            at_one: radius(0.0)?,
            way: 2.0 * geometry.wedge_angle.tan(),
            parameters,
        })
    }

    /// Pitch radii at ln i, m, and their derivatives.
    pub fn radii(&self, log_ratio: f64) -> PerPulley<Sloped> {
        let AxisPosition { index, fraction } = self.points.find(log_ratio);
        let step = self.radii[index + 1] - self.radii[index];
        let (value, slope) = (self.radii[index] + fraction * step, step * self.points.per_step);
        let ratio = log_ratio.exp();
        PerPulley {
            primary: Sloped { value, slope },
            secondary: Sloped {
                value: ratio * value,
                slope: ratio * (value + slope),
            },
        }
    }

    /// Loads and values of the tables in a state under these inputs.
    pub fn point(&self, state: &State, inputs: &Inputs) -> Point {
        let Parameters {
            friction, geometry, ..
        } = &*self.parameters;
        let radii = self.radii(state.log_ratio);
        let radius = radii.primary.value;
        let positions = radii.map(|radius| self.way * (radius.value - self.at_one));
        let clamping = self
            .parameters
            .total_clamping_forces_at(inputs, positions, state.speeds);
        let force = match self.parameters.secondary.axial {
            Axial::Held => clamping.primary / state.thrust_ratio,
            Axial::Force => clamping.secondary,
        };
        let position = self
            .tables
            .position(force.max(0.0), state.speeds.primary.abs(), state.log_ratio);
        let around = radius * state.speeds.primary;
        let speed = (around * around + SLIP_SPEED * SLIP_SPEED).sqrt();
        let limits = self.tables.limits.interpolate(&position, 0, 0.0);
        let [against, along, slip_against, slip_along] = limits.map(|limit| limit.value);
        let capacity = |utilisation, slip: f64| Capacity {
            utilisation,
            sliding: slip.abs() * speed,
        };
        // Slightly steeper than b, so that only one direction is evaluated at running speeds.
        let direction = (1.001 * around / speed).clamp(-1.0, 1.0);
        let mut point = Point {
            position,
            speeds: state.speeds,
            radius,
            ratio: state.log_ratio.exp(),
            positions,
            ways: radii.map(|radius| self.way * radius.slope),
            clamping,
            force,
            full_slip: full_slip_torque(friction, geometry.wedge_angle.cos(), force.max(0.0), radius),
            speed,
            ahead: 0.5 * (1.0 + direction),
            capacities: PerPulley {
                secondary: capacity(against, slip_against),
                primary: capacity(along, slip_along),
            },
            ..Point::default()
        };
        point.sliding = point.sliding_at(state.speeds);
        let fading = (state.speeds.primary / SPEED_SMOOTHING).tanh();
        for (sign, fraction) in point.directions() {
            let Sloped { value, slope } = self.one_way(&point, sign * point.sliding);
            let most = point.capacity(value).utilisation.abs();
            let [thrust, loss, bearing] = self.tables.belt.interpolate(&position, 0, value / most);
            point.traction.value += sign * fraction * value;
            point.traction.slope += fraction * slope;
            point.forward += fraction * value;
            point.thrust_ratio += fraction * thrust.value;
            point.thrust_slope += fraction * sign * thrust.slope / most;
            point.torque_loss += fraction * fading * loss.value;
            point.bearing_load += fraction * bearing.value;
        }
        point
    }

    /// u and ∂u/∂v of forward running at a sliding speed, m/s.
    #[inline(always)]
    fn one_way(&self, point: &Point, sliding: f64) -> Sloped {
        let capacity = point.capacity(sliding);
        let fraction = sliding / capacity.sliding;
        if fraction.abs() <= 1.0 {
            let [mut traction] = self.tables.traction.interpolate(&point.position, 0, fraction);
            traction.slope /= capacity.sliding;
            return traction;
        }
        let Friction { fall, fall_speed, .. } = self.parameters.friction;
        let decay = (-(sliding.abs() - capacity.sliding) / fall_speed).exp();
        Sloped {
            value: capacity.utilisation * (1.0 - fall * (1.0 - decay)),
            slope: -capacity.utilisation * fall * decay / fall_speed * sliding.signum(),
        }
    }

    /// u and ∂u/∂v at another sliding speed, m/s.
    pub fn traction(&self, point: &Point, sliding: f64) -> Sloped {
        let mut mean = Sloped::default();
        for (sign, fraction) in point.directions() {
            let Sloped { value, slope } = self.one_way(point, sign * sliding);
            mean.value += sign * fraction * value;
            mean.slope += fraction * slope;
        }
        mean
    }

    pub fn drags(&self, point: &Point) -> PerPulley<Drag> {
        let load = [point.bearing_load, 0.0];
        PerPulley::from_fn(|j| self.parameters.pulley(j).drag.loads(point.speeds[j], load))
    }

    /// ℓ' in a state, 1/s, and its slope over the utilisation by way of the thrust ratio; 0 with a
    /// held sheave.
    pub fn shift(&self, point: &Point) -> Sloped {
        if self.parameters.holds_a_sheave() {
            return Sloped::default();
        }
        let speed = point.speeds.primary.abs();
        let under = |seal_friction: PerPulley<f64>| {
            let [secondary, primary] = Pulley::BOTH.map(|j| point.clamping[j] - seal_friction[j]);
            let holding = point.thrust_ratio * secondary;
            let excess = (primary.max(LEAST_FORCE) / holding.max(LEAST_FORCE)).ln();
            let rate = self.tables.shift_rate(&point.position, point.forward, excess);
            Sloped {
                value: -speed * rate.value,
                slope: speed * (rate.slope * point.thrust_slope / point.thrust_ratio),
            }
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
        // The rate falls with its own friction: there is one root, between 0 and the rate without
        // friction.
        let range = free.value.min(0.0)..=free.value.max(0.0);
        let value = bisected(range, |rate| under(rate).value > rate);
        let near = 1e-2 * self.parameters.friction.velocity / point.ways.secondary.abs();
        let falls = (under(value + near).value - under(value - near).value) / (2.0 * near);
        let slope = under(value).slope / (1.0 - falls.min(0.0));
        Sloped { value, slope }
    }
}
