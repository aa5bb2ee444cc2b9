//! A model without internal steps behind the shorter trait: y' = u t, which depends on the time of its steps.

use pushbelt_fmi::log::Status::{self, Discard, Error, Ok};
use pushbelt_fmi::prelude::*;
use pushbelt_fmi::slave::Version;

use crate::importer::{BOTH, experiment};

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
        Result::Ok(Self(0.0))
    }

    fn readings(&mut self) -> &f64 {
        &self.0
    }

    fn advance(&mut self, u: &f64, from: f64, to: f64) -> Result<(), StepFailure> {
        if to - from > LONGEST {
            return Err(StepFailure::Discarded("the step is too long".into()));
        }
        self.0 += 0.5 * u * (to * to - from * from);
        Result::Ok(())
    }

    fn serialize(&mut self, archive: &mut Archive<'_>) {
        archive.real(&mut self.0);
    }
}

type Importer = crate::importer::Importer<SimpleUnit<Ramp>>;

/// An instance at `time`, s, with an input of 4; the status of its start.
fn started(version: Version, time: f64) -> (Importer, Status) {
    let importer = Importer::new(version);
    assert_eq!(importer.enter(experiment(time, None)), Ok);
    assert_eq!(importer.set(1, 4.0), Ok);
    let status = importer.exit();
    (importer, status)
}

#[test]
fn steps_begin_at_the_start_time_and_follow_each_other() {
    for version in BOTH {
        let (importer, _) = started(version, 1.0);
        let discarded = importer.step(1.0, 3.0);
        assert_eq!(
            (discarded.status, discarded.time, importer.real(2)),
            (Discard, 1.0, 0.0)
        );
        assert_eq!(importer.step(1.0, 1.0).status, Ok, "a shorter one");
        assert_eq!(importer.real(2), 6.0);
        let (other, _) = started(version, 0.0);
        assert_eq!(other.continue_from(&importer.bytes()), Ok);
        for importer in [importer, other] {
            assert_eq!(importer.step(2.0, 2.0).status, Ok);
            assert_eq!(importer.real(2), 30.0);
        }
        assert_eq!(started(version, -1.0).1, Error);
    }
}
