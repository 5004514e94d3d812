//! Values of options: one of several words, or a number within a range.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// Words of an option, each with its value and help.
pub type Choices<T> = [(&'static str, T, &'static str)];

/// Returns a parser for one of these words.
pub fn one_of<T: Copy + Send + Sync + 'static>(choices: &'static Choices<T>) -> impl TypedValueParser<Value = T> {
    let word = |&(word, _, help): &(&'static str, T, &'static str)| PossibleValue::new(word).help(help);
    // Clap has matched the word, with the case sensitivity of the option.
    PossibleValuesParser::new(choices.iter().map(word)).try_map(|given| {
        let found = choices.iter().find(|(word, ..)| word.eq_ignore_ascii_case(&given));
        found.map(|(_, value, _)| *value).ok_or("an unknown word")
    })
}

pub fn word_of<T: PartialEq>(choices: &Choices<T>, value: &T) -> &'static str {
    choices.iter().find(|(_, other, _)| other == value).map_or("", |(word, ..)| *word)
}

/// True if pixels are stored in texture blocks. An alias of `bool`, because clap treats `bool` as a switch without a
/// value.
pub type InBlocks = bool;

/// Parses a finite number.
pub fn parse_number(text: &str) -> Result<f64, String> {
    let value: Option<f64> = text.trim().parse().ok().filter(|value: &f64| value.is_finite());
    value.ok_or_else(|| format!("'{text}' is not a number"))
}

/// Parses a finite number within a range. `expected` describes the range.
pub fn parse_number_where(text: &str, is_in: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    let value = parse_number(text)?;
    if is_in(value) { Ok(value) } else { Err(format!("'{text}': {expected}")) }
}

pub fn parse_positive(text: &str) -> Result<f64, String> {
    parse_number_where(text, |value| value > 0.0, "more than 0 was expected")
}

pub fn parse_not_negative(text: &str) -> Result<f64, String> {
    parse_number_where(text, |value| value >= 0.0, "0 or more was expected")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_finite_and_in_range() {
        assert_eq!(
            (parse_number(" -1.5 "), parse_positive("2e-3"), parse_not_negative("0")),
            (Ok(-1.5), Ok(2e-3), Ok(0.0))
        );
        for text in ["", "inf", "nan", "1,5", "2m"] {
            let said = parse_number(text).unwrap_err();
            assert!(said.contains("is not a number"), "{said}");
            assert!(parse_positive(text).is_err() && parse_not_negative(text).is_err());
        }
        assert!(parse_positive("0").unwrap_err().contains("more than 0"));
        assert!(parse_not_negative("-1").unwrap_err().contains("0 or more"));
    }
}
