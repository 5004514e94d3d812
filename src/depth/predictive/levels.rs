//! Surface codes of footage that holds few of them, such as that of a depth sensor: pixels are coded by number (depth.md 15.2).

#[cfg(feature = "encode")]
use std::borrow::Cow;
use std::sync::Arc;

use crate::depth::quantise::{BACKGROUND_CODE, FAR_CODE};
use crate::error::{Error, Result};

/// Most levels of a stream.
pub const MAX_LEVELS: usize = 4096;

/// The surface codes that occur in a stream, ascending; none where any may.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Levels(Arc<[u16]>);

impl Levels {
    /// These levels.
    ///
    /// # Errors
    /// No code, more than [`MAX_LEVELS`], codes that do not ascend, or background among them.
    pub fn new(codes: Vec<u16>) -> Result<Levels> {
        if codes.is_empty() || codes.len() > MAX_LEVELS {
            return Err(Error::invalid(format!("{} levels, 1 to {MAX_LEVELS} are legal", codes.len())));
        }
        if let Some(pair) = codes.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(Error::invalid(format!("level {} behind {}, levels ascend", pair[1], pair[0])));
        }
        match codes.last() {
            Some(&last) if last > FAR_CODE => Err(Error::invalid("background as a level")),
            _ => Ok(Levels(codes.into())),
        }
    }

    /// The codes, ascending.
    pub fn codes(&self) -> &[u16] {
        &self.0
    }

    /// Whether any code may occur.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Turns numbers of levels into codes, in place. Numbers beyond the last level mean it; background stays.
    pub fn to_codes(&self, numbers: &mut [u16]) {
        let [.., last] = self.codes() else { return };
        for number in numbers.iter_mut().filter(|number| **number != BACKGROUND_CODE) {
            *number = *self.codes().get(usize::from(*number)).unwrap_or(last);
        }
    }

    /// The number of the level that a code is; of background, itself.
    #[cfg(feature = "encode")]
    fn number(&self, code: u16) -> Option<u16> {
        match self.codes().binary_search(&code) {
            Ok(number) => Some(number as u16),
            Err(_) => (code == BACKGROUND_CODE).then_some(code),
        }
    }

    /// Numbers of the levels that codes are, as the encoder takes them; without levels the codes themselves.
    ///
    /// # Errors
    /// The place of the first code that is neither a level nor background.
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
