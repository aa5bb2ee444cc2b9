//! A communication step on its way, one own step after the other: whoever watches can read at the end of each, change inputs
//! there or end the communication step. Left alone, it is [`Variator::advance_along`] to the last bit.

use crate::pulley::{PerPulley, Pulley};
use crate::solver::bounded::{Budget, TICK};
use crate::solver::newton::Counts;
use crate::solver::sdirk::{Stalled, Stretch};
use crate::variator::pulleys::rows::Stop;
use crate::variator::run::course::{Course, SHORTEST_STEP};
use crate::variator::run::variator::{NEWTON_TOLERANCE, StepError, Variator};
use crate::variator::settings::signals::{Inputs, Work};
use crate::variator::survey::ledger::Running;
use crate::variator::survey::observe::macro_slip;

/// A communication step on its way.
#[derive(Clone, Debug)]
pub struct Way {
    /// Where it began and where it ends, s.
    from: f64,
    to: f64,
    /// Inputs that were given last, and how they come into force.
    given: Inputs,
    course: Course,
    /// The stretch under way, and its end, s.
    stretch: Option<(Stretch, f64)>,
    ticks: Ticks,
    /// Work that had been done before.
    before: Counts,
    /// End stops that the sheaves were at in the beginning.
    stops: PerPulley<Option<Stop>>,
    over: bool,
}

impl Way {
    /// Whether its end is reached.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.over
    }
}

/// Ticks of a communication step: from when on, how many of what length, and how many are done.
#[derive(Clone, Copy, Debug)]
struct Ticks {
    from: f64,
    length: f64,
    count: f64,
    ended: f64,
}

impl Ticks {
    fn new([from, to]: [f64; 2]) -> Self {
        let count = ((to - from) / TICK - SHORTEST_STEP).ceil().max(1.0);
        Self {
            from,
            length: (to - from) / count,
            count,
            ended: 0.0,
        }
    }
}

/// What a master may want to handle when it happens.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The belt begins to slip through.
    Slips,
    /// The belt grips again.
    Grips,
    /// A movable sheave reaches an end stop.
    Reaches(Pulley, Stop),
}

impl Event {
    /// The event in words.
    #[must_use]
    pub fn text(self) -> String {
        match self {
            Self::Slips => "the belt begins to slip through (macro-slip)".into(),
            Self::Grips => "the belt grips again".into(),
            Self::Reaches(pulley, stop) => format!("the {} sheave reaches its {} stop", pulley.name(), stop.name()),
        }
    }
}

impl Variator {
    /// Sets out for a communication step to time `to` as [`Variator::advance_along`] does it: [`Variator::step_along`] until the
    /// way is over, then [`Variator::arrive`].
    ///
    /// # Errors
    /// Inputs out of range.
    pub fn set_out(&mut self, to: f64, inputs: &Inputs, rates: &Inputs) -> Result<Way, StepError> {
        inputs.validate()?;
        let from = self.time;
        let ramp = self.system.parameters.solver.input_ramp;
        let course = Course::new(ramp, [from, to], &self.held.at(from), inputs, rates);
        self.integrator.newton.left = 0.0;
        Ok(Way {
            from,
            to,
            given: *inputs,
            course,
            stretch: None,
            ticks: Ticks::new([from, to]),
            before: self.counts(),
            stops: self.stops(),
            over: to - from < SHORTEST_STEP,
        })
    }

    /// One own step of a way that is not over.
    ///
    /// # Errors
    /// A step that can't be done: the way ends there.
    pub fn step_along(&mut self, way: &mut Way) -> Result<(), StepError> {
        self.stale = true;
        if self.real_time.is_some() {
            self.tick_along(way);
            return Ok(());
        }
        let outcome = self.integrate_one(&way.course, way.to, &mut way.stretch);
        let over = outcome.map_err(|stalled| {
            self.count_pace(way);
            StepError::Stalled {
                from: way.from,
                reached: stalled.time,
                reason: stalled.to_string(),
            }
        })?;
        way.over = over;
        Ok(())
    }

    /// Makes outputs those of the present, on a way that goes on.
    pub fn look(&mut self) {
        self.hold_external();
        self.stale = true;
    }

    /// Gives inputs anew on a way that is not over: those that differ from what was given before count at once.
    ///
    /// # Errors
    /// Inputs out of range; nothing was changed.
    pub fn give_anew(&mut self, way: &mut Way, inputs: &Inputs) -> Result<(), StepError> {
        if *inputs == way.given {
            return Ok(());
        }
        inputs.validate()?;
        way.course = way.course.given_anew(self.time, &way.given, inputs);
        way.given = *inputs;
        way.stretch = None;
        Ok(())
    }

    /// Lets a way end at a time, s, or where it is if that is past. It never becomes longer.
    pub fn end_at(&mut self, way: &mut Way, time: f64) {
        if time >= way.to {
            return;
        }
        way.to = time.max(self.time);
        way.stretch = None;
        way.ticks = Ticks::new([self.time, way.to]);
        way.over |= way.to - self.time < SHORTEST_STEP;
    }

