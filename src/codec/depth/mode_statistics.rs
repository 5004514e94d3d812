//! Counts nodes by level and function.

use crate::depth::nodes::{Function, Grid, Node};
use crate::depth::runtime::LEVELS;
use crate::depth::storage::stored_bytes;

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Share {
    pub nodes: u64,
    pub pixels: u64,
    /// Bytes of the functions in the storage form, without the walk, which all nodes share.
    pub bytes: u64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ModeStatistics {
    shares: [[Share; 4]; LEVELS],
}

impl Share {
    fn add(&mut self, other: Share) {
        self.nodes += other.nodes;
        self.pixels += other.pixels;
        self.bytes += other.bytes;
    }
}

impl ModeStatistics {
    pub fn count(&mut self, grid: Grid, node: &Node) {
        let share = Share { nodes: 1, pixels: grid.pixels_of(node.place), bytes: stored_bytes(node) as u64 };
        self.add_share(node.place.level, node.function(), share);
    }

    pub fn add_share(&mut self, level: u8, function: Function, share: Share) {
        self.shares[usize::from(level)][function as usize].add(share);
    }

    pub fn add(&mut self, other: &ModeStatistics) {
        for (row, other) in self.shares.iter_mut().zip(&other.shares) {
            row.iter_mut().zip(other).for_each(|(share, other)| share.add(*other));
        }
    }

    pub fn share(&self, level: u8, function: Function) -> Share {
        self.shares.get(usize::from(level)).map_or(Share::default(), |row| row[function as usize])
    }

    pub fn of(&self, function: Function) -> Share {
        let mut sum = Share::default();
        self.shares.iter().for_each(|row| sum.add(row[function as usize]));
        sum
    }

    /// Returns the levels that have nodes, finest first.
    pub fn levels(&self) -> impl Iterator<Item = u8> {
        (0..LEVELS as u8).filter(|&level| self.shares[usize::from(level)].iter().any(|share| share.nodes > 0))
    }

    pub fn is_empty(&self) -> bool {
        self.levels().next().is_none()
    }
}
