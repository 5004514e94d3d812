//! Attributes of a container (container.md 6.3): named byte strings after the chunk table, which readers may ignore.

use crate::container::fields::Fields;
use crate::error::Result;

/// Maximum length of a name in bytes.
pub const MAX_NAME_BYTES: usize = 64;

/// Named byte strings, sorted by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Attributes(Vec<(String, Vec<u8>)>);

impl Attributes {
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub fn iter(&self) -> impl Iterator<Item = (&str, &[u8])> {
        self.0.iter().map(|(name, value)| (name.as_str(), value.as_slice()))
    }

    pub fn get(&self, name: &str) -> Option<&[u8]> {
        self.place(name).ok().map(|at| self.0[at].1.as_slice())
    }

    /// Adds an attribute, or replaces the value of an existing one.
    pub fn set(&mut self, name: &str, value: Vec<u8>) {
        match self.place(name) {
            Ok(at) => self.0[at].1 = value,
            Err(at) => self.0.insert(at, (name.to_owned(), value)),
        }
    }

    fn place(&self, name: &str) -> std::result::Result<usize, usize> {
        self.0.binary_search_by(|(known, _)| known.as_str().cmp(name))
    }

    /// Reads the attributes, which fill the rest of an index.
    pub(super) fn read(fields: &mut Fields<'_>) -> Result<Attributes> {
        fields.enter("container.md 6.3");
        let mut attributes: Vec<(String, Vec<u8>)> = Vec::new();
        while fields.remaining() > 0 {
            let start = fields.offset();
            let name = fields.string("an attribute's name")?;
            if !is_name(&name) {
                return Err(fields.error_at(start, format!("{name:?} is not an attribute name")));
            }
            if attributes.last().is_some_and(|(before, _)| *before >= name) {
                return Err(fields.error_at(start, format!("the attribute {name} does not ascend by name")));
            }
            let bytes = fields.varint_u32()?;
            attributes.push((name, fields.bytes(bytes as usize)?.to_vec()));
        }
        Ok(Attributes(attributes))
    }
}

/// True if a name consists of 1 to 64 lower-case letters, digits, `_` and `.`.
pub fn is_name(name: &str) -> bool {
    let plain = |byte: u8| byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_' || byte == b'.';
    (1..=MAX_NAME_BYTES).contains(&name.len()) && name.bytes().all(plain)
}

#[cfg(feature = "encode")]
#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Attributes {
        let mut attributes = Attributes::default();
        for (name, value) in [("b.c", &b"two"[..]), ("a_1", b""), ("b", b"one")] {
            attributes.set(name, value.to_vec());
        }
        attributes
    }

    #[test]
    fn attributes_come_back_in_the_order_of_their_names() {
        let mut bytes = Vec::new();
        sample().write(&mut bytes).unwrap();
        let mut fields = Fields::new(&bytes, 0, "");
        let read = Attributes::read(&mut fields).unwrap();
        fields.finish().unwrap();
        assert_eq!(read, sample());
        assert_eq!(read.iter().map(|(name, _)| name).collect::<Vec<_>>(), ["a_1", "b", "b.c"]);
        assert_eq!((read.get("b"), read.get("c")), (Some(&b"one"[..]), None));
        // A cut behind a row leaves the rows before; they have 6, 7 and 9 bytes.
        assert_eq!(bytes.len(), 22);
        for length in 0..bytes.len() {
            let left = [0, 6, 13].iter().position(|&end| end == length);
            let read = Attributes::read(&mut Fields::new(&bytes[..length], 0, ""));
            assert_eq!(read.ok().map(|read| read.iter().count()), left, "{length}");
        }
    }

    #[test]
    fn names_that_are_illegal_or_out_of_order_are_refused() {
        for (names, words) in [
            (["b", "a"], "does not ascend"),
            (["a", "a"], "does not ascend"),
            (["A", "b"], "not an attribute name"),
            (["", "bb"], "not an attribute name"),
        ] {
            let unsorted = Attributes(names.map(|name| (name.to_owned(), Vec::new())).to_vec());
            let mut bytes = Vec::new();
            unsorted.write_rows(&mut bytes).unwrap();
            let message = Attributes::read(&mut Fields::new(&bytes, 0, "")).unwrap_err().to_string();
            assert!(message.contains(words), "{message}");
        }
        let mut wrong = sample();
        wrong.set("Ä", Vec::new());
        assert!(wrong.write(&mut Vec::new()).is_err());
    }
}
