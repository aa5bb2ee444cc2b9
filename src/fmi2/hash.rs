//! A hash that tells texts and stored states apart.

use std::io::{self, Write};

/// FNV-1a with 128 bits (Fowler, Noll, Vo): finds accidents, protects against nobody.
pub(super) struct Fnv(u128);

impl Default for Fnv {
    fn default() -> Self {
        Self(0x6c62_272e_07bb_0142_62b8_2175_6295_c58d)
    }
}

impl Fnv {
    /// Hash of bytes.
    pub(super) fn of(bytes: &[u8]) -> u128 {
        let mut hash = Self::default();
        hash.add(bytes);
        hash.value()
    }

    /// Hash of what has been written.
    pub(super) fn value(&self) -> u128 {
        self.0
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u128::from(*byte)).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
        }
    }
}

impl Write for Fnv {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.add(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
