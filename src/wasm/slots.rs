//! Objects that the page knows by numbers.

use codec::error::{Error, Result};

pub struct Slots<T> {
    slots: Vec<Option<T>>,
}

impl<T> Slots<T> {
    pub const fn new() -> Slots<T> {
        Slots { slots: Vec::new() }
    }

    /// Returns the number of a new object: the lowest that is free.
    pub fn insert(&mut self, object: T) -> i32 {
        let free = self.slots.iter().position(Option::is_none).unwrap_or(self.slots.len());
        match self.slots.get_mut(free) {
            Some(slot) => *slot = Some(object),
            None => self.slots.push(Some(object)),
        }
        free as i32
    }

    pub fn get(&self, number: u32) -> Result<&T> {
        self.slots.get(number as usize).and_then(Option::as_ref).ok_or_else(|| missing(number))
    }

    pub fn get_mut(&mut self, number: u32) -> Result<&mut T> {
        self.slots.get_mut(number as usize).and_then(Option::as_mut).ok_or_else(|| missing(number))
    }

    pub fn remove(&mut self, number: u32) {
        if let Some(slot) = self.slots.get_mut(number as usize) {
            *slot = None;
        }
    }
}

fn missing(number: u32) -> Error {
    Error::Usage(format!("there is no object of number {number}"))
}
