//! Prints `modelDescription.xml` of `PushbeltPaper.fmu`.

#![forbid(unsafe_code)]

fn main() {
    print!("{}", pushbelt_paper::unit::model_description());
}
