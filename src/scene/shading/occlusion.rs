//! Ambient occlusion: the fraction of the ambient light that nearby surfaces do not block.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::mesh::Ray;
use crate::raycast::SceneAtTime;
use crate::surface::Surface;

/// Returns the fraction of the ambient light that reaches a surface, 0 to 1: the fraction of cosine-weighted rays that hit
/// nothing nearby.
///
/// All points use the same directions around their normal, so neighbouring points, and the same point in different views,
/// differ only by their occluders and not by noise.
pub(super) fn open_part(scene: &SceneAtTime, surface: &Surface) -> f64 {
    let count = scene.light_rays.occlusion;
    if count == 0 {
        return 1.0;
    }
    let (across, along) = surface.normal.any_orthonormal_pair();
    let above = surface.point + scene.lift(surface.point) * surface.side;
    let is_open = |at: &u32| {
        let [x, y, height] = direction(*at, count);
        let towards: DVec3 = x * across + y * along + height * surface.normal;
        // A shading normal may lean, so some directions point below the surface; these are blocked.
        towards.dot(surface.side) > 0.0
            && !scene.light_stopped(&Ray::from_unit(above, towards.normalize()), scene.occlusion_reach())
    };
    (0..count).filter(is_open).count() as f64 / f64::from(count)
}

/// Returns the unit vector of a sample, with the normal as third axis: Hammersley points on a disk, projected to the
/// hemisphere, which makes the density proportional to the cosine.
fn direction(at: u32, count: u32) -> [f64; 3] {
    let squared = (f64::from(at) + 0.5) / f64::from(count);
    let angle = TAU * f64::from(at.reverse_bits()) / 2f64.powi(32);
    let radius = squared.sqrt();
    [radius * angle.cos(), radius * angle.sin(), (1.0 - squared).sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_have_length_1_and_the_cosines_mean() {
        let all: Vec<[f64; 3]> = (0..256).map(|at| direction(at, 256)).collect();
        assert!(all.iter().all(|at| (DVec3::from_array(*at).length() - 1.0).abs() < 1e-12));
        // The mean cosine of cosine-weighted directions is 2/3.
        let mean = all.iter().map(|at| at[2]).sum::<f64>() / 256.0;
        assert!((mean - 2.0 / 3.0).abs() < 1e-2, "{mean}");
        let middle = all.iter().map(|at| DVec3::from_array(*at)).sum::<DVec3>() / 256.0;
        assert!(middle.x.abs() < 0.02 && middle.y.abs() < 0.02, "{middle}");
    }
}
