//! A hash of texts, stored states and libraries: FNV-1a with 128 bits (Fowler, Noll, Vo). It
//! detects accidents, not attacks.

const START: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
const PRIME: u128 = 0x0000_0000_0100_0000_0000_0000_0000_013b;

fn mix(hash: u128, value: u128) -> u128 {
    (hash ^ value).wrapping_mul(PRIME)
}

/// Hash of bytes.
#[must_use]
pub fn of_bytes(bytes: &[u8]) -> u128 {
    bytes.iter().fold(START, |hash, byte| mix(hash, (*byte).into()))
}

/// Hash of bytes taken eight at a time, the last ones filled up with zeros: for long states.
#[must_use]
pub fn of_words(bytes: &[u8]) -> u128 {
    let (words, rest) = bytes.as_chunks::<8>();
    let mut last = [0; 8];
    last[..rest.len()].copy_from_slice(rest);
    let words = words.iter().chain([&last]);
    words.fold(START, |hash, word| mix(hash, u64::from_le_bytes(*word).into()))
}

/// Length and hash of a file's content, in words: what identifies the variant of a library.
#[must_use]
pub fn of_file(content: &[u8]) -> String {
    format!("{}-{:032x}", content.len(), of_words(content))
}

#[cfg(test)]
mod tests {
    use super::{of_bytes, of_file, of_words};

    /// Values of the hash's authors.
    #[test]
    fn hashes_are_those_of_fnv_1a() {
        assert_eq!(of_bytes(b"a"), 0xd228_cb69_6f1a_8caf_7891_2b70_4e4a_8964);
        assert_eq!(of_bytes(b"foobar"), 0x343e_1662_793c_64bf_6f0d_3597_ba44_6f18);
        assert_eq!(of_words(b"a"), of_bytes(b"a"));
        assert_ne!(of_words(&[1; 8]), of_words(&[1; 9]));
        assert_eq!(of_file(b"a"), "1-d228cb696f1a8caf78912b704e4a8964");
    }
}
