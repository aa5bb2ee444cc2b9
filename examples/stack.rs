//! TEMP
use pushbelt::variator::Variator;
use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_lab::film::{Film, FilmBench, Load, RATIOS, SHARES};
use pushbelt_lab::inside::stations;
use pushbelt_lab::loads::{Driven, LOADS};
use pushbelt_lab::manoeuvre::Manoeuvre;
use pushbelt_lab::variators::variator;

fn counts(v: &Variator) -> String {
    let c = v.counts();
    format!("{c:?}")
}

fn least(v: &Variator) -> f64 {
    stations(v, v.state())
        .iter()
        .map(|s| s.push)
        .fold(f64::INFINITY, f64::min)
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let what = args[0].as_str();
    let ring = if args.get(1).is_some_and(|a| a == "ALE0") {
        RingModel::Ale0
    } else {
        RingModel::Ale
    };
    match what {
        "man" => {
            let trace = Manoeuvre::read().trace(pushbelt_lab::fingerprint::STEP);
            let mut v = Variator::new(Manoeuvre::variator(Parameters {
                ring_model: ring,
                ..Parameters::default()
            }))
            .unwrap();
            v.initialise(0.0, &trace[0]).unwrap();
            let mut low = f64::INFINITY;
            for (k, i) in trace.iter().enumerate() {
                v.advance((k + 1) as f64 * pushbelt_lab::fingerprint::STEP, i).unwrap();
                let l = least(&v);
                if l < low - 2.0 && low < -15.0 {
                    if low < -15.0 {
                        println!(
                            "t {:.3}: {l:.1} ω {:?}",
                            (k + 1) as f64 * pushbelt_lab::fingerprint::STEP,
                            v.outputs().primary.speed
                        );
                    }
                }
                low = low.min(l);
            }
            println!("man {ring:?}: {} least {low:.1} N", counts(&v));
        }
        "loads" => {
            let letters = args[2].clone();
            for load in LOADS.into_iter().filter(|l| letters.contains(l.letter())) {
                for &ratio in load.ratios() {
                    let mut driven = Driven::new(load, variator(ring), ratio);
                    let start = driven.variator.counts();
                    let seconds: f64 = args.get(3).map_or(0.5, |s| s.parse().unwrap());
                    let steps = (seconds / load.step()).round() as usize;
                    let mut low = f64::INFINITY;
                    for _ in 0..steps {
                        let inputs = driven.inputs();
                        let t = driven.until();
                        if let Err(e) = driven.variator.advance(t, &inputs) {
                            println!("FAIL {e:?}");
                            break;
                        }
                        low = low.min(least(&driven.variator));
                    }
                    let c = driven.variator.counts() - start;
                    println!("load {} {ratio} {ring:?}: {c:?} least {low:.1}", load.letter());
                }
            }
        }
        "play" => {
            let mut film = Film::of(&Parameters::default());
            film.damping = args[2].parse().unwrap();
            film.squeeze = args[3].parse().unwrap();
            film.thickness = args[4].parse().unwrap();
            film.suction = args[5].parse().unwrap();
            let bench = FilmBench::new(film, ring);
            let slips = [2e-4, 4e-4].map(|p| bench.slip(p).unwrap());
            println!(
                "{ring:?} {film:?} slip {:.2} play {:.3}",
                1e2 * slips[0],
                1e2 * (slips[1] - slips[0])
            );
        }
        "film" => {
            let bench = FilmBench::new(Film::of(&Parameters::default()), ring);
            print!("film {ring:?}: onset");
            for s in SHARES {
                print!(" {:.2}", bench.onset(s).unwrap());
            }
            let slips = [2e-4, 4e-4].map(|p| bench.slip(p).unwrap());
            print!(" slip {:.2} play {:.3}", 1e2 * slips[0], 1e2 * (slips[1] - slips[0]));
            print!(" peak");
            if args.get(2).is_none() {
                for (_, r) in RATIOS {
                    let [s, _] = bench.near_peak(r).unwrap();
                    print!(" {:.2}", 1e2 * s);
                }
            }
            println!();
            for speed in [52.36, 209.44, 400.0, 733.0] {
                let mut low = f64::INFINITY;
                let mut none = 0;
                for (_, r) in RATIOS {
                    for share in [-0.6, 0.0, 0.4, 0.8] {
                        for f in [2e3, 12e3] {
                            match bench.steady(r, speed, f, Load::Share(share)).unwrap() {
                                Some(v) => {
                                    let l = least(&v);
                                    if l < -12.0 {
                                        print!("[{r:.2} {share} {f}: {l:.0}]");
                                    }
                                    low = low.min(l)
                                }
                                None => none += 1,
                            }
                        }
                    }
                }
                println!("least at {speed}: {low:.1} none {none}");
            }
        }
        "cmp" => {
            let benches =
                [RingModel::Ale, RingModel::Ale0].map(|r| FilmBench::new(Film::of(&Parameters::default()), r));
            let (mut sum, mut worst, mut n, mut slips, mut beyond, mut beyond30, mut idle, mut idles) =
                (0.0, 0.0_f64, 0, 0, 0, 0, 0, 0);
            for ratio in [2.25, 1.5, 1.0, 1.0 / 1.5, 1.0 / 2.25] {
                for force in [6e3, 15e3, 30e3] {
                    for r in [-0.5, 0.0, 0.3, 0.6, 0.8] {
                        let [a, b] = benches
                            .each_ref()
                            .map(|x| x.outputs(ratio, force, Load::Share(r)).unwrap());
                        let (Some(a), Some(b)) = (a, b) else {
                            println!("none {ratio:.2} {force} {r}");
                            continue;
                        };
                        let off = b.thrust_ratio / a.thrust_ratio - 1.0;
                        sum += off * off;
                        n += 1;
                        worst = worst.max(off.abs());
                        let mut text = String::new();
                        if a.slip.abs() > 0.003 {
                            slips += 1;
                            let d = b.slip / a.slip - 1.0;
                            if d.abs() > 0.2 {
                                beyond += 1;
                            }
                            if d.abs() > 0.3 {
                                beyond30 += 1;
                            }
                            text = format!(" slip {:+.0} %", 1e2 * d);
                        }
                        for p in 0..2 {
                            let [x, y] = [&a, &b].map(|o| {
                                if p == 0 {
                                    o.primary.idle_arc
                                } else {
                                    o.secondary.idle_arc
                                }
                            });
                            if x > 0.05 || y > 0.05 {
                                idles += 1;
                                if (x - y).abs() > 0.35 {
                                    idle += 1;
                                    text += &format!(" idle {p} {x:.2} {y:.2}");
                                }
                            }
                        }
                        println!("{ratio:.2} {force} {r}: {:+.1} %{text}", 1e2 * off);
                    }
                }
            }
            println!(
                "rms {:.1} % worst {:.1} % of {n}; slip beyond 20 %: {beyond}, 30 %: {beyond30} of {slips}; idle beyond .35: {idle} of {idles}",
                1e2 * (sum / n as f64).sqrt(),
                1e2 * worst
            );
        }
        _ => {}
    }
}
