//! Values of a JSON document with their paths, such as `view_groups[0].views[2]`, for errors and notes.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use codec::error::{Error, Result, escaped};

/// Maximum characters of an unknown key in a note.
const KEY_CHARACTERS: usize = 60;
/// Maximum number of notes that are listed; further ones are only counted.
const MAX_NOTES: usize = 20;

/// Notes about a document, with the number of occurrences of each.
#[derive(Debug, Default)]
pub struct Notes(BTreeMap<String, usize>);

impl Notes {
    /// Counts an occurrence of a note. Notes contain no indices, so that equal ones are merged.
    pub fn add(&mut self, what: String) {
        *self.0.entry(what).or_default() += 1;
    }

    pub fn lines(&self) -> Vec<String> {
        let line = |(what, &count): (&String, &usize)| match count {
            1 => what.clone(),
            count => format!("{what} ({count} times)"),
        };
        let mut lines: Vec<String> = self.0.iter().take(MAX_NOTES).map(line).collect();
        if self.0.len() > MAX_NOTES {
            lines.push(format!("and {} more notes", self.0.len() - MAX_NOTES));
        }
        lines
    }
}

/// A value and its path.
pub struct Node<'a> {
    value: &'a Value,
    /// Path of the value; empty for the whole document.
    path: String,
}

impl<'a> Node<'a> {
    pub fn root(value: &'a Value) -> Node<'a> {
        Node { value, path: String::new() }
    }

    pub fn path(&self) -> &str {
        &self.path
    }

    /// Creates an error about this value.
    pub fn fault(&self, message: impl std::fmt::Display) -> Error {
        let place = if self.path.is_empty() { "the document" } else { &self.path };
        Error::invalid(format!("{place}: {message}"))
    }

    /// Returns the path without list indices.
    pub fn kind(&self) -> String {
        let parts = self.path.split('[').map(|part| part.split_once(']').map_or(part, |(_, behind)| behind));
        parts.collect::<Vec<_>>().join("[]")
    }

    /// Creates an error that states what was expected and what was found.
    pub fn expected(&self, what: &str) -> Error {
        let found = match self.value {
            Value::Null => "null".to_owned(),
            Value::Bool(value) => value.to_string(),
            Value::Number(value) => value.to_string(),
            Value::String(text) => format!("the text \"{}\"", shortened(text)),
            Value::Array(list) => format!("a list of {}", list.len()),
            Value::Object(_) => "an object".to_owned(),
        };
        self.fault(format!("{what} was expected, not {found}"))
    }

    fn map(&self) -> Result<&'a Map<String, Value>> {
        self.value.as_object().ok_or_else(|| self.expected("an object"))
    }

    /// Adds a note for each key that is not `known`.
    pub fn note_unknown(&self, known: &[&str], notes: &mut Notes) -> Result<()> {
        for key in self.map()?.keys().filter(|key| !known.contains(&key.as_str())) {
            let key = shortened(key);
            let kind = self.kind();
            notes.add(if kind.is_empty() { format!("{key} is not read") } else { format!("{kind}.{key} is not read") });
        }
        Ok(())
    }

    /// Returns the value of a key; `None` if it is absent or null.
    pub fn get(&self, key: &str) -> Result<Option<Node<'a>>> {
        let value = self.map()?.get(key).filter(|value| !value.is_null());
        let path = if self.path.is_empty() { key.to_owned() } else { format!("{}.{key}", self.path) };
        Ok(value.map(|value| Node { value, path }))
    }

    pub fn need(&self, key: &str) -> Result<Node<'a>> {
        self.get(key)?.ok_or_else(|| self.fault(format!("the key \"{key}\" is missing")))
    }

    pub fn list(&self) -> Result<impl ExactSizeIterator<Item = Node<'a>>> {
        let values = self.value.as_array().ok_or_else(|| self.expected("a list"))?;
        let path = self.path.clone();
        Ok(values.iter().enumerate().map(move |(at, value)| Node { value, path: format!("{path}[{at}]") }))
    }

    /// Returns a list of exactly `N` numbers.
    pub fn numbers<const N: usize>(&self) -> Result<[f64; N]> {
        let list = self.value.as_array().filter(|list| list.len() == N);
        if list.is_none() {
            return Err(self.expected(&format!("a list of {N} numbers")));
        }
        let mut numbers = [0.0; N];
        for (number, node) in numbers.iter_mut().zip(self.list()?) {
            *number = node.value.as_f64().ok_or_else(|| node.expected("a number"))?;
        }
        Ok(numbers)
    }

    /// Returns an integer from 1 to `most`.
    pub fn count(&self, most: u32) -> Result<u32> {
        let number = self.value.as_f64().filter(|number| number.fract() == 0.0);
        let in_range = number.filter(|number| (1.0..=f64::from(most)).contains(number));
        in_range.map(|number| number as u32).ok_or_else(|| self.expected(&format!("a whole number of 1 to {most}")))
    }

    pub fn text(&self) -> Result<&'a str> {
        self.value.as_str().ok_or_else(|| self.expected("a text"))
    }
}

fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(KEY_CHARACTERS).collect();
    if short.len() < text.len() {
        short.push('…');
    }
    escaped(&short)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn errors_name_the_path_and_notes_the_kind() {
        let value = json!({"a": [{"b": [1, 2], "x": 0}, {"b": "text", "x": 1, "y\n": 2}]});
        let root = Node::root(&value);
        let items: Vec<Node<'_>> = root.need("a").unwrap().list().unwrap().collect();
        assert_eq!(items[0].need("b").unwrap().numbers::<2>().unwrap(), [1.0, 2.0]);
        let said = |result: Result<[f64; 2]>| result.unwrap_err().to_string();
        assert_eq!(
            said(items[1].need("b").unwrap().numbers::<2>()),
            "a[1].b: a list of 2 numbers was expected, not the text \"text\""
        );
        assert_eq!(said(items[0].need("c").map(|_| [0.0; 2])), "a[0]: the key \"c\" is missing");
        assert_eq!(said(root.need("c").map(|_| [0.0; 2])), "the document: the key \"c\" is missing");
        let mut notes = Notes::default();
        for item in &items {
            item.note_unknown(&["b"], &mut notes).unwrap();
        }
        assert_eq!(notes.lines(), ["a[].x is not read (2 times)", "a[].y\\n is not read"]);
    }

    #[test]
    fn many_notes_are_counted() {
        let mut notes = Notes::default();
        (0..25).for_each(|at| notes.add(format!("{at:02}")));
        assert_eq!(notes.lines().len(), MAX_NOTES + 1);
        assert_eq!(notes.lines().last().unwrap(), "and 5 more notes");
    }

    #[test]
    fn counts_are_whole_and_in_range() {
        let value = json!([1, 2.0, 7, 8, 0, -1, 1.5, "2", 1e300]);
        let counts: Vec<Option<u32>> = Node::root(&value).list().unwrap().map(|node| node.count(7).ok()).collect();
        assert_eq!(counts, [Some(1), Some(2), Some(7), None, None, None, None, None, None]);
    }
}
