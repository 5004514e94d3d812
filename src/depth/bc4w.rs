//! stub
use crate::depth::block::*;
use crate::effort::Effort;
/// s
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bc4w([u8; 32]);
impl Bc4w {
    /// s
    pub fn from_bytes(b: [u8; 32]) -> Self {
        Bc4w(b)
    }
    /// s
    pub fn as_bytes(&self) -> &[u8; 32] {
        &self.0
    }
    /// s
    pub fn decode(&self, _t: &mut BlockMut<'_>) {}
}
/// s
pub fn encode(_b: &Block<'_>, _e: Effort) -> (Bc4w, Accuracy) {
    (Bc4w([0; 32]), Accuracy { max_error: 0, squared_error: 0 })
}
/// s
pub fn encode_within(_b: &Block<'_>, _bound: u16, _e: Effort) -> Option<(Bc4w, Accuracy)> {
    None
}
