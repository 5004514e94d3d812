//! Numbers in JSON reports. JSON has no infinities: such a number is null, and the key beside it that ends in `_is` has "inf" or
//! "-inf". NaN, a number that there is none of, is null alone. CSV has the words in the cells.

use std::time::Duration;

use serde::{Serialize, Serializer};

use crate::error::{Error, Result};

/// An infinite number on its way to a report, and the word that stands for it there.
const INFINITIES: [(&str, &str); 2] = [("∞", "inf"), ("-∞", "-inf")];

/// Indented, with a newline at its end.
pub fn pretty(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
    Ok(text.lines().map(|line| finite(line) + "\n").collect())
}

/// A line of indented JSON, an entry, with null for an infinite number and the word in a further entry.
fn finite(line: &str) -> String {
    let (entry, comma) = line.strip_suffix(',').map_or((line, ""), |entry| (entry, ","));
    let infinite = INFINITIES.iter().find_map(|(sign, word)| Some((entry.strip_suffix(&format!("\"{sign}\""))?, word)));
    match infinite {
        None => line.to_owned(),
        Some((before, word)) => match before.strip_suffix("\": ") {
            Some(key) => format!("{key}\": null,\n{key}_is\": \"{word}\"{comma}"),
            None => format!("{before}null{comma}"),
        },
    }
}

/// The word of an infinite number, other text as it is.
pub fn word(text: &str) -> &str {
    INFINITIES.iter().find(|(sign, _)| *sign == text).map_or(text, |(_, word)| word)
}

/// A number of a report, by its key: infinite where it is null and the key beside it says so.
pub fn read_number(object: &serde_json::Value, key: &str) -> Option<f64> {
    match object.get(format!("{key}_is")).and_then(serde_json::Value::as_str) {
        Some("inf") => Some(f64::INFINITY),
        Some("-inf") => Some(f64::NEG_INFINITY),
        _ => object.get(key)?.as_f64(),
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Number(pub f64);

impl Number {
    /// The 64-bit number with the digits that print a 32-bit one.
    pub fn shortest(value: f32) -> Number {
        Number(value.to_string().parse().unwrap_or(f64::from(value)))
    }
}

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self.0 {
            value if value.is_finite() => serializer.serialize_f64(value),
            value if value.is_nan() => serializer.serialize_none(),
            value => serializer.serialize_str(INFINITIES[usize::from(value < 0.0)].0),
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
        let value: serde_json::Value = serde_json::from_str(&text).unwrap();
        let expected = serde_json::json!({
            "name": "inf", "db": [], "psnr_db": null, "psnr_db_is": "inf", "limit": null, "limit_is": "-inf",
            "list": [1.5, null, null], "none": null,
        });
        assert_eq!(value, expected);
        let read = |key: &str| read_number(&value, key);
        assert_eq!(
            [read("psnr_db"), read("limit"), read("none")],
            [Some(f64::INFINITY), Some(f64::NEG_INFINITY), None]
        );
        assert_eq!([word("∞"), word("a")], ["inf", "a"]);
        assert_eq!(serde_json::to_string(&Number::shortest(0.1)).unwrap(), "0.1");
        assert_eq!(Number::shortest(f32::INFINITY).0, f64::INFINITY);
    }
}
