//! Valid inputs from which mutated ones are generated: the frozen vectors, small containers, images and text files.

use std::fs;
use std::path::Path;
use std::sync::{Arc, Mutex};

use cli::report::tradeoff::coding::CODING;
use codec::container::{
    ChunkKey, Compression as Stored, Journal, PackedChunk, PayloadKind, Reader, StreamEntry, Writer, compression,
};
use codec::image::Plane;
use codec::monitor::Silent;
use codec::streams::shard::{ShardEntry, WholeStream};
use codec::streams::{CodecHeader, ColorCoding};
use evaluate::cameras::{self as camera_formats, CameraFormat, Content, FileCamera, ReadSettings, Written};
use exr::prelude::{
    AnyChannel, AnyChannels, Blocks, Compression, Encoding, FlatSamples, Image, ImageAttributes, IntegerBounds, Layer,
    LayerAttributes, LineOrder, Vec2, WritableImage,
};
use footage::dataset::{Source, SourceOptions};
use footage::encode::{EncodeSettings, ScanFile, Shard};
use footage::image_files::png;
use glam::DVec3;
use half::f16;
use image::ExtendedColorType;
use image::codecs::jpeg::JpegEncoder;
use scene::mesh::{ImageTexture, Mesh, Wrap};
use simplify::export::glb as quads_glb;
use simplify::quad_mesh::QuadMesh;

use crate::model_files::{Gltf, MTL, OBJ, rich};
use crate::samples::{self, Random, Shape};
use crate::targets::cameras::{BETWEEN, SETTINGS as CAMERA_SETTINGS};
use crate::targets::stream::Case;
use crate::targets::transform;

/// Returns the containers of a folder of frozen vectors.
pub fn vectors(name: &str) -> Vec<Vec<u8>> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/vectors").join(name);
    let mut paths: Vec<_> =
        fs::read_dir(folder).expect("the vectors").map(|entry| entry.expect("a file").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "lfold"));
    paths.sort();
    paths.iter().map(|path| fs::read(path).expect("a vector")).collect()
}

/// Returns small valid containers, which run fast.
pub fn containers() -> Vec<Vec<u8>> {
    let mut all = vectors("valid");
    all.retain(|file| file.len() < 12 << 10);
    let shape = Shape { face: 2, size: [9, 6], unit: [8, 4], first_frame: 3, frame_count: 5 };
    let settings = codec::depth::TemporalSettings { window: 1, epsilon: 0, max_aabbs: 4, keyframe_interval: 2 };
    let moving = samples::moving_codes([9, 6], 5, 3);
    let streams = [
        samples::depth(shape, [0.5, 8.0], &moving, settings),
        samples::blocks(Shape { face: 1, ..shape }, &moving, 2),
        samples::material(Shape { face: 3, ..shape }, &samples::drifting_bytes([9, 6], 5), settings),
    ];
    all.push(samples::container(0, samples::probe("00", 9), &streams, Stored::None));
    all.push(samples::container(0, samples::probe("00", 9), &streams, Stored::Lzma2(6)));
    all.push(samples::container(0, samples::probe("00", 9), &streams, Stored::Zstd(9)));
    all
}

/// Returns the streams of a codec in the vectors as cases of the target `stream`.
pub fn cases(codec: [u8; 4]) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for file in vectors("valid") {
        let Ok(reader) = Reader::from_memory(file) else { continue };
        for (at, stream) in (0..).zip(&reader.index().streams).filter(|(_, stream)| stream.codec == codec) {
            for unit in 0..stream.unit_count().min(4) {
                let [_, _, width, height] = stream.unit_rect(unit);
                let chunks = reader.index().unit_chunks(at, unit);
                let frames = chunks[0].key.frame_count;
                let equal = chunks.iter().take_while(|chunk| chunk.key.frame_count == frames).take(8);
                let payloads: Vec<Vec<u8>> =
                    equal.filter_map(|chunk| reader.fetch(chunk).ok()).map(|payload| payload.to_vec()).collect();
                let is_large = frames > 256 || width.max(height) > 192 || stream.codec_header.len() > 255;
                if is_large || payloads.iter().any(|payload| payload.len() > 60_000) {
                    continue;
                }
                let unit_sides = [stream.unit_width, stream.unit_height].map(|side| side.min(192));
                let case = Case {
                    sizes: [width, height, unit_sides[0], unit_sides[1]].map(|side| side as u16 - 1),
                    frames: (frames - 1) as u8,
                    chunks: (payloads.len() - 1) as u8,
                    header: stream.codec_header.to_vec(),
                    payloads,
                };
                all.push(case.write());
            }
        }
    }
    all.sort();
    all.dedup();
    all
}

