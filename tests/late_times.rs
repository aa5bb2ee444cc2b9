//! Runs that start at a time of today, in seconds since 1970, and stored states with wild numbers.

use pushbelt::fmi::log::Log;
use pushbelt::fmi::slave::{CallError, Master, Type, Version};
use pushbelt::fmi::unit::Experiment;
use pushbelt::fmi::{Slave, hash};
use pushbelt::unit::{Settings, VariatorUnit};

use pushbelt::variator::settings::{Mode, RingModel};
use pushbelt_support::shared_library::reference;

type Variator = Slave<VariatorUnit>;

const TODAY: f64 = 1.7e9;
const OUTPUTS: [&str; 4] = ["thrustRatio", "slip", "secondary.speed", "ratio.geometric"];

fn settings(mode: Mode) -> Settings {
    let mut settings = Settings::default();
    settings.parameters.ring_model = RingModel::Ale0;
    settings.parameters.solver.mode = mode;
    settings
}

fn running(mode: Mode, start: f64) -> Result<Variator, CallError> {
    let mut slave = Slave::with(Master::default(), Log::new(Version::Two, None, false), settings(mode));
    slave.initialize(Experiment {
        start,
        ..Experiment::default()
    })?;
    slave.exit_initialization_mode()?;
    Ok(slave)
}

/// Outputs after steps of 0.1 ms under a torque that jumps, by a host that sums up its steps or multiplies.
fn outputs(mode: Mode, start: f64, sums: bool) -> Vec<[f64; 4]> {
    let mut slave = running(mode, start).expect("a run");
    let (torque, references) = (reference("primary.torque"), OUTPUTS.map(reference));
    let mut time = start;
    let step = |k: u32| {
        let value = if (k / 50).is_multiple_of(2) { 80.0 } else { 50.0 };
        slave.set(Type::Real, &[torque], &[value]).expect("a torque");
        slave.do_step(time, 1e-4).expect("a step");
        time = if sums {
            time + 1e-4
        } else {
            start + 1e-4 * f64::from(k + 1)
        };
        let mut found = [0.0; 4];
        slave.get(Type::Real, &references, &mut found).expect("outputs");
        found
    };
    (0..200).map(step).collect()
}

/// Within the tolerance of the solver, 1e-4, of the outputs' size.
#[test]
fn a_late_run_equals_one_from_zero() {
    let nominal = [1.0, 0.01, 200.0, 1.0];
    for mode in [Mode::Accurate, Mode::RealTime] {
        let expected = outputs(mode, 0.0, true);
        for sums in [true, false] {
            let found = outputs(mode, TODAY, sums);
            let differences = found
                .iter()
                .flatten()
                .zip(expected.iter().flatten())
                .zip(nominal.iter().cycle());
            let worst = differences
                .map(|((a, b), size)| (a - b).abs() / size)
                .fold(0.0, f64::max);
            println!("{mode:?}, sums {sums}: {worst:.1e}");
            assert!(worst < 1e-4, "{mode:?}, sums {sums}: {worst}");
        }
    }
}

#[test]
fn a_start_without_room_for_steps_is_refused() {
    assert!(running(Mode::Accurate, 1e14).is_err());
}

/// Every number of a stored state in turn is NaN: each is refused or not in use, and what is read steps on or discards.
#[test]
fn wild_numbers_in_a_stored_state_do_no_harm() {
    for mode in [Mode::Accurate, Mode::RealTime] {
        let mut slave = running(mode, 0.0).expect("a run");
        slave.do_step(0.0, 2e-3).expect("a step");
        let stored = slave.save().expect("a state");
        let good = slave.serialize(&stored).expect("bytes");
        slave.deserialize(&good).expect("the same state");
        let content = good.len() - 16;
        let (mut refused, mut tried) = (0, 0);
        // Numbers lie at any byte. A prime, so that all parts of the state are hit.
        for at in (36..content - 8).step_by(211) {
            for wild in [f64::NAN, f64::INFINITY] {
                let mut bytes = good[..content].to_vec();
                bytes[at..at + 8].copy_from_slice(&wild.to_le_bytes());
                let checksum = hash::of_words(&bytes);
                bytes.extend(checksum.to_le_bytes());
                tried += 1;
                let Ok(found) = slave.deserialize(&bytes) else {
                    refused += 1;
                    continue;
                };
                slave.restore(&found).expect("a state");
                let stepped = slave.do_step(2e-3, 1e-3);
                assert!(!matches!(stepped, Err(CallError::Failed(_))), "{at}: {stepped:?}");
            }
        }
        println!("{mode:?}: {refused} of {tried} refused");
        assert!(10 * refused >= tried, "{mode:?}: {refused} of {tried}");
    }
}
