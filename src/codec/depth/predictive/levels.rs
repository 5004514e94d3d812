//! Levels: the surface codes of footage with few distinct codes, such as that of a depth sensor. Pixels are coded as level
//! numbers (depth.md 15.2).

#[cfg(feature = "encode")]
use std::borrow::Cow;
use std::sync::Arc;

use crate::depth::quantise::{BACKGROUND_CODE, FAR_CODE};
use crate::error::{Error, Result};

/// Maximum number of levels of a stream.
pub const MAX_LEVELS: usize = 4096;

/// Surface codes that occur in a stream, in ascending order; empty if any code may occur.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Levels(Arc<[u16]>);

impl Levels {
    /// Creates levels from their codes.
    ///
    /// # Errors
    /// Fails for no code, more than [`MAX_LEVELS`] codes, codes that do not ascend, or background.
    pub fn new(codes: Vec<u16>) -> Result<Levels> {
        if codes.is_empty() || codes.len() > MAX_LEVELS {
            return Err(Error::invalid(format!("{} levels, 1 to {MAX_LEVELS} are legal", codes.len())));
        }
        if let Some(pair) = codes.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(Error::invalid(format!("level {} follows {}, but levels must ascend", pair[1], pair[0])));
        }
        match codes.last() {
            Some(&last) if last > FAR_CODE => Err(Error::invalid("background cannot be a level")),
            _ => Ok(Levels(codes.into())),
        }
    }

    /// Returns the codes in ascending order.
    pub fn codes(&self) -> &[u16] {
        &self.0
    }

    /// Returns true if there are no levels, so that any code may occur.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Converts level numbers to codes, in place. Numbers beyond the last level become the last level; background stays.
    pub fn to_codes(&self, numbers: &mut [u16]) {
        let [.., last] = self.codes() else { return };
        for number in numbers.iter_mut().filter(|number| **number != BACKGROUND_CODE) {
            *number = *self.codes().get(usize::from(*number)).unwrap_or(last);
        }
    }

    /// Returns the level number of a code; the background code is returned unchanged.
    #[cfg(feature = "encode")]
    fn number(&self, code: u16) -> Option<u16> {
        match self.codes().binary_search(&code) {
            Ok(number) => Some(number as u16),
            Err(_) => (code == BACKGROUND_CODE).then_some(code),
        }
    }

    /// Converts codes to level numbers, the input of the encoder; without levels returns the codes unchanged.
    ///
    /// # Errors
    /// Index of the first code that is neither a level nor background.
    #[cfg(feature = "encode")]
    pub fn numbers<'a>(&self, codes: &'a [u16]) -> std::result::Result<Cow<'a, [u16]>, usize> {
        if self.is_empty() {
            return Ok(Cow::Borrowed(codes));
        }
        let number = |(place, &code)| self.number(code).ok_or(place);
        codes.iter().enumerate().map(number).collect::<std::result::Result<_, _>>().map(Cow::Owned)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_ascend_and_hold_no_background() {
        assert!(Levels::new(vec![]).is_err());
        assert!(Levels::new(vec![3, 3]).is_err());
        assert!(Levels::new(vec![4, 3]).is_err());
        assert!(Levels::new(vec![3, BACKGROUND_CODE]).is_err());
        assert!(Levels::new((0..=MAX_LEVELS as u16).collect()).is_err());
        assert!(Levels::new((0..MAX_LEVELS as u16).collect()).is_ok());
    }

    #[test]
    fn numbers_become_codes_and_codes_numbers() {
        let levels = Levels::new(vec![7, 20, 65_534]).unwrap();
        let codes = [20, 7, BACKGROUND_CODE, 65_534];
        let mut numbers = levels.numbers(&codes).unwrap().into_owned();
        assert_eq!(numbers, [1, 0, BACKGROUND_CODE, 2]);
        levels.to_codes(&mut numbers);
        assert_eq!(numbers, codes);
        assert_eq!(levels.numbers(&[7, 8, 9]), Err(1));
        let mut beyond = [3, 65_533];
        levels.to_codes(&mut beyond);
        assert_eq!(beyond, [65_534; 2]);
        let mut any = [3, 9];
        Levels::default().to_codes(&mut any);
        assert_eq!(any, [3, 9]);
        assert_eq!(*Levels::default().numbers(&any).unwrap(), any);
    }
}
