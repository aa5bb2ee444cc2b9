//! Whether the processor has what the code is compiled for. Checked first, in a function that does nothing
//! else: an instruction that the processor lacks ends the host.

use std::ffi::CStr;

/// The message of a function where it has not.
macro_rules! objection {
    ($function:literal) => {
        match CStr::from_bytes_with_nul(
            concat!(
                $function,
                ": this processor lacks AVX2, which the FMU's binary was compiled for; one built by `cargo fmu build --portable` \
                 does without\0"
            )
            .as_bytes(),
        ) {
            Ok(text) => text,
            Err(_) => c"",
        }
    };
}

/// The message of FMI 2.0 where it has not.
pub const OBJECTION: &CStr = objection!("fmi2Instantiate");
/// The message of FMI 3.0.
pub const OBJECTION3: &CStr = objection!("fmi3InstantiateCoSimulation");

/// Whether the processor has what the code is compiled for.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[must_use]
pub fn suffices() -> bool {
    // Where the compiler may use AVX2, the standard library does not check the processor for it. It does check processor and
    // operating system for FMA and BMI2, and no processor has these two without AVX2.
    std::arch::is_x86_feature_detected!("fma") && std::arch::is_x86_feature_detected!("bmi2")
}

/// Whether the processor has what the code is compiled for: the code needs nothing beyond the architecture's first processors.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
#[must_use]
pub fn suffices() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::{OBJECTION, OBJECTION3};

    #[test]
    fn the_messages_name_their_function_and_the_way_out() {
        for (message, function) in [
            (OBJECTION, "fmi2Instantiate: "),
            (OBJECTION3, "fmi3InstantiateCoSimulation: "),
        ] {
            let text = message.to_str().expect("UTF-8");
            assert!(
                text.starts_with(function) && text.contains("`cargo fmu build --portable` does without"),
                "{text}"
            );
        }
    }
}
