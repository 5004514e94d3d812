//! Keyframe animation of nodes (glTF 2.0, sections 3.11 and 5.4, appendix C). Before the first key and after the last one, the
//! value of that key holds.

use glam::{DQuat, DVec3};
use gltf::json;
use gltf::json::animation::{Interpolation, Property};
use gltf::json::validation::Checked;

use crate::mesh::gltf::buffers::Buffers;
use crate::mesh::gltf::nodes::{Pose, quaternion};
use codec::error::{Error, Result};

#[derive(Debug, Clone)]
pub struct Curve {
    /// Key times in seconds, non-decreasing; at least one.
    times: Vec<f32>,
    /// The value of each key; for a cubic spline the in-tangent, value and out-tangent.
    values: Vec<f32>,
    /// Number of components of a value.
    width: usize,
    interpolation: Interpolation,
}

#[derive(Debug, Clone)]
pub struct Channel {
    pub node: usize,
    pub property: Property,
    pub curve: Curve,
}

#[derive(Debug, Clone, Default)]
pub struct Animation {
    /// If two channels animate the same property, the later one applies.
    pub channels: Vec<Channel>,
    /// Time of the last key, seconds.
    pub duration_s: f64,
}

impl Animation {
    pub fn read(animation: &json::Animation, node_count: usize, buffers: &mut Buffers) -> Result<Animation> {
        let mut read = Animation::default();
        for (number, channel) in animation.channels.iter().enumerate() {
            let context = |error: Error| error.context(format!("channel {number}"));
            let Checked::Valid(property) = channel.target.path else {
                return Err(context(Error::invalid("it animates an unknown property")));
            };
            let node = channel.target.node.value();
            if node >= node_count {
                return Err(context(Error::invalid(format!("it animates node {node}, which does not exist"))));
            }
            let sampler = animation.samplers.get(channel.sampler.value());
            let sampler = sampler.ok_or_else(|| context(Error::invalid("it has no sampler")))?;
            let curve = Curve::read(sampler, property, buffers).map_err(context)?;
            read.duration_s = read.duration_s.max(curve.times.last().map_or(0.0, |&time| f64::from(time)));
            read.channels.push(Channel { node, property, curve });
        }
        Ok(read)
    }
}

impl Channel {
    /// Returns the times of the first and the last key, seconds.
    pub fn ends_s(&self) -> [f64; 2] {
        [self.curve.times.first(), self.curve.times.last()].map(|time| time.map_or(0.0, |&time| f64::from(time)))
    }

    pub fn is_constant(&self) -> bool {
        let Curve { values, width, interpolation, .. } = &self.curve;
        let keys = values.chunks_exact(self.curve.stride());
        match interpolation {
            Interpolation::CubicSpline => {
                let value = |key: &[f32]| key[*width..2 * width].to_vec();
                let flat = |key: &[f32]| key[..*width].iter().chain(&key[2 * width..]).all(|&slope| slope == 0.0);
                keys.clone().all(flat) && keys.clone().map(value).is_sorted_by(|one, other| one == other)
            }
            _ => keys.is_sorted_by(|one, other| one == other),
        }
    }

    pub fn move_pose(&self, time_s: f64, pose: &mut Pose) {
        let vector = || DVec3::from_slice(&self.curve.at(time_s));
        match self.property {
            Property::Translation => pose.translation = vector(),
            Property::Scale => pose.scale = vector(),
            Property::Rotation => pose.rotation = self.curve.rotation(time_s),
            Property::MorphTargetWeights => {}
        }
    }
}

/// Position of a time relative to the keys.
enum Span {
    /// At a key, before the first key, or after the last one.
    Key(usize),
    /// After this key, by this fraction of an interval of this many seconds.
    Between(usize, f64, f64),
}

