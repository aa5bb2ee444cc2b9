//! Torques, losses and shift rate of a state.
//!
//! The state is ω_P, ω_S and ℓ = ln i, with i = r_S/r_P of the pitch radii. The sliding speed v = r_P ω_P − r_S ω_S gives the slip
//! s = v/q with q = √((r_P ω_P)² + v_0²), and the table of the traction the utilisation u(s). The torque of the primary shaft on the belt
//! is T_P = u 2μ r_P F_S/cosβ, positive where it drives. Beyond the slip s_c at capacity u_c
//!
//! u = u_c (1 − fall (1 − e^(−(|v| − |s_c| q)/v_f))),
//!
//! and the belt slips through. The torque of the belt on the secondary shaft is T_S = i (T_P − tanh(ω_P/ω_0) T_l), with ω_0 of the
//! [drag](pushbelt::shaft), so the belt loses T_P ω_P − T_S ω_S = s T_P ω_P + (1 − s) tanh(ω_P/ω_0) T_l ω_P at running speed. A growing primary force closes the primary pulley, so
//! ℓ' = −|ω_P| G(ln(F_P/(κ F_S))), with G of the sign of its argument.
//!
//! F_P and F_S are those of clamps and [cylinders](pushbelt::cylinder). Seals act on the shift alone, in the quotient of the forces.
//!
//! Reverse running is the mirror image: ω, v and T change their signs, and the tables are those at the slip −s. With b = r_P ω_P/q,
//! which is ±1 except near standstill, u = (1+b)/2 U(s) − (1−b)/2 U(−s); other quantities are means with these weights.

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::shaft::SPEED_SMOOTHING;
use pushbelt::variator::settings::{Friction, Inputs, Parameters, bisected};

use crate::tables::{Belt, Even, Place, Tables, Traction};

/// Regularisation speed v_0 of the slip, m/s.
const SLIP_SPEED: f64 = 0.1;
/// Smallest force in a quotient of forces, N.
const LEAST_FORCE: f64 = 1.0;
/// Number of places of the table of radii.
const RADII: usize = 257;
/// Iterations for a pitch radius: each leaves some hundredth of the error.
const ITERATIONS: usize = 15;
/// Range of ln i of the table of radii beyond the end stops.
const BEYOND_STOPS: f64 = 0.05;

/// Radii over the ratio, between the end stops.
#[derive(Clone, Debug)]
pub struct Radii {
    /// Places over ln i.
    along: Even,
    primary: Vec<f64>,
    /// Pitch radius at ratio 1, m.
    at_one: f64,
    /// Way of a sheave per change of its radius.
    place: f64,
    /// Least and greatest ln i, at the end stops.
    pub stops: [f64; 2],
}

impl Radii {
    /// The radii of a variator with these settings.
    ///
    /// # Errors
    /// The radii at the end stops allow no range of ratios.
    pub fn new(parameters: &Parameters) -> Result<Self, String> {
        let (least, most) = parameters.ratio_range();
        if least >= most {
            return Err("the radii at the end stops leave no range of ratios".to_owned());
        }
        // The detailed unit has the ratio of the radii of the ring's centre line, and pitch radii at it.
        let at = |reference: f64| {
            let radii = parameters.pitch_radii(reference);
            radii.ok_or_else(|| format!("no belt fits at the ratio {reference:.3}"))
        };
        let of_pitch = |reference: f64| at(reference).map(|(primary, secondary)| (secondary / primary).ln());
        let radius = |ratio: f64| {
            let mut reference = ratio;
            for _ in 0..ITERATIONS {
                let (primary, secondary) = at(reference)?;
                reference *= ratio * primary / secondary;
            }
            at(reference).map(|(primary, _)| primary)
        };
        let stops = [of_pitch(least)?, of_pitch(most)?];
        let along = Even::between(stops[0] - BEYOND_STOPS, stops[1] + BEYOND_STOPS, RADII);
        let primary = along.places().into_iter().map(|log_ratio| radius(log_ratio.exp()));
        Ok(Self {
            along,
            primary: primary.collect::<Result<_, _>>()?,
            at_one: radius(1.0)?,
            place: 2.0 * parameters.geometry.wedge_angle.tan(),
            stops,
        })
    }

    /// Pitch radius on the primary pulley at ln i, m, and its derivative.
    #[must_use]
    pub fn primary(&self, log_ratio: f64) -> (f64, f64) {
        let (k, t) = self.along.find(log_ratio);
        let step = self.primary[k + 1] - self.primary[k];
        (self.primary[k] + t * step, step * self.along.per_step)
    }

