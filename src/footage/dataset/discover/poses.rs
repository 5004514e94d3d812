//! Camera poses from the attribute `worldToCamera` of EXR files, and lenses from the attribute `worldToNDC`.
//!
//! Matrices are for row vectors; camera x points right, y up. Camera z is ignored, because some renderers look along +z and
//! others along −z: in a right-handed world the viewing direction is up × right.

use glam::{DMat3, DMat4, DQuat, DVec3};

use super::sequences::Found;
use crate::dataset::manifest::{Pose, Probe};
use crate::image_files::exr;
use codec::error::Result;
use codec::image::{Face, FrameRange, ReadLimits};

/// Returns the pose of a probe, or the poses if it moves, in a [`Probe`] without a name; `None` if the files state none.
pub fn of(files: &Found, face: Face, frames: [u32; 2], limits: &ReadLimits) -> Result<Option<Probe>> {
    let pose = |frame: u32| -> Result<Option<Pose>> {
        let header = exr::read_header(&files.file(frame)?, limits)?;
        Ok(header.world_to_camera.and_then(|matrix| pose(matrix, face, frame)))
    };
    if files.header.as_ref().is_none_or(|header| header.world_to_camera.is_none()) {
        return Ok(None);
    }
    let ends = [frames[0], frames[1]].map(|frame| if files.frames.contains(&frame) { pose(frame) } else { Ok(None) });
    let [Some(first), last] = [ends[0].as_ref().ok().copied().flatten(), ends[1].as_ref().ok().copied().flatten()]
    else {
        return Ok(None);
    };
    let is_still = last.is_none_or(|last| (last.position, last.orientation) == (first.position, first.orientation));
    if is_still {
        let orientation = (first.orientation != [0.0, 0.0, 0.0, 1.0]).then_some(first.orientation);
        return Ok(Some(Probe { position: Some(first.position), orientation, ..Probe::default() }));
    }
    let mut poses = Vec::new();
    for frame in (frames[0]..=frames[1]).filter(|frame| files.frames.contains(frame)) {
        poses.extend(pose(frame)?);
    }
    let is_whole = poses.len() as u64 == FrameRange { first: frames[0], last: frames[1] }.count();
    Ok(is_whole.then(|| Probe { poses, ..Probe::default() }))
}

/// Returns fx, fy, cx, cy in pixels of images of `size`; `None` if the first or last file states none, or the two differ.
pub fn lens(files: &Found, size: (u32, u32), frames: [u32; 2], limits: &ReadLimits) -> Option<[f64; 4]> {
    let of = |frame: u32| {
        let header = exr::read_header(&files.file(frame).ok()?, limits).ok()?;
        intrinsics(header.world_to_camera?, header.world_to_ndc?, [size.0, size.1].map(f64::from))
    };
    let [first, last] = frames.map(of);
    let [first, last] = [first?, last?];
    first.iter().zip(last).all(|(a, b)| (a - b).abs() < 1e-3 * f64::from(size.0.max(size.1))).then_some(first)
}

fn intrinsics(to_camera: [f32; 16], to_ndc: [f32; 16], size: [f64; 2]) -> Option<[f64; 4]> {
    // Read column by column as stored, these row-vector matrices become matrices for column vectors.
    let [to_camera, to_ndc] = [to_camera, to_ndc].map(|matrix| DMat4::from_cols_array(&matrix.map(f64::from)));
    let matrices = match is_transposed(|row, column| to_camera.col(row)[column]) {
        true => [to_camera.transpose(), to_ndc.transpose()],
        false => [to_camera, to_ndc],
    };
    let projection = matrices[1] * matrices[0].inverse();
    // Clip w is a multiple of camera z.
    let weight = projection.z_axis.w;
    let is_perspective = projection.x_axis.w.abs().max(projection.y_axis.w.abs()) < 1e-3 * weight.abs();
    if !is_perspective || !projection.is_finite() {
        return None;
    }
    let centre = [projection.z_axis.x / weight, projection.z_axis.y / weight];
    let (least, span) = match centre {
        [x, y] if x.abs().max(y.abs()) < 0.25 => (-1.0, 2.0),
        [x, y] if (x - 0.5).abs().max((y - 0.5).abs()) < 0.25 => (0.0, 1.0),
        _ => return None,
    };
    let [across, up] = [projection.x_axis.x / weight, projection.y_axis.y / weight];
    let [fx, fy] = [(across, size[0]), (up, size[1])].map(|(scale, pixels)| scale.abs() / span * pixels);
    let [left, bottom] = centre.map(|at| (at - least) / span);
    // With x to the right, NDC y may point up or down.
    let top = if (across > 0.0) == (up > 0.0) { 1.0 - bottom } else { bottom };
    let found = [fx, fy, left * size[0], top * size[1]];
    (found.iter().all(|value| value.is_finite()) && fx > 0.0 && fy > 0.0).then_some(found)
}

/// Returns true if a matrix is for column vectors, as some renderers write it.
fn is_transposed(at: impl Fn(usize, usize) -> f64) -> bool {
    (0..3).all(|axis| at(3, axis) == 0.0) && (0..3).any(|axis| at(axis, 3) != 0.0)
}

