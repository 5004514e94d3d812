//! Text files that people and other programs write: their encoding, and JSON.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8};
use serde::de::{DeserializeOwned, IgnoredAny};
use serde_json::Value;

use codec::error::{Error, Result};

/// Decodes text in UTF-8, or in the encoding that a byte order mark states: UTF-8 or UTF-16. The mark is removed.
///
/// # Errors
///
/// [`Error::Invalid`] with the offset of the first byte that is not of this encoding.
pub fn decode(bytes: &[u8]) -> Result<Cow<'_, str>> {
    let (encoding, mark) = Encoding::for_bom(bytes).unwrap_or((UTF_8, 0));
    let text = &bytes[mark..];
    if encoding == UTF_8 {
        let valid = std::str::from_utf8(text).map(Cow::Borrowed);
        return valid.map_err(|error| {
            let at = (mark + error.valid_up_to()) as u64;
            Error::invalid_at("", at, "this is not text in UTF-8, nor in UTF-16 with a byte order mark")
        });
    }
    encoding.decode_without_bom_handling_and_without_replacement(text).ok_or_else(|| {
        Error::invalid(format!("this is not text in {}, which its byte order mark states", encoding.name()))
    })
}

/// As [`decode`], with U+FFFD in place of bytes that are not of the encoding: names in other encodings are common in scenes.
pub fn decode_lossy(bytes: &[u8]) -> Cow<'_, str> {
    UTF_8.decode(bytes).0
}

/// Parses JSON text of any encoding of [`decode`]. `what` names the content in errors, such as `a lightfield manifest`.
///
/// # Errors
///
/// [`Error::Invalid`] with the line and column.
pub fn json<T: DeserializeOwned>(bytes: &[u8], what: &str) -> Result<T> {
    let text = decode(bytes)?;
    serde_json::from_str(&text).map_err(|error| {
        // A fault of the content may only follow from one of the syntax.
        let message = match serde_json::from_str::<Value>(&text) {
            Ok(_) => format!("this is not {what}: {error}"),
            Err(error) => format!("this is not JSON: {}", fault(&text, &error)),
        };
        Error::invalid(message)
    })
}

/// As [`json`], with comments and trailing commas as some programs read them.
///
/// # Errors
///
/// [`Error::Invalid`] with the line and column, without them for a fault of the content of a file with comments.
pub fn json_with_comments<T: DeserializeOwned>(bytes: &[u8], what: &str) -> Result<T> {
    let text = decode(bytes)?;
    if serde_json::from_str::<IgnoredAny>(&text).is_ok() || nesting(text.as_bytes()) > MAX_NESTING {
        return json(bytes, what);
    }
    match jsonc_parser::parse_to_serde_value::<Value>(&text, &jsonc_parser::ParseOptions::default()) {
        Ok(value) => {
            serde_json::from_value(value).map_err(|error| Error::invalid(format!("this is not {what}: {error}")))
        }
        Err(_) => json(bytes, what),
    }
}

/// Maximum nesting of JSON with comments, that of JSON without.
const MAX_NESTING: i32 = 127;

/// Returns the maximum nesting of brackets in a text; those in strings and comments count.
pub fn nesting(text: &[u8]) -> i32 {
    let step = |depth: &mut i32, byte: &u8| {
        *depth += i32::from(matches!(byte, b'(' | b'[' | b'{')) - i32::from(matches!(byte, b')' | b']' | b'}'));
        Some(*depth)
    };
    text.iter().scan(0, step).max().unwrap_or(0)
}

/// Describes a fault of the syntax.
fn fault(text: &str, error: &serde_json::Error) -> String {
    let line = text.lines().nth(error.line().saturating_sub(1)).unwrap_or_default();
    // Columns count bytes from 1; that of an unexpected value is its first byte or the one before it.
    let near = line.get(error.column().saturating_sub(2)..).or(line.get(error.column().saturating_sub(1)..));
    let near = near.unwrap_or_default().trim_start_matches(|c: char| !c.is_alphanumeric() && c != '-' && c != '/');
    let place = format!("at line {} column {}", error.line(), error.column());
    let number = ["NaN", "-NaN", "Infinity", "-Infinity", "nan", "inf", "-inf"];
    match number.into_iter().find(|number| near.starts_with(number)) {
        Some(number) => format!("{number} {place} is not a number of JSON"),
        None if near.starts_with("//") || near.starts_with("/*") => format!("JSON has no comments, as {place}"),
        None => error.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str) -> [Vec<u8>; 2] {
        let little = [0xff, 0xfe].into_iter().chain(text.encode_utf16().flat_map(u16::to_le_bytes));
        let big = [0xfe, 0xff].into_iter().chain(text.encode_utf16().flat_map(u16::to_be_bytes));
        [little.collect(), big.collect()]
    }

    #[test]
    fn byte_order_marks_state_the_encoding_and_are_removed() {
        let text = "{\"é\": 1}\r\n";
        for bytes in utf16(text).into_iter().chain([text.into(), format!("\u{feff}{text}").into_bytes()]) {
            assert_eq!(decode(&bytes).unwrap(), text);
            assert_eq!(json::<Value>(&bytes, "a test").unwrap()["é"], 1);
        }
        let said = decode(b"ab\xff").unwrap_err().to_string();
        assert!(said.starts_with("at byte 2: this is not text in UTF-8"), "{said}");
        assert!(decode(b"\xff\xfe\x00\xd8").unwrap_err().to_string().contains("UTF-16LE"));
    }

    #[test]
    fn faults_of_json_are_named_with_their_place() {
        for (text, expected) in [
            ("{\"w\": 1,\n}", "this is not JSON: trailing comma at line 2 column 1"),
            ("{\"w\": NaN}", "this is not JSON: NaN at line 1 column 7 is not a number of JSON"),
            ("[1,\n -Infinity]", "this is not JSON: -Infinity at line 2 column 3 is not a number of JSON"),
            ("{\n  // width\n\"w\": 1}", "this is not JSON: JSON has no comments, as at line 2 column 3"),
            ("{\"w\": \"a\"}", "this is not a test: invalid type: string \"a\", expected u32 at line 1 column 9"),
        ] {
            let said = json::<std::collections::HashMap<String, u32>>(text.as_bytes(), "a test");
            assert_eq!(said.unwrap_err().to_string(), expected);
        }
        let deep = "[".repeat(100_000);
        assert!(json::<Value>(deep.as_bytes(), "a test").unwrap_err().to_string().contains("recursion limit"));
    }

    #[test]
    fn comments_and_trailing_commas_are_read_where_they_are_accepted() {
        let text = "{ // width\n \"w\": 1, /* height */ \"h\": 2, }";
        let read: Value = json_with_comments(text.as_bytes(), "a test").unwrap();
        assert_eq!((&read["w"], &read["h"]), (&1.into(), &2.into()));
        assert!(json_with_comments::<Value>(b"{ \"w\": }", "a test").unwrap_err().to_string().contains("line 1"));
    }
}
