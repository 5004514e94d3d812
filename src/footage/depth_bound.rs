//! Maximum error of decoded depth as it is reported: in percent of the distance, and in metres at some distances.

use std::collections::BTreeMap;

use serde::ser::SerializeStruct;
use serde::{Serialize, Serializer};

use crate::json::Number;
use codec::depth::DepthRange;
use codec::streams::DepthHeader;

/// Distances at which the error is reported in metres.
pub const STATED_DISTANCES_M: [f32; 3] = [1.0, 10.0, 100.0];

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DepthBound {
    pub range: DepthRange,
    /// Maximum error in codes; `None` without a bound.
    pub codes: Option<u16>,
}

impl DepthBound {
    pub fn of(header: &DepthHeader) -> DepthBound {
        DepthBound { range: header.range, codes: header.error_bound() }
    }

    /// Maximum error relative to the distance; `None` without a bound.
    pub fn share(&self) -> Option<f64> {
        self.codes.map(|codes| self.range.relative_error(codes))
    }

    /// Maximum error in metres of a surface at this distance; `None` outside near and far, and without a bound.
    pub fn metres_at(&self, distance_m: f32) -> Option<f64> {
        let is_within = (self.range.near_m()..=self.range.far_m()).contains(&distance_m);
        self.share().filter(|_| is_within).map(|share| share * f64::from(distance_m))
    }

    pub fn percent(&self) -> Option<f64> {
        self.share().map(|share| 100.0 * share)
    }

    /// Maximum error in metres by the keys `at_1_m` and so on.
    pub fn metres(&self) -> BTreeMap<String, Option<f64>> {
        STATED_DISTANCES_M.into_iter().map(|distance| (format!("at_{distance}_m"), self.metres_at(distance))).collect()
    }
}

impl Serialize for DepthBound {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut fields = serializer.serialize_struct("DepthBound", 5)?;
        fields.serialize_field("near_m", &Number::shortest(self.range.near_m()))?;
        fields.serialize_field("far_m", &Number::shortest(self.range.far_m()))?;
        fields.serialize_field("error_bound_codes", &self.codes)?;
        fields.serialize_field("max_error_percent", &self.percent())?;
        fields.serialize_field("max_error_m", &self.metres())?;
        fields.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_in_metres_are_those_within_the_range() {
        let of = |near, far, codes| DepthBound { range: DepthRange::new(near, far).unwrap(), codes };
        let bound = of(1.0, 50.0, Some(100));
        let share = bound.share().unwrap();
        assert!((share - 0.006).abs() < 1e-4, "{share}");
        assert_eq!(bound.metres_at(10.0), Some(10.0 * share));
        assert_eq!([1.0, 50.0, 100.0, 0.5].map(|z| bound.metres_at(z).is_some()), [true, true, false, false]);
        assert_eq!(of(1.0, 50.0, None).metres_at(10.0), None);
        let json = serde_json::to_value(bound).unwrap();
        assert_eq!(
            (&json["max_error_m"]["at_100_m"], &json["error_bound_codes"]),
            (&serde_json::Value::Null, &100.into())
        );
    }
}