fn pose(matrix: [f32; 16], face: Face, frame: u32) -> Option<Pose> {
    let at = |row: usize, column: usize| f64::from(matrix[4 * row + column]);
    let is_transposed = is_transposed(at);
    let at = |row: usize, column: usize| if is_transposed { at(column, row) } else { at(row, column) };
    let axes = [0, 1, 2].map(|column| DVec3::new(at(0, column), at(1, column), at(2, column)));
    let lengths = axes.map(DVec3::length);
    if lengths.iter().any(|length| !(*length > 1e-9 && length.is_finite())) {
        return None;
    }
    let unit = [0, 1, 2].map(|axis| axes[axis] / lengths[axis]);
    let [right, up, _] = unit;
    if right.dot(up).abs() > 1e-3 {
        return None;
    }
    let position: DVec3 = (0..3).map(|axis| -unit[axis] * at(3, axis) / lengths[axis]).sum();
    // Faces may be mirrored, so only the viewing direction and the down axis are used.
    let basis = |forward: DVec3, down: DVec3| DMat3::from_cols(forward, down, forward.cross(down));
    let [forward, _, down] = face.axes();
    let turn = basis(up.cross(right), -up) * basis(forward, down).transpose();
    let orientation = DQuat::from_mat3(&turn).normalize();
    // Rounding in 32-bit matrices would turn the identity into a small rotation.
    let orientation = if orientation.angle_between(DQuat::IDENTITY) < 1e-5 { DQuat::IDENTITY } else { orientation };
    (position.is_finite() && orientation.is_finite()).then(|| Pose {
        frame,
        position: position.to_array(),
        orientation: orientation.to_array(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cameras_of_both_conventions_and_faces() {
        // Camera at (1, 2, 3), looking along -Z with +Y up, then along +X.
        for z in [1.0, -1.0] {
            let along_z = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, z, 0.0, -1.0, -2.0, -3.0 * z, 1.0];
            let found = pose(along_z, Face::View, 7).unwrap();
            assert_eq!(found, Pose { frame: 7, position: [1.0, 2.0, 3.0], orientation: [0.0, 0.0, 0.0, 1.0] });
            let found = pose(along_z, Face::Nz, 7).unwrap();
            assert_eq!((found.position, found.orientation), ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 1.0]));
            // Right is +Z, so that the camera looks along +X.
            let along_x = [0.0, 0.0, -z, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -3.0, -2.0, z, 1.0];
            let found = pose(along_x, Face::View, 7).unwrap();
            assert_eq!(found.position, [1.0, 2.0, 3.0]);
            let forward = DQuat::from_array(found.orientation) * DVec3::NEG_Z;
            assert!((forward - DVec3::X).length() < 1e-9, "{forward}");
            assert_eq!(pose(along_x, Face::Px, 7).unwrap().orientation, [0.0, 0.0, 0.0, 1.0]);
        }
        assert_eq!(pose([0.0; 16], Face::View, 0), None);
    }

    #[test]
    fn lenses_of_images_of_both_ranges() {
        let (size, wanted) = ([200.0, 100.0], [150.0, 120.0, 110.0, 40.0]);
        let to_camera = DMat4::from_translation(DVec3::new(-1.0, -2.0, -3.0));
        // First a camera that looks along -Z, then one along +Z, whose camera matrix has the other sign.
        for z in [-1.0, 1.0] {
            let to_camera = DMat4::from_scale(DVec3::new(1.0, 1.0, -z)) * to_camera;
            for (least, span, up) in [(-1.0, 2.0, 1.0), (0.0, 1.0, 1.0), (0.0, 1.0, -1.0)] {
                let top = if up > 0.0 { 1.0 - wanted[3] / size[1] } else { wanted[3] / size[1] };
                let [x, y] = [wanted[0] / size[0], up * wanted[1] / size[1]].map(|scale| span * scale);
                let [centre_x, centre_y] = [wanted[2] / size[0], top].map(|at| least + span * at);
                let to_ndc = DMat4::from_cols_array(&[
                    x,
                    0.0,
                    0.0,
                    0.0,
                    0.0,
                    y,
                    0.0,
                    0.0,
                    centre_x * z,
                    centre_y * z,
                    z,
                    z,
                    0.0,
                    0.0,
                    -0.1,
                    0.0,
                ]) * to_camera;
                let rows = |matrix: DMat4| matrix.to_cols_array().map(|value| value as f32);
                for [a, b] in [[to_camera, to_ndc], [to_camera.transpose(), to_ndc.transpose()]] {
                    let found = intrinsics(rows(a), rows(b), size).unwrap();
                    assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?}, {z} {least} {up}");
                }
            }
        }
        let still = DMat4::IDENTITY.to_cols_array().map(|value| value as f32);
        assert_eq!(intrinsics(still, still, size), None, "it is orthographic");
        assert_eq!(intrinsics([0.0; 16], still, size), None);
        assert_eq!(pose([f32::NAN; 16], Face::View, 0), None);
    }
}
