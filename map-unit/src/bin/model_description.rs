//! Prints the model description of the map FMU, of FMI 2.0 or 3.0: `pushbelt_map_description 2|3 [FOLDER]`. FOLDER has the file of the
//! tables, whose hash is in the token.

use std::path::Path;

use pushbelt_fmi::{Version, model_description};
use pushbelt_map_unit::tables::Tables;
use pushbelt_map_unit::unit::MapUnit;

fn main() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let is_three = arguments.next().is_some_and(|version| version == "3");
    let version = if is_three { Version::Three } else { Version::Two };
    let tables = arguments.next().map(|folder| Tables::read(Path::new(&folder)));
    let hash = tables.transpose()?.map(|tables| tables.hash);
    print!("{}", model_description::<MapUnit>(version, hash));
    Ok(())
}
