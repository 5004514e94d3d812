//! The header `Range` (RFC 9110, 14.1.2 and 14.2): a single range of bytes, from a position or a suffix.
//!
//! Implemented here because available parsers reject a suffix longer than the file, which must select the whole file.

/// The part of a file that a request asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Asked {
    /// The whole file: there is no range, or one that a server ignores.
    Whole,
    /// At least one byte, within the length.
    Part {
        first: u64,
        length: u64,
    },
    Unsatisfiable,
}

/// Parses the value of `Range` for a representation of `length` bytes. Ignores multiple ranges, other units and malformed
/// values.
pub fn asked(value: &str, length: u64) -> Asked {
    let Some((unit, range)) = value.split_once('=') else { return Asked::Whole };
    let Some((first, last)) = range.trim().split_once('-') else { return Asked::Whole };
    if !unit.trim().eq_ignore_ascii_case("bytes") {
        return Asked::Whole;
    }
    match (number(first), number(last)) {
        (Some(Some(first)), Some(Some(last))) if last < first => Asked::Whole,
        (Some(Some(first)), Some(last)) => match length.checked_sub(first) {
            Some(rest @ 1..) => {
                let wanted = last.map_or(rest, |last| (last - first).saturating_add(1));
                Asked::Part { first, length: wanted.min(rest) }
            }
            _ => Asked::Unsatisfiable,
        },
        (Some(None), Some(Some(wanted))) => match wanted.min(length) {
            0 => Asked::Unsatisfiable,
            length_of_end => Asked::Part { first: length - length_of_end, length: length_of_end },
        },
        _ => Asked::Whole,
    }
}

/// Parses digits, saturating at the maximum; returns `Some(None)` for an empty text, and `None` for anything else.
fn number(text: &str) -> Option<Option<u64>> {
    let is_number = text.bytes().all(|byte| byte.is_ascii_digit());
    is_number.then(|| (!text.is_empty()).then(|| text.parse().unwrap_or(u64::MAX)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_range_is_answered_and_others_are_ignored() {
        let part = |first, length| Asked::Part { first, length };
        let rows = [
            ("bytes=0-0", part(0, 1)),
            ("bytes=2-5", part(2, 4)),
            ("Bytes = 2-5", part(2, 4)),
            ("bytes=002-5", part(2, 4)),
            ("bytes=9-9", part(9, 1)),
            ("bytes=3-", part(3, 7)),
            ("bytes=3-10", part(3, 7)),
            ("bytes=0-99999999999999999999999", part(0, 10)),
            ("bytes=0-18446744073709551615", part(0, 10)),
            ("bytes=-1", part(9, 1)),
            ("bytes=-10", part(0, 10)),
            ("bytes=-99999999999999999999999", part(0, 10)),
            ("bytes=-0", Asked::Unsatisfiable),
            ("bytes=10-", Asked::Unsatisfiable),
            ("bytes=10-12", Asked::Unsatisfiable),
            ("bytes=99999999999999999999999-", Asked::Unsatisfiable),
        ];
        for (value, expected) in rows {
            assert_eq!(asked(value, 10), expected, "{value}");
        }
        let ignored = "bytes=5-2|bytes=0-1,4-5|bytes=0-1,|bytes=-|bytes=|bytes|bytes=1|bytes=a-b|bytes=+1-2|bytes=1--2|bytes=0x1-2|\
            bytes=1 - 2|lines=0-1||=0-1|bytes=\u{0661}-2";
        for value in ignored.split('|') {
            assert_eq!(asked(value, 10), Asked::Whole, "{value}");
        }
    }

    #[test]
    fn nothing_of_an_empty_file_can_be_asked_for() {
        for value in ["bytes=0-", "bytes=0-0", "bytes=-5"] {
            assert_eq!(asked(value, 0), Asked::Unsatisfiable, "{value}");
        }
    }
}
