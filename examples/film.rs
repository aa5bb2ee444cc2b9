//! Gaps, slip and traction over the oil between the elements: suction, thickness, roughness and
//! damping. Prints the Markdown table:
//!
//! `cargo run --release --example film`
//!
//! Values in the order of the table's columns give one row of it, `ALE0` behind them uses that
//! ring: `cargo run --release --example film -- 19 6e-6 1e-7 2.7 150`

use std::error::Error;

use pushbelt::variator::settings::{Parameters, RingModel};
use pushbelt_support::film::{self, Load, RATIOS, SHARES, film_variator};

/// Suction, thickness, roughness and the two dampings of the rows: the default, and changes of it.
const TRIED: [[f64; 5]; 11] = [
    [19.0, 6e-6, 1e-7, 2.7, 75.0],
    [10.0, 6e-6, 1e-7, 2.7, 75.0],
    [40.0, 6e-6, 1e-7, 2.7, 75.0],
    [19.0, 3e-6, 1e-7, 2.7, 75.0],
    [19.0, 12e-6, 1e-7, 2.7, 75.0],
    [19.0, 6e-6, 5e-8, 2.7, 75.0],
    [19.0, 6e-6, 2e-7, 2.7, 75.0],
    [19.0, 6e-6, 1e-7, 1.35, 75.0],
    [19.0, 6e-6, 1e-7, 5.4, 75.0],
    [19.0, 6e-6, 1e-7, 2.7, 37.5],
    [19.0, 6e-6, 1e-7, 2.7, 150.0],
];

fn heading() {
    println!(
        "| ring | suction, N | thickness, µm | roughness, µm | film damping, N·s | squeeze damping, N·s | least push force, N | idle arc at r = 0.4 | 0.6 | 0.8 \
         | slip at 0.2 mm of play | added at 0.4 mm | slip at 95 % of the peak, LOW | medium | OD | peaks | thrust ratio at r = 0.6, LOW | medium | OD | OD, r = 0 |"
    );
    println!("|---|{}", "---|".repeat(19));
}

fn row(oil: [f64; 5], ring: RingModel) -> Result<(), Box<dyn Error>> {
    let mut variator = film_variator(ring);
    for (parameter, value) in film::film(&mut variator).into_iter().zip(oil) {
        *parameter = value;
    }
    let [suction, thickness, roughness, damping, squeeze] = oil;
    print!(
        "| {} | {suction} | {:.3} | {:.3} | {damping} | {squeeze} | {:.1} |",
        if ring == RingModel::Ale0 { "`ALE0`" } else { "`ALE`" },
        1e6 * thickness,
        1e6 * roughness,
        film::least_push(&variator)?
    );
    for share in SHARES {
        print!(" {:.2} |", film::onset(&variator, share)?);
    }
    let slips = [film::slip(&variator, 2e-4)?, film::slip(&variator, 4e-4)?];
    print!(" {:.2} % | {:+.2} |", 1e2 * slips[0], 1e2 * (slips[1] - slips[0]));
    let mut peaks = String::new();
    for ratio in RATIOS {
        let [slip, peak] = film::near_peak(&variator, ratio)?;
        print!(" {:.2} % |", 1e2 * slip);
        peaks += &format!(" {peak:.3}");
    }
    print!("{peaks} |");
    for ratio in RATIOS {
        let outputs = film::outputs(&variator, ratio, 15e3, Load::Share(0.6))?;
        print!(" {:.3} |", outputs.map_or(f64::NAN, |o| o.thrust_ratio));
    }
    let outputs = film::outputs(&variator, RATIOS[2], 15e3, Load::Share(0.0))?;
    println!(" {:.3} |", outputs.map_or(f64::NAN, |o| o.thrust_ratio));
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if arguments.is_empty() {
        heading();
        for oil in TRIED {
            row(oil, RingModel::Ale)?;
            row(oil, RingModel::Ale0)?;
        }
        return Ok(());
    }
    let mut oil = film::film(&mut Parameters::default()).map(|value| *value);
    for (value, text) in oil.iter_mut().zip(&arguments) {
        *value = text.parse()?;
    }
    let of_circles = arguments.get(5).is_some_and(|name| name == "ALE0");
    row(oil, if of_circles { RingModel::Ale0 } else { RingModel::Ale })
}
