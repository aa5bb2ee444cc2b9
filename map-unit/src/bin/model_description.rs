//! Prints the model description of the map FMU, of FMI 2.0 or 3.0: `pushbelt_map_description 2|3
//! FOLDER`. FOLDER has the file of the tables, whose hash is in the token.

use pushbelt_fmi::unit::Unit;
use pushbelt_fmi::{Version, model_description};
use pushbelt_map_unit::unit::MapUnit;

fn main() -> Result<(), String> {
    let [version, folder] = [1, 2].map(|k| std::env::args().nth(k).unwrap_or_default());
    let version = if version == "3" { Version::Three } else { Version::Two };
    let settings = MapUnit::load(Some(folder.as_ref()))?;
    print!("{}", model_description::<MapUnit>(version, MapUnit::data(&settings)));
    Ok(())
}
