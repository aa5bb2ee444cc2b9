//! Torques, losses and shift rate of a state.
//!
//! The state is ω_P, ω_S and ℓ = ln i, with i = r_S/r_P of the pitch radii. The sliding speed v = r_P ω_P − r_S ω_S gives the slip
//! s = v/q with q = √((r_P ω_P)² + v_0²), and the table of the traction the utilisation u(s). The torque of the primary shaft on the belt
//! is T_P = u 2μ r_P F_S/cosβ, positive where it drives. Beyond the slip s_c at capacity u_c
//!
//! u = u_c (1 − fall (1 − e^(−(|v| − |s_c| q)/v_f))),
//!
//! and the belt slips through. The torque of the belt on the secondary shaft is T_S = i (T_P − tanh(ω_P/ω_0) T_l), with ω_0 of the [drag](pushbelt::shaft), so the belt loses
//! T_P ω_P − T_S ω_S = s T_P ω_P + (1 − s) tanh(ω_P/ω_0) T_l ω_P at running speed. A growing primary force closes the primary pulley, so
//! ℓ' = −|ω_P| G(ln(F_P/(κ F_S))), with G of the sign of its argument.
//!
//! F_P and F_S are those of clamps and [cylinders](pushbelt::cylinder). Seals act on the shift alone, in the quotient of the forces.
//!
//! Reverse running is the mirror image: ω, v and T change their signs, and the tables are those at the slip −s. With b = r_P ω_P/q,
//! which is ±1 except near standstill, u = (1+b)/2 U(s) − (1−b)/2 U(−s); other quantities are means with these weights.

use pushbelt::pulley::Pulley::{Primary, Secondary};
use pushbelt::variator::settings::{Friction, Inputs, Parameters};

use crate::tables::{Belt, Place, Tables};

/// Regularisation speed v_0 of the slip, m/s.
pub const SLIP_SPEED: f64 = 0.1;
/// Iterations for the shift rate under the friction of seals.
const RUBBED: usize = 60;
/// Smallest force in a quotient of forces, N.
pub const LEAST_FORCE: f64 = 1.0;
/// Number of places of the table of radii.
const RADII: usize = 257;
/// Iterations for a pitch radius: each leaves some hundredth of the error.
const ITERATIONS: usize = 15;
/// Range of ln i of the table of radii beyond the end stops.
const BEYOND_STOPS: f64 = 0.05;

/// Radii over the ratio, between the end stops.
#[derive(Clone, Debug)]
pub struct Radii {
    first: f64,
    per_step: f64,
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
        let first = stops[0] - BEYOND_STOPS;
        let step = (stops[1] + BEYOND_STOPS - first) / (RADII - 1) as f64;
        Ok(Self {
            first,
            per_step: 1.0 / step,
            primary: (0..RADII)
                .map(|k| radius((first + k as f64 * step).exp()))
                .collect::<Result<_, _>>()?,
            at_one: radius(1.0)?,
            place: 2.0 * parameters.geometry.wedge_angle.tan(),
            stops,
        })
    }

    /// Pitch radius on the primary pulley at ln i, m.
    #[must_use]
    pub fn primary(&self, log_ratio: f64) -> f64 {
        self.with_slope(log_ratio).0
    }

    /// Pitch radius on the primary pulley at ln i, m, and its derivative.
    fn with_slope(&self, log_ratio: f64) -> (f64, f64) {
        let scaled = ((log_ratio - self.first) * self.per_step).clamp(0.0, (RADII - 1) as f64);
        let k = (scaled as usize).min(RADII - 2);
        let step = self.primary[k + 1] - self.primary[k];
        (self.primary[k] + (scaled - k as f64) * step, step * self.per_step)
    }

    /// Positions of the primary and the secondary sheave at ln i, m, 0 at ratio 1, and their derivatives.
    #[must_use]
    pub fn positions(&self, log_ratio: f64) -> [(f64, f64); 2] {
        let (radius, slope) = self.with_slope(log_ratio);
        let ratio = log_ratio.exp();
        [(radius, slope), (ratio * radius, ratio * (radius + slope))]
            .map(|(radius, slope)| (self.place * (radius - self.at_one), self.place * slope))
    }
}

