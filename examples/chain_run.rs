use pushbelt::variator::run::Variator;
use pushbelt::variator::settings::{BeltKind, RingModel};
use pushbelt_lab::bench::*;
use pushbelt_lab::manoeuvre::*;
use pushbelt_lab::variators::variator;
fn main() {
    let m = Manoeuvre::read();
    let trace = m.trace(1e-3);
    for model in [RingModel::Ale, RingModel::Ale0] {
        for kind in [BeltKind::PushBelt, BeltKind::PullChain] {
            let mut p = variator(model);
            p.kind = kind;
            let p = Manoeuvre::variator(p);
            let (time, counts) = manoeuvre(|| Variator::new(p.clone()).unwrap(), &trace, |advance| advance());
            println!("{model:?} {kind:?} {time:.2} {counts:?}");
            let mut v = Variator::new(p.clone()).unwrap();
            v.initialise(0.0, &trace[0]).unwrap();
            for (k, inputs) in trace.iter().enumerate() {
                v.advance((k + 1) as f64 * 1e-3, inputs).unwrap();
                if k % 1000 == 999 {
                    let o = v.outputs();
                    println!(
                        "{} kappa {:.3} i {:.3} slip {:.4} T {:.0}..{:.0} eff {:.4} resid {:.2e} vb {:.2} vr {:.2} joints {:.1} macro {}",
                        k + 1,
                        o.thrust_ratio,
                        o.ratio_geometric,
                        o.slip,
                        o.ring_tension_min,
                        o.ring_tension_max,
                        o.efficiency,
                        o.energy_residual,
                        o.belt_speed,
                        o.ring_speed,
                        o.losses.joints,
                        o.macro_slip
                    );
                }
            }
            for m in v.take_messages() {
                println!("{}", m.text);
            }
        }
    }
}
