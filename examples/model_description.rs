//! Prints the model description that the variable table gives. `cargo fmu describe` writes it down.

fn main() {
    print!("{}", pushbelt::unit::model_description());
}
