//! A hash of texts and stored states.

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

    /// Hash of bytes taken eight at a time, the last ones filled up with zeros: for what is long.
    pub(super) fn of_words(bytes: &[u8]) -> u128 {
        let mut hash = Self::default();
        let (words, rest) = bytes.as_chunks::<8>();
        let mut last = [0; 8];
        last[..rest.len()].copy_from_slice(rest);
        for word in words.iter().chain([&last]) {
            hash.mix(u64::from_le_bytes(*word).into());
        }
        hash.value()
    }

    /// Hash of what has been written.
    pub(super) fn value(&self) -> u128 {
        self.0
    }

    fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.mix((*byte).into());
        }
    }

    fn mix(&mut self, value: u128) {
        self.0 = (self.0 ^ value).wrapping_mul(0x0000_0000_0100_0000_0000_0000_0000_013b);
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
