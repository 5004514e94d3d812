//! The view with which a film opens (formats/manifest.md 2.7).
//!
//! Takes an open container; nothing is decoded: the stored bytes of units measure how much structure a direction shows. Returns
//! the camera that the container states, or else one at a probe.

use glam::{DQuat, DVec3, Vec3};

use codec::container::ProbeEntry;
use codec::decode::{Decoder, StreamInfo};
use codec::image::texel_map::PlanarPoint;
use codec::image::{Face, StreamKind, TexelMap};
use codec::math::camera::rotation;
use codec::streams::StartView;

const FOV_Y_DEG: f64 = 60.0;
/// Headings of cube maps, evenly spaced, and pitches in degrees, each with the factor by which the structure of its picture must
/// exceed that of a level one.
const HEADINGS: u32 = 12;
const PITCHES: [(f64, f64); 3] = [(0.0, 1.0), (-15.0, 1.2), (-30.0, 2.0)];
/// Width over height of the pictures that are compared, and rays of each along its sides.
const ASPECT: f64 = 16.0 / 9.0;
const RAYS: [u32; 2] = [32, 18];
/// Factor by which the structure of another direction must exceed that of the probe's own heading.
const MIN_GAIN: f64 = 1.1;

/// Returns the view with which players open a film; `None` if no probe has a face with depth and colour.
pub fn start_view(decoder: &Decoder) -> Option<StartView> {
    if let Some(stated) = decoder.footage().view {
        return Some(stated);
    }
    let (at, probe) = middle_probe(decoder)?;
    let eye = DVec3::from_array(probe.position);
    let turn = rotation(probe.orientation)?;
    let own = turn * DVec3::NEG_Z;
    let streams: Vec<&StreamInfo> = decoder.streams().iter().filter(|stream| stream.probe == at).collect();
    let forward = match streams.iter().any(|stream| stream.face == Face::View) {
        true => own,
        false => richest_direction(decoder, &streams, turn),
    };
    let look_at = eye + forward;
    Some(StartView { eye: eye.to_array(), look_at: look_at.to_array(), fov_y_deg: FOV_Y_DEG })
}

/// Returns the probe with depth and colour nearest to the middle of the box of all such probes, as it stands in its first frame.
fn middle_probe(decoder: &Decoder) -> Option<(usize, ProbeEntry)> {
    let streams = decoder.streams();
    let has_color = |depth: &StreamInfo| {
        streams
            .iter()
            .any(|other| (other.probe, other.face, other.kind) == (depth.probe, depth.face, StreamKind::Color))
    };
    let first = streams.iter().map(|stream| stream.frames.first).min()?;
    let mut probes: Vec<(usize, ProbeEntry)> = Vec::new();
    for depth in streams.iter().filter(|stream| stream.kind == StreamKind::Depth && has_color(stream)) {
        if probes.iter().all(|(at, _)| *at != depth.probe) {
            probes.push((depth.probe, decoder.probe_at(depth.probe, first)));
        }
    }
    let positions = || probes.iter().map(|(_, probe)| DVec3::from_array(probe.position));
    let middle = (positions().reduce(DVec3::min)? + positions().reduce(DVec3::max)?) / 2.0;
    let away = |probe: &ProbeEntry| DVec3::from_array(probe.position).distance_squared(middle);
    probes.into_iter().min_by(|(_, a), (_, b)| away(a).total_cmp(&away(b)))
}

/// Returns the direction with the most structure; level along the probe's own heading if none has more.
fn richest_direction(decoder: &Decoder, streams: &[&StreamInfo], turn: DQuat) -> DVec3 {
    let own = turn * DVec3::NEG_Z;
    let own_yaw = f64::atan2(-own.x, -own.z);
    let densities = [StreamKind::Depth, StreamKind::Color].map(|kind| Densities::new(decoder, streams, kind));
    let structure = |axes: [DVec3; 3]| {
        let to_probe = turn.inverse();
        let sum = |density: &Densities<'_>| rays(axes).map(|ray| density.at((to_probe * ray).as_vec3())).sum::<f64>();
        let [depth, color] = densities.each_ref().map(sum);
        depth * color
    };
    let ahead = axes(own_yaw, 0.0);
    let mut best = (ahead[0], structure(ahead) * MIN_GAIN);
    for (pitch_deg, factor) in PITCHES {
        for step in 0..HEADINGS {
            let yaw = own_yaw + std::f64::consts::TAU * f64::from(step) / f64::from(HEADINGS);
            let axes = axes(yaw, pitch_deg.to_radians());
            let found = structure(axes) / factor;
            if found > best.1 {
                best = (axes[0], found);
            }
        }
    }
    best.0
}

/// Returns forward, right and up of an upright picture; angles in radians.
fn axes(yaw: f64, pitch: f64) -> [DVec3; 3] {
    let forward = DVec3::new(-yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos());
    let right = DVec3::new(yaw.cos(), 0.0, -yaw.sin());
    [forward, right, right.cross(forward)]
}

/// Returns the rays of a picture, of any length.
fn rays([forward, right, up]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
    let half = (FOV_Y_DEG.to_radians() / 2.0).tan();
    let part = |at: u32, of: u32| (f64::from(at) + 0.5) / f64::from(of) * 2.0 - 1.0;
    (0..RAYS[1]).flat_map(move |row| {
        let ray = forward - up * part(row, RAYS[1]) * half;
        (0..RAYS[0]).map(move |column| ray + right * part(column, RAYS[0]) * half * ASPECT)
    })
}

/// Stored bytes per pixel of a probe's images of one kind, in their first frame.
struct Densities<'a> {
    /// By the index of the face: the stream, and the values of its units.
    faces: [Option<(&'a StreamInfo, Vec<f64>)>; 7],
}

impl<'a> Densities<'a> {
    fn new(decoder: &Decoder, streams: &[&'a StreamInfo], kind: StreamKind) -> Densities<'a> {
        let mut faces = [const { None }; 7];
        for &stream in streams.iter().filter(|stream| stream.kind == kind) {
            let index = decoder.reader().index();
            let density = |unit: u32| {
                let bytes = index.unit_chunks(stream.index, unit).first().map_or(0, |chunk| chunk.stored_bytes);
                let [_, _, width, height] = stream.entry.unit_rect(unit);
                f64::from(bytes) / (f64::from(width) * f64::from(height))
            };
            let values = (0..stream.entry.unit_count()).map(density).collect();
            faces[stream.face as usize] = Some((stream, values));
        }
        Densities { faces }
    }

    /// Returns the value in a direction in the probe's axes; 0 where it has no image.
    fn at(&self, direction: Vec3) -> f64 {
        let point = PlanarPoint::on_cube(direction);
        let Some((stream, values)) = &self.faces[point.face] else { return 0.0 };
        let entry = &stream.entry;
        let at = TexelMap::cube_face([entry.width, entry.height]).position(point.plane);
        // Casts saturate at 0.
        let column = (at[0] as u32).min(entry.width - 1) / entry.unit_width;
        let row = (at[1] as u32).min(entry.height - 1) / entry.unit_height;
        values[(row * entry.grid()[0] + column) as usize]
    }
}