/// Returns the transform payloads of the vectors, with the table sets of their streams.
pub fn transforms() -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for file in vectors("valid") {
        let Ok(reader) = Reader::from_memory(file) else { continue };
        for (at, stream) in (0..).zip(&reader.index().streams).filter(|(_, stream)| stream.codec.starts_with(b"CTR")) {
            let own_sets = own_sets_of(stream);
            for chunk in reader.index().stream_chunks(at) {
                let [_, _, width, height] = stream.unit_rect(chunk.key.unit);
                let Ok(payload) = reader.fetch(chunk) else { continue };
                all.push(transform::Case {
                    is_half: stream.codec == *b"CTRH",
                    size: [width, height].map(|side| side as usize),
                    frames: chunk.key.frame_count,
                    own_sets: own_sets.clone(),
                    payload: payload.to_vec(),
                });
            }
        }
    }
    all.iter().map(transform::Case::write).collect()
}

/// Returns the number of a stream's own table sets and the sets, as in its codec header; empty if it has none.
fn own_sets_of(stream: &StreamEntry) -> Vec<u8> {
    let CodecHeader::Color(header) = CodecHeader::read(stream).expect("a valid header") else { return Vec::new() };
    let ColorCoding::Transform(tables) = header.coding else { return Vec::new() };
    let mut bytes = Vec::new();
    if tables.own_count() > 0 {
        bytes.push(tables.own_count());
        tables.write(&mut bytes);
    }
    bytes
}

/// Returns LZMA2 streams, each preceded by its uncompressed size.
pub fn lzma2() -> Vec<Vec<u8>> {
    compressed(|raw| compression::lzma2(raw, 6, PayloadKind::Mixed).expect("LZMA2"))
}

/// Returns Zstandard frames, each preceded by its uncompressed size.
pub fn zstd() -> Vec<Vec<u8>> {
    [1, 19].into_iter().flat_map(|level| compressed(|raw| compression::zstd(raw, level).expect("Zstandard"))).collect()
}

fn compressed(compress: impl Fn(&[u8]) -> Vec<u8>) -> Vec<Vec<u8>> {
    let mut random = Random(5);
    let noise: Vec<u8> = (0..3000).map(|_| random.below(256) as u8).collect();
    let text: Vec<u8> = (0..5000u32).map(|at| (at / 7 * at % 31) as u8).collect();
    let raws = [vec![], vec![7], vec![0; 20_000], noise, text, vec![1; 70_000]];
    let stream = |raw: &Vec<u8>| {
        let mut bytes = (raw.len() as u32).to_le_bytes().to_vec();
        bytes.extend(compress(raw));
        bytes
    };
    raws.iter().map(stream).collect()
}

