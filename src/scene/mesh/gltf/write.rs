//! Writes meshes as binary glTF (glTF 2.0, section 4.4): one node per mesh, one primitive per material of the mesh.
//!
//! Positions are rounded to f32. Images are embedded as PNG.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use serde_json::{Value, json};

use crate::mesh::material::Material;
use crate::mesh::texture::{ImageTexture, Wrap};
use crate::mesh::triangles::Mesh;
use codec::error::{Error, Result};
use codec::math::Camera;

const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;
/// Targets of buffer views.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
/// Linear filter without mipmaps.
const LINEAR: u32 = 9729;

/// Data besides meshes.
#[derive(Debug, Default)]
pub struct Additions<'a> {
    /// Extras of the file.
    pub extras: Option<Value>,
    /// Attributes of the corners of the first mesh. Names begin with an underscore (glTF 2.0, section 3.7.2.1).
    pub attributes: &'a [(&'a str, &'a [Vec3])],
    /// A camera, whose clip planes are stored if they are above 0 and finite.
    pub camera: Option<Camera>,
}

/// Writes meshes as a `.glb` file. The materials of their triangles are indices into `materials`. Triangles of a material keep
/// their order.
pub fn glb(meshes: &[Mesh], materials: &[Material], additions: &Additions, out: &mut dyn Write) -> Result<()> {
    let mut document = Document::default();
    for material in materials {
        let material = document.material(material)?;
        document.materials.push(material);
    }
    let attributes = |at: usize| if at == 0 { additions.attributes } else { &[] };
    let parts = meshes.iter().enumerate().map(|(at, mesh)| document.mesh(mesh, attributes(at)));
    let parts = parts.collect::<Result<Vec<Value>>>()?;
    let mut nodes: Vec<Value> = (0..parts.len()).map(|mesh| json!({ "mesh": mesh })).collect();
    let mut cameras = Vec::new();
    if let Some(camera) = &additions.camera {
        let turn = camera.orientation().unwrap_or([0.0, 0.0, 0.0, 1.0]);
        nodes.push(json!({ "camera": 0, "translation": camera.eye().to_array(), "rotation": turn }));
        let mut lens = perspective(camera);
        // The viewer's window defines the aspect ratio.
        lens.as_object_mut().and_then(|lens| lens.remove("aspectRatio"));
        cameras.push(json!({ "type": "perspective", "perspective": lens }));
    }
    let mut root = json!({ "asset": { "version": "2.0", "generator": "lightfold" }, "scene": 0 });
    root["scenes"] = json!([{ "nodes": (0..nodes.len()).collect::<Vec<usize>>() }]);
    let lists = [
        ("nodes", nodes),
        ("cameras", cameras),
        ("meshes", parts),
        ("materials", document.materials),
        ("textures", document.textures),
        ("images", document.images),
        ("samplers", document.samplers),
        ("accessors", document.accessors),
        ("bufferViews", document.views),
        ("extensionsUsed", document.extensions.into_iter().map(Value::from).collect()),
    ];
    if let Some(extras) = &additions.extras {
        root["extras"] = extras.clone();
    }
    // glTF does not allow empty lists.
    for (name, list) in lists.into_iter().filter(|(_, list)| !list.is_empty()) {
        root[name] = list.into();
    }
    binary_file(root, &document.bytes, out)
}

/// Near plane in metres of cameras without one; glTF requires a value above 0.
const DEFAULT_NEAR_M: f64 = 0.01;

/// Returns the lens of a camera (glTF 2.0, section 5.14).
pub fn perspective(camera: &Camera) -> Value {
    let lens = camera.lens();
    let mut perspective = json!({
        "yfov": lens.fov_y_deg.to_radians(),
        "aspectRatio": lens.aspect,
        "znear": if lens.near_m > 0.0 { lens.near_m } else { DEFAULT_NEAR_M },
    });
    if lens.far_m.is_finite() {
        perspective["zfar"] = lens.far_m.into();
    }
    perspective
}

