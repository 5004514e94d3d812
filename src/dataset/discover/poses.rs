//! Poses of cameras from the attribute `worldToCamera` of EXR files.
//!
//! The matrix is for row vectors; x of the camera is right, y is up. Its z is not used, as some renderers look along it and
//! others along its opposite: in a right-handed world the viewing direction is that of up × right.

use glam::{DMat3, DQuat, DVec3};

use super::sequences::Found;
use crate::dataset::manifest::{Pose, Probe};
use crate::error::Result;
use crate::image::{Face, FrameRange, ReadLimits, exr};

/// Pose of a probe, or poses where it moves, in a [`Probe`] without a name; `None` where files state none.
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

fn pose(matrix: [f32; 16], face: Face, frame: u32) -> Option<Pose> {
    let at = |row: usize, column: usize| f64::from(matrix[4 * row + column]);
    // Some write the transpose, for column vectors.
    let is_transposed = (0..3).all(|axis| at(3, axis) == 0.0) && (0..3).any(|axis| at(axis, 3) != 0.0);
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
    // Images of faces may be mirrored, so that only the viewing direction and down count.
    let basis = |forward: DVec3, down: DVec3| DMat3::from_cols(forward, down, forward.cross(down));
    let [forward, _, down] = face.axes();
    let turn = basis(up.cross(right), -up) * basis(forward, down).transpose();
    let orientation = DQuat::from_mat3(&turn).normalize();
    // Rounding of 32-bit matrices would make a turn of none.
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
        // At (1, 2, 3), looking along -Z with +Y up, then along +X.
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
        assert_eq!(pose([f32::NAN; 16], Face::View, 0), None);
    }
}
