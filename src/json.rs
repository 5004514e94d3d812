//! Numbers in JSON reports: infinities, which JSON lacks, are the strings "inf" and "-inf"; NaN is null.

use std::time::Duration;

use serde::{Serialize, Serializer};

use crate::error::{Error, Result};

/// Indented, with a newline at its end.
pub fn pretty(value: &impl Serialize) -> Result<String> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Error::invalid(format!("JSON: {error}")))?;
    Ok(text + "\n")
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
            value => serializer.serialize_str(if value > 0.0 { "inf" } else { "-inf" }),
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
    fn numbers_that_json_lacks_are_words() {
        let text = |value: f64| serde_json::to_string(&Number(value)).unwrap();
        assert_eq!([1.5, f64::INFINITY, f64::NEG_INFINITY, f64::NAN].map(text), ["1.5", "\"inf\"", "\"-inf\"", "null"]);
        assert_eq!(serde_json::to_string(&Number::shortest(0.1)).unwrap(), "0.1");
        assert_eq!(Number::shortest(f32::INFINITY).0, f64::INFINITY);
    }
}
