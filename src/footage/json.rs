//! Numbers in JSON reports. JSON cannot represent infinities: an infinite number is null, and a second key with the suffix
//! `_is` has the value "inf" or "-inf". NaN, a missing number, is null alone. CSV has these words in its cells.

use std::io::{self, Write};
use std::time::Duration;

use serde::{Serialize, Serializer};
use serde_json::Value;
use serde_json::ser::{Formatter, PrettyFormatter};

use codec::error::{Error, Result};

/// Returns indented JSON with a final newline.
pub fn pretty(value: &impl Serialize) -> Result<String> {
    let mut text = Vec::new();
    let written = value.serialize(&mut serde_json::Serializer::with_formatter(&mut text, Indented::default()));
    text.push(b'\n');
    written
        .map_err(|error| error.to_string())
        .and_then(|()| String::from_utf8(text).map_err(|error| error.to_string()))
        .map_err(|error| Error::invalid(format!("JSON: {error}")))
}

/// Formatter of indented JSON. Byte arrays in reports are always the words of infinite numbers: each is written as null,
/// followed by an entry for the word.
#[derive(Default)]
struct Indented {
    plain: PrettyFormatter<'static>,
    /// Key of the entry that is being written.
    key: String,
    is_in_key: bool,
    /// Word of the last value, if it is infinite.
    word: Option<String>,
}

impl Formatter for Indented {
    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.plain.begin_array(writer)
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.plain.end_array(writer)
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, is_first: bool) -> io::Result<()> {
        self.plain.begin_array_value(writer, is_first)
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.word = None;
        self.plain.end_array_value(writer)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.plain.begin_object(writer)
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.plain.end_object(writer)
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, is_first: bool) -> io::Result<()> {
        self.key.clear();
        self.is_in_key = true;
        self.plain.begin_object_key(writer, is_first)
    }

    fn end_object_key<W: ?Sized + Write>(&mut self, _: &mut W) -> io::Result<()> {
        self.is_in_key = false;
        Ok(())
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.plain.begin_object_value(writer)
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.plain.end_object_value(writer)?;
        let Some(word) = self.word.take() else { return Ok(()) };
        self.plain.begin_object_key(writer, false)?;
        write!(writer, "\"{}\"", word_key(&self.key))?;
        self.plain.begin_object_value(writer)?;
        write!(writer, "\"{word}\"")?;
        self.plain.end_object_value(writer)
    }

    fn write_string_fragment<W: ?Sized + Write>(&mut self, writer: &mut W, fragment: &str) -> io::Result<()> {
        if self.is_in_key {
            self.key.push_str(fragment);
        }
        writer.write_all(fragment.as_bytes())
    }

    fn write_byte_array<W: ?Sized + Write>(&mut self, writer: &mut W, word: &[u8]) -> io::Result<()> {
        self.word = Some(String::from_utf8_lossy(word).into_owned());
        self.write_null(writer)
    }
}

/// Key of the word of a number.
fn word_key(key: &str) -> String {
    format!("{key}_is")
}

fn word(value: f64) -> Option<&'static str> {
    value.is_infinite().then_some(if value > 0.0 { "inf" } else { "-inf" })
}

/// Sets a number in an object, in the form that [`pretty`] writes.
pub fn put(object: &mut Value, key: &str, value: f64) {
    object[key] = value.into();
    if let Some(word) = word(value) {
        object[word_key(key)] = word.into();
    }
}

/// Returns the word of a number that is null, by the number's key.
pub fn read_word<'v>(object: &'v Value, key: &str) -> Option<&'v str> {
    object.get(word_key(key))?.as_str()
}

/// Returns a number of a report by its key; infinite if it has a word.
pub fn read_number(object: &Value, key: &str) -> Option<f64> {
    match read_word(object, key) {
        Some("inf") => Some(f64::INFINITY),
        Some("-inf") => Some(f64::NEG_INFINITY),
        _ => object.get(key)?.as_f64(),
    }
}

/// A number of a report. An infinite number is serialised as the bytes of its word; each output format writes these in its
/// own way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub f64);

impl Number {
    /// Returns the 64-bit number with the shortest decimal digits of a 32-bit number.
    pub fn shortest(value: f32) -> Number {
        Number(value.to_string().parse().unwrap_or(f64::from(value)))
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match word(self.0) {
            Some(word) => serializer.serialize_bytes(word.as_bytes()),
            None if self.0.is_nan() => serializer.serialize_none(),
            None => serializer.serialize_f64(self.0),
        }
    }
}

pub fn number<S: Serializer>(value: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    Number(*value).serialize(serializer)
}

pub fn seconds<S: Serializer>(value: &Duration, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_f64(value.as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn infinite_numbers_are_null_beside_a_word() {
        #[derive(Serialize)]
        struct Report {
            name: &'static str,
            db: [(); 0],
            psnr_db: Number,
            limit: Number,
            list: [Number; 3],
            none: Number,
        }
        let list = [1.5, f64::INFINITY, f64::NEG_INFINITY].map(Number);
        let [psnr_db, limit, none] = [f64::INFINITY, f64::NEG_INFINITY, f64::NAN].map(Number);
        let text = pretty(&Report { name: "inf", db: [], psnr_db, limit, list, none }).unwrap();
        let value: Value = serde_json::from_str(&text).unwrap();
        let expected = serde_json::json!({
            "name": "inf", "db": [], "psnr_db": null, "psnr_db_is": "inf", "limit": null, "limit_is": "-inf",
            "list": [1.5, null, null], "none": null,
        });
        assert_eq!(value, expected);
        assert!(text.contains("\n  \"psnr_db\": null,\n  \"psnr_db_is\": \"inf\",\n"), "{text}");
        let mut value = value;
        put(&mut value, "put_db", f64::NEG_INFINITY);
        put(&mut value, "finite", 1.5);
        assert_eq!([&value["put_db_is"], &value["finite"]], [&Value::from("-inf"), &Value::from(1.5)]);
        let read = |key: &str| read_number(&value, key);
        assert_eq!(
            [read("psnr_db"), read("limit"), read("put_db"), read("none")],
            [Some(f64::INFINITY), Some(f64::NEG_INFINITY), Some(f64::NEG_INFINITY), None]
        );
        assert_eq!(serde_json::to_string(&Number::shortest(0.1)).unwrap(), "0.1");
        assert_eq!(Number::shortest(f32::INFINITY).0, f64::INFINITY);
    }
}
