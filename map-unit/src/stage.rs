//! One implicit stage: y = base + k f(y).
//!
//! For given ratio, drag and belt loss both speeds are linear in the torque T_P, so the sliding speed is v = v_0 − m T_P(v) with m ≥ 0.
//! This equation in one unknown has a bracket, and is solved by Newton's method with bisection as a fallback. Ratio,
//! drag and belt loss follow in an outer iteration.

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::variator::settings::{Drive, Inputs, SPEED_LAG};

use crate::file::UTILISATION;
use crate::law::{Frame, Law, State};
use crate::tables::Traction;
use crate::tuning::{ITERATIONS, LEAST_SHARE, TOLERANCE};

/// A stage: the laws, and the inputs at its time.
pub struct Stage<'a> {
    /// Laws.
    pub law: &'a Law<'a>,
    /// Inputs.
    pub inputs: Inputs,
}

impl Stage<'_> {
    /// The solution, from a guess; none if the iteration does not converge.
    #[must_use]
    pub fn solve(&self, base: &State, k: f64, guess: &State) -> Option<State> {
        let mut state = *guess;
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let next = self.iterate(base, k, &state)?;
            let relative = |j: Pulley| (next.speeds[j] - state.speeds[j]).abs() / (1.0 + next.speeds[j].abs());
            let change = Pulley::BOTH.map(relative).into_iter();
            let change = change.fold((next.log_ratio - state.log_ratio).abs(), f64::max);
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
        let frame = law.frame(state, &self.inputs);
        let sliding = frame.sliding(state.speeds);
        let point = law.point(&frame, sliding);
        let utilisation = point.traction.value;
        let lines = PerPulley::from_fn(|j| {
            let torques = match j {
                Pulley::Primary => [0.0, -1.0],
                Pulley::Secondary => [-frame.ratio * point.torque_loss, frame.ratio],
            };
            self.line(
                j,
                [base, state].map(|state| state.speeds[j]),
                k,
                point.bearing_load,
                torques,
            )
        });
        // v_0 and −m for each N·m.
        let [free, per_torque] = [0, 1].map(|n| frame.sliding(lines.map(|line| line[n])));
        // The ratio changes with the torque too, by way of the thrust ratio: to first order it is part of the equation.
        let (rate, slope) = law.shift(&frame, &point);
        let around = frame.radius * frame.ratio * state.speeds.secondary;
        let [least, most] = law.radii.stops;
        let behind = (base.log_ratio + k * rate).clamp(least, most) - state.log_ratio;
        let per_utilisation = -per_torque * frame.torque;
        let coupled = (around * k * slope).clamp(-LEAST_SHARE * per_utilisation, per_utilisation / LEAST_SHARE);
        let found = self.utilisation(
            &frame,
            free - around * behind + coupled * utilisation,
            per_utilisation + coupled,
            (sliding, point.traction),
        )?;
        let torque = frame.torque * found;
        Some(State {
            speeds: lines.map(|[constant, slope]| constant + slope * torque),
            log_ratio: (base.log_ratio + k * (rate + slope * (found - utilisation))).clamp(least, most),
        })
    }

    /// The speed of a shaft and its slope over T_P: J (ω − base) = k (T + own + lever T_P − drag), with the drag linear about the present
    /// speed; or its lag behind the set point.
    fn line(&self, j: Pulley, [base, speed]: [f64; 2], k: f64, load: f64, [own, lever]: [f64; 2]) -> [f64; 2] {
        let (pulley, inputs) = (self.law.parameters.pulley(j), self.inputs.pulley(j));
        if pulley.drive == Drive::Speed {
            let share = k / SPEED_LAG;
            return [(base + share * inputs.speed_setpoint) / (1.0 + share), 0.0];
        }
        let drag = pulley.drag.at(speed, [load, 0.0]);
        let per_torque = k / (pulley.inertia + k * drag.by_speed);
        let torque = inputs.torque + own - drag.torque + drag.by_speed * speed;
        [per_torque * (pulley.inertia / k * base + torque), per_torque * lever]
    }

    /// The utilisation at the root of v − `free` + `per_utilisation` u(v), from a guess with its traction.
    fn utilisation(&self, frame: &Frame, free: f64, per_utilisation: f64, guess: (f64, Traction)) -> Option<f64> {
        let reach = UTILISATION[1] * per_utilisation;
        let (mut low, mut high) = (free - reach, free + reach);
        let (mut v, mut traction) = guess;
        if v < low || v > high {
            v = v.clamp(low, high);
            traction = self.law.traction(frame, v);
        }
        let tolerance = 1e-11 + 1e-13 * (free.abs() + reach);
        for _ in 0..ITERATIONS {
            let excess = v - free + per_utilisation * traction.value;
            if excess > 0.0 {
                high = v;
            } else {
                low = v;
            }
            let slope = 1.0 + per_utilisation * traction.slope;
            let newton = v - excess / slope;
            if slope > 0.0 && (newton - v).abs() <= tolerance {
                return Some(traction.value + traction.slope * (newton - v));
            }
            if high - low <= tolerance {
                return Some(traction.value);
            }
            v = if slope > 0.0 && newton > low && newton < high {
                newton
            } else {
                0.5 * (low + high)
            };
            traction = self.law.traction(frame, v);
        }
        None
    }
}
