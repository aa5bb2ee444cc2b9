//! Communication steps, one own step of the unit after the other: `fmi3DoStep` where someone watches.

use super::instance::Slave;
use super::outcome::Outcome;
use super::steps::started;
use crate::log::{Category, Status};
use crate::stepping::OwnSteps;

/// A communication step on its way.
#[derive(Debug)]
pub struct Underway<W> {
    way: W,
    /// Where it ends, as the master counts, s.
    end: f64,
    /// Whether the unit has come to the end.
    over: bool,
    /// Whether the end was brought nearer.
    shortened: bool,
}

impl<W> Underway<W> {
    /// Whether the unit has come to the end.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.over
    }
}

impl<U: OwnSteps> Slave<U> {
    /// Begins a communication step; `None` with the status if it can't be done.
    pub fn set_out(&mut self, current: f64, step: f64) -> (Status, Option<Underway<U::Way>>) {
        let mut underway = None;
        let status = self.call("fmi3DoStep", |slave| {
            let ahead = slave.ahead(current, step)?;
            let unit = started(&mut slave.now.unit)?;
            let rates = slave.now.rates.take();
            match unit.set_out(ahead.to, &slave.now.settings, rates.as_ref()) {
                Ok(way) => {
                    let over = unit.is_over(&way);
                    underway = Some(Underway {
                        way,
                        end: ahead.end,
                        over,
                        shortened: false,
                    });
                    Ok(())
                }
                Err(failure) => slave.ended(Err(failure), ahead.end),
            }
        });
        (status, underway)
    }

    /// One own step of a communication step that is not over, with the inputs as they are now.
    pub fn own_step(&mut self, underway: &mut Underway<U::Way>) -> Status {
        self.call("fmi3DoStep", |slave| {
            let mut remarks = Vec::new();
            let unit = started(&mut slave.now.unit)?;
            let result = unit.own_step(&mut underway.way, &slave.now.settings, &mut remarks);
            underway.over = unit.is_over(&underway.way);
            slave.log_remarks(&remarks);
            match result {
                Ok(()) => Ok(()),
                failed => slave.ended(failed, underway.end),
            }
        })
    }

    /// What has happened since a communication step began, if its master wants to handle that.
    #[must_use]
    pub fn event(&self, underway: &Underway<U::Way>) -> Option<String> {
        self.now.unit.as_ref()?.event(&underway.way)
    }

    /// Time of the unit on its way, s.
    #[must_use]
    pub fn own_time(&self) -> f64 {
        self.now.unit.as_ref().map_or(self.now.point, U::time)
    }

    /// Lets a communication step end at a time, s, or here if that is past; it never becomes longer.
    pub fn end_at(&mut self, underway: &mut Underway<U::Way>, time: f64) -> Status {
        self.call("fmi3DoStep", |slave| {
            if !underway.over && time < underway.end {
                let unit = started(&mut slave.now.unit)?;
                unit.end_at(&mut underway.way, time);
                underway.over = unit.is_over(&underway.way);
                underway.shortened = true;
            }
            Ok(())
        })
    }

    /// Ends a communication step where the unit has come to, with the event that ends it. Whether that is earlier than the
    /// master asked for.
    pub fn arrive(&mut self, underway: &Underway<U::Way>, event: Option<&str>) -> (Status, bool) {
        let early = underway.shortened;
        let status = self.call("fmi3DoStep", |slave| -> Outcome {
            let mut remarks = Vec::new();
            let unit = started(&mut slave.now.unit)?;
            unit.arrive(&underway.way, &mut remarks);
            let end = if early { unit.time() } else { underway.end };
            slave.log_remarks(&remarks);
            if let Some(event) = event {
                slave
                    .log
                    .send(Status::Ok, Category::Events, &format!("event at {end} s: {event}"));
            }
            slave.ended(Ok(()), end)
        });
        (status, early)
    }
}
