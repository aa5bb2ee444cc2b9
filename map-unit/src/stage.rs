//! One implicit stage: y = base + k f(y).
//!
//! For given ratio, drag and belt loss both speeds are linear in the torque T_P, so the sliding speed is v = v_0 − m T_P(v) with m ≥ 0.
//! This equation in one unknown has a bracket, and is solved by Newton's method with bisection as a fallback. Ratio,
//! drag and belt loss follow in an outer iteration.

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::variator::settings::{Drive, SPEED_LAG};

use crate::file::UTILISATION;
use crate::law::{Acting, Frame, Law, State, Traction};
use crate::tuning::{ITERATIONS, LEAST_SHARE, TOLERANCE};

impl Law {
    /// The solution of a stage under what acts at its time, from a guess; none if the iteration does not converge.
    #[must_use]
    pub fn stage(&self, acting: &Acting, base: &State, k: f64, guess: &State) -> Option<State> {
        let mut state = *guess;
        let mut before = f64::INFINITY;
        for _ in 0..ITERATIONS {
            let next = self.iterate(acting, base, k, &state)?;
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

    fn iterate(&self, acting: &Acting, base: &State, k: f64, state: &State) -> Option<State> {
        let frame = self.frame(state, acting);
        let sliding = frame.sliding(state.speeds);
        let point = self.point(&frame, sliding);
        let utilisation = point.traction.value;
        let drags = self.drags(state.speeds, &point);
        // Speeds without T_P and their slopes over it: J (ω − base) = k (T + own + lever T_P − drag), with the drag linear about the present
        // speed; or the lag behind the set point.
        let lines = PerPulley::from_fn(|j| {
            let (pulley, inputs, drag) = (self.parameters.pulley(j), acting.inputs.pulley(j), drags[j]);
            if pulley.drive == Drive::Speed {
                let share = k / SPEED_LAG;
                return [(base.speeds[j] + share * inputs.speed_setpoint) / (1.0 + share), 0.0];
            }
            let [own, lever] = match j {
                Pulley::Primary => [0.0, -1.0],
                Pulley::Secondary => [-frame.ratio * point.torque_loss, frame.ratio],
            };
            let per_torque = k / (pulley.inertia + k * drag.by_speed);
            let torque = inputs.torque + own - drag.torque + drag.by_speed * state.speeds[j];
            [
                per_torque * (pulley.inertia / k * base.speeds[j] + torque),
                per_torque * lever,
            ]
        });
        // v_0 and −m for each N·m.
        let [free, per_torque] = [0, 1].map(|n| frame.sliding(lines.map(|line| line[n])));
        // The ratio changes with the torque too, by way of the thrust ratio: to first order it is part of the equation.
        let (rate, slope) = self.shift(&frame, &point);
        let around = frame.radius * frame.ratio * state.speeds.secondary;
        let [least, most] = self.radii.stops;
        let behind = (base.log_ratio + k * rate).clamp(least, most) - state.log_ratio;
        let per_utilisation = -per_torque * frame.torque;
        let coupled = (around * k * slope).clamp(-LEAST_SHARE * per_utilisation, per_utilisation / LEAST_SHARE);
        let free = free - around * behind + coupled * utilisation;
        let found = self.utilisation(&frame, free, per_utilisation + coupled, (sliding, point.traction))?;
        let torque = frame.torque * found;
        Some(State {
            speeds: lines.map(|[constant, slope]| constant + slope * torque),
            log_ratio: (base.log_ratio + k * (rate + slope * (found - utilisation))).clamp(least, most),
        })
    }

    /// The utilisation at the root of v − `free` + `per_utilisation` u(v), from a guess with its traction.
    fn utilisation(&self, frame: &Frame, free: f64, per_utilisation: f64, guess: (f64, Traction)) -> Option<f64> {
        let reach = UTILISATION[1] * per_utilisation;
        let (mut low, mut high) = (free - reach, free + reach);
        let (mut v, mut traction) = guess;
        if v < low || v > high {
            v = v.clamp(low, high);
            traction = self.traction(frame, v);
        }
        let tolerance = 1e-11 + 1e-13 * (free.abs() + reach);
        for _ in 0..ITERATIONS {
            let excess = v - free + per_utilisation * traction.value;
            *(if excess > 0.0 { &mut high } else { &mut low }) = v;
            let slope = 1.0 + per_utilisation * traction.slope;
            let newton = v - excess / slope;
            if slope > 0.0 && (newton - v).abs() <= tolerance {
                return Some(traction.value + traction.slope * (newton - v));
            }
            if high - low <= tolerance {
                return Some(traction.value);
            }
            let inside = slope > 0.0 && newton > low && newton < high;
            v = if inside { newton } else { 0.5 * (low + high) };
            traction = self.traction(frame, v);
        }
        None
    }
}
