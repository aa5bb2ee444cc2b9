//! `ALE0` compared with `ALE`: thrust ratios of the nine load cases, and shift rates.
//!
//! `cargo run --release --example level_of_detail` prints a line per load case and a line per
//! shift. Shifts start without load at 1000 rpm, in the steady state of the speed ratio s = r_P/r_S
//! and the secondary force. There F_P is raised by e^0.3. The gain is ds/dt per unit of ln F_P,
//! from 60 to 120 ms after the step.

use pushbelt::variator::settings::RingModel;
use pushbelt_support::load_cases::LoadCase;
use pushbelt_support::shift::unloaded_shift;
use pushbelt_support::steady::load_case;
use pushbelt_support::variators::variator;

/// The compared rings.
const RINGS: [RingModel; 2] = [RingModel::Ale, RingModel::Ale0];

/// The thrust ratio and slip of a load case.
fn thrust(ring: RingModel, torque: f64, of_three: usize) -> [f64; 2] {
    let parameters = variator(ring);
    let case = LoadCase::three(&parameters, torque)[of_three];
    let outputs = load_case(&parameters, &case).outputs;
    [outputs.thrust_ratio, outputs.slip]
}

/// Difference of `ALE0` from `ALE`, %.
fn off([ale, ale0]: [f64; 2]) -> f64 {
    100.0 * (ale0 / ale - 1.0)
}

fn main() {
    println!("thrust ratio: ALE, ALE0, difference; slip: ALE, ALE0");
    for torque in [30.0, 50.0, 100.0] {
        for (k, name) in ["underdrive", "medium", "overdrive"].into_iter().enumerate() {
            let found = RINGS.map(|ring| thrust(ring, torque, k));
            let [thrust, slip] = [0, 1].map(|i| found.map(|of| of[i]));
            println!(
                "{name:<10} {torque:>3} N·m  {:.4} {:.4} {:+.1} %  {:.2} % {:.2} %",
                thrust[0],
                thrust[1],
                off(thrust),
                100.0 * slip[0],
                100.0 * slip[1]
            );
        }
    }
    println!("shift gain, 1/s: ALE, ALE0, difference; F_P/F_S before: ALE, ALE0");
    for s in [0.6, 0.8, 1.0, 1.25, 1.5, 1.8] {
        for force in [8e3, 12e3, 20e3] {
            let found = RINGS.map(|ring| unloaded_shift(ring, s, force));
            let [gain, force_ratio] = [
                found.each_ref().map(|of| of.gain),
                found.each_ref().map(|of| of.force_ratio),
            ];
            println!(
                "s {s:<4} {:>2} kN  {:.4} {:.4} {:+.1} %  {:.4} {:.4}",
                force / 1e3,
                gain[0],
                gain[1],
                off(gain),
                force_ratio[0],
                force_ratio[1]
            );
        }
    }
}
