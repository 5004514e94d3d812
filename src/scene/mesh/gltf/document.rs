//! JSON of a glTF file, checked before it is used (glTF 2.0, sections 3 and 4.4): the crates that parse it use the indices of a
//! file without checks.

use gltf::json::validation::{Checked, Error as Fault, Validate};
use gltf::{Document, json};
use serde::Deserialize;
use serde::de::IgnoredAny;

use codec::error::{Error, Result};
use footage::text::decode;

/// Extensions that are read. A file may require no other ones.
const KNOWN: &[&str] = &[
    "EXT_mesh_gpu_instancing",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

/// Maximum number of elements of a list: an element `{}` takes a few hundred bytes of memory.
const MAX_COUNT: usize = 1 << 18;

/// Parts that are checked before the rest is read into memory.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Preview {
    asset: Option<Version>,
    #[serde(rename = "extensionsRequired")]
    required: Vec<String>,
    #[serde(rename = "extensionsUsed")]
    used: Vec<String>,
    nodes: Vec<Extended<NodeExtensions>>,
    meshes: Vec<IgnoredAny>,
    materials: Vec<IgnoredAny>,
    textures: Vec<Extended<TextureExtensions>>,
    images: Vec<IgnoredAny>,
    samplers: Vec<IgnoredAny>,
    buffers: Vec<IgnoredAny>,
    scenes: Vec<IgnoredAny>,
    skins: Vec<IgnoredAny>,
    animations: Vec<IgnoredAny>,
}

/// Extensions of an element that the crate does not read.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Extended<T> {
    extensions: Option<T>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct NodeExtensions {
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instances: Option<Instances>,
}

#[derive(Deserialize)]
struct Visibility {
    #[serde(default = "yes")]
    visible: bool,
}

fn yes() -> bool {
    true
}

/// Accessors of the transforms of instances (EXT_mesh_gpu_instancing).
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
struct Instances {
    attributes: Transforms,
}

#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default, rename_all = "UPPERCASE")]
pub struct Transforms {
    pub translation: Option<usize>,
    pub rotation: Option<usize>,
    pub scale: Option<usize>,
}

#[derive(Deserialize, Default)]
#[serde(default)]
struct TextureExtensions {
    #[serde(rename = "EXT_texture_webp")]
    webp: Option<Source>,
    #[serde(rename = "KHR_texture_basisu")]
    basisu: Option<Source>,
}

#[derive(Deserialize)]
struct Source {
    source: u32,
}

#[derive(Deserialize)]
struct Version {
    version: String,
}

#[derive(Debug)]
pub struct Parsed {
    pub document: Document,
    /// Binary chunk: the bytes of buffer 0, if that has no URI.
    pub blob: Option<Vec<u8>>,
    /// Nodes that are hidden with all their descendants (KHR_node_visibility).
    pub hidden: Vec<usize>,
    /// Nodes whose mesh is shown once for each of several transforms (EXT_mesh_gpu_instancing).
    pub instanced: Vec<(usize, Transforms)>,
    /// Extensions that the file uses and that are ignored, in order.
    pub ignored: Vec<String>,
}

pub fn is_glb(bytes: &[u8]) -> bool {
    bytes.starts_with(b"glTF")
}

/// Parses a glTF or GLB file. Fails if the file requires an unknown extension, or an index is out of range.
pub fn parse(bytes: &[u8]) -> Result<Parsed> {
    let (text, blob) = if is_glb(bytes) { split(bytes)? } else { (bytes, None) };
    let text = decode(text)?;
    let text = text.as_bytes();
    let damaged = |error: serde_json::Error| Error::invalid(format!("the JSON of the glTF file is damaged: {error}"));
    let preview: Preview = serde_json::from_slice(text).map_err(damaged)?;
    check_preview(&preview)?;
    let mut root: json::Root = json::deserialize::from_slice(text).map_err(damaged)?;
    // Checked above against `KNOWN`, instead of the extensions that the crate knows.
    root.extensions_required.clear();
    let Preview { textures, nodes, used, .. } = preview;
    for (texture, extended) in root.textures.iter_mut().zip(textures) {
        let other = extended.extensions.and_then(|of| of.webp.or(of.basisu));
        if let (true, Some(other)) = (is_without_image(texture), other) {
            texture.source = json::Index::new(other.source);
        }
    }
    check(&root)?;
    let (mut hidden, mut instanced) = (Vec::new(), Vec::new());
    for (number, extensions) in nodes.into_iter().enumerate().filter_map(|(at, node)| Some((at, node.extensions?))) {
        if extensions.visibility.is_some_and(|of| !of.visible) {
            hidden.push(number);
        }
        instanced.extend(extensions.instances.map(|of| (number, of.attributes)));
    }
    let ignored = used.into_iter().filter(|name| !KNOWN.contains(&name.as_str())).collect();
    let document = Document::from_json_without_validation(root);
    Ok(Parsed { document, blob: blob.map(<[u8]>::to_vec), hidden, instanced, ignored })
}

