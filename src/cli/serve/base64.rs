//! Base64 (RFC 4648, 4), in pieces.

/// Bytes of a piece must be a multiple of this, except of the last one.
pub const GROUP_BYTES: usize = 3;

const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

/// Returns the characters of some bytes, four for each group.
pub fn encode(bytes: &[u8]) -> Vec<u8> {
    let mut text = Vec::with_capacity(bytes.len().div_ceil(GROUP_BYTES) * 4);
    for group in bytes.chunks(GROUP_BYTES) {
        let byte = |at: usize| u32::from(group.get(at).copied().unwrap_or(0));
        let bits = byte(0) << 16 | byte(1) << 8 | byte(2);
        for at in 0..4 {
            let character = ALPHABET[(bits >> (18 - 6 * at) & 63) as usize];
            text.push(if at <= group.len() { character } else { b'=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodes_the_test_vectors_of_the_standard() {
        let rows =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("fooba", "Zm9vYmE=")];
        for (bytes, text) in rows {
            assert_eq!(encode(bytes.as_bytes()), text.as_bytes());
        }
        assert_eq!(encode(&[0xfb, 0xff, 0xfe]), b"+//+");
    }
}