/// Returns OpenEXR files in every compression, in scan lines and tiles, with half, float and integer channels, and with one and
/// several layers.
pub fn exr() -> Vec<Vec<u8>> {
    let compressions = [
        Compression::Uncompressed,
        Compression::RLE,
        Compression::ZIP1,
        Compression::ZIP16,
        Compression::PIZ,
        Compression::PXR24,
        Compression::B44,
        Compression::B44A,
        Compression::DWAA(None),
        Compression::DWAB(Some(45.0)),
    ];
    let mut all = Vec::new();
    for compression in compressions {
        for blocks in [Blocks::ScanLines, Blocks::Tiles(Vec2(8, 4))] {
            all.push(exr_file(compression, blocks, &[("Z", 'f')], 1));
            all.push(exr_file(compression, blocks, &[("Z", 'u')], 1));
            all.push(exr_file(compression, blocks, &[("R", 'h'), ("G", 'h'), ("B", 'h'), ("A", 'h'), ("Z", 'f')], 1));
            all.push(exr_file(compression, blocks, &[("B", 'f'), ("G", 'f'), ("R", 'f')], 2));
        }
    }
    let material = [("reflect", 'h'), ("refract", 'f'), ("ior", 'u')];
    all.push(exr_file(Compression::ZIP16, Blocks::ScanLines, &material, 1));
    all.push(exr_file(Compression::ZIP1, Blocks::ScanLines, &[("R", 'u'), ("G", 'h'), ("B", 'f'), ("Z", 'f')], 3));
    all
}

/// Returns the offsets of the chunks of an OpenEXR file.
pub fn exr_chunks(file: &[u8]) -> Vec<usize> {
    let mut rest = std::io::Cursor::new(file);
    let meta = exr::meta::MetaData::read_from_buffered(&mut rest, true).expect("a seed is an EXR file");
    let count: usize = meta.headers.iter().map(|header| header.chunk_count).sum();
    let table = &file[rest.position() as usize..];
    table.as_chunks::<8>().0[..count].iter().map(|place| u64::from_le_bytes(*place) as usize).collect()
}

fn exr_file(compression: Compression, blocks: Blocks, channels: &[(&str, char)], layers: usize) -> Vec<u8> {
    let size = (21, 13);
    let layer = |number: usize| {
        let samples = |kind: char| match kind {
            'f' => FlatSamples::F32((0..273).map(|i| (i / 6 * 7 % 5) as f32 / 3.0).collect()),
            'h' => FlatSamples::F16((0..273).map(|i| f16::from_f32((i / 8 % 3) as f32 / 8.0)).collect()),
            _ => FlatSamples::U32((0..273).map(|i| i / 5 * 5 % 7).collect()),
        };
        let channels = channels.iter().map(|&(name, kind)| AnyChannel::new(name, samples(kind))).collect();
        let mut attributes = LayerAttributes::named(format!("layer{number}").as_str());
        attributes.layer_position = Vec2(number as i32 - 1, 2);
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        Layer::new(size, attributes, encoding, AnyChannels::sort(channels))
    };
    let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((20, 15)));
    let image = Image::from_layers(attributes, (0..layers).map(layer).collect::<Vec<_>>());
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write().non_parallel().to_buffered(&mut bytes).expect("an EXR file");
    bytes.into_inner()
}

/// Returns PNG files of 8 and 16 bits.
pub fn png() -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("p.png");
    let mut all = Vec::new();
    png::write_color8(&path, &Plane::from_fn(13, 7, |x, y| [(x * 20) as u8, (y * 30) as u8, 9])).expect("a PNG file");
    all.push(fs::read(&path).expect("a PNG file"));
    png::write_depth16(&path, &Plane::from_fn(9, 11, |x, y| (x * 3001 + y * 257) as u16)).expect("a PNG file");
    all.push(fs::read(&path).expect("a PNG file"));
    all
}

/// Returns a glTF scene of one triangle.
fn triangle() -> Gltf {
    let mut file = Gltf::new();
    let mesh = file.triangle();
    file.root_node(serde_json::json!({ "mesh": mesh, "rotation": [0.0, 0.6, 0.0, 0.8] }));
    file
}

pub fn gltf() -> Vec<Vec<u8>> {
    vec![rich().text(), triangle().text()]
}

pub fn glb() -> Vec<Vec<u8>> {
    vec![rich().glb(), triangle().glb()]
}

