//! Whether the processor has the instructions that the code is compiled for. This is checked first,
//! in a function that does nothing else: a missing instruction terminates the host.

use std::ffi::CStr;

/// The error of an `instantiate` function if the processor lacks them.
pub const NO_AVX2: &CStr =
    c"this processor lacks AVX2, for which the binary of the FMU was compiled; use an FMU built by \
    `cargo fmu build --portable`";

/// Whether the processor has what the code is compiled for.
#[cfg(all(target_arch = "x86_64", target_feature = "avx2"))]
pub fn suffices() -> bool {
    // With AVX2 enabled in the compiler, the standard library does not check the processor for it.
    // It does check processor and operating system for FMA and BMI2, and every processor with these
    // two has AVX2.
    std::arch::is_x86_feature_detected!("fma") && std::arch::is_x86_feature_detected!("bmi2")
}

/// Always true: the code needs no instructions beyond the architecture's baseline.
#[cfg(not(all(target_arch = "x86_64", target_feature = "avx2")))]
pub fn suffices() -> bool {
    true
}
