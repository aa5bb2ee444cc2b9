//! Prints a file that is generated from the variable table or the tables of C functions; `cargo fmu
//! describe` runs it. The first argument names it: `modelDescription.xml` (FMI 2.0, also without an
//! argument), `modelDescription3.xml` (FMI 3.0), `terminalsAndIcons.xml` or `exports.def`.

use pushbelt::fmi::Version;
use pushbelt::unit::{model_description, terminals};

fn main() -> Result<(), String> {
    let file = std::env::args().nth(1);
    let text = match file.as_deref() {
        None | Some("modelDescription.xml") => model_description(Version::Two),
        Some("modelDescription3.xml") => model_description(Version::Three),
        Some("terminalsAndIcons.xml") => terminals(),
        Some("exports.def") => pushbelt_library::definition(),
        Some(other) => return Err(format!("{other} is not generated")),
    };
    print!("{text}");
    Ok(())
}
