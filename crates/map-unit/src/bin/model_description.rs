//! Prints the model description of the map FMU: of FMI 2.0, or with the argument 3 of FMI 3.0. Its token is that of a unit without
//! tables; the tool that packs tables calculates the other.

use pushbelt_fmi::{fmi2, fmi3};
use pushbelt_map_unit::unit::MapUnit;

fn main() {
    let third = std::env::args().nth(1).is_some_and(|version| version == "3");
    let describe = if third {
        fmi3::model_description::<MapUnit>
    } else {
        fmi2::model_description::<MapUnit>
    };
    print!("{}", describe());
}
