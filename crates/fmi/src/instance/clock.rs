//! The time of an instance: that of the importer, and that of its unit, which counts from the start
//! of the run and so keeps its digits: doubles near 1.7e9 s are 0.2 µs apart. Where the importer's
//! times are too coarse for its steps, the unit's time is the sum of these steps.

use super::{CallError, refused};
use pushbelt_archive::Archive;

/// Latest time and earliest time of an importer, s, some three thousand years.
const LATEST: f64 = 1e11;
/// A time is known to so many times the rounding of the number: importers reach one point by
/// different sums.
const UNCERTAIN: f64 = 16.0;
/// Rounding of an importer that sums up its steps, as a fraction of the time.
const ROUNDING_OF_TIME: f64 = 1e-9;
/// The least difference between two communication points that is taken for rounding, as a fraction
/// of the step.
const LEAST_ROUNDING: f64 = 1e-6;
/// The largest difference that is taken for rounding, as a fraction of the step: results hardly
/// change by it.
const LARGEST_ROUNDING: f64 = 1e-3;

/// Times at a communication point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Clock {
    /// Time of the importer, by its own sum of steps, s.
    pub point: f64,
    /// Time since the start, s.
    pub elapsed: f64,
    /// Time of the importer at the unit's time 0, s.
    origin: f64,
}

impl Clock {
    /// The clock at the start of a run, if the importer's time is in range.
    ///
    /// # Errors
    /// The time is not finite or not in range.
    pub fn start(time: f64) -> Result<Self, CallError> {
        // False for NaN.
        if time.abs() <= LATEST {
            return Ok(Self {
                point: time,
                elapsed: 0.0,
                origin: time,
            });
        }
        refused(format!(
            "the start time {time:?} s is not from -{LATEST:e} to {LATEST:e} s: later times have no room for \
             steps; is it in seconds?"
        ))
    }

    /// The clock after a step of size `step` from the importer's time `current`, s, which is at
    /// most `longest`, if it is one forward from this point that does not end after the stop time.
    ///
    /// # Errors
    /// The step does not begin here, is not forward or too long, or ends after the stop time or the
    /// latest time.
    pub fn after(&self, current: f64, step: f64, longest: f64, stop: Option<f64>) -> Result<Self, CallError> {
        let start = self.point;
        if !(current.is_finite() && step.is_finite() && step > 0.0) {
            return refused(format!(
                "a step of {step} s from {current} s is not a step forward in finite time"
            ));
        }
        if step > longest {
            return refused(format!(
                "the step of {step} s is longer than the longest admissible step, {longest} s"
            ));
        }
        if !same_time(current, start, step) {
            return refused(format!(
                "the step starts at {current} s, but the last one ended at {start} s"
            ));
        }
        let end = current + step;
        if end > LATEST {
            return refused(format!("the step ends at {end} s, after the latest time, {LATEST:e} s"));
        }
        if let Some(stop) = stop
            && end > stop
            && !same_time(end, stop, step)
        {
            return refused(format!("the step to {end} s ends after the stop time {stop} s"));
        }
        let mut clock = Self { point: end, ..*self };
        let rounding = f64::EPSILON * end.abs().max(self.origin.abs());
        if rounding <= LEAST_ROUNDING * step {
            clock.elapsed = end - self.origin;
        } else {
            clock.elapsed += step;
            clock.origin = end - clock.elapsed;
        }
        Ok(clock)
    }

    /// The unit's time at this point, s, reached by a step of size `step`: on a decimal grid of
    /// about a millionth of the step. Importers reach the same point by different sums, which a
    /// model can amplify to visible differences; on the grid all get the same bits.
    pub fn on_grid(&self, step: f64) -> f64 {
        let time = self.elapsed;
        let digits = -(LEAST_ROUNDING * step).log10().floor();
        if digits > EXACT_POWERS_OF_TEN {
            return time;
        }
        #[expect(clippy::cast_possible_truncation, reason = "at most 22")]
        let grid = 10_f64.powi(digits.max(0.0) as i32);
        let count = (time * grid).round();
        let exact = 1.0 / f64::EPSILON;
        if count.abs() < exact { count / grid } else { time }
    }

    /// Whether a time of the unit, s, is before this point by more than the rounding of the
    /// importer's times.
    pub fn is_after(&self, time: f64) -> bool {
        self.elapsed - time >= UNCERTAIN * f64::EPSILON * self.point.abs().max(self.origin.abs())
    }

    /// The clock at a time of the unit before this point, s.
    pub fn back_at(&self, elapsed: f64) -> Self {
        let point = self.importer_time(elapsed);
        Self {
            point,
            elapsed,
            ..*self
        }
    }

    /// Time of the importer at a time of the unit, s.
    pub fn importer_time(&self, elapsed: f64) -> f64 {
        self.origin + elapsed
    }

    /// Time of the unit at a time of the importer, s.
    pub fn unit_time(&self, time: f64) -> f64 {
        time - self.origin
    }

    /// Whether a time of the unit, s, is that of this point, after steps of at most `longest`, s.
    pub fn agrees_with(&self, time: f64, longest: f64) -> bool {
        (time - self.elapsed).abs() <= LEAST_ROUNDING * longest
    }

    /// Writes to an archive, or reads from it.
    pub fn serialize(&mut self, archive: &mut Archive<'_>) {
        let Self {
            point,
            elapsed,
            origin,
        } = self;
        archive.real(point);
        archive.real(elapsed);
        archive.real(origin);
        let rounding = UNCERTAIN * f64::EPSILON * LATEST;
        let sound = point.abs() <= LATEST
            && (0.0..=2.0 * LATEST).contains(elapsed)
            && (*origin + *elapsed - *point).abs() <= rounding;
        if !sound {
            archive.reject();
        }
    }
}

/// The largest power of ten that a double holds exactly is 10²².
const EXACT_POWERS_OF_TEN: f64 = 22.0;

/// Whether two times are the same communication point, up to the rounding of an importer that sums
/// up its steps.
fn same_time(a: f64, b: f64, step: f64) -> bool {
    let size = a.abs().max(b.abs());
    let rounding = (ROUNDING_OF_TIME * size).clamp(LEAST_ROUNDING * step, LARGEST_ROUNDING * step);
    // The tolerance is at least the rounding of the time itself.
    (a - b).abs() <= rounding.max(4.0 * f64::EPSILON * size)
}
