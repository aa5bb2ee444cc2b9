//! Prints the model description of the first-order lag: of FMI 2.0, or with the argument 3 of FMI
//! 3.0.

use pushbelt_fmi::{Version, model_description};

#[path = "lag.rs"]
mod lag;

fn main() {
    let third = std::env::args().nth(1).is_some_and(|version| version == "3");
    let version = if third { Version::Three } else { Version::Two };
    print!("{}", model_description::<lag::Lag>(version, None));
}
