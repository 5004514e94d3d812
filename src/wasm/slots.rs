//! Objects that the page knows by numbers.

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

    /// # Panics
    /// If there is no object of this number.
    pub fn get(&self, number: u32) -> &T {
        self.slots[number as usize].as_ref().expect("an object of this number")
    }

    /// # Panics
    /// As [`Self::get`].
    pub fn get_mut(&mut self, number: u32) -> &mut T {
        self.slots[number as usize].as_mut().expect("an object of this number")
    }

    pub fn remove(&mut self, number: u32) {
        self.slots[number as usize] = None;
    }
}
