use pushbelt_elements::case::Case;
fn main() {
    let name = std::env::args().nth(1).unwrap();
    let seconds: f64 = std::env::args().nth(2).unwrap().parse().unwrap();
    let mut case = Case::named(&name).unwrap();
    if let Some(dt) = std::env::args().nth(3) { case.options.step = Some(dt.parse().unwrap()); }
    let mut m = case.start().unwrap();
    let start = std::time::Instant::now();
    let mut next = 0.0;
    let every = seconds / 40.0;
    let mut steps = 0u64;
    let mut sum = [0.0; 6];
    let mut count = 0.0;
    let mut e0: f64 = 0.0; let mut l0 = m.ledger;
    while m.time < seconds {
        case.drive(&mut m);
        m.step();
        steps += 1;
        let l = &m.loads;
        let r = [0, 1].map(|j| l[j].weight[1] / l[j].weight[0]);
        for (k, v) in [l[0].axial, l[1].axial, r[0], r[1], m.pulleys[0].omega, m.pulleys[1].omega].iter().enumerate() { sum[k] += v; }
        count += 1.0;
        if steps % 64 == 0 { if let Err(e) = m.check() { println!("{e}"); break; } }
        if m.time >= next {
            let a = sum.map(|s| s / count);
            let slip = 1.0 - a[4] / a[5] * a[2] / a[3];
            let e: f64 = m.energies().iter().sum();
            let d = m.ledger.since(&l0);
            println!("{:.5} s {:.4} thrust {:.4} slip% {:.4} axS {:.0} | work {:.3} loss {:.3} dE {:.3} res {:.4} of work1 {:.3} q {:.1} {:.1} gaps {}", m.time, a[2]/a[3], a[1]/a[0], slip*100.0, a[0],
                d.work(), d.losses(), e - e0, d.work()-d.losses()-(e-e0), d.0[1],
                m.stack.push[1..=m.law.count].iter().cloned().fold(f64::MAX, f64::min), m.stack.push[1..=m.law.count].iter().cloned().fold(f64::MIN, f64::max),
                m.chords.length[1..=m.law.count].iter().filter(|l| **l > m.law.thickness + 1e-6).count());
            l0 = m.ledger; e0 = e; sum = [0.0; 6]; count = 0.0;
            next += every;
        }
    }
    let t = start.elapsed().as_secs_f64();
    for (n, v) in pushbelt_elements::machine::Ledger::NAMES.iter().zip(m.ledger.0) { print!("{n} {v:.4}; "); }
    println!("\n{} element steps/s {:.3e}, {:.1} us a step", steps, steps as f64 * m.law.count as f64 / t, t / steps as f64 * 1e6);
}
