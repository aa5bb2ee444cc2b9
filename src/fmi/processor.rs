//! Whether the processor has what the code is compiled for. Asked before anything else, in a function that does nothing
//! else: an instruction that the processor lacks would end the host.

use std::ffi::CStr;

/// The message where it has not.
pub const OBJECTION: &CStr = c"fmi2Instantiate: this processor lacks AVX2, which the FMU's binary was compiled for; \
    one built by `cargo fmu build --portable` does without";

/// Whether the processor has what the code is compiled for.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
#[must_use]
pub fn suffices() -> bool {
    // Where the compiler may use AVX2, the standard library does not ask the processor for it. It does ask processor and
    // operating system for FMA and BMI2, and no processor has these two without AVX2.
    std::arch::is_x86_feature_detected!("fma") && std::arch::is_x86_feature_detected!("bmi2")
}

/// Whether the processor has what the code is compiled for: nothing beyond the architecture's first processors is asked for.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
#[must_use]
pub fn suffices() -> bool {
    true
}