    /// Positions of the sheaves at ln i, m, 0 at ratio 1, and their derivatives.
    #[must_use]
    pub fn positions(&self, log_ratio: f64) -> PerPulley<(f64, f64)> {
        let (radius, slope) = self.primary(log_ratio);
        let ratio = log_ratio.exp();
        let radii = PerPulley {
            primary: (radius, slope),
            secondary: (ratio * radius, ratio * (radius + slope)),
        };
        radii.map(|(radius, slope)| (self.place * (radius - self.at_one), self.place * slope))
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

/// What is constant over the solution of a stage.
pub struct Law<'a> {
    /// The tables.
    pub tables: &'a Tables,
    /// Radii over the ratio.
    pub radii: &'a Radii,
    /// Parameters.
    pub parameters: &'a Parameters,
    /// With a held secondary sheave: the thrust ratio from which it gets its force.
    pub held_thrust_ratio: Option<f64>,
}

/// What the tables give at a sliding speed in one direction of running.
#[derive(Clone, Copy, Debug)]
struct Way {
    traction: Traction,
    belt: Belt,
}

/// What the tables give at a sliding speed.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// The traction.
    pub traction: Traction,
    /// The direction with the larger share.
    main: Way,
    /// Near standstill: the share of the other direction, and the other direction.
    other: Option<(f64, Way)>,
}

impl Point {
    fn mean(&self, of: impl Fn(&Way) -> f64) -> f64 {
        let main = of(&self.main);
        match &self.other {
            None => main,
            Some((share, other)) => (1.0 - share) * main + share * of(other),
        }
    }

    /// Thrust ratio κ.
    #[must_use]
    pub fn thrust_ratio(&self) -> f64 {
        self.mean(|way| way.belt.thrust_ratio)
    }

    /// Torque loss of the belt at the primary pulley, which runs at a speed, rad/s; N·m.
    #[must_use]
    pub fn lost(&self, primary: f64) -> f64 {
        (primary / SPEED_SMOOTHING).tanh() * self.mean(|way| way.belt.torque_loss)
    }

    /// Resultant of the belt's contact forces on a pulley, N.
    #[must_use]
    pub fn bearing_load(&self) -> f64 {
        self.mean(|way| way.belt.bearing_load)
    }
}

/// The place of a state in the tables, and what the traction needs there.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Place in the tables.
    pub place: Place,
    /// Pitch radius on the primary pulley, m.
    pub radius: f64,
    /// Ratio.
    pub ratio: f64,
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
    capacity: [f64; 2],
    capacity_slip: [f64; 2],
}

impl Frame {
    /// The sliding speed v, m/s.
    #[must_use]
    pub fn sliding(&self, speeds: PerPulley<f64>) -> f64 {
        self.radius * (speeds.primary - self.ratio * speeds.secondary)
    }

    /// What `way` gives in the direction with the larger share, and near standstill the share of the other direction and what it gives
    /// there. Reverse running is forward running at −v.
    #[inline(always)]
    fn ways<W>(&self, sliding: f64, way: impl Fn(f64) -> W) -> (W, Option<(f64, W)>) {
        let (main, share) = if self.forward >= 0.5 {
            (sliding, 1.0 - self.forward)
        } else {
            (-sliding, self.forward)
        };
        (way(main), (share > 0.0).then(|| (share, way(-main))))
    }

    /// The traction at a sliding speed, m/s, from those of [`Frame::ways`].
    #[inline(always)]
    fn mix(&self, sliding: f64, main: Traction, other: Option<(f64, Traction)>) -> Traction {
        let ahead = self.forward >= 0.5;
        let sign = if ahead { 1.0 } else { -1.0 };
        match other {
            None => Traction {
                value: sign * main.value,
                between: if ahead {
                    main.between
                } else {
                    [-main.between[1], -main.between[0]]
                },
                ..main
            },
            Some((share, other)) => Traction {
                value: sign * ((1.0 - share) * main.value - share * other.value),
                slope: (1.0 - share) * main.slope + share * other.slope,
                macro_slip: main.macro_slip,
                between: [sliding; 2],
            },
        }
    }
}