impl Curve {
    fn read(sampler: &json::animation::Sampler, property: Property, buffers: &mut Buffers) -> Result<Curve> {
        let Checked::Valid(interpolation) = sampler.interpolation else {
            return Err(Error::invalid("its interpolation is unknown"));
        };
        let times: Vec<f32> = buffers.floats::<1>(sampler.input.value())?.into_iter().flatten().collect();
        let output = sampler.output.value();
        let parts = if interpolation == Interpolation::CubicSpline { 3 } else { 1 };
        let (values, width) = match property {
            Property::Rotation => (buffers.floats::<4>(output)?.into_flattened(), 4),
            Property::Translation | Property::Scale => (buffers.floats::<3>(output)?.into_flattened(), 3),
            Property::MorphTargetWeights => {
                let values = buffers.floats::<1>(output)?.into_flattened();
                let width = values.len() / (parts * times.len().max(1));
                (values, width)
            }
        };
        if times.is_empty() || !times.iter().all(|time| time.is_finite()) || !times.is_sorted() {
            return Err(Error::invalid("its times do not increase"));
        }
        if width == 0 || values.len() != parts * times.len() * width {
            return Err(Error::invalid(format!("{} numbers for {} keys", values.len(), times.len())));
        }
        Ok(Curve { times, values, width, interpolation })
    }

    /// Returns the number of components per key, including tangents.
    fn stride(&self) -> usize {
        if self.interpolation == Interpolation::CubicSpline { 3 * self.width } else { self.width }
    }

    fn span(&self, time_s: f64) -> Span {
        let behind = self.times.partition_point(|&time| f64::from(time) <= time_s);
        if behind == 0 {
            return Span::Key(0);
        }
        let key = behind - 1;
        let (Some(&next), false) = (self.times.get(behind), self.interpolation == Interpolation::Step) else {
            return Span::Key(key);
        };
        // The next key is later than `time_s`, so the interval is not empty.
        let start = f64::from(self.times[key]);
        let length = f64::from(next) - start;
        Span::Between(key, (time_s - start) / length, length)
    }

    fn part(&self, key: usize, part: usize) -> impl Iterator<Item = f64> {
        let at = key * self.stride() + part * self.width;
        self.values[at..at + self.width].iter().map(|&value| f64::from(value))
    }

    fn value(&self, key: usize) -> impl Iterator<Item = f64> {
        self.part(key, usize::from(self.interpolation == Interpolation::CubicSpline))
    }

    /// Interpolates each component separately.
    pub fn at(&self, time_s: f64) -> Vec<f64> {
        match self.span(time_s) {
            Span::Key(key) => self.value(key).collect(),
            Span::Between(key, t, seconds) if self.interpolation == Interpolation::CubicSpline => {
                let (t2, t3) = (t * t, t * t * t);
                let from = self.value(key).zip(self.part(key, 2));
                let to = self.value(key + 1).zip(self.part(key + 1, 0));
                from.zip(to)
                    .map(|((from, out), (to, into))| {
                        (2.0 * t3 - 3.0 * t2 + 1.0) * from
                            + seconds * (t3 - 2.0 * t2 + t) * out
                            + (3.0 * t2 - 2.0 * t3) * to
                            + seconds * (t3 - t2) * into
                    })
                    .collect()
            }
            Span::Between(key, t, _) => {
                self.value(key).zip(self.value(key + 1)).map(|(from, to)| from + t * (to - from)).collect()
            }
        }
    }

