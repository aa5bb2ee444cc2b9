//! Whether the processor has the instructions that the code is compiled for. This is checked first, in a function that does
//! nothing else: a missing instruction terminates the host.

use std::ffi::CStr;

/// The error of a function if the processor lacks them.
macro_rules! no_avx2 {
    ($function:literal) => {
        match CStr::from_bytes_with_nul(
            concat!(
                $function,
                ": this processor lacks AVX2, for which the binary of the FMU was compiled; use an FMU built by \
                 `cargo fmu build --portable`\0"
            )
            .as_bytes(),
        ) {
            Ok(text) => text,
            Err(_) => c"",
        }
    };
}

/// The error of FMI 2.0 if the processor lacks them.
pub const NO_AVX2: &CStr = no_avx2!("fmi2Instantiate");
/// The error of FMI 3.0.
pub const NO_AVX2_FMI3: &CStr = no_avx2!("fmi3InstantiateCoSimulation");

/// Whether the processor has what the code is compiled for.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[must_use]
pub fn suffices() -> bool {
    // With AVX2 enabled in the compiler, the standard library does not check the processor for it. It does check processor and
    // operating system for FMA and BMI2, and every processor with these two has AVX2.
    std::arch::is_x86_feature_detected!("fma") && std::arch::is_x86_feature_detected!("bmi2")
}

/// Always true: the code needs no instructions beyond the architecture's baseline.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
#[must_use]
pub fn suffices() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::{NO_AVX2, NO_AVX2_FMI3};

    #[test]
    fn the_messages_name_their_function_and_the_remedy() {
        for (message, function) in [
            (NO_AVX2, "fmi2Instantiate: "),
            (NO_AVX2_FMI3, "fmi3InstantiateCoSimulation: "),
        ] {
            let text = message.to_str().expect("UTF-8");
            assert!(
                text.starts_with(function) && text.contains("use an FMU built by `cargo fmu build --portable`"),
                "{text}"
            );
        }
    }
}