/// Returns simplified scenes as GLB files, with affine and with projective texture coordinates.
pub fn quads() -> Vec<Vec<u8>> {
    let corners = [[-1.0, 1.0], [1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]];
    let mesh = Mesh {
        positions: corners.map(|[x, y]| DVec3::new(x, y, -2.0)).to_vec(),
        uvs: corners.map(|[x, y]| glam::Vec2::new(0.5 + 0.4 * x as f32, 0.5 - 0.4 * y as f32)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        material_of: vec![0; 2],
        ..Mesh::default()
    };
    let pixels = vec![[10, 20, 30, 255], [200, 100, 0, 128], [0, 0, 255, 0], [255; 4]];
    let texture = Arc::new(ImageTexture { width: 2, height: 2, pixels, wrap: [Wrap::Clamp; 2] });
    let mut scene = QuadMesh { mesh, texture, stq: Vec::new(), light: None, runs: Vec::new() };
    let written = |scene: &QuadMesh| {
        let mut bytes = Vec::new();
        quads_glb::write(scene, serde_json::json!({ "lightfold": { "frame": 3 } }), None, &mut bytes)
            .expect("a scene is written");
        bytes
    };
    let affine = written(&scene);
    scene.stq = scene.mesh.uvs.iter().map(|uv| uv.extend(1.0) * 0.5).collect();
    vec![affine, written(&scene)]
}

pub fn obj() -> Vec<Vec<u8>> {
    vec![OBJ.into(), b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1e30\nf 1 2 3 4\nf 1// 2// -1//\n".to_vec()]
}

pub fn mtl() -> Vec<Vec<u8>> {
    vec![MTL.into(), b"newmtl b\nKd 0.5\nillum 5\nTr 0.5\n".to_vec()]
}

/// Returns light field manifests.
pub fn manifests() -> Vec<Vec<u8>> {
    [
        r#"{"lightfield":1,"name":"room","fps":24,"frames":[0,9],"projection":"cubemap","size":[256,256],
            "faces_present":["px","nz"],"depth":{"kind":"planar","unit":"cm","background":"inf","near":0.1,"far":50},
            "color":{"space":"linear-rec709"},"files":{"color":"{probe}/{face}.%04d.exr","depth":"d/{probe}_{face}.####.exr"},
            "probes":[{"name":"00","position":[0,1,2],"orientation":[0,0,0,1]},{"name":"a.b","position":[1,1,1],"frames":[2,5]}]}"#,
        r#"{"lightfield":1,"name":"view","fps":29.97,"frames":[5,5],"projection":"perspective","size":[640,480],
            "depth":{"scale":0.001,"background":0},"material":{"channels":{"reflection":"a","refraction":"b","ior":"c"}},
            "files":{"depth":"x@@@@.png","material":"m%d.exr"},"extra":{"anything":[1,2,{"x":null}]},
            "probes":[{"name":"0","position":[0,0,0],"fov_y_deg":60}]}"#,
        r#"{"lightfield":1,"name":"pano","fps":1,"frames":[0,4294967295],"projection":"equirect","size":[64,32],
            "color":{"space":"srgb"},"files":{"color":"{probe}.%d.png"},
            "probes":[{"name":"p-1","position":[1e3,0,-2.5],"extra":"kept"}]}"#,
        r#"{"lightfield":1,"name":"cross","fps":60,"frames":[1,2],"projection":"cubemap","faces":"opengl-cube-cross",
            "size":[64,48],"files":{"color":"c.%06d.exr"},"probes":[{"name":"x","position":[0,0,0]}]}"#,
        r#"{"lightfield":1,"name":"kinect","fps":30,"frames":[1,2],"projection":"perspective","size":[64,48],
            "files":{"depth":"c.%06d.exr"},"probes":[{"name":"x","position":[0,0,0],"intrinsics":[525,525,32,24]}]}"#,
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// Returns manifests of Seurat captures: perspective cameras with and without a far plane, orthographic ones, and matrices with w
/// of 1 and 2.
pub fn seurat_manifests() -> Vec<Vec<u8>> {
    let view = |clip_from_eye: &str, world_from_eye: &str, depth_type: &str| {
        format!(
            r#"{{"projective_camera":{{"image_width":64,"image_height":48,"clip_from_eye_matrix":[{clip_from_eye}],
            "world_from_eye_matrix":[{world_from_eye}],"depth_type":"{depth_type}"}},"depth_image_file":{{"color":
            {{"path":"none/c.exr","channel_0":"R","channel_1":"CONSTANT_ZERO","channel_2":"b.x","channel_alpha":"CONSTANT_ONE"}},
            "depth":{{"path":"none/d.png","channel_0":"R"}}}}}}"#
        )
    };
    let identity = "1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1";
    let (moved, scaled) = ("1,0,0,1.5, 0,1,0,-2, 0,0,1,3e2, 0,0,0,1", "-2,0,0,0, 0,2,0,0, 0,0,2,0, 0,0,0,2");
    let finite = "1.5,0,0.25,0, 0,2,-0.5,0, 0,0,-1.0202,-0.20202, 0,0,-1,0";
    let infinite = "1,0,0,0, 0,1,0,0, 0,0,-1,-0.2, 0,0,-1,0";
    let views = [
        view(finite, moved, "WINDOW_Z"),
        view(infinite, scaled, "EYE_Z"),
        view(identity, scaled, "RAY_DEPTH"),
        view(infinite, identity, "WINDOW_Z"),
    ];
    let all = format!(r#"{{"headbox_center":[0,1,-2.5],"view_groups":[{{"views":[{}]}}]}}"#, views.join(","));
    let groups = views.map(|view| format!(r#"{{"views":[{view}],"name":"left"}}"#));
    [all, format!(r#"{{"view_groups":[{}]}}"#, groups.join(","))].map(String::into_bytes).to_vec()
}

/// Returns camera files.
pub fn cameras() -> Vec<Vec<u8>> {
    [
        r#"{"cameras":[{"eye":[1,2,3],"look_at":[1,2,0],"up":[0,1,0],"fov_y_deg":90,"aspect":1.5,"frames":[2,4]},
            {"eye":[1,2,3],"orientation":[0,0,0,1],"fov_y_deg":90,"near_m":0.1,"far_m":50}]}"#,
        r#"{"cameras":[{"eye":[0,0,0],"look_at":[0,0,-1],"fov_y_deg":60}]}"#,
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// Returns JPEG files, in colour and in grey.
pub fn jpeg() -> Vec<Vec<u8>> {
    let pixels: Vec<u8> = (0..3 * 24 * 17u32).map(|at| (at / 5 * 7 % 251) as u8).collect();
    let jpeg = |size: [u32; 2], color: ExtendedColorType, quality: u8| {
        let bytes = size[0] as usize * size[1] as usize * if color == ExtendedColorType::Rgb8 { 3 } else { 1 };
        let mut file = Vec::new();
        let mut encoder = JpegEncoder::new_with_quality(&mut file, quality);
        encoder.encode(&pixels[..bytes], size[0], size[1], color).expect("a JPEG file");
        file
    };
    let rgb = ExtendedColorType::Rgb8;
    vec![jpeg([24, 17], rgb, 90), jpeg([16, 16], rgb, 20), jpeg([9, 31], ExtendedColorType::L8, 75)]
}

/// Returns textures: PNG and JPEG files.
pub fn textures() -> Vec<Vec<u8>> {
    [png(), jpeg()].concat()
}

/// Returns the camera files of [`cameras`] in another program's format.
pub fn camera_files(format: CameraFormat) -> Vec<Vec<u8>> {
    let files = cameras();
    let read = files.iter().map(|bytes| {
        let path = Path::new("cameras.json");
        camera_formats::parse(&Content { path, bytes, settings: ReadSettings::with_fps(24.0) })
            .expect("cameras")
            .cameras
    });
    let written = |cameras: Vec<FileCamera>| match camera_formats::write(&cameras, format, &CAMERA_SETTINGS) {
        Ok(Written::File(bytes)) => bytes,
        Ok(Written::Folder(files)) => {
            let text = |name: &str| files.iter().find(|(of, _)| *of == name).map_or("", |(_, text)| text.as_str());
            [text("cameras.txt").as_bytes(), BETWEEN, text("images.txt").as_bytes()].concat()
        }
        Err(error) => panic!("cameras are not written: {error}"),
    };
    read.map(written).collect()
}

/// Returns glTF files with static cameras, cameras below other nodes, and animated cameras.
pub fn cameras_gltf() -> Vec<Vec<u8>> {
    [
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"camera":0,"name":"a","translation":[1,2,3],
            "rotation":[0,0.6,0,0.8]},{"children":[2],"matrix":[1,0,0,0,0,1,0,0,0,0,1,0,4,5,6,1]},{"camera":1,"scale":[2,2,2]}],
            "cameras":[{"type":"perspective","perspective":{"yfov":1.0,"znear":0.1,"aspectRatio":1.5}},
            {"type":"perspective","perspective":{"yfov":0.5,"znear":0.1,"zfar":100}}]}"#,
        r#"{"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"camera":0}],
            "cameras":[{"type":"perspective","perspective":{"yfov":1.0,"znear":0.1}}],
            "buffers":[{"byteLength":32,"uri":"data:application/octet-stream;base64,AAAAAKuqKj0AAAAAAAAAAAAAAAAAAIA/AAAAQAAAQEA="}],
            "bufferViews":[{"buffer":0,"byteLength":8},{"buffer":0,"byteOffset":8,"byteLength":24}],
            "accessors":[{"bufferView":0,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[0.0416667]},
            {"bufferView":1,"componentType":5126,"count":2,"type":"VEC3"}],
            "animations":[{"samplers":[{"input":0,"output":1}],"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}]}]}"#,
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// Returns scans of two frames of depth and colour: of all footage, and of one of two shards.
pub fn scans() -> Vec<Vec<u8>> {
    let folder = tempfile::tempdir().expect("a folder");
    let manifest = r#"{"lightfield":1,"name":"view","fps":24,"frames":[0,1],"projection":"perspective","size":[8,4],
        "files":{"color":"c.%04d.exr","depth":"d.%04d.exr"},"probes":[{"name":"0","position":[0,0,0],"fov_y_deg":60}]}"#;
    fs::write(folder.path().join("lightfield.json"), manifest).expect("the manifest");
    for frame in 0..2 {
        let depth = Plane::from_fn(8, 4, |x, y| 1.0 + (x * 3 + y + frame) as f32);
        let color = Plane::from_fn(8, 4, |x, y| [f16::from_f32((x + y + frame) as f32 / 16.0); 3]);
        footage::image_files::exr::write_depth(&folder.path().join(format!("d.{frame:04}.exr")), &depth)
            .expect("depth");
        footage::image_files::exr::write_color(&folder.path().join(format!("c.{frame:04}.exr")), &color)
            .expect("colour");
    }
    let source = Source::open(folder.path(), &SourceOptions::default()).expect("footage");
    let settings = EncodeSettings::default();
    [None, Some(Shard { number: 1, count: 2 })]
        .map(|shard| {
            let mut scan = ScanFile::new(&source);
            scan.scan(&source, &settings, shard, &Silent, &mut |_| Ok(())).expect("a scan");
            scan.to_json().expect("a scan").into_bytes()
        })
        .to_vec()
}

/// Returns shard entries with 0, 1 and 5 streams.
pub fn shards() -> Vec<Vec<u8>> {
    let stream = |at: u32| WholeStream {
        kind: (at % 3) as u8,
        probe: at as u16 * 300,
        face: (at % 6) as u8,
        group: at,
        first_frame: 200 * at,
        frame_count: 1 + at,
    };
    [0, 1, 5]
        .map(|count| ShardEntry {
            job: [7; 16],
            number: 1 + count,
            count: 200,
            streams: (0..count).map(stream).collect(),
        })
        .map(|entry| entry.write())
        .to_vec()
}

/// Returns CSV files of sweeps.
pub fn sweeps() -> Vec<Vec<u8>> {
    let knobs: Vec<&str> = CODING.knobs.iter().map(|knob| knob.name).collect();
    let figures: Vec<&str> = CODING.measures.iter().map(|measure| measure.name).collect();
    let heads = [&["studies", "kind"][..], &knobs, &figures, &["command", "made_of"]].concat();
    let row = |kind: &str, psnr: &str| {
        let cell = |head: &&str| match *head {
            "studies" => "color-psnr;cells".to_owned(),
            "kind" => kind.to_owned(),
            "psnr" => psnr.to_owned(),
            "psnr_db" => "inf".to_owned(),
            "min_psnr_db" => "40.125".to_owned(),
            "encode_runs" | "decode_runs" => "0.5;0.25".to_owned(),
            "command" => "\"lightfold encode 'a, \"\"b\"\"' -o point.lfold\"".to_owned(),
            "made_of" => "00abcdef".to_owned(),
            name if figures.contains(&name) => "17".to_owned(),
            _ => String::new(),
        };
        heads.iter().map(cell).collect::<Vec<_>>().join(",")
    };
    let rows = [heads.join(","), row("color", "30"), row("color", "40"), row("depth", "")];
    vec![format!("{}\n", rows.join("\n")).into_bytes(), format!("{}\n", heads.join(",")).into_bytes()]
}

/// Returns `.cube` files with a table of one dimension, of three, and of both.
pub fn lookup_tables() -> Vec<Vec<u8>> {
    let corners: String = (0..8).map(|at| format!("{} {} {}\n", at & 1, at >> 1 & 1, at >> 2)).collect();
    let curve = "0 0 0\n0.25 0.5 0.125\n1 1 1\n";
    [
        format!("TITLE \"a\"\n# a\nLUT_1D_SIZE 3\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 4 4 4\n{curve}"),
        format!("LUT_3D_SIZE 2\n\n{corners}"),
        format!(
            "LUT_1D_SIZE 3\nLUT_1D_INPUT_RANGE -0.01 222.8\nLUT_3D_SIZE 2\nLUT_3D_INPUT_RANGE 0 1\n{curve}{corners}"
        ),
    ]
    .map(String::into_bytes)
    .into()
}

/// Returns file name patterns and frame ranges.
pub fn patterns() -> Vec<Vec<u8>> {
    [
        "a/b.%04d.exr",
        "b%d.exr",
        "b.#.exr",
        "b@@@.exr",
        "b%%%01d.exr",
        "shot#1/b.exr",
        "é#.png",
        "3-9",
        "7",
        "0-4294967295",
        "",
    ]
    .map(|text| text.as_bytes().to_vec())
    .to_vec()
}

/// Returns journals with their containers.
pub fn journals() -> Vec<Vec<u8>> {
    [0, 3, 9].map(journal).to_vec()
}

/// Returns a journal of `chunks` chunks with a note before each, and its container. Chunks from the sixth on have equal bytes.
fn journal(chunks: u32) -> Vec<u8> {
    let sink = Shared::default();
    let journal = Journal::start(Box::new(sink.clone()), b"what is encoded, and how");
    let mut container = Vec::new();
    let mut writer = Writer::new(&mut container, "journal", 24.0, 0).unwrap().with_journal(journal);
    for at in 0..chunks {
        writer.note(&[at as u8; 5]);
        let key = ChunkKey { stream: 0, unit: at, first_frame: 3, frame_count: 1 + at };
        let payload = vec![at.min(5) as u8; 40];
        let compression = [Stored::Lzma2(0), Stored::None, Stored::Zstd(1)][at as usize % 3];
        writer.push(&PackedChunk::new(key, payload, (compression, PayloadKind::Mixed)).unwrap()).unwrap();
    }
    writer.checkpoint().unwrap();
    drop(writer);
    let journal = sink.0.lock().unwrap();
    [&(journal.len() as u32).to_le_bytes(), journal.as_slice(), &container].concat()
}

/// Shared buffer, which implements `Write`.
#[derive(Clone, Default)]
struct Shared(Arc<Mutex<Vec<u8>>>);

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}
