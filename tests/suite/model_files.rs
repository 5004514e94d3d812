//! Small glTF, GLB, OBJ and MTL files, built in code.

use serde_json::{Value, json};

/// Builder of a glTF document with one buffer.
pub struct Gltf {
    /// The JSON document without `buffers`, which [`Self::glb`] and [`Self::text`] add.
    pub root: Value,
    /// Bytes of the buffer.
    pub buffer: Vec<u8>,
}

impl Gltf {
    /// Creates a document with an empty scene.
    pub fn new() -> Gltf {
        let root = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": []
        });
        Gltf { root, buffer: Vec::new() }
    }

    /// Appends an element to a list of the document and returns its index.
    pub fn push(&mut self, list: &str, value: Value) -> usize {
        let list = &mut self.root[list];
        if list.is_null() {
            *list = json!([]);
        }
        let list = list.as_array_mut().unwrap();
        list.push(value);
        list.len() - 1
    }

    /// Appends bytes to the buffer and adds a buffer view of them.
    pub fn view(&mut self, bytes: &[u8]) -> usize {
        let offset = self.buffer.len();
        self.buffer.extend_from_slice(bytes);
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.push("bufferViews", json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() }))
    }

    /// Adds an accessor of 32-bit floats of a type such as `VEC3`.
    pub fn floats(&mut self, kind: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        let view = self.view(&bytes);
        let count = values.len() / width;
        self.push("accessors", json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind }))
    }

    /// Adds an accessor of unsigned 16-bit integers.
    pub fn shorts(&mut self, kind: &str, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = values.len() / if kind == "VEC4" { 4 } else { 1 };
        self.push("accessors", json!({ "bufferView": view, "componentType": 5123, "count": count, "type": kind }))
    }

    /// Adds a mesh of one primitive.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// Adds a node to the scene.
    pub fn root_node(&mut self, node: Value) -> usize {
        let number = self.push("nodes", node);
        self.root["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(number));
        number
    }

    /// Adds a mesh of one triangle with the corners (0, 0, 0), (1, 0, 0), (0, 1, 0), which faces +Z.
    pub fn triangle(&mut self) -> usize {
        let positions = self.floats("VEC3", &TRIANGLE);
        self.mesh(json!({ "attributes": { "POSITION": positions } }))
    }

    /// Adds an animation of one channel.
    pub fn animate(&mut self, node: usize, path: &str, sampler: Value) -> usize {
        let channel = json!({ "sampler": 0, "target": { "node": node, "path": path } });
        self.push("animations", json!({ "channels": [channel], "samplers": [sampler] }))
    }

    fn finished(&self, uri: Option<String>) -> Value {
        let mut root = self.root.clone();
        let mut buffer = json!({ "byteLength": self.buffer.len() });
        if let Some(uri) = uri {
            buffer["uri"] = json!(uri);
        }
        if !self.buffer.is_empty() {
            root["buffers"] = json!([buffer]);
        }
        root
    }

    /// Returns the document as a GLB file.
    pub fn glb(&self) -> Vec<u8> {
        let mut text = self.finished(None).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let length = 12 + 8 + text.len() + 8 + self.buffer.len();
        let mut file = b"glTF".to_vec();
        for word in [2, length as u32, text.len() as u32] {
            file.extend(word.to_le_bytes());
        }
        file.extend(b"JSON");
        file.extend(&text);
        file.extend((self.buffer.len() as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(&self.buffer);
        file
    }

    /// Returns the document as a glTF file whose buffer is at a URI.
    pub fn text_with(&self, uri: &str) -> Vec<u8> {
        self.finished(Some(uri.to_string())).to_string().into_bytes()
    }

    /// Returns the document as a glTF file with an embedded buffer.
    pub fn text(&self) -> Vec<u8> {
        self.text_with(&format!("data:application/octet-stream;base64,{}", base64(&self.buffer)))
    }
}

/// Corners of [`Gltf::triangle`].
pub const TRIANGLE: [f32; 9] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0];

/// Encodes bytes as base64 (RFC 4648, section 4).
pub fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let word = group.iter().chain(&[0, 0]).take(3).fold(0, |word, &byte| word << 8 | usize::from(byte));
        for at in 0..4 {
            let letter = LETTERS[word >> (18 - 6 * at) & 63] as char;
            text.push(if at <= group.len() { letter } else { '=' });
        }
    }
    text
}

/// Returns a PNG file of 8-bit RGBA pixels.
pub fn png(width: u32, height: u32, pixels: &[[u8; 4]]) -> Vec<u8> {
    let image = image::RgbaImage::from_raw(width, height, pixels.as_flattened().to_vec()).unwrap();
    let mut file = std::io::Cursor::new(Vec::new());
    image.write_to(&mut file, image::ImageFormat::Png).unwrap();
    file.into_inner()
}