/// Writes a document and the bytes of its only buffer as a `.glb` file.
pub fn binary_file(mut root: Value, buffer: &[u8], out: &mut dyn Write) -> Result<()> {
    if !buffer.is_empty() {
        root["buffers"] = json!([{ "byteLength": buffer.len() }]);
    }
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let total = u32::try_from(28 + text.len() + buffer.len());
    let total = total.map_err(|_| Error::unsupported("the meshes take more than the 4 GiB of a GLB file"))?;
    let chunk = |kind: &[u8; 4], bytes: &[u8]| [&(bytes.len() as u32).to_le_bytes()[..], kind, bytes].concat();
    let head = [&b"glTF"[..], &2_u32.to_le_bytes(), &total.to_le_bytes()].concat();
    let failed = |error: std::io::Error| Error::io("the GLB file", error);
    for bytes in [head, chunk(b"JSON", &text), chunk(b"BIN\0", buffer)] {
        out.write_all(&bytes).map_err(failed)?;
    }
    Ok(())
}

/// Lists and buffer of a file that is being built.
#[derive(Default)]
struct Document {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    samplers: Vec<Value>,
    textures: Vec<Value>,
    materials: Vec<Value>,
    extensions: BTreeSet<&'static str>,
    /// Texture indices by the addresses of their images.
    known: BTreeMap<*const ImageTexture, usize>,
}

fn push(list: &mut Vec<Value>, value: Value) -> usize {
    list.push(value);
    list.len() - 1
}

impl Document {
    fn view(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        let mut view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        push(&mut self.views, view)
    }

