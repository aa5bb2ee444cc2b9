//! Speed of the variator from maps: steps of 10 ms with inputs that change in every step. `cargo
//! run --release --package pushbelt-map-unit --example speed`

use std::path::Path;

use cpu_time::ProcessTime;
use pushbelt::variator::settings::Inputs;
use pushbelt_fmi::unit::{Experiment, Unit};
use pushbelt_map_unit::unit::MapUnit;

const STEP: f64 = 1e-2;
const STEPS: u32 = 200_000;

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../resources/maps");
    let mut settings = MapUnit::load(Some(&folder)).expect("the checked-in tables");
    // Shafts as heavy as an engine and a car.
    let of = &mut settings.parameters;
    (of.primary.inertia, of.secondary.inertia) = (0.15, 8.0);
    for (name, slope) in [("inputs as ramps", true), ("inputs held, reached within 1 ms", false)] {
        let mut unit = MapUnit::start(&settings, &Experiment::default(), &mut Vec::new()).expect("a start");
        let (mut settings, mut rates) = (settings.clone(), settings.clone());
        rates.inputs = Inputs::ZERO;
        let (mut sum, mut outside) = (0.0, false);
        let begin = ProcessTime::now();
        for k in 0..STEPS {
            let (phase, to) = (0.02 * f64::from(k), STEP * f64::from(k + 1));
            let speed = unit.readings(false).outputs.secondary.speed / 200.0;
            let (given, rate) = (&mut settings.inputs, &mut rates.inputs);
            given.primary.torque = 40.0 + 30.0 * phase.sin();
            given.secondary.torque = -40.0 * speed * speed.abs();
            given.primary.clamping_force = 13.5e3 + 2e3 * (0.3 * phase).sin();
            (rate.primary.torque, rate.primary.clamping_force) =
                (60.0 * phase.cos(), 1.2e3 * (0.3 * phase).cos());
            (rate.secondary.torque, rate.secondary.clamping_force) = (1e-3, 1e-3);
            let mut step = unit.begin(to, &settings, slope.then_some(&rates)).expect("a step");
            unit.advance(to, &mut step, &settings, &mut Vec::new()).expect("a step");
            let readings = unit.readings(false);
            sum += readings.outputs.slip;
            outside |= readings.outside;
        }
        let real_time = STEP * f64::from(STEPS) / begin.elapsed().as_secs_f64();
        let slip = sum / f64::from(STEPS);
        println!(
            "{name}: {real_time:.0} times faster than real time by processor time, mean slip {slip:.5}, beyond the tables: {outside}"
        );
    }
}
