//! Reads OBJ files.
//!
//! The text is normalised before it is parsed: continued lines are joined, elements without a surface are dropped, and invalid
//! corner indices are rejected.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::BufReader;
use std::path::Path;

use glam::{DVec3, Vec2, Vec4};

use super::mtl;
use crate::mesh::assembly::{Assembly, Channels, Part, Winding};
use crate::mesh::budget::{Budget, CORNER_BYTES, TRIANGLE_BYTES};
use crate::mesh::folder::Folder;
use crate::mesh::gltf::materials::unit;
use crate::mesh::polygon::triangulate;
use crate::{MeshMaterial, SceneMesh};
use codec::error::{Error, Result};
use codec::image::Transfer;
use footage::account::Account;
use footage::text::decode_lossy;

/// Maximum bytes that the parser allocates per byte of text.
const PARSED: u64 = 32;

/// Returns the mesh and [`Folder::contents`].
pub fn read(bytes: &[u8], path: &Path, account: &mut Account) -> Result<(SceneMesh, String)> {
    let notes = &mut account.left_out;
    let mut budget = Budget::new(bytes.len() as u64);
    budget.take(bytes.len() as u64, PARSED, "the text")?;
    let Plain { text, no_surface } = plain(bytes)?;
    if no_surface > 0 {
        notes.push(format!("{no_surface} points, lines or curves are ignored: they have no surface"));
    }
    let options = tobj::LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };
    let mut folder = Folder::of(path);
    let library = mtl::Library { folder: &mut folder, budget: &mut budget, notes, textures: BTreeMap::new() };
    let library = RefCell::new(library);
    let loaded =
        tobj::load_obj_buf(&mut BufReader::new(text.as_slice()), &options, |name| library.borrow_mut().load(name));
    let (models, materials) = loaded.map_err(|error| Error::invalid(format!("the OBJ file is damaged: {error}")))?;
    let mut library = library.into_inner();
    let mut paints = vec![MeshMaterial::default()];
    let mut placements = vec![mtl::Placement::default()];
    let materials = materials.unwrap_or_default();
    for material in &materials {
        placements.push(library.placement(material));
        paints.push(library.convert(material));
    }
    drop(text);

    let count = |numbers: &[f32], size: usize| numbers.len() / size;
    let aligned = |mesh: &tobj::Mesh, numbers: &[f32], size: usize| {
        !numbers.is_empty() && count(numbers, size) == count(&mesh.positions, 3)
    };
    let channels = Channels {
        normals: models.iter().any(|model| aligned(&model.mesh, &model.mesh.normals, 3)),
        uvs: models.iter().any(|model| aligned(&model.mesh, &model.mesh.texcoords, 2)),
        colors: models.iter().any(|model| aligned(&model.mesh, &model.mesh.vertex_color, 3)),
    };
    let mut assembly = Assembly::new(channels);
    for tobj::Model { mesh, name } in &models {
        budget.take(triangle_count(mesh) as u64, TRIANGLE_BYTES, name)?;
        budget.take(count(&mesh.positions, 3) as u64, CORNER_BYTES, name)?;
        // If only some corners of a group have normals, the parser does not report which, so none are used.
        let normals = if aligned(mesh, &mesh.normals, 3) { mesh.normals.as_slice() } else { &[] };
        let uvs = if aligned(mesh, &mesh.texcoords, 2) { mesh.texcoords.as_slice() } else { &[] };
        let vectors = |numbers: &[f32]| -> Vec<DVec3> {
            numbers.as_chunks::<3>().0.iter().map(|v| DVec3::from_array(v.map(f64::from))).collect()
        };
        let material = mesh.material_id.map_or(0, |id| id + 1).min(paints.len() - 1);
        // In OBJ, v increases upwards.
        let place = |&uv: &[f32; 2]| placements[material].place(uv.into());
        let uvs: Vec<Vec2> = uvs.as_chunks::<2>().0.iter().map(place).map(|uv| Vec2::new(uv.x, 1.0 - uv.y)).collect();
        let colors = if aligned(mesh, &mesh.vertex_color, 3) { mesh.vertex_color.as_slice() } else { &[] };
        let colors: Vec<Vec4> = colors.as_chunks::<3>().0.iter().map(|&srgb| linear(srgb)).collect();
        let positions = vectors(&mesh.positions);
        let triangles = triangles(mesh, &positions);
        assembly.add(&Part {
            positions: &positions,
            normals: &vectors(normals),
            uvs: &uvs,
            colors: &colors,
            triangles: &triangles,
            material: material as u32,
            winding: Winding::Outward,
        });
    }
    assembly.left_out.note(notes);
    notes.extend(folder.notes());
    let materials = || models.iter().filter_map(|model| materials.get(model.mesh.material_id?));
    account.add("object", models.iter().map(|model| model.name.clone()));
    account.add("material", materials().map(|material| material.name.clone()));
    account.add("file", folder.files());
    Ok((SceneMesh::new(assembly.finish(), paints.into()), folder.contents(bytes)))
}