    fn floats<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = vectors.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes, Some(VERTICES));
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let accessor = json!({ "bufferView": view, "componentType": FLOAT, "count": vectors.len(), "type": kind });
        push(&mut self.accessors, accessor)
    }

    fn mesh(&mut self, mesh: &Mesh, additions: &[(&str, &[Vec3])]) -> Result<Value> {
        let positions: Vec<[f32; 3]> = mesh.positions.iter().map(|at| at.as_vec3().to_array()).collect();
        let mut attributes = json!({ "POSITION": self.floats(&positions) });
        let bound = |pick: fn(Vec3, Vec3) -> Vec3| {
            positions.iter().copied().map(Vec3::from_array).reduce(pick).map_or([0.0; 3], |corner| corner.to_array())
        };
        if let Some(accessor) = self.accessors.last_mut() {
            (accessor["min"], accessor["max"]) = (json!(bound(Vec3::min)), json!(bound(Vec3::max)));
        }
        if !mesh.normals.is_empty() {
            let normals: Vec<_> = mesh.normals.iter().map(|normal| normal.normalize_or(Vec3::Y).to_array()).collect();
            attributes["NORMAL"] = self.floats(&normals).into();
        }
        if !mesh.uvs.is_empty() {
            attributes["TEXCOORD_0"] = self.floats(&mesh.uvs.iter().map(Vec2::to_array).collect::<Vec<_>>()).into();
        }
        if !mesh.colors.is_empty() {
            attributes["COLOR_0"] = self.floats(&mesh.colors.iter().map(Vec4::to_array).collect::<Vec<_>>()).into();
        }
        for (name, values) in additions {
            if values.len() != mesh.positions.len() {
                return Err(Error::invalid(format!(
                    "{name}: {} values for {} corners",
                    values.len(),
                    mesh.positions.len()
                )));
            }
            attributes[*name] = self.floats(&values.iter().map(Vec3::to_array).collect::<Vec<_>>()).into();
        }
        // Index 65535 is not allowed in 16-bit lists (glTF 2.0, section 3.7.2.1).
        let is_short = mesh.positions.len() <= usize::from(u16::MAX);
        let (component, component_bytes) = if is_short { (UNSIGNED_SHORT, 2) } else { (UNSIGNED_INT, 4) };
        let mut parts: BTreeMap<u32, Vec<u8>> = BTreeMap::new();
        for (corners, &material) in mesh.triangles.iter().zip(&mesh.material_of) {
            if corners.iter().any(|&corner| corner as usize >= mesh.positions.len()) {
                return Err(Error::invalid("a triangle refers to a vertex that does not exist"));
            }
            if material as usize >= self.materials.len() {
                return Err(Error::invalid(format!("a triangle refers to material {material}, which does not exist")));
            }
            let indices = corners.iter().flat_map(|corner| corner.to_le_bytes().into_iter().take(component_bytes));
            parts.entry(material).or_default().extend(indices);
        }
        let mut primitives = Vec::new();
        for (material, bytes) in parts {
            let view = self.view(&bytes, Some(INDICES));
            let count = bytes.len() / component_bytes;
            let indices = json!({ "bufferView": view, "componentType": component, "count": count, "type": "SCALAR" });
            let indices = push(&mut self.accessors, indices);
            primitives.push(json!({ "attributes": attributes, "indices": indices, "material": material }));
        }
        Ok(json!({ "primitives": primitives }))
    }

    fn material(&mut self, material: &Material) -> Result<Value> {
        let [r, g, b] = material.base_color.to_array();
        let mut value = json!({
            "name": material.name,
            "doubleSided": true,
            "pbrMetallicRoughness": {
                "baseColorFactor": [r, g, b, material.alpha],
                "metallicFactor": material.metallic,
                "roughnessFactor": material.roughness,
            },
        });
        if let Some(texture) = &material.base_texture {
            value["pbrMetallicRoughness"]["baseColorTexture"] = json!({ "index": self.texture(texture)? });
        }
        if material.is_blended {
            value["alphaMode"] = "BLEND".into();
        } else if let Some(cutoff) = material.alpha_cutoff {
            (value["alphaMode"], value["alphaCutoff"]) = ("MASK".into(), cutoff.into());
        }
        let strength = material.emission.max_element().max(1.0);
        value["emissiveFactor"] = json!((material.emission / strength).to_array());
        if let Some(texture) = &material.emissive_texture {
            value["emissiveTexture"] = json!({ "index": self.texture(texture)? });
        }
        let mut extend = |is_needed: bool, name: &'static str, extension: Value| {
            if is_needed {
                self.extensions.insert(name);
                value["extensions"][name] = extension;
            }
        };
        extend(strength > 1.0, "KHR_materials_emissive_strength", json!({ "emissiveStrength": strength }));
        extend(material.unlit, "KHR_materials_unlit", json!({}));
        extend(material.ior != 1.5, "KHR_materials_ior", json!({ "ior": material.ior }));
        let transmission = json!({ "transmissionFactor": material.transmission });
        extend(material.transmission > 0.0, "KHR_materials_transmission", transmission);
        let of_ior = ((material.ior - 1.0) / (material.ior + 1.0)).powi(2);
        let specular = material.specular.map(|specular| specular / of_ior).filter(|color| color.is_finite());
        let color = specular.map(|color| color.to_array());
        extend(color.is_some(), "KHR_materials_specular", json!({ "specularColorFactor": color }));
        Ok(value)
    }

    fn texture(&mut self, texture: &Arc<ImageTexture>) -> Result<usize> {
        if let Some(&known) = self.known.get(&Arc::as_ptr(texture)) {
            return Ok(known);
        }
        let view = self.view(&texture.png()?, None);
        let image = push(&mut self.images, json!({ "bufferView": view, "mimeType": "image/png" }));
        let [wrap_s, wrap_t] = texture.wrap.map(|wrap| match wrap {
            Wrap::Repeat => 10497,
            Wrap::Mirror => 33648,
            Wrap::Clamp => 33071,
        });
        let sampler = push(
            &mut self.samplers,
            json!({
                "magFilter": LINEAR, "minFilter": LINEAR, "wrapS": wrap_s, "wrapT": wrap_t
            }),
        );
        let number = push(&mut self.textures, json!({ "source": image, "sampler": sampler }));
        self.known.insert(Arc::as_ptr(texture), number);
        Ok(number)
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec2};

    use super::*;
    use crate::mesh::assembly::{Assembly, Channels, Part, Winding};
    use crate::mesh::budget::Budget;
    use crate::mesh::bvh::tests::Numbers;
    use crate::mesh::folder::Folder;
    use crate::mesh::gltf::buffers::Buffers;
    use crate::mesh::gltf::{document, materials, primitives};

    fn texture(wrap: [Wrap; 2]) -> Arc<ImageTexture> {
        Arc::new(ImageTexture { width: 2, height: 1, pixels: vec![[1, 2, 3, 4], [250, 128, 0, 255]], wrap })
    }

    /// Adjacent squares of two materials, with values that f32 represents exactly.
    fn mesh() -> Mesh {
        let mut mesh = Mesh::default();
        let mut numbers = Numbers::new(3);
        for square in 0..20_u32 {
            let first = 4 * square;
            for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
                mesh.positions.push(DVec3::new(x + f64::from(square), y, f64::from(numbers.next() as f32)));
                mesh.normals.push(Vec3::Z);
                mesh.uvs.push(Vec2::new(x as f32, y as f32));
                mesh.colors.push(Vec4::new(0.25, 0.5, 1.0, y as f32));
            }
            mesh.triangles.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
            mesh.material_of.extend([square / 10; 2]);
        }
        mesh
    }

    fn palette() -> Vec<Material> {
        vec![
            Material {
                name: "glass".into(),
                base_color: DVec3::new(0.5, 0.25, 1.0),
                transmission: 0.75,
                ior: 1.25,
                specular: None,
                ..Material::default()
            },
            Material {
                name: "sign".into(),
                base_color: DVec3::ONE,
                base_texture: Some(texture([Wrap::Clamp, Wrap::Mirror])),
                emissive_texture: Some(texture([Wrap::Repeat; 2])),
                emission: DVec3::new(4.0, 2.0, 0.0),
                alpha: 0.5,
                alpha_cutoff: Some(0.25),
                metallic: 0.5,
                roughness: 0.125,
                unlit: true,
                ..Material::default()
            },
        ]
    }

    fn read(bytes: &[u8]) -> (Mesh, Vec<Material>) {
        let document::Parsed { document, blob, .. } = document::parse(bytes).unwrap();
        let folder = Folder::of(std::path::Path::new("a.glb"));
        let mut buffers = Buffers::new(document.as_json(), blob, folder, Budget::new(bytes.len() as u64));
        let mut notes = Vec::new();
        let paints = materials::read_all(&document, &mut buffers, &mut notes);
        assert_eq!(notes, [""; 0]);
        let mut assembly = Assembly::new(Channels { normals: true, uvs: true, colors: true });
        for primitive in document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
            let material = primitive.material().index().unwrap();
            let coordinates = Some(primitives::Coordinates { set: 0, transform: Default::default() });
            let read = primitives::read(&primitive, material as u32, coordinates, &mut buffers).unwrap().unwrap();
            assembly.add(&Part {
                positions: &read.positions.iter().map(|at| at.as_dvec3()).collect::<Vec<_>>(),
                normals: &read.normals.iter().map(|normal| normal.as_dvec3()).collect::<Vec<_>>(),
                uvs: &read.uvs,
                colors: &read.colors,
                triangles: &read.triangles,
                material: read.material,
                winding: Winding::Outward,
            });
        }
        (assembly.finish(), paints.into_iter().skip(1).map(|paint| paint.material).collect())
    }

    #[test]
    fn what_is_written_is_read_again() {
        let mut bytes = Vec::new();
        glb(&[mesh()], &palette(), &Additions::default(), &mut bytes).unwrap();
        let (found, materials) = read(&bytes);
        assert_eq!(found, mesh());
        assert_eq!(format!("{materials:?}"), format!("{:?}", palette()));
        // An independent reader must read the same mesh.
        let other = gltf::Gltf::from_slice(&bytes).unwrap();
        let blob = other.blob.as_deref().unwrap();
        let primitive = other.meshes().next().unwrap().primitives().next().unwrap();
        let reader = primitive.reader(|_| Some(blob));
        let positions: Vec<DVec3> =
            reader.read_positions().unwrap().map(|at| Vec3::from_array(at).as_dvec3()).collect();
        assert_eq!(positions, mesh().positions);
        let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
        assert_eq!(indices, mesh().triangles[..20].as_flattened());
    }

    #[test]
    fn indices_are_of_32_bits_where_there_are_many_corners() {
        for (count, kind) in [(65_535, gltf::accessor::DataType::U16), (65_536, gltf::accessor::DataType::U32)] {
            let last = count as u32 - 1;
            let positions = (0..count).map(|at| DVec3::splat(f64::from(at))).collect();
            let mesh = Mesh { positions, triangles: vec![[0, 1, last]], material_of: vec![0], ..Mesh::default() };
            let mut bytes = Vec::new();
            glb(&[mesh], &palette(), &Additions::default(), &mut bytes).unwrap();
            let read = gltf::Gltf::from_slice(&bytes).unwrap();
            let primitive = read.meshes().next().unwrap().primitives().next().unwrap();
            assert_eq!(primitive.indices().unwrap().data_type(), kind);
            let blob = read.blob.as_deref().unwrap();
            let indices: Vec<u32> = primitive.reader(|_| Some(blob)).read_indices().unwrap().into_u32().collect();
            assert_eq!(indices, [0, 1, last]);
        }
    }

    #[test]
    fn additions_are_of_the_first_mesh() {
        let stq = vec![Vec3::new(0.5, 0.25, 2.0); 80];
        let additions = Additions { extras: Some(json!({ "a": 1 })), attributes: &[("_STQ", &stq)], camera: None };
        let mut bytes = Vec::new();
        glb(&[mesh(), mesh()], &palette(), &additions, &mut bytes).unwrap();
        let read = gltf::Gltf::from_slice(&bytes).unwrap();
        let of = |mesh: gltf::Mesh| {
            let accessor = mesh.primitives().next()?.get(&gltf::Semantic::Extras("STQ".into()))?;
            Some((accessor.count(), accessor.dimensions()))
        };
        let found: Vec<_> = read.meshes().map(of).collect();
        assert_eq!(found, [Some((80, gltf::accessor::Dimensions::Vec3)), None]);
        let document::Parsed { document, blob, .. } = document::parse(&bytes).unwrap();
        let folder = Folder::of(std::path::Path::new("a.glb"));
        let mut buffers = Buffers::new(document.as_json(), blob, folder, Budget::new(bytes.len() as u64));
        let primitives: Vec<_> = document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()).collect();
        let mut read = |at: usize, name| primitives::application_vectors(&primitives[at], name, &mut buffers).unwrap();
        assert_eq!((read(0, "STQ"), read(0, "OTHER"), read(2, "STQ")), (stq.clone(), vec![], vec![]));
        let wrong = Additions { extras: None, attributes: &[("_STQ", &stq[1..])], camera: None };
        let said = glb(&[mesh()], &palette(), &wrong, &mut Vec::new()).unwrap_err().to_string();
        assert!(said.contains("_STQ: 79 values for 80 corners"), "{said}");
    }

    #[test]
    fn meshes_share_textures_and_may_be_empty() {
        let shared = texture([Wrap::Repeat; 2]);
        let of = || Material { base_texture: Some(shared.clone()), ..Material::default() };
        let mut bytes = Vec::new();
        glb(&[mesh(), mesh()], &[of(), of()], &Additions::default(), &mut bytes).unwrap();
        let read = gltf::Gltf::from_slice(&bytes).unwrap();
        assert_eq!((read.nodes().len(), read.images().len(), read.materials().len()), (2, 1, 2));
        let mut bytes = Vec::new();
        glb(&[], &[], &Additions::default(), &mut bytes).unwrap();
        assert_eq!(gltf::Gltf::from_slice(&bytes).unwrap().nodes().len(), 0);
    }

    #[test]
    fn wrong_indices_are_refused() {
        let refused =
            |mesh: Mesh| glb(&[mesh], &palette(), &Additions::default(), &mut Vec::new()).unwrap_err().to_string();
        assert!(refused(Mesh { material_of: vec![2; 40], ..mesh() }).contains("material 2"));
        assert!(refused(Mesh { positions: vec![], ..mesh() }).contains("vertex"));
    }
}
