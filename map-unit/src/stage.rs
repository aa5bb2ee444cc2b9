//! One implicit stage: y = base + k f(y).
//!
//! For given ratio, drag and belt loss both speeds are linear in the torque T_P, so the sliding
//! speed is v = v_0 − m T_P(v) with m ≥ 0: Newton's method in a bracket with bisection. Ratio, drag
//! and belt loss follow in an outer iteration.

use pushbelt::pulley::{PerPulley, Pulley};
use pushbelt::variator::settings::{Drive, Inputs, SPEED_LAG};

use crate::file::UTILISATION;
use crate::law::{Law, Point, State};
use crate::tables::Sloped;
use crate::tuning::{LEAST_FRACTION, SLIDING_ITERATIONS, STAGE_ITERATIONS, TOLERANCE};

impl Law {
    /// The solution of a stage under the inputs at its time, from a guess; none if the iteration
    /// does not converge.
    pub fn stage(&self, inputs: &Inputs, base: &State, k: f64, guess: &State) -> Option<State> {
        let mut state = *guess;
        let mut before = f64::INFINITY;
        for _ in 0..STAGE_ITERATIONS {
            let next = self.iterate(inputs, base, k, &state)?;
            let relative =
                |j: Pulley| (next.speeds[j] - state.speeds[j]).abs() / (1.0 + next.speeds[j].abs());
            let [secondary, primary] = Pulley::BOTH.map(relative);
            let change = primary.max(secondary).max((next.log_ratio - state.log_ratio).abs());
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

    /// The next iterate; none if it is not finite, which the largest change would leave out.
    fn iterate(&self, inputs: &Inputs, base: &State, k: f64, state: &State) -> Option<State> {
        let point = self.point(state, inputs);
        let utilisation = point.traction.value;
        let drags = self.drags(&point);
        // Speeds without T_P and their slopes over it: J (ω − base) = k (T + own + lever T_P −
        // drag), with the drag linear about the present speed; or the lag behind the set point.
        let lines = PerPulley::from_fn(|j| {
            let (pulley, inputs, drag) = (self.parameters.pulley(j), inputs.pulley(j), drags[j]);
            if pulley.drive == Drive::Speed {
                let fraction = k / SPEED_LAG;
                return Sloped {
                    value: (base.speeds[j] + fraction * inputs.speed_setpoint) / (1.0 + fraction),
                    slope: 0.0,
                };
            }
            let (own, lever) = match j {
                Pulley::Primary => (0.0, -1.0),
                Pulley::Secondary => (-point.ratio * point.torque_loss, point.ratio),
            };
            let per_torque = k / (pulley.inertia + k * drag.by_speed);
            let torque = inputs.torque + own - drag.torque + drag.by_speed * state.speeds[j];
            let free = pulley.inertia / k * base.speeds[j] + torque;
            Sloped {
                value: per_torque * free,
                slope: per_torque * lever,
            }
        });
        // v_0 and −m for each N·m.
        let free = point.sliding_at(lines.map(|line| line.value));
        let per_torque = point.sliding_at(lines.map(|line| line.slope));
        // The ratio changes with the torque by way of the thrust ratio: to first order in the
        // equation.
        let Sloped { value: rate, slope } = self.shift(&point);
        let around = point.radius * point.ratio * state.speeds.secondary;
        let (least, most) = self.stops.clone().into_inner();
        let behind = (base.log_ratio + k * rate).clamp(least, most) - state.log_ratio;
        let per_utilisation = -per_torque * point.full_slip;
        let coupled =
            (around * k * slope).clamp(-LEAST_FRACTION * per_utilisation, per_utilisation / LEAST_FRACTION);
        let free = free - around * behind + coupled * utilisation;
        let found = self.utilisation(&point, free, per_utilisation + coupled)?;
        let torque = point.full_slip * found;
        let next = State {
            speeds: lines.map(|line| line.value + line.slope * torque),
            log_ratio: (base.log_ratio + k * (rate + slope * (found - utilisation))).clamp(least, most),
            ..*state
        };
        let PerPulley { primary, secondary } = next.speeds;
        (primary + secondary + next.log_ratio).is_finite().then_some(next)
    }

    /// The utilisation at the root of v − `free` + `per_utilisation` u(v), from a point on.
    fn utilisation(&self, point: &Point, free: f64, per_utilisation: f64) -> Option<f64> {
        let reach = UTILISATION.end() * per_utilisation;
        let (mut low, mut high) = (free - reach, free + reach);
        let (mut v, mut traction) = (point.sliding, point.traction);
        if v < low || v > high {
            v = v.clamp(low, high);
            traction = self.traction(point, v);
        }
        let tolerance = 1e-11 + 1e-13 * (free.abs() + reach);
        for _ in 0..SLIDING_ITERATIONS {
            let Sloped { value, slope } = traction;
            let excess = v - free + per_utilisation * value;
            *(if excess > 0.0 { &mut high } else { &mut low }) = v;
            let steepness = 1.0 + per_utilisation * slope;
            let newton = v - excess / steepness;
            if steepness > 0.0 && (newton - v).abs() <= tolerance {
                return Some(value + slope * (newton - v));
            }
            if high - low <= tolerance {
                return Some(value);
            }
            let inside = steepness > 0.0 && newton > low && newton < high;
            v = if inside { newton } else { 0.5 * (low + high) };
            traction = self.traction(point, v);
        }
        None
    }
}
