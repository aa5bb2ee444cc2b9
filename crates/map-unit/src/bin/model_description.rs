//! Prints the model description of the map FMU, of FMI 2.0 or 3.0: `pushbelt_map_description 2|3 [FOLDER]`. FOLDER has the file of the
//! tables, whose hash is in the token.

use std::path::Path;
use std::process::ExitCode;

use pushbelt_fmi::{fmi2, fmi3};
use pushbelt_map_unit::tables::Tables;
use pushbelt_map_unit::unit::MapUnit;

fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let third = arguments.first().is_some_and(|version| version == "3");
    let Some(folder) = arguments.get(1) else {
        let describe = if third {
            fmi3::model_description::<MapUnit>
        } else {
            fmi2::model_description::<MapUnit>
        };
        print!("{}", describe());
        return ExitCode::SUCCESS;
    };
    let describe = if third {
        fmi3::model_description_with::<MapUnit>
    } else {
        fmi2::model_description_with::<MapUnit>
    };
    match Tables::read(Path::new(folder)) {
        Ok(tables) => {
            print!("{}", describe(tables.hash));
            ExitCode::SUCCESS
        }
        Err(why) => {
            eprintln!("{why}");
            ExitCode::FAILURE
        }
    }
}
