//! A model without internal steps behind the shorter trait: y' = u t, which depends on the time of its steps.

use pushbelt_fmi::prelude::*;
use pushbelt_fmi::slave::{CallError, StatusKind, Type};

/// Longest step that the model takes, s.
const LONGEST: f64 = 2.0;

#[derive(Clone)]
struct Ramp(f64);

impl SimpleModel for Ramp {
    type Settings = f64;
    type Readings = f64;
    const IDENTITY: Identity = Identity::new("Ramp", "dy/dt = u t");

    fn table() -> Table<f64, f64> {
        type V = Variable<f64, f64>;
        const UNITS: &[UnitDefinition] = &[UnitDefinition::new("1", &[])];
        let u = Access::Setting {
            get: |u| *u,
            set: |u, value| *u = value,
        };
        let variables = vec![
            V::real(1, "u", "Input", Causality::Input, "1", u),
            V::real(2, "y", "Output", Causality::Output, "1", Access::Reading(|y| *y)),
        ];
        Table::new(UNITS, &[], variables)
    }

    fn start(_: &f64, time: f64) -> Result<Self, String> {
        if time < 0.0 {
            return Err("the ramp begins at 0 s".into());
        }
        Ok(Self(0.0))
    }

    fn readings(&mut self) -> &f64 {
        &self.0
    }

    fn advance(&mut self, u: &f64, from: f64, to: f64) -> Result<(), StepFailure> {
        if to - from > LONGEST {
            return Err(StepFailure::Discarded("the step is too long".into()));
        }
        self.0 += 0.5 * u * (to * to - from * from);
        Ok(())
    }

    fn serialize(&mut self, tape: &mut Tape<'_>) {
        tape.real(&mut self.0);
    }
}

type Slave = pushbelt_fmi::Slave<SimpleUnit<Ramp>>;

/// A slave in step mode at `time`, s.
fn running(time: f64) -> Result<Slave, CallError> {
    let mut slave = Slave::new(None, false);
    slave.setup_experiment(Experiment {
        start: time,
        ..Experiment::default()
    })?;
    slave.enter_initialization_mode()?;
    slave.exit_initialization_mode()?;
    Ok(slave)
}

fn output(slave: &mut Slave) -> Result<f64, CallError> {
    let mut value = [f64::NAN];
    slave.get(Type::Real, &[2], &mut value)?;
    Ok(value[0])
}

#[test]
fn steps_begin_at_the_start_time_and_follow_each_other() -> Result<(), CallError> {
    let mut slave = running(1.0)?;
    slave.set(Type::Real, &[1], &[4.0])?;
    slave.do_step(1.0, 1.0)?;
    assert_eq!(output(&mut slave)?, 6.0);
    slave.do_step(2.0, 2.0)?;
    assert_eq!(output(&mut slave)?, 30.0);
    Ok(())
}

#[test]
fn an_error_at_the_start_is_reported() {
    assert!(running(-1.0).is_err());
}

#[test]
fn after_a_discarded_step_a_shorter_one_continues() -> Result<(), CallError> {
    let mut slave = running(1.0)?;
    slave.set(Type::Real, &[1], &[4.0])?;
    assert!(slave.do_step(1.0, 3.0).is_err());
    let reached = slave.last_successful_time(StatusKind::LastSuccessfulTime as i32)?;
    assert_eq!((reached, output(&mut slave)?), (1.0, 0.0));
    slave.do_step(1.0, 1.0)?;
    assert_eq!(output(&mut slave)?, 6.0);
    Ok(())
}

#[test]
fn a_stored_state_has_model_and_time() -> Result<(), CallError> {
    let mut slave = running(1.0)?;
    slave.set(Type::Real, &[1], &[4.0])?;
    slave.do_step(1.0, 1.0)?;
    let snapshot = slave.save()?;
    let bytes = slave.serialize(&snapshot)?;

    let mut other = running(0.0)?;
    let read = other.deserialize(&bytes)?;
    other.restore(&read)?;
    assert_eq!(output(&mut other)?, 6.0);
    other.do_step(2.0, 1.0)?;
    assert_eq!(output(&mut other)?, 16.0);
    Ok(())
}
