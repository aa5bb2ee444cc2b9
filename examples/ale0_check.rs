//! Compares ALE0 with ALE: steady load cases, shifts.
use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{Drive, Inputs, Parameters, PulleyInputs, RingModel};
use pushbelt_lab::load_cases::LoadCase;
use pushbelt_lab::steady::load_case;
use std::time::Instant;

fn parameters(model: RingModel, future: bool, force: f64) -> Parameters {
    let mut p = Parameters { ring_model: model, ..Parameters::default() };
    if future {
        p.contact.stiffness = 5e10;
        let k = force * 0.0365 / (1.02 * (0.6e-3 + 0.02e-3 * force / 1e3));
        p.primary.tilt_stiffness = k;
        p.secondary.tilt_stiffness = k;
    }
    p
}

fn shift(model: RingModel, future: bool, s: f64, force: f64, rpm: f64) -> Result<[f64; 4], String> {
    let mut p = parameters(model, future, force);
    p.primary.drive = Drive::Speed;
    p.initial.ratio = 1.0 / s;
    let omega = rpm * std::f64::consts::PI / 30.0;
    let pulley = |torque, clamping_force| PulleyInputs { torque, clamping_force, speed_setpoint: omega };
    let mut f_p = force;
    for _ in 0..2 {
        let mut v = Variator::new(p.clone()).map_err(|e| format!("{e:?}"))?;
        v.initialise(0.0, &Inputs { primary: pulley(0.0, f_p), secondary: pulley(0.0, force) }).map_err(|e| format!("{e:?}"))?;
        f_p = v.outputs().primary.axial_force;
    }
    let mut v = Variator::new(p).map_err(|e| format!("{e:?}"))?;
    v.initialise(0.0, &Inputs { primary: pulley(0.0, f_p), secondary: pulley(0.0, force) }).map_err(|e| format!("{e:?}"))?;
    for m in v.take_messages() { println!("   {}", m.text); }
    let inputs = Inputs { primary: pulley(0.0, f_p * 0.3f64.exp()), secondary: pulley(0.0, force) };
    let mut at = [0.0; 2];
    let begin = Instant::now();
    for k in 1..=120 {
        v.advance(f64::from(k) * 1e-3, &inputs).map_err(|e| format!("{e:?}"))?;
        if k == 60 { at[0] = 1.0 / v.outputs().ratio_geometric; }
        if k == 120 { at[1] = 1.0 / v.outputs().ratio_geometric; }
    }
    let moved = v.ledger().moved + v.outputs().stored_energy * 0.5;
    Ok([(at[1] - at[0]) / 0.06 / 0.3, f_p / force, v.outputs().energy_residual / moved, begin.elapsed().as_secs_f64()])
}

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let future = args.get(2).is_some_and(|a| a == "future");
    match args[1].as_str() {
        "cases" => {
            for torque in [30.0, 50.0, 100.0] {
                for k in 0..3 {
                    let of = |model| {
                        let case = LoadCase::three(&parameters(model, false, 0.0), torque)[k];
                        let p = parameters(model, future, case.clamping);
                        let begin = Instant::now();
                        let s = std::panic::catch_unwind(|| load_case(&p, &case));
                        s.ok().map(|s| {
                            let o = &s.outputs;
                            let l = s.system.belt.layout;
                            let c: Vec<f64> = l.centres().map(|i| s.state.q[i] * 1e3).collect();
                            println!("{model:?} {} {torque} F_S {:.0}: thrust {:.4} slip {:.4} eff {:.4} spiral {:.3}/{:.3} mm defect {:.2e} {:?} {:.2} s centres {c:.3?}",
                                case.name, case.clamping, o.thrust_ratio, o.slip, o.efficiency, o.primary.spiral * 1e3, o.secondary.spiral * 1e3,
                                s.power_defect(), s.counts, begin.elapsed().as_secs_f64());
                            o.thrust_ratio
                        })
                    };
                    if let (Some(a), Some(b)) = (of(RingModel::Ale), of(RingModel::Ale0)) {
                        println!("== ALE0/ALE {:+.2} %", (b / a - 1.0) * 100.0);
                    }
                }
            }
        }
        "shift" => {
            let rpm: f64 = args.get(3).map_or(1000.0, |a| a.parse().unwrap());
            for s in [0.6, 1.0, 1.8] {
                for force in [8e3, 20e3] {
                    let of = |model| match shift(model, future, s, force, rpm) {
                        Ok(r) => r,
                        Err(e) => { println!("{model:?} {s} {force}: {e}"); [f64::NAN; 4] }
                    };
                    let (a, b) = (of(RingModel::Ale), of(RingModel::Ale0));
                    println!("s {s} F {force}: ALE {a:.5?} ALE0 {b:.5?} ratio {:.3}", b[0] / a[0]);
                }
            }
        }
        "profile" => {
            for (name, k) in [("underdrive", 0), ("medium", 1), ("overdrive", 2)] {
                for model in [RingModel::Ale, RingModel::Ale0] {
                    let case = LoadCase::three(&parameters(model, false, 0.0), 50.0)[k];
                    let s = load_case(&parameters(model, future, case.clamping), &case);
                    for at in s.stations() {
                        let a = at.sample;
                        println!("{name},{model:?},{},{},{},{},{},{},{}", a.xi, a.normal, a.pitch_radius, a.penetration, a.tension, a.push, at.segment);
                    }
                }
            }
        }
        _ => {}
    }
}