    /// What has happened since the way began, the first of what there is.
    #[must_use]
    pub fn event(&self, way: &Way) -> Option<Event> {
        let sums = &self.ledger.last.sums;
        let slips = macro_slip(&self.system, self.state.view(), sums, self.macro_slip);
        if slips != self.macro_slip {
            return Some(if slips { Event::Slips } else { Event::Grips });
        }
        let now = self.stops();
        let reached = Pulley::BOTH.map(|pulley| (pulley, now[pulley], way.stops[pulley]));
        let mut reached = reached.into_iter().filter(|(_, now, before)| now != before);
        reached.find_map(|(pulley, now, _)| Some(Event::Reaches(pulley, now?)))
    }

    /// Ends a communication step where its way has led.
    pub fn arrive(&mut self, way: &Way) {
        if self.time == way.from {
            return;
        }
        let (defect, behind, rollbacks) = match &mut self.real_time {
            Some(real_time) => {
                let of_ticks = (
                    real_time.take_defect() / NEWTON_TOLERANCE,
                    real_time.behind(),
                    real_time.rollbacks(),
                );
                self.held = way.course.held(self.time);
                self.apply();
                of_ticks
            }
            None => {
                self.count_pace(way);
                (self.integrator.newton.left, 0.0, 0)
            }
        };
        self.work = work(self.counts(), defect, behind, rollbacks);
        self.report_slip();
        self.report_buckling();
        self.hold_external();
        self.stale = true;
    }

    /// Integrates to a time, s, with steps as the error control requires.
    pub(super) fn integrate_along(&mut self, course: &Course, to: f64) -> Result<(), Stalled> {
        let mut stretch = None;
        while !self.integrate_one(course, to, &mut stretch)? {}
        Ok(())
    }

    /// One step of the integrator on the way to a time, s: under loads that change alike over a stretch. Whether that time is
    /// reached.
    fn integrate_one(
        &mut self,
        course: &Course,
        to: f64,
        under_way: &mut Option<(Stretch, f64)>,
    ) -> Result<bool, Stalled> {
        let (mut stretch, end) = under_way.take().unwrap_or_else(|| {
            self.held = course.held(self.time);
            let piece = self.time + self.soft_start.piece(self.time);
            let end = to.min(piece).min(course.until(self.time));
            self.apply();
            (Stretch::new(self.time, end), end)
        });
        let mut running = Running {
            system: &mut self.system,
            ledger: &mut self.ledger,
        };
        if let Err(stalled) = self.integrator.step(&mut running, &mut self.state, &mut stretch) {
            self.time = stalled.time;
            return Err(stalled);
        }
        if !stretch.is_over() {
            self.time = stretch.reached();
            *under_way = Some((stretch, end));
            return Ok(false);
        }
        self.time = end;
        let over = to - self.time < SHORTEST_STEP;
        if over {
            self.time = to;
        }
        Ok(over)
    }

    /// Bounded work for a tick of the clock.
    fn tick_along(&mut self, way: &mut Way) {
        let Ticks {
            from,
            length,
            count,
            ended,
        } = &mut way.ticks;
        *ended += 1.0;
        let over = *ended >= *count;
        let end = if over { way.to } else { *from + *ended * *length };
        way.over = over;
        let Some(mut real_time) = self.real_time.take() else {
            return;
        };
        let jacobians = self.system.parameters.solver.effort as usize;
        real_time.live(&way.course, [self.time, end], jacobians);
        for mut budget in Budget::millisecond(jacobians) {
            while let Some(plan) = real_time.plan(&budget) {
                self.held = plan.held;
                self.system.round(plan.rounding);
                self.apply();
                let mut running = Running {
                    system: &mut self.system,
                    ledger: &mut self.ledger,
                };
                real_time.tick(&mut running, &mut self.state, &mut budget);
            }
        }
        self.real_time = Some(real_time);
        self.time = end;
    }

    /// End stops that the sheaves are at.
    fn stops(&self) -> PerPulley<Option<Stop>> {
        PerPulley::from_fn(|pulley| self.system.pulleys.stop_reached(pulley, self.state.view()))
    }

    /// Counts the work of a communication step, and warns where there is too much of it.
    fn count_pace(&mut self, way: &Way) {
        let work = self.counts() - way.before;
        let unknowns = self.state.y.len();
        if let Some(late) = self.pace.count(&way.given, way.to - way.from, work, unknowns) {
            self.log(true, late);
        }
    }
}

/// Counts as outputs, with a defect in units of Newton's scale and the time behind the clock, s.
fn work(counts: Counts, defect: f64, behind: f64, rollbacks: u64) -> Work {
    let output = |count: u64| i32::try_from(count).unwrap_or(i32::MAX);
    Work {
        steps: output(counts.steps + counts.rejected + counts.failed),
        jacobians: output(counts.factorizations),
        residuals: output(counts.residuals),
        defect,
        behind,
        rollbacks: output(rollbacks),
    }
}
