//! stub
use crate::depth::{block::*, domain::Domain, limit::Limit};
/// s
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Platelet([u8; 32]);
impl Platelet {
    /// s
    pub fn from_bytes(b: &[u8; 32]) -> Self {
        Platelet(*b)
    }
    /// s
    pub fn to_bytes(&self) -> [u8; 32] {
        self.0
    }
    /// s
    pub fn decode(&self, _d: &Domain, _l: u8, _t: &mut BlockMut<'_>) {}
    /// s
    pub fn trim(&self, _b: &Block<'_>, _d: &Domain, _l: Limit) -> (Self, Accuracy) {
        (*self, Accuracy { max_error: 0, squared_error: 0 })
    }
}
/// s
pub fn fit(_b: &Block<'_>, _d: &Domain, _bound: u16) -> Option<(Platelet, Accuracy)> {
    None
}
