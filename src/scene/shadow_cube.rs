//! Shadow casters of a lamp, in the cells of a cube map around it.

use std::array;

use glam::DVec3;

use super::light::Lamp;
use super::object::Object;

#[derive(Debug, Clone)]
pub(super) struct ShadowCube {
    lamp: DVec3,
    /// Indices of objects per cell: by axis, side (towards −, towards +), row, column.
    cells: Vec<Vec<usize>>,
}

impl ShadowCube {
    /// Cells along an edge of a face.
    const SIDE: usize = 12;
    pub(super) fn new(objects: &[Object], lamp: &Lamp) -> Self {
        let casters: Vec<_> = objects.iter().enumerate().filter(|(_, object)| object.is_occluder()).collect();
        let count = if casters.is_empty() { 0 } else { 6 * Self::SIDE * Self::SIDE };
        let mut cube = ShadowCube { lamp: lamp.position, cells: vec![Vec::new(); count] };
        for (index, object) in casters {
            let [min, max] = [object.bounds.min, object.bounds.max].map(|corner| corner - lamp.position);
            // Far more than the rounding errors of a ray.
            let margin = f64::max(1e-4, 1e-9 * min.abs().max(max.abs()).max_element());
            let (min, max) = (min - margin, max + margin);
            let nearest = DVec3::ZERO.max(min).min(max);
            if nearest.length() > lamp.reach {
                continue;
            }
            for face in 0..6 {
                cube.add(index, face, [min, max]);
            }
        }
        cube
    }

    /// Adds a box, relative to the lamp, to the cells of a face that it may overlap.
    fn add(&mut self, index: usize, face: usize, [min, max]: [DVec3; 2]) {
        let [depth, across, up] = [face / 2, (face / 2 + 1) % 3, (face / 2 + 2) % 3];
        let (near, far) = if face.is_multiple_of(2) { (-max[depth], -min[depth]) } else { (min[depth], max[depth]) };
        if far <= 0.0 {
            return;
        }
        // Slopes within which all of the box lies that is in front of the lamp; infinite if it reaches the lamp's plane.
        let near = near.max(0.0);
        let [columns, rows] = [across, up].map(|axis| {
            let low = min[axis] / if min[axis] < 0.0 { near } else { far };
            let high = max[axis] / if max[axis] > 0.0 { near } else { far };
            [Self::cell(low), Self::cell(high)]
        });
        // The face ends at slopes of 1, but border cells also hold boxes beside it, which are tested needlessly.
        for row in rows[0]..=rows[1] {
            for column in columns[0]..=columns[1] {
                if let Some(cell) = self.cells.get_mut((face * Self::SIDE + row) * Self::SIDE + column) {
                    cell.push(index);
                }
            }
        }
    }

    /// Returns the row or column of a slope. The cast saturates and maps NaN to 0.
    fn cell(slope: f64) -> usize {
        (((0.5 * slope + 0.5) * Self::SIDE as f64) as usize).min(Self::SIDE - 1)
    }

    /// Returns the indices of the objects that may be between `point` and the lamp.
    pub(super) fn casters(&self, point: DVec3) -> &[usize] {
        let from_lamp = (point - self.lamp).to_array();
        let size = from_lamp.map(f64::abs);
        let depth = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[2] > size[1]) };
        let face = 2 * depth + usize::from(from_lamp[depth] > 0.0);
        let [column, row] = array::from_fn(|axis| Self::cell(from_lamp[(depth + axis + 1) % 3] / size[depth]));
        self.cells.get((face * Self::SIDE + row) * Self::SIDE + column).map_or(&[], Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DemoKind, DemoScene};
    use codec::math::random::Random;

    /// Every object whose box a ray to a lamp meets is among the casters of its origin.
    #[test]
    fn casters_of_a_point_include_all_objects_before_the_lamp() {
        let mut random = Random::new(5);
        for kind in [DemoKind::Interior, DemoKind::Street, DemoKind::Cornell] {
            let scene = DemoScene::new(kind).at(0.4);
            let bounds = scene.bounds.unwrap();
            let (mut hits, mut listed) = (0, 0);
            for lamp in &scene.light.lamps {
                let cube = ShadowCube::new(&scene.objects, lamp);
                for _ in 0..2000 {
                    let share = DVec3::from_array(array::from_fn(|_| f64::from(random.below(10_000)) / 1e4));
                    let point = bounds.min + share * (bounds.max - bounds.min);
                    let length = (lamp.position - point).length();
                    let ray = crate::mesh::Ray::new(point, lamp.position - point).unwrap();
                    if length >= lamp.reach {
                        continue;
                    }
                    let casters = cube.casters(point);
                    listed += casters.len();
                    for (index, object) in scene.objects.iter().enumerate().filter(|(_, object)| object.is_occluder()) {
                        if object.shape.intersect(&ray, 0.0).is_some_and(|hit| hit.distance < length) {
                            assert!(casters.contains(&index), "{kind:?}: {object:?} between {point} and {lamp:?}");
                            hits += 1;
                        }
                    }
                }
            }
            assert!(hits > 100 && listed > hits, "{kind:?}: {hits} {listed}");
        }
    }
}
