//! One implicit stage: y = base + k f(y).
//!
//! For given ratio, drag and belt loss both speeds are linear in the torque T_P, so the sliding speed is v = v_0 − m T_P(v) with m ≥ 0.
//! This equation in one unknown has a bracket, and is solved by Newton's method with bisection as a fallback. Ratio, drag and belt loss follow in an
//! outer iteration.

use pushbelt::shaft::FADING_SPEED;
use pushbelt::variator::settings::{Drive, Inputs, PulleyParameters, SPEED_LAG};

use crate::law::{Frame, Law, State, Traction};

/// Largest number of outer iterations.
const ITERATIONS: usize = 60;
/// Largest number of iterations for the sliding speed.
const INNER: usize = 80;
/// Relative tolerance of speeds, and tolerance of ln i.
const TOLERANCE: f64 = 1e-9;
/// Bound of the coupling of the ratio, as a share of the coupling by the torque.
const LEAST_SHARE: f64 = 0.5;
/// Bound of the utilisation, above every capacity.
const MOST: f64 = 3.0;

/// A stage.
pub struct Stage<'a> {
    /// Laws.
    pub law: &'a Law<'a>,
    /// The inputs at the time of the stage.
    pub inputs: Inputs,
    /// With a held secondary sheave: the thrust ratio from which it gets its force.
    pub held_thrust_ratio: Option<f64>,
}

/// Speed of a shaft as a linear function of a torque.
struct Line {
    constant: f64,
    slope: f64,
}

impl Stage<'_> {
    /// The solution, from a guess; none if the iteration does not converge.
    #[must_use]
    pub fn solve(&self, base: &State, k: f64, guess: &State) -> Option<State> {
        let mut state = *guess;
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let next = self.iterate(base, k, &state)?;
            let relative = |a: f64, b: f64| (a - b).abs() / (1.0 + a.abs());
            let change = relative(next.primary, state.primary)
                .max(relative(next.secondary, state.secondary))
                .max((next.log_ratio - state.log_ratio).abs());
            state = next;
            // The next change is smaller by the factor between the last two.
            let rate = change / before;
            if change <= TOLERANCE * 1e-3 || before.is_finite() && rate < 0.5 && change * rate <= TOLERANCE {
                return Some(state);
            }
            before = change;
        }
        None
    }

    fn iterate(&self, base: &State, k: f64, state: &State) -> Option<State> {
        let law = self.law;
        let parameters = law.parameters;
        let [closing, own] = law.closing(state, &self.inputs);
        let force = self.held_thrust_ratio.map_or(own, |ratio| closing / ratio);
        let frame = law.frame(state, force);
        let sliding = frame.radius * (state.primary - frame.ratio * state.secondary);
        let point = law.point(&frame, sliding);
        let utilisation = point.traction.value;
        let load = point.bearing_load();
        let lost = (state.primary / FADING_SPEED).tanh() * point.torque_loss();

        let torque = self.inputs.primary.torque;
        let shaft = (&parameters.primary, base.primary, state.primary);
        let primary = self.line(shaft, k, load, torque, -1.0, self.inputs.primary.speed_setpoint);
        let torque = self.inputs.secondary.torque - frame.ratio * lost;
        let shaft = (&parameters.secondary, base.secondary, state.secondary);
        let secondary = self.line(
            shaft,
            k,
            load,
            torque,
            frame.ratio,
            self.inputs.secondary.speed_setpoint,
        );

        let free = frame.radius * (primary.constant - frame.ratio * secondary.constant);
        let per_torque = -frame.radius * (primary.slope - frame.ratio * secondary.slope);
        // The ratio changes with the torque too, by way of the thrust ratio: to first order it is part of the equation.
        let held = parameters.holds_a_sheave();
        let (rate, slope) = if held {
            (0.0, 0.0)
        } else {
            law.shift(&frame, &point, state, &self.inputs)
        };
        let around = frame.radius * frame.ratio * state.secondary;
        let behind = if held {
            0.0
        } else {
            base.log_ratio + k * rate - state.log_ratio
        };
        let [least, most] = law.radii.stops;
        let behind = behind.clamp(least - state.log_ratio, most - state.log_ratio);
        let coupled = around * k * slope;
        let per_utilisation = per_torque * frame.torque;
        let coupled = coupled.clamp(-LEAST_SHARE * per_utilisation, per_utilisation / LEAST_SHARE);
        let found = self.utilisation(
            &frame,
            free - around * behind + coupled * utilisation,
            per_utilisation + coupled,
            (sliding, point.traction),
        )?;
        let torque = frame.torque * found;
        let log_ratio = if held {
            base.log_ratio
        } else {
            (base.log_ratio + k * (rate + slope * (found - utilisation))).clamp(least, most)
        };
        Some(State {
            primary: primary.constant + primary.slope * torque,
            secondary: secondary.constant + secondary.slope * torque,
            log_ratio,
        })
    }

    /// The speed of a shaft: J (ω − base) = k (T + `lever` T_P − drag), with the drag linear about the present speed; or its lag
    /// behind the set point.
    fn line(
        &self,
        (pulley, base, speed): (&PulleyParameters, f64, f64),
        k: f64,
        load: f64,
        torque: f64,
        lever: f64,
        setpoint: f64,
    ) -> Line {
        if pulley.drive == Drive::Speed {
            return Line {
                constant: (base + k / SPEED_LAG * setpoint) / (1.0 + k / SPEED_LAG),
                slope: 0.0,
            };
        }
        let drag = pulley.drag.at(speed, [load, 0.0]);
        let per_torque = k / (pulley.inertia + k * drag.by_speed);
        let constant = per_torque * (pulley.inertia / k * base + torque - drag.torque + drag.by_speed * speed);
        Line {
            constant,
            slope: per_torque * lever,
        }
    }

    /// The utilisation at the root of v − `free` + `per_utilisation` u(v), from a guess with its traction.
    fn utilisation(&self, frame: &Frame, free: f64, per_utilisation: f64, guess: (f64, Traction)) -> Option<f64> {
        if per_utilisation == 0.0 {
            return Some(self.law.traction(frame, free).value);
        }
        let reach = MOST * per_utilisation;
        let (mut low, mut high) = (free - reach, free + reach);
        let (mut v, mut traction) = guess;
        if v < low || v > high {
            v = v.clamp(low, high);
            traction = self.law.traction(frame, v);
        }
        let tolerance = 1e-11 + 1e-13 * (free.abs() + reach);
        for _ in 0..INNER {
            let excess = v - free + per_utilisation * traction.value;
            if excess > 0.0 {
                high = v;
            } else {
                low = v;
            }
            let slope = 1.0 + per_utilisation * traction.slope;
            let newton = v - excess / slope;
            let [from, to] = traction.between;
            // The traction is piecewise linear: the root within a piece is exact.
            if slope > 0.0 && (newton >= from && newton <= to || (newton - v).abs() <= tolerance) {
                return Some(traction.value + traction.slope * (newton - v));
            }
            let next = if slope > 0.0 && newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            v = next;
            traction = self.law.traction(frame, v);
            if high - low <= tolerance {
                return Some(traction.value);
            }
        }
        None
    }
}
