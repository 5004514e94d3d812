//! Triangles of a glTF mesh (glTF 2.0, sections 3.7.2 and 5.24), in the space of their node.

use glam::{Affine2, Vec2, Vec3, Vec4};
use gltf::Semantic;
use gltf::accessor::Dimensions;
use gltf::mesh::Mode;

use super::buffers::Buffers;
use codec::error::{Error, Result};

/// Triangles in the space of their node. Lists of vertex attributes may be empty.
#[derive(Debug, Default)]
pub struct Geometry {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    /// Linear RGBA, 0..=1.
    pub colors: Vec<Vec4>,
    /// Corner indices; all are in range.
    pub triangles: Vec<[u32; 3]>,
    pub material: u32,
    pub targets: Vec<Target>,
    /// Sets of four joints per corner.
    pub influences: Vec<Influences>,
}

/// Displacements of a morph target; empty if it has none.
#[derive(Debug, Default)]
pub struct Target {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
}

/// Four joints that move each corner, as indices into the skin, with their weights.
#[derive(Debug)]
pub struct Influences {
    pub joints: Vec<[u32; 4]>,
    pub weights: Vec<[f32; 4]>,
}

/// Texture coordinates that a material uses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Coordinates {
    pub set: u32,
    /// Maps the file's coordinates to those of the image.
    pub transform: Affine2,
}

/// Reads a primitive; `None` for points and lines. Fails if accessors differ in length, or an index is out of range.
pub fn read(
    primitive: &gltf::Primitive,
    material: u32,
    coordinates: Option<Coordinates>,
    buffers: &mut Buffers,
) -> Result<Option<Geometry>> {
    let mode = primitive.mode();
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        return Ok(None);
    }
    let accessor = primitive.get(&Semantic::Positions).ok_or_else(|| Error::invalid("it has no positions"))?;
    let positions: Vec<Vec3> = buffers.floats::<3>(accessor.index())?.into_iter().map(Vec3::from_array).collect();
    let count = positions.len();
    let normals = vectors(primitive.get(&Semantic::Normals), count, "normals", buffers)?;
    let mut uvs = Vec::new();
    if let Some(Coordinates { set, transform }) = coordinates
        && let Some(accessor) = primitive.get(&Semantic::TexCoords(set))
    {
        let read = buffers.floats::<2>(accessor.index())?;
        uvs = read.into_iter().map(|uv| transform.transform_point2(Vec2::from_array(uv))).collect();
        same(count, uvs.len(), "texture coordinates")?;
    }
    let colors = colors(primitive, count, buffers)?;
    let order = primitive.indices().map(|accessor| buffers.integers::<1>(accessor.index())).transpose()?;
    let order = order.map(Vec::into_flattened);
    let most = order.as_ref().and_then(|order| order.iter().max());
    if let Some(most) = most.filter(|&&most| most as usize >= count) {
        return Err(Error::invalid(format!("a triangle refers to vertex {most}, but there are {count}")));
    }
    let corners = order.as_ref().map_or(count, Vec::len);
    buffers.budget.take(corners as u64, 12, "triangles")?;
    let corner = |at: usize| order.as_ref().map_or(at as u32, |order| order[at]);
    let triangles = triangles(mode, corners).map(|triangle| triangle.map(corner)).collect();
    let mut targets = Vec::new();
    for target in primitive.morph_targets() {
        targets.push(Target {
            positions: vectors(target.positions(), count, "displacements of a morph target", buffers)?,
            normals: vectors(target.normals(), count, "normals of a morph target", buffers)?,
        });
    }
    let influences = influences(primitive, count, buffers)?;
    Ok(Some(Geometry { positions, normals, uvs, colors, triangles, material, targets, influences }))
}

/// Reads an application-specific attribute by its name without the underscore, one vector per corner; empty if there is none.
pub fn application_vectors(primitive: &gltf::Primitive, name: &str, buffers: &mut Buffers) -> Result<Vec<Vec3>> {
    let count = primitive.get(&Semantic::Positions).map_or(0, |accessor| accessor.count());
    vectors(primitive.get(&Semantic::Extras(name.into())), count, name, buffers)
}

/// Reads the first set of vertex colours. Colours without alpha are opaque.
fn colors(primitive: &gltf::Primitive, count: usize, buffers: &mut Buffers) -> Result<Vec<Vec4>> {
    let Some(accessor) = primitive.get(&Semantic::Colors(0)) else { return Ok(Vec::new()) };
    let read = match accessor.dimensions() {
        Dimensions::Vec3 => {
            buffers.floats::<3>(accessor.index())?.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect()
        }
        _ => buffers.floats::<4>(accessor.index())?,
    };
    same(count, read.len(), "colours")?;
    let sound = |color: Vec4| if color.is_finite() { color.clamp(Vec4::ZERO, Vec4::ONE) } else { Vec4::ONE };
    Ok(read.into_iter().map(|color| sound(Vec4::from_array(color))).collect())
}

/// Reads one vector per corner; empty without an accessor.
fn vectors(accessor: Option<gltf::Accessor>, count: usize, what: &str, buffers: &mut Buffers) -> Result<Vec<Vec3>> {
    let Some(accessor) = accessor else { return Ok(Vec::new()) };
    let vectors = buffers.floats::<3>(accessor.index())?;
    same(count, vectors.len(), what)?;
    Ok(vectors.into_iter().map(Vec3::from_array).collect())
}

fn influences(primitive: &gltf::Primitive, count: usize, buffers: &mut Buffers) -> Result<Vec<Influences>> {
    let mut sets = Vec::new();
    let set = |number: u32| primitive.get(&Semantic::Joints(number)).zip(primitive.get(&Semantic::Weights(number)));
    while let Some((joints, weights)) = set(sets.len() as u32) {
        let joints = buffers.integers::<4>(joints.index())?;
        let weights = buffers.floats::<4>(weights.index())?;
        same(count, joints.len(), "sets of joints")?;
        same(count, weights.len(), "sets of weights")?;
        sets.push(Influences { joints, weights });
    }
    Ok(sets)
}

/// Returns the corners of each triangle, as positions in the list of indices.
fn triangles(mode: Mode, corners: usize) -> Box<dyn Iterator<Item = [usize; 3]>> {
    let last = corners.saturating_sub(2);
    match mode {
        // Every other triangle of a strip is flipped, so that all face the same side.
        Mode::TriangleStrip => Box::new((0..last).map(|at| [at, at + 1 + at % 2, at + 2 - at % 2])),
        Mode::TriangleFan => Box::new((0..last).map(|at| [at + 1, at + 2, 0])),
        _ => Box::new((0..corners / 3).map(|at| [3 * at, 3 * at + 1, 3 * at + 2])),
    }
}

fn same(positions: usize, others: usize, what: &str) -> Result<()> {
    if positions == others {
        return Ok(());
    }
    Err(Error::invalid(format!("{others} {what} for {positions} positions")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_side() {
        let all = |mode: Mode, corners: usize| triangles(mode, corners).collect::<Vec<_>>();
        assert_eq!(all(Mode::TriangleStrip, 5), [[0, 1, 2], [1, 3, 2], [2, 3, 4]]);
        assert_eq!(all(Mode::TriangleFan, 5), [[1, 2, 0], [2, 3, 0], [3, 4, 0]]);
        assert_eq!(all(Mode::Triangles, 7), [[0, 1, 2], [3, 4, 5]]);
        for mode in [Mode::TriangleStrip, Mode::TriangleFan, Mode::Triangles] {
            for corners in 0..3 {
                assert!(all(mode, corners).is_empty());
            }
        }
    }
}
