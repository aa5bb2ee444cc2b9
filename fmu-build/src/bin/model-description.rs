//! Prints the model description that the variable table gives.

fn main() {
    print!("{}", pushbelt::unit::model_description());
}
