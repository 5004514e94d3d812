//! Options whose value is one of several words.

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