/// True for a texture without an image (glTF 2.0, section 5.29).
pub fn is_without_image(texture: &json::Texture) -> bool {
    texture.source.value() == u32::MAX as usize
}

/// Returns the JSON and the binary chunk of a `.glb` file (glTF 2.0, section 4.4); other chunks are skipped.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>)> {
    let word =
        |at: usize| bytes.get(at..at + 4).and_then(|word| word.first_chunk::<4>()).map(|w| u32::from_le_bytes(*w));
    let ends = |at: usize| {
        Error::invalid(format!("the GLB file ends early: {} bytes, of which {at} were needed", bytes.len()))
    };
    let version = word(4).ok_or_else(|| ends(12))?;
    if version != 2 {
        return Err(Error::unsupported(format!("GLB version {version}; save it as version 2")));
    }
    let length = word(8).ok_or_else(|| ends(12))? as usize;
    if length > bytes.len() {
        return Err(ends(length));
    }
    let (mut text, mut binary) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let (size, kind) = (word(at).unwrap_or(0) as usize, &bytes[at + 4..at + 8]);
        let body = bytes[..length].get(at + 8..at + 8 + size).ok_or_else(|| ends(at + 8 + size))?;
        match kind {
            b"JSON" if text.is_none() => text = Some(body),
            b"BIN\0" if binary.is_none() => binary = Some(body),
            _ => {}
        }
        at += 8 + size;
    }
    Ok((text.ok_or_else(|| Error::invalid("the GLB file has no JSON chunk"))?, binary))
}

fn check_preview(preview: &Preview) -> Result<()> {
    let version = preview.asset.as_ref().map(|asset| asset.version.as_str());
    // A file without a version is rejected when all of it is read.
    if let Some(version) = version.filter(|version| version.split('.').next() != Some("2")) {
        let version: String = version.chars().take(20).collect();
        return Err(Error::unsupported(format!("glTF version “{version}”; save it as version 2.0")));
    }
    if let Some(unknown) = preview.required.iter().find(|name| !KNOWN.contains(&name.as_str())) {
        let name: String = unknown.chars().take(80).collect();
        let compressed = matches!(unknown.as_str(), "KHR_draco_mesh_compression" | "EXT_meshopt_compression");
        let advice = if compressed { "save it without compression of meshes" } else { "save it without that" };
        return Err(Error::unsupported(format!("the file requires the extension {name}; {advice}")));
    }
    let counts = [
        ("nodes", preview.nodes.len()),
        ("meshes", preview.meshes.len()),
        ("materials", preview.materials.len()),
        ("textures", preview.textures.len()),
        ("images", preview.images.len()),
        ("samplers", preview.samplers.len()),
        ("buffers", preview.buffers.len()),
        ("scenes", preview.scenes.len()),
        ("skins", preview.skins.len()),
        ("animations", preview.animations.len()),
    ];
    match counts.iter().find(|(_, count)| *count > MAX_COUNT) {
        Some((name, count)) => Err(Error::unsupported(format!("{count} {name}, at most {MAX_COUNT} are supported"))),
        None => Ok(()),
    }
}

/// Checks all indices and enumerations.
fn check(root: &json::Root) -> Result<()> {
    // The crate's validation uses this accessor index before it checks it.
    for (number, mesh) in root.meshes.iter().enumerate() {
        for primitive in &mesh.primitives {
            let positions = primitive.attributes.get(&Checked::Valid(json::mesh::Semantic::Positions));
            if positions.is_some_and(|accessor| accessor.value() >= root.accessors.len()) {
                return Err(Error::invalid(format!(
                    "mesh {number} refers to an accessor for positions that does not exist"
                )));
            }
        }
    }
    let mut first: Option<(String, Fault)> = None;
    root.validate(root, json::Path::new, &mut |path, fault| {
        if first.is_none() {
            let path = path().to_string();
            // Bounds of positions are required in files, but not used.
            let bounds = path.ends_with("POSITION\"].min") || path.ends_with("POSITION\"].max");
            // An accessor without a view is all zeros (glTF 2.0, section 5.1).
            let zeros = path.starts_with("accessors[") && path.ends_with("].bufferView") && fault == Fault::Missing;
            // A texture without an image is left out, with a note.
            let empty = path.starts_with("textures[") && path.ends_with("].source") && fault == Fault::Missing;
            if !bounds && !zeros && !empty {
                first = Some((path, fault));
            }
        }
    });
    match first {
        None => Ok(()),
        Some((path, fault)) => Err(Error::invalid(match fault {
            Fault::IndexOutOfBounds => format!("glTF: {path} is an invalid index"),
            Fault::Missing => format!("glTF: {path} is missing"),
            _ => format!("glTF: {path} has a value that is not allowed"),
        })),
    }
}