/// Returns a document that uses many features: a textured quad that rotates, a bar with a skin of two joints and a morph target,
/// and a lamp.
pub fn rich() -> Gltf {
    let mut file = Gltf::new();
    let picture = file.view(&png(2, 2, &[[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 0], [255; 4]]));
    let image = file.push("images", json!({ "bufferView": picture, "mimeType": "image/png" }));
    let sampler = file.push("samplers", json!({ "wrapS": 33071, "wrapT": 33648 }));
    let texture = file.push("textures", json!({ "source": image, "sampler": sampler }));
    let moved = json!({ "KHR_texture_transform": { "offset": [0.25, 0.0], "rotation": 0.5, "scale": [2.0, 2.0] } });
    let painted = file.push(
        "materials",
        json!({ "name": "painted", "alphaMode": "MASK", "alphaCutoff": 0.25, "emissiveFactor": [0.5, 0.0, 0.0],
                "pbrMetallicRoughness": { "baseColorTexture": { "index": texture, "extensions": moved },
                                          "metallicFactor": 0.25, "roughnessFactor": 0.5 } }),
    );
    let quad = file.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let normals = file.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let uvs = file.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let order = file.shorts("SCALAR", &[0, 1, 2, 0, 2, 3]);
    let mesh = file.mesh(json!({ "attributes": { "POSITION": quad, "NORMAL": normals, "TEXCOORD_0": uvs },
                                 "indices": order, "material": painted }));
    let turning = file.root_node(json!({ "mesh": mesh, "translation": [0.0, 1.0, 0.0] }));
    let glass = file.push(
        "materials",
        json!({ "extensions": { "KHR_materials_transmission": { "transmissionFactor": 1.0 }, "KHR_materials_ior": { "ior": 1.4 } } }),
    );
    let shift = file.floats("VEC3", &[0.0, 0.0, 0.5].repeat(4));
    let joints = file.shorts("VEC4", &[[0, 0, 0, 0], [0, 0, 0, 0], [0, 1, 0, 0], [1, 0, 0, 0]].concat());
    let weights = file.floats(
        "VEC4",
        &[[1.0, 0.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0]].concat(),
    );
    let bar = file.push(
        "meshes",
        json!({ "weights": [0.5], "primitives": [{ "mode": 5, "material": glass, "targets": [{ "POSITION": shift }],
                "attributes": { "POSITION": quad, "JOINTS_0": joints, "WEIGHTS_0": weights } }] }),
    );
    let elbow = file.push("nodes", json!({ "translation": [0.0, 1.0, 0.0] }));
    let shoulder = file.root_node(json!({ "children": [elbow] }));
    let identity = [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let mut lowered = identity;
    lowered[13] = -1.0;
    let bind = file.floats("MAT4", &[identity, lowered].concat());
    let skin = file.push("skins", json!({ "joints": [shoulder, elbow], "inverseBindMatrices": bind }));
    let bending = file.root_node(json!({ "mesh": bar, "skin": skin }));
    file.root["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "spot", "intensity": 10.0, "range": 20.0, "spot": { "innerConeAngle": 0.2, "outerConeAngle": 0.5 } }] } });
    file.root_node(json!({ "extensions": { "KHR_lights_punctual": { "light": 0 } }, "matrix":
        [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 3.0, 1.0] }));
    let times = file.floats("SCALAR", &[0.0, 2.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turn = file.floats("VEC4", &[0.0, 0.0, 0.0, 1.0, 0.0, half, 0.0, half]);
    let swell = file.floats("SCALAR", &[0.0, 0.0, 1.0, -1.0, 1.0, 0.0]);
    let sampler = |output: usize, how: &str| json!({ "input": times, "output": output, "interpolation": how });
    let channel = |sampler: usize, node: usize, path: &str| json!({ "sampler": sampler, "target": { "node": node, "path": path } });
    file.push(
        "animations",
        json!({ "name": "all", "samplers": [sampler(turn, "LINEAR"), sampler(swell, "CUBICSPLINE"), sampler(turn, "STEP")],
                "channels": [channel(0, turning, "rotation"), channel(1, bending, "weights"), channel(2, elbow, "rotation")] }),
    );
    file
}

/// OBJ file with the statements that are usual in such files.
pub const OBJ: &str = "# a comment\nmtllib none.mtl\no one\nv 0 0 0 1 0 0\nv 1 0 0\nv 1 1 0 1\nv 0 1 0.5\nvt 0 0\nvt 1 0\n\
    vt 1 1\nvt 0 1\nvn 0 0 1\nusemtl red\nf 1/1/1 2/2/1 3/3/1 \\\n4/4/1\ng two\nf -4//1 -2//1 -1//1\nf 1 2 3\nl 1 2 3\np 1\ns off\n";

/// MTL file with the statements that are usual in such files.
pub const MTL: &str = "newmtl a\nKa 1 1 1\nKd 0.5 0.25 1\nKs 0.5 0.5 0.5\nKe 1 0 0\nNs 20\nNi 1.5\nd 0.75\nillum 2\nTf 1 1 1\n\
    map_Kd -clamp on -s 1 1 1 none.png\nmap_d ../none.png\nnewmtl b\nKd 0.5\nillum 7\nTr 0.25\nmap_Ke none.png\n";