/// Returns the linear colour of a vertex. Programs that write colours behind positions write sRGB.
fn linear(srgb: [f32; 3]) -> Vec4 {
    let [r, g, b] = srgb.map(|code| Transfer::Srgb.decode(unit(code)) as f32);
    Vec4::new(r, g, b, 1.0)
}

/// Returns the number of triangles of a mesh: of each polygon two fewer than its corners.
fn triangle_count(mesh: &tobj::Mesh) -> usize {
    match mesh.face_arities.len() {
        0 => mesh.indices.len() / 3,
        polygons => mesh.indices.len().saturating_sub(2 * polygons),
    }
}

/// Returns the triangles of a mesh of polygons.
fn triangles(mesh: &tobj::Mesh, positions: &[DVec3]) -> Vec<[u32; 3]> {
    if mesh.face_arities.is_empty() {
        return mesh.indices.as_chunks::<3>().0.to_vec();
    }
    let mut triangles = Vec::with_capacity(triangle_count(mesh));
    let mut rest = mesh.indices.as_slice();
    for &count in &mesh.face_arities {
        let (polygon, behind) = rest.split_at((count as usize).min(rest.len()));
        rest = behind;
        let corners: Vec<DVec3> = polygon.iter().map(|&at| positions[at as usize]).collect();
        triangulate(&corners, |triangle| triangles.push(triangle.map(|at| polygon[at])));
    }
    triangles
}

struct Plain {
    text: Vec<u8>,
    /// Number of elements without a surface.
    no_surface: usize,
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

/// True if each vertex has a colour behind its position.
fn has_colors(bytes: &[u8]) -> bool {
    let is_number = |word: &[u8]| std::str::from_utf8(word).is_ok_and(|word| word.parse::<f32>().is_ok());
    let has_color = |line: &[u8]| words(line).skip(1).count() == 6 && words(line).skip(1).all(is_number);
    let mut vertices = bytes.split(|&byte| byte == b'\n').filter(|line| words(line).next() == Some(b"v")).peekable();
    vertices.peek().is_some() && vertices.all(has_color)
}

fn plain(bytes: &[u8]) -> Result<Plain> {
    let decoded = decode_lossy(bytes);
    let bytes = decoded.as_bytes();
    let has_colors = has_colors(bytes);
    let mut text = Vec::with_capacity(bytes.len());
    let mut no_surface = 0;
    // Number of positions, texture coordinates and normals so far.
    let mut counts = [0; 3];
    let mut joined = Vec::new();
    for (number, line) in (1..).zip(bytes.split(|&byte| byte == b'\n')) {
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if let Some(begun) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(begun);
            joined.push(b' ');
            continue;
        }
        joined.extend_from_slice(line);
        let mut words = joined.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => {
                // Drops weights.
                text.push(b'v');
                for word in words.take(if has_colors { 6 } else { 3 }) {
                    text.push(b' ');
                    text.extend_from_slice(word);
                }
                counts[0] += 1;
            }
            Some(b"f") => {
                text.push(b'f');
                for word in words {
                    let word = String::from_utf8_lossy(word);
                    let Some(corner) = corner(&word, counts) else {
                        let word: String = word.chars().take(40).collect();
                        return Err(Error::invalid(format!("line {number}: “{word}” is not a face vertex")));
                    };
                    text.push(b' ');
                    text.extend_from_slice(corner.as_bytes());
                }
            }
            Some(b"l" | b"p" | b"curv" | b"curv2" | b"surf") => no_surface += 1,
            // No name selects the default material; the parser does not accept it.
            Some(b"usemtl") if words.next().is_none() => {}
            Some(word @ (b"vt" | b"vn" | b"o" | b"g" | b"usemtl" | b"mtllib")) => {
                counts[1] += usize::from(word == b"vt");
                counts[2] += usize::from(word == b"vn");
                text.extend_from_slice(String::from_utf8_lossy(&joined).as_bytes());
            }
            _ => {}
        }
        text.push(b'\n');
        joined.clear();
    }
    Ok(Plain { text, no_surface })
}

