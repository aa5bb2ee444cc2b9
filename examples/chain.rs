use pushbelt::pulley::Pulley;
use pushbelt::variator::pulleys::loads::ShaftMode;
use pushbelt::variator::settings::{BeltKind, Parameters, RingModel};
use pushbelt::variator::steady::solve::SteadyTask;
use pushbelt_lab::load_cases::{pair, speeds};
use pushbelt_lab::steady::steady;
use pushbelt_lab::variators::{SPEED, belt_alone, variator};

fn main() {
    for model in [RingModel::Ale, RingModel::Ale0] {
        for ratio in [2.2, 1.0, 0.5] {
            for kind in 0..3 {
                let mut p: Parameters = belt_alone(variator(model));
                p.joints.radius = 0.0;
                match kind {
                    0 => {}
                    1 => {
                        p.belt.play = 0.05;
                        p.friction.ring = 1.0;
                        p.friction.ring_velocity = 1e-4;
                        p.belt.pitch_offset = 0.0;
                    }
                    _ => p.kind = BeltKind::PullChain,
                }
                let task = SteadyTask {
                    ratio,
                    warm: false,
                    reaction: Pulley::Primary,
                    clamping: pair(11e3, 11e3),
                    shaft: pair(ShaftMode::Fixed, ShaftMode::Torque(50.0)),
                    slip: 0.01,
                };
                let s = steady(&p, &task, speeds(ratio, SPEED));
                let o = &s.outputs;
                println!(
                    "{model:?} {ratio} kind {kind}: kappa {:.4} T {:.0}..{:.0} Q {:.0} slip {:.3}% loss {:.1} (ring {:.3} joints {:.2}) defect {:.1e} {:?}",
                    o.thrust_ratio,
                    o.ring_tension_min,
                    o.ring_tension_max,
                    o.push_force_max,
                    100.0 * o.slip,
                    o.losses.total(),
                    o.losses.ring,
                    o.losses.joints,
                    s.power_defect(),
                    s.counts
                );
            }
        }
    }
}