/// A state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct State {
    /// Primary speed, rad/s.
    pub primary: f64,
    /// Secondary speed, rad/s.
    pub secondary: f64,
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
}

/// Utilisation, its derivative with respect to the sliding speed, s/m, and whether the belt slips through.
#[derive(Clone, Copy, Debug)]
pub struct Traction {
    /// Utilisation u.
    pub value: f64,
    /// ∂u/∂v.
    pub slope: f64,
    /// Whether the slip is beyond that at capacity.
    pub macro_slip: bool,
    /// Sliding speeds between which the slope holds, m/s; the same speed twice where it does not hold around the present one.
    pub between: [f64; 2],
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

    /// Torque loss of the belt at the primary pulley, N·m, without its sign.
    #[must_use]
    pub fn torque_loss(&self) -> f64 {
        self.mean(|way| way.belt.torque_loss)
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
    /// Torque at utilisation 1, N·m.
    pub torque: f64,
    /// Speed q by which the sliding speed is divided, m/s.
    pub speed: f64,
    /// Share of forward running: 1, or 0 for reverse running, and between them near standstill.
    pub forward: f64,
    capacity: [f64; 2],
    capacity_slip: [f64; 2],
}

impl Law<'_> {
    /// The frame of a state under a secondary force, N.
    #[must_use]
    pub fn frame(&self, state: &State, force: f64) -> Frame {
        let force = force.max(0.0);
        let place = self.tables.place(force, state.primary.abs(), state.log_ratio);
        let (capacity, capacity_slip) = self.tables.limits(&place);
        let radius = self.radii.primary(state.log_ratio);
        let around = radius * state.primary;
        let speed = (around * around + SLIP_SPEED * SLIP_SPEED).sqrt();
        // Slightly steeper than b, so that only one direction is evaluated at running speeds.
        let direction = (1.001 * around / speed).clamp(-1.0, 1.0);
        Frame {
            place,
            radius,
            ratio: state.log_ratio.exp(),
            torque: 2.0 * self.parameters.friction.pulley * radius * force / self.parameters.geometry.wedge_angle.cos(),
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
                value: line.value,
                slope: line.slope / limit,
                macro_slip: false,
                between: line.between.map(|share| share * limit),
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
        let b = frame.forward;
        if b == 1.0 {
            return self.one_way(frame, sliding);
        }
        let mirrored = self.one_way(frame, -sliding);
        if b == 0.0 {
            return mirror_image(mirrored);
        }
        between(b, sliding, self.one_way(frame, sliding), mirrored)
    }

    /// All that the tables give at a sliding speed v, m/s.
    #[must_use]
    pub fn point(&self, frame: &Frame, sliding: f64) -> Point {
        let way = |sliding: f64| {
            let traction = self.one_way(frame, sliding);
            Way {
                traction,
                belt: self.tables.belt(&frame.place, traction.value),
            }
        };
        let b = frame.forward;
        if b == 1.0 {
            let main = way(sliding);
            let (traction, other) = (main.traction, None);
            return Point { traction, main, other };
        }
        let mirrored = way(-sliding);
        if b == 0.0 {
            return Point {
                traction: mirror_image(mirrored.traction),
                main: mirrored,
                other: None,
            };
        }
        let ahead = way(sliding);
        let traction = between(b, sliding, ahead.traction, mirrored.traction);
        let (main, share, other) = if b >= 0.5 {
            (ahead, 1.0 - b, mirrored)
        } else {
            (mirrored, b, ahead)
        };
        Point {
            traction,
            main,
            other: Some((share, other)),
        }
    }

    /// Forces of clamps and cylinders that close the primary and the secondary pulley in a state, without their seals, N.
    #[must_use]
    pub fn closing(&self, state: &State, inputs: &Inputs) -> [f64; 2] {
        let [primary, secondary] = self.radii.positions(state.log_ratio);
        [
            (Primary, primary, state.primary),
            (Secondary, secondary, state.secondary),
        ]
        .map(|(pulley, (position, _), speed)| {
            let cylinder = &self.parameters.pulley(pulley).cylinder;
            inputs.pulley(pulley).force(cylinder) + cylinder.push(position, speed)
        })
    }

    /// Friction of the seals of both cylinders along the speeds of the sheaves, m/s; N.
    #[must_use]
    pub fn rubbing(&self, velocities: [f64; 2]) -> [f64; 2] {
        let Parameters {
            primary,
            secondary,
            friction,
            ..
        } = self.parameters;
        [
            primary.cylinder.drag(velocities[0], friction.velocity),
            secondary.cylinder.drag(velocities[1], friction.velocity),
        ]
    }

    /// ℓ' in a state with the forces of the inputs, 1/s, and its slope over the utilisation by way of the thrust ratio.
    #[must_use]
    pub fn shift(&self, frame: &Frame, point: &Point, state: &State, inputs: &Inputs) -> (f64, f64) {
        let forces = self.closing(state, inputs);
        let free = self.shift_under(frame, point, state.primary, forces);
        let Parameters { primary, secondary, .. } = self.parameters;
        if primary.cylinder.seal == 0.0 && secondary.cylinder.seal == 0.0 {
            return free;
        }
        let slopes = self.radii.positions(state.log_ratio).map(|(_, slope)| slope);
        let under = |rate: f64| {
            let rubbing = self.rubbing(slopes.map(|slope| slope * rate));
            let rubbed = [forces[0] - rubbing[0], forces[1] - rubbing[1]];
            self.shift_under(frame, point, state.primary, rubbed)
        };
        // The friction of the seals falls with the rate that it causes: one root, between no motion and that without friction.
        let (mut low, mut high) = (free.0.min(0.0), free.0.max(0.0));
        for _ in 0..RUBBED {
            let middle = 0.5 * (low + high);
            if under(middle).0 > middle {
                low = middle;
            } else {
                high = middle;
            }
        }
        let rate = 0.5 * (low + high);
        let near = 1e-2 * self.parameters.friction.velocity / slopes[1].abs();
        let falls = (under(rate + near).0 - under(rate - near).0) / (2.0 * near);
        (rate, under(rate).1 / (1.0 - falls.min(0.0)))
    }

    /// [`Law::shift`] under forces of the sheaves on the belt, N.
    fn shift_under(&self, frame: &Frame, point: &Point, primary: f64, [closing, other]: [f64; 2]) -> (f64, f64) {
        let at = |way: &Way| {
            let Belt {
                thrust_ratio,
                thrust_slope,
                ..
            } = way.belt;
            let holding = thrust_ratio * other;
            let excess = (closing.max(LEAST_FORCE) / holding.max(LEAST_FORCE)).ln();
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

/// The traction of reverse running, from that at the mirrored sliding speed.
fn mirror_image(mirrored: Traction) -> Traction {
    let [low, high] = mirrored.between;
    Traction {
        value: -mirrored.value,
        between: [-high, -low],
        ..mirrored
    }
}

/// The traction near standstill, from those of both directions; `b` is the share of forward running.
fn between(b: f64, sliding: f64, ahead: Traction, mirrored: Traction) -> Traction {
    let main = if b >= 0.5 { ahead } else { mirrored };
    Traction {
        value: b * ahead.value - (1.0 - b) * mirrored.value,
        slope: b * ahead.slope + (1.0 - b) * mirrored.slope,
        macro_slip: main.macro_slip,
        between: [sliding; 2],
    }
}
