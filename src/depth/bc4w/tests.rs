use super::*;

/// A block that ends after `width` columns and `height` rows.
fn check(codes: &[u16], width: usize, effort: Effort) -> Accuracy {
    let block = Block::of(codes, width, 1, [0, 0]);
    let (coded, accuracy) = encode(&block, effort);
    verify(codes, width, coded, accuracy);
    accuracy
}

/// Decodes and compares with what the encoder says; no byte pattern may be a marker.
fn verify(codes: &[u16], width: usize, coded: Bc4w, accuracy: Accuracy) {
    assert_ne!(coded.as_bytes()[28..], [0xff; 4]);
    assert_eq!(Bc4w::from_bytes(*coded.as_bytes()), Some(coded));
    let mut decoded = vec![0; codes.len()];
    coded.decode(&mut BlockMut::of(&mut decoded, width, 1, [0, 0]));
    assert_eq!(Block::of(codes, width, 1, [0, 0]).accuracy(&decoded), Some(accuracy));
}

#[test]
fn constants() {
    for code in [0, 1, 4, 1000, 65534, 65535] {
        for effort in [Effort::Fast, Effort::Normal, Effort::Exhaustive] {
            let accuracy = check(&[code; 64], 8, effort);
            assert!(accuracy.max_error <= 4, "{code} {effort:?} {accuracy:?}");
        }
    }
}