    fn rotation(&self, time_s: f64) -> DQuat {
        let read = |value: Vec<f64>| quaternion([value[0], value[1], value[2], value[3]]);
        match self.span(time_s) {
            Span::Between(key, t, _) if self.interpolation == Interpolation::Linear => {
                let [from, to] = [key, key + 1].map(|key| read(self.value(key).collect()));
                // `slerp` takes the shorter arc.
                from.slerp(to, t).normalize()
            }
            _ => read(self.at(time_s)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(interpolation: Interpolation, width: usize, times: &[f32], values: &[f32]) -> Curve {
        Curve { times: times.to_vec(), values: values.to_vec(), width, interpolation }
    }

    #[test]
    fn values_between_keys_are_what_the_interpolation_says() {
        let times = [1.0, 2.0, 4.0];
        let step = curve(Interpolation::Step, 1, &times, &[3.0, 5.0, 9.0]);
        let linear = curve(Interpolation::Linear, 1, &times, &[3.0, 5.0, 9.0]);
        // With slopes of 2, a spline through points of one line equals that line.
        let spline = curve(Interpolation::CubicSpline, 1, &times, &[7.0, 3.0, 2.0, 2.0, 5.0, 2.0, 2.0, 9.0, 7.0]);
        let cases =
            [(0.0, 3.0, 3.0), (1.0, 3.0, 3.0), (1.5, 3.0, 4.0), (2.0, 5.0, 5.0), (3.0, 5.0, 7.0), (9.0, 9.0, 9.0)];
        for (time, stepped, between) in cases {
            assert_eq!(step.at(time), [stepped], "{time}");
            assert_eq!(linear.at(time), [between], "{time}");
            assert_eq!(spline.at(time), [between], "{time}");
        }
        // Analytically: from 0 to 1 with zero tangents, the value at a quarter is 3/16 − 2/64.
        let eased = curve(Interpolation::CubicSpline, 1, &[0.0, 2.0], &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        assert_eq!(eased.at(0.5), [0.156_25]);
        // An out-tangent of 4 over two seconds adds 2 · 4 · (1/64 − 2/16 + 1/4).
        let thrown = curve(Interpolation::CubicSpline, 1, &[0.0, 2.0], &[0.0, 0.0, 4.0, 0.0, 1.0, 0.0]);
        assert_eq!(thrown.at(0.5), [0.156_25 + 8.0 * 0.140_625]);
    }

    #[test]
    fn rotations_turn_evenly_the_shorter_way() {
        let half = std::f32::consts::FRAC_1_SQRT_2;
        // A quarter turn about y, with both signs of the quaternion, which are the same rotation.
        for sign in [1.0, -1.0] {
            let quarter = [0.0, sign * half, 0.0, sign * half];
            let values = [[0.0, 0.0, 0.0, 1.0], quarter].concat();
            let turning = curve(Interpolation::Linear, 4, &[0.0, 3.0], &values);
            let turned = turning.rotation(1.0) * DVec3::X;
            let angle = 30f64.to_radians();
            assert!((turned - DVec3::new(angle.cos(), 0.0, -angle.sin())).length() < 1e-7, "{turned}");
        }
    }

    #[test]
    fn keys_at_one_time_are_a_jump() {
        let jump = curve(Interpolation::Linear, 1, &[0.0, 1.0, 1.0, 2.0], &[0.0, 1.0, 5.0, 6.0]);
        assert_eq!([jump.at(0.5), jump.at(1.0), jump.at(1.5)], [[0.5], [5.0], [5.5]]);
    }

    #[test]
    fn what_stays_is_constant() {
        let channel = |interpolation: Interpolation, values: &[f32]| Channel {
            node: 0,
            property: Property::Scale,
            curve: curve(interpolation, 1, &[0.0, 1.0], values),
        };
        assert!(channel(Interpolation::Linear, &[2.0, 2.0]).is_constant());
        assert!(!channel(Interpolation::Step, &[2.0, 3.0]).is_constant());
        assert!(channel(Interpolation::CubicSpline, &[0.0, 2.0, 0.0, 0.0, 2.0, 0.0]).is_constant());
        assert!(!channel(Interpolation::CubicSpline, &[0.0, 2.0, 1.0, 0.0, 2.0, 0.0]).is_constant());
        assert!(!channel(Interpolation::CubicSpline, &[0.0, 2.0, 0.0, 0.0, 3.0, 0.0]).is_constant());
    }
}
