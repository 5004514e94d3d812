//! stub
use crate::depth::{block::*, domain::Domain, limit::Limit};
/// s
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Biquadratic {
    /// s
    pub coefficients: [i32; 6],
}
/// s
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Order {
    /// s
    Constant,
    /// s
    Plane,
    /// s
    Full,
}
impl Biquadratic {
    /// s
    pub fn from_bytes(b: &[u8; 32]) -> Self {
        let mut c = [0; 6];
        for i in 0..6 {
            c[i] = i32::from_le_bytes([b[4 * i], b[4 * i + 1], b[4 * i + 2], b[4 * i + 3]])
        }
        Biquadratic { coefficients: c }
    }
    /// s
    pub fn to_bytes(&self) -> [u8; 32] {
        let mut o = [0xff; 32];
        for i in 0..6 {
            o[4 * i..4 * i + 4].copy_from_slice(&self.coefficients[i].to_le_bytes())
        }
        o
    }
    /// s
    pub fn decode(&self, _d: &Domain, t: &mut BlockMut<'_>) {
        let v = ((self.coefficients[5] + 8192) >> 14).clamp(0, 65535) as u16;
        for r in t.rows_mut() {
            r.fill(v)
        }
    }
    /// s
    pub fn trim(&self, _b: &Block<'_>, _d: &Domain, _l: Limit) -> (Self, Accuracy) {
        (*self, Accuracy { max_error: 0, squared_error: 0 })
    }
}
/// s
pub fn fit(b: &Block<'_>, _d: &Domain, bound: u16, _o: Order) -> Option<(Biquadratic, Accuracy)> {
    let v = b.row(0)[0];
    let dec = vec![v; b.pixel_count()];
    let a = b.accuracy(&dec)?;
    (a.max_error <= bound).then(|| {
        (Biquadratic { coefficients: [0, 0, 0, 0, 0, if v == 65535 { 1 << 30 } else { i32::from(v) << 14 }] }, a)
    })
}