impl Law<'_> {
    /// The frame of a state under inputs.
    #[must_use]
    pub fn frame(&self, state: &State, inputs: &Inputs) -> Frame {
        let closing = self.closing(state, inputs);
        let force = self
            .held_thrust_ratio
            .map_or(closing.secondary, |ratio| closing.primary / ratio);
        let primary = state.speeds.primary;
        let place = self.tables.place(force.max(0.0), primary.abs(), state.log_ratio);
        let (capacity, capacity_slip) = self.tables.limits(&place);
        let (radius, _) = self.radii.primary(state.log_ratio);
        let around = radius * primary;
        let speed = (around * around + SLIP_SPEED * SLIP_SPEED).sqrt();
        // Slightly steeper than b, so that only one direction is evaluated at running speeds.
        let direction = (1.001 * around / speed).clamp(-1.0, 1.0);
        let Parameters { friction, geometry, .. } = self.parameters;
        Frame {
            place,
            radius,
            ratio: state.log_ratio.exp(),
            closing,
            force,
            torque: 2.0 * friction.pulley * radius * force.max(0.0) / geometry.wedge_angle.cos(),
            speed,
            forward: 0.5 * (1.0 + direction),
            capacity,
            capacity_slip,
        }
    }

    /// The traction of forward running at a sliding speed, m/s.
    fn one_way(&self, frame: &Frame, sliding: f64) -> Traction {
        let driving = usize::from(sliding >= 0.0);
        let limit = frame.capacity_slip[driving].abs() * frame.speed;
        let share = sliding / limit;
        if share.abs() <= 1.0 {
            let line = self.tables.traction(&frame.place, share);
            return Traction {
                slope: line.slope / limit,
                between: line.between.map(|share| share * limit),
                ..line
            };
        }
        let Friction { fall, fall_speed, .. } = self.parameters.friction;
        let decay = (-(sliding.abs() - limit) / fall_speed).exp();
        let capacity = frame.capacity[driving];
        Traction {
            value: capacity * (1.0 - fall * (1.0 - decay)),
            slope: -capacity * fall * decay / fall_speed * sliding.signum(),
            macro_slip: true,
            between: [sliding; 2],
        }
    }

    /// The traction at a sliding speed v, m/s.
    #[must_use]
    pub fn traction(&self, frame: &Frame, sliding: f64) -> Traction {
        let (main, other) = frame.ways(sliding, |sliding| self.one_way(frame, sliding));
        frame.mix(sliding, main, other)
    }

    /// All that the tables give at a sliding speed v, m/s.
    #[must_use]
    pub fn point(&self, frame: &Frame, sliding: f64) -> Point {
        let (main, other) = frame.ways(sliding, |sliding| {
            let traction = self.one_way(frame, sliding);
            let belt = self.tables.belt(&frame.place, traction.value);
            Way { traction, belt }
        });
        let near = other.map(|(share, way)| (share, way.traction));
        let traction = frame.mix(sliding, main.traction, near);
        Point { traction, main, other }
    }

    /// Forces of clamps and cylinders that close the pulleys in a state, without their seals, N.
    fn closing(&self, state: &State, inputs: &Inputs) -> PerPulley<f64> {
        let positions = self.radii.positions(state.log_ratio);
        PerPulley::from_fn(|j| {
            let cylinder = &self.parameters.pulley(j).cylinder;
            inputs.pulley(j).force(cylinder) + cylinder.push(positions[j].0, state.speeds[j])
        })
    }

    /// Friction of the seals of both cylinders along the speeds of the sheaves, m/s; N.
    #[must_use]
    pub fn rubbing(&self, velocities: PerPulley<f64>) -> PerPulley<f64> {
        let velocity = self.parameters.friction.velocity;
        PerPulley::from_fn(|j| self.parameters.pulley(j).cylinder.drag(velocities[j], velocity))
    }

    /// ℓ' in a state, 1/s, and its slope over the utilisation by way of the thrust ratio; 0 with a held sheave.
    #[must_use]
    pub fn shift(&self, frame: &Frame, point: &Point, state: &State) -> (f64, f64) {
        if self.parameters.holds_a_sheave() {
            return (0.0, 0.0);
        }
        let forces = frame.closing;
        let primary = state.speeds.primary;
        let free = self.shift_under(frame, point, primary, forces);
        if Pulley::BOTH
            .iter()
            .all(|j| self.parameters.pulley(*j).cylinder.seal == 0.0)
        {
            return free;
        }
        let slopes = self.radii.positions(state.log_ratio).map(|(_, slope)| slope);
        let under = |rate: f64| {
            let rubbing = self.rubbing(slopes.map(|slope| slope * rate));
            self.shift_under(frame, point, primary, PerPulley::from_fn(|j| forces[j] - rubbing[j]))
        };
        // The friction of the seals falls with the rate that it causes: one root, between no motion and that without friction.
        let rate = bisected([free.0.min(0.0), free.0.max(0.0)], |rate| under(rate).0 > rate);
        let near = 1e-2 * self.parameters.friction.velocity / slopes.secondary.abs();
        let falls = (under(rate + near).0 - under(rate - near).0) / (2.0 * near);
        (rate, under(rate).1 / (1.0 - falls.min(0.0)))
    }

    /// [`Law::shift`] under forces of the sheaves on the belt, N.
    fn shift_under(&self, frame: &Frame, point: &Point, primary: f64, closing: PerPulley<f64>) -> (f64, f64) {
        let at = |way: &Way| {
            let Belt {
                thrust_ratio,
                thrust_slope,
                ..
            } = way.belt;
            let holding = thrust_ratio * closing.secondary;
            let excess = (closing.primary.max(LEAST_FORCE) / holding.max(LEAST_FORCE)).ln();
            let (rate, gain) = self.tables.shift_rate(&frame.place, way.traction.value, excess);
            (rate, -gain * thrust_slope / thrust_ratio)
        };
        let (main, slope) = at(&point.main);
        let rate = match &point.other {
            None => main,
            Some((share, other)) => (1.0 - share) * main + share * at(other).0,
        };
        let direction = 2.0 * frame.forward - 1.0;
        (-primary.abs() * rate, -primary.abs() * slope * direction)
    }
}
