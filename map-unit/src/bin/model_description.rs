//! Prints the model description of the map FMU, of FMI 2.0 or 3.0: `pushbelt_map_description 2|3 [FOLDER]`. FOLDER has the file of the
//! tables, whose hash is in the token.

use std::path::Path;
use std::process::ExitCode;

use pushbelt_fmi::{Version, model_description};
use pushbelt_map_unit::tables::Tables;
use pushbelt_map_unit::unit::MapUnit;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let version = match arguments.first() {
        Some(version) if version == "3" => Version::Three,
        _ => Version::Two,
    };
    let data = match arguments.get(1).map(|folder| Tables::read(Path::new(folder))) {
        Some(Ok(tables)) => Some(tables.hash),
        Some(Err(why)) => {
            eprintln!("{why}");
            return ExitCode::FAILURE;
        }
        None => None,
    };
    print!("{}", model_description::<MapUnit>(version, data));
    ExitCode::SUCCESS
}