/// Converts a face corner to absolute indices, given the counts so far; `None` if it is invalid.
fn corner(word: &str, counts: [usize; 3]) -> Option<String> {
    let mut numbers = Vec::new();
    for (at, part) in word.split('/').enumerate() {
        let count = *counts.get(at)?;
        if part.is_empty() && at > 0 {
            numbers.push(String::new());
            continue;
        }
        let number: i64 = part.parse().ok()?;
        let number = if number < 0 { i64::try_from(count).ok()?.checked_add(number)? + 1 } else { number };
        numbers.push((1..=i64::from(u32::MAX)).contains(&number).then(|| number.to_string())?);
    }
    Some(numbers.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read_text(text: &str) -> SceneMesh {
        super::read(text.as_bytes(), Path::new("a.obj"), &mut Account::default()).unwrap().0
    }

    #[test]
    fn colours_behind_positions_are_linear() {
        let vertices = "v 0 0 0 1 0 0.5\nv 1 0 0 1 0 0.5\nv 0 1 0 1 0 0.5\nf 1 2 3\n";
        let color = read_text(vertices).mesh.colors[0];
        assert!((color - Vec4::new(1.0, 0.0, 0.21404114, 1.0)).length() < 1e-6, "{color}");
        // A weight and words are no colour, and colours of some vertices count for none.
        for text in [
            vertices.replace(" 1 0 0.5", " 1"),
            vertices.replace(" 1 0 0.5", " r g b"),
            vertices.replacen(" 1 0 0.5", "", 1),
            format!("v\t2 2 2\n{vertices}"),
        ] {
            assert!(read_text(&text).mesh.colors.is_empty(), "{text}");
        }
    }

    #[test]
    fn concave_polygons_keep_their_notches() {
        let mesh = read_text("v 0 0 0\nv 2 -1 0\nv 1 0 0\nv 2 1 0\nf 1 2 3 4\nf 1/ 2/ 4/\n").mesh;
        let area = |at: usize| {
            let [a, b, c] = mesh.corners(at);
            0.5 * (b - a).cross(c - a).length()
        };
        assert_eq!(mesh.triangles.len(), 3);
        assert!((area(0) + area(1) - 1.0).abs() < 1e-6 && (area(2) - 2.0).abs() < 1e-6);
    }

    #[test]
    fn corners_are_counted_from_the_first() {
        let of = |word: &str| corner(word, [9, 5, 2]);
        for (word, expected) in
            [("3", "3"), ("-1", "9"), ("-9/-5/-2", "1/1/1"), ("4//1", "4//1"), ("7/8/9", "7/8/9"), ("1//", "1//")]
        {
            assert_eq!(of(word).as_deref(), Some(expected));
        }
        for word in [
            "0",
            "-10",
            "1/-6",
            "1/2/-3",
            "1/2/3/4",
            "/1",
            "",
            "x",
            "4294967296",
            "9223372036854775808",
            "-9223372036854775808",
        ] {
            assert_eq!(of(word), None, "{word}");
        }
    }
}
