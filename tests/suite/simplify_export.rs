//! Output files of `lightfold simplify`: glTF, OBJ, KTX2 and EXR contain the same scene.

use std::fs;
use std::path::Path;

use codec::block::{Bc6h, Bc7Rgba, BlockFormat, decode_image};
use codec::image::ReadLimits;
use footage::image_files::exr;
use half::f16;
use serde_json::Value;

use crate::commands::{fine, refused};
use crate::simplify::room;

const BUDGETS: &str = "--triangles 2000 --area 2 --peak-overdraw 3.5 --atlas 256 --effort fast --json";

fn simplified(options: &str, folder: &Path) -> Value {
    serde_json::from_slice(&fine(&format!("simplify room {BUDGETS} {options}"), folder).stdout).unwrap()
}

/// Reads a GLB file: its document, its buffers and its only texture, in RGBA.
fn glb(path: &Path) -> (gltf::Document, Vec<gltf::buffer::Data>, gltf::image::Data) {
    let (document, buffers, mut images) = gltf::import(path).unwrap();
    assert_eq!(images.len(), 1);
    (document, buffers, images.remove(0))
}

fn psnr(pairs: impl Iterator<Item = (u8, u8)>) -> f64 {
    let (sum, count) =
        pairs.fold((0.0, 0.0), |(sum, count), (a, b)| (sum + f64::from(a.abs_diff(b)).powi(2), count + 1.0));
    10.0 * (255.0f64.powi(2) * count / sum).log10()
}

fn lightfold_extras(document: &gltf::Document) -> Value {
    let extras = document.as_json().extras.as_ref().unwrap();
    serde_json::from_str::<Value>(extras.get()).unwrap()["lightfold"].clone()
}

#[test]
fn obj_and_png_hold_what_the_glb_holds() {
    let folder = room();
    let report = simplified("-o a.glb", folder.path());
    simplified("-o b.obj", folder.path());
    let (document, buffers, image) = glb(&folder.path().join("a.glb"));
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
    let (models, materials) = tobj::load_obj(folder.path().join("b.obj"), &tobj::LoadOptions::default()).unwrap();
    let [model] = &models[..] else { panic!("one mesh, in drawing order") };
    // The OBJ reader renumbers vertices, so corners are compared one by one.
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    let positions: Vec<[f32; 3]> = reader.read_positions().unwrap().collect();
    let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    assert_eq!(model.mesh.indices.len(), indices.len());
    for (&own, &other) in indices.iter().zip(&model.mesh.indices) {
        assert_eq!(&model.mesh.positions.as_chunks().0[other as usize], &positions[own as usize]);
        let ([u, v], [s, t]) = (uvs[own as usize], model.mesh.texcoords.as_chunks().0[other as usize]);
        assert!((u - s).abs() < 1e-6 && (1.0 - v - t).abs() < 1e-6);
    }
    let material = &materials.unwrap()[0];
    assert!(material.diffuse_texture.as_ref().unwrap().ends_with("b.png"));
    let png = ::image::open(folder.path().join("b.png")).unwrap().into_rgba8();
    assert!(*png.as_raw() == image.pixels);

    // Runs of blended and opaque triangles cover all triangles, and opaque ones have alpha 255.
    let extras = lightfold_extras(&document);
    let runs: Vec<usize> = serde_json::from_value(extras["runs_blended_opaque"].clone()).unwrap();
    assert_eq!(runs.iter().sum::<usize>() as u64, report["triangles"].as_u64().unwrap());
    assert!(report["counters"]["opaque_tiles"].as_u64().unwrap() > 0 && runs.len() > 2);
    let mut first = 0;
    for (at, run) in runs.iter().enumerate() {
        for corner in indices[3 * first..3 * (first + run)].iter().filter(|_| at % 2 == 1) {
            let [u, v] = uvs[*corner as usize];
            let texel = (v * image.height as f32) as usize * image.width as usize + (u * image.width as f32) as usize;
            assert_eq!(image.pixels[4 * texel + 3], 255);
        }
        first += run;
    }
    assert_eq!(extras["three_js"]["material.forceSinglePass"], true);
    assert_eq!(extras["three_js"]["renderer.sortObjects"], false);
}

#[test]
fn projective_texture_coordinates_are_in_the_glb_and_in_the_obj() {
    let folder = room();
    let report = simplified("--uv projective -o a.glb", folder.path());
    assert_eq!(report["triangles"].as_u64(), report["tiles"].as_u64().map(|tiles| 2 * tiles));
    simplified("--uv projective -o b.obj", folder.path());
    let (document, buffers, _) = glb(&folder.path().join("a.glb"));
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
    let uvs: Vec<[f32; 2]> = reader.read_tex_coords(0).unwrap().into_f32().collect();
    let accessor = primitive.get(&gltf::Semantic::Extras("TEXCOORD_STQ".into())).unwrap();
    let stq: Vec<[f32; 3]> =
        gltf::accessor::Iter::new(accessor, |buffer| Some(&buffers[buffer.index()])).unwrap().collect();
    assert_eq!(stq.len(), uvs.len());
    assert!(stq.iter().zip(&uvs).all(|(stq, uv)| (0..2).all(|at| (stq[at] / stq[2] - uv[at]).abs() < 1e-6)));
    // Some corners have different distances.
    assert!(stq.iter().any(|stq| stq[2] < 0.9));
    let obj = fs::read_to_string(folder.path().join("b.obj")).unwrap();
    let found: Vec<[f32; 3]> = (obj.lines().filter_map(|line| line.strip_prefix("vt ")))
        .map(|line| <[f32; 3]>::try_from(line.split(' ').map(|at| at.parse().unwrap()).collect::<Vec<_>>()).unwrap())
        .collect();
    let flipped = |[s, t, q]: [f32; 3]| [s, q - t, q];
    assert!(found == stq.into_iter().map(flipped).collect::<Vec<_>>());
}

#[test]
fn ktx2_files_hold_the_texture_of_the_glb() {
    let folder = room();
    let report = simplified("-o a.glb --ktx2 a.ktx2", folder.path());
    let paths: Vec<&str> =
        report["files"].as_array().unwrap().iter().map(|file| file["path"].as_str().unwrap()).collect();
    assert_eq!(paths, ["a.glb", "a.ktx2"]);
    let (document, _, image) = glb(&folder.path().join("a.glb"));
    assert_eq!(lightfold_extras(&document)["textures"], serde_json::json!(["a.ktx2"]));
    let (width, height) = (image.width as usize, image.height as usize);
    let wanted = || image.pixels.iter().copied();

    let file = fs::read(folder.path().join("a.ktx2")).unwrap();
    let reader = ktx2::Reader::new(&file).unwrap();
    assert_eq!(reader.header().format, Some(ktx2::Format::BC7_SRGB_BLOCK));
    assert_eq!([reader.header().pixel_width, reader.header().pixel_height], [image.width, image.height]);
    let mut pixels = vec![[0; 4]; width * height];
    decode_image::<Bc7Rgba>(reader.levels().next().unwrap().data, width, height, &mut pixels);
    let bc7_db = psnr(pixels.as_flattened().iter().copied().zip(wanted()));
    assert!(bc7_db > 35.0, "{bc7_db}");
}

#[test]
fn hdr_textures_keep_light_above_one() {
    let folder = room();
    let report = simplified("--hdr -o a.glb --ktx2 a.ktx2", folder.path());
    assert!(report["counters"]["float_texels"].as_u64().unwrap() > 0);
    let paths: Vec<&str> =
        report["files"].as_array().unwrap().iter().map(|file| file["path"].as_str().unwrap()).collect();
    assert_eq!(paths, ["a.glb", "a.exr", "a.ktx2"]);
    for file in report["files"].as_array().unwrap() {
        let bytes = fs::metadata(folder.path().join(file["path"].as_str().unwrap())).unwrap().len();
        assert_eq!(file["bytes"], bytes);
    }
    let limits = ReadLimits::default();
    let texels = exr::read_channels(&folder.path().join("a.exr"), ["R", "G", "B", "A"], &limits).unwrap();
    let (_, _, image) = glb(&folder.path().join("a.glb"));
    assert_eq!([texels.width(), texels.height()], [image.width, image.height]);
    // Straight alpha, equal to that of the PNG.
    for (texel, pixel) in texels.data().iter().zip(image.pixels.as_chunks::<4>().0) {
        assert_eq!((texel[3] * 255.0).round(), f32::from(pixel[3]));
    }
    assert!(texels.data().iter().any(|texel| texel[0] > 1.5));

    let file = fs::read(folder.path().join("a.ktx2")).unwrap();
    let reader = ktx2::Reader::new(&file).unwrap();
    assert_eq!(reader.header().format, Some(ktx2::Format::BC6H_UFLOAT_BLOCK));
    let blocks = reader.levels().next().unwrap().data;
    let mut decoded = vec![<Bc6h as BlockFormat>::Texel::default(); texels.data().len()];
    decode_image::<Bc6h>(blocks, image.width as usize, image.height as usize, &mut decoded);
    let close = decoded.iter().zip(texels.data()).filter(|(bits, texel)| {
        (0..3).all(|at| (f16::from_bits(bits[at]).to_f32() - texel[at]).abs() <= 0.1 * texel[at].abs() + 0.02)
    });
    let share = close.count() as f64 / decoded.len() as f64;
    assert!(share > 0.9, "{share}");

    simplified("--hdr -o b.obj", folder.path());
    assert_eq!(fs::read(folder.path().join("a.exr")).unwrap(), fs::read(folder.path().join("b.exr")).unwrap());
    assert!(fs::read_to_string(folder.path().join("b.mtl")).unwrap().contains("b.exr"));
    assert!(!folder.path().join("b.png").exists());
}

#[test]
fn normals_and_material_have_the_texture_coordinates_of_light() {
    let folder = tempfile::TempDir::new().unwrap();
    let cameras = "--position=0,1.5,0 --position=0.3,1.6,0.1 --size 32 --samples 1 --frames 0-0";
    fine(&format!("capture mirrors {cameras} --aov depth,normal,material -o room"), folder.path());
    let manifest = fs::read_to_string(folder.path().join("room/lightfield.json")).unwrap();
    assert!(serde_json::from_str::<Value>(&manifest).unwrap()["files"]["normal"].is_string());
    let report = simplified("--gbuffer -o a.glb", folder.path());
    let paths: Vec<&str> =
        report["files"].as_array().unwrap().iter().map(|file| file["path"].as_str().unwrap()).collect();
    assert_eq!(paths, ["a.glb", "a.normal.exr", "a.material.exr"]);
    let (document, buffers, image) = glb(&folder.path().join("a.glb"));
    let limits = ReadLimits::default();
    let read = |name: &str, channels| exr::read_channels(&folder.path().join(name), channels, &limits).unwrap();
    let normals = read("a.normal.exr", ["X", "Y", "Z"]);
    let materials = read("a.material.exr", ["reflect", "refract", "ior"]);
    for plane in [&normals, &materials] {
        assert_eq!([plane.width(), plane.height()], [image.width, image.height]);
    }
    assert!(materials.data().iter().any(|[reflect, ..]| *reflect > 0.4));
    // At the centroid of most triangles, the normal is the triangle's normal.
    let primitive = document.meshes().next().unwrap().primitives().next().unwrap();
    let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
    let positions: Vec<glam::Vec3> = reader.read_positions().unwrap().map(glam::Vec3::from_array).collect();
    let uvs: Vec<glam::Vec2> = reader.read_tex_coords(0).unwrap().into_f32().map(glam::Vec2::from_array).collect();
    let indices: Vec<u32> = reader.read_indices().unwrap().into_u32().collect();
    let (mut close, mut count) = (0, 0);
    for corners in indices.chunks_exact(3) {
        let [a, b, c] = [0, 1, 2].map(|at| positions[corners[at] as usize]);
        let middle = corners.iter().map(|corner| uvs[*corner as usize]).sum::<glam::Vec2>() / 3.0;
        let normal = normals.get((middle.x * image.width as f32) as u32, (middle.y * image.height as f32) as u32);
        let normal = glam::Vec3::from_array(normal);
        if normal != glam::Vec3::ZERO {
            assert!((normal.length() - 1.0).abs() < 0.01, "{normal}");
            close += u32::from((b - a).cross(c - a).normalize_or_zero().dot(normal) > 0.9);
            count += 1;
        }
    }
    assert!(count > 100 && close * 10 > count * 6, "{close} of {count}");

    let other = room();
    let said = refused("simplify room --effort fast --gbuffer -o a.glb", other.path());
    assert!(said.contains("--gbuffer needs a capture with normals or material"), "{said}");
}

#[test]
fn texture_filters_spread_light_over_fewer_or_more_texels() {
    let folder = room();
    let of = |filter: &str| {
        let report = simplified(&format!("-o {filter}.glb --texture-filter {filter}"), folder.path());
        let (document, _, image) = glb(&folder.path().join(format!("{filter}.glb")));
        let counts: Vec<usize> = document.accessors().map(|accessor| accessor.count()).collect();
        (report["counters"]["filled_texels"].as_u64().unwrap(), counts, image)
    };
    let [boxed, gaussian, spline] = ["box", "gaussian", "b-spline"].map(of);
    // The mesh does not depend on the filter; wider filters leave fewer texels without a sample.
    assert!(boxed.1 == gaussian.1 && gaussian.1 == spline.1);
    assert!(boxed.0 > gaussian.0 && gaussian.0 > spline.0, "{} {} {}", boxed.0, gaussian.0, spline.0);
    // Mean difference of neighbouring texels, most of which belong to the same tile.
    let roughness = |image: &gltf::image::Data| {
        let rows = image.pixels.chunks_exact(4 * image.width as usize);
        let pairs = rows.flat_map(|row| row.chunks_exact(4).zip(row.chunks_exact(4).skip(1)));
        pairs.map(|(a, b)| u64::from(a[1].abs_diff(b[1]))).sum::<u64>() as f64 / image.pixels.len() as f64
    };
    let [smooth, rough] = [&spline.2, &gaussian.2].map(roughness);
    assert!(smooth < 0.95 * rough, "{smooth} {rough}");
    simplified("-o default.glb", folder.path());
    let bytes = |name: &str| fs::read(folder.path().join(name)).unwrap();
    assert!(bytes("default.glb") == bytes("gaussian.glb"));
    let said = refused("simplify room -o a.glb --texture-filter lanczos", folder.path());
    assert!(said.contains("b-spline"), "{said}");
}

#[test]
fn names_that_do_not_tell_what_to_write_are_refused_before_work() {
    let folder = room();
    let cases = [
        ("-o a.ply", "a.ply: a name that ends in .glb or .obj"),
        ("-o a.glb --ktx2 a.glb", "a.glb: --ktx2 needs a different file name"),
        ("-o - --hdr", "specify an output file instead of -"),
        ("-o a.glb --ktx2 nowhere/a.ktx2", "--ktx2 nowhere/a.ktx2: there is no folder nowhere"),
    ];
    for (options, words) in cases {
        let said = refused(&format!("simplify room --effort fast {options}"), folder.path());
        assert!(said.contains(words), "{options}: {said}");
    }
    // The folder contains only the capture.
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}
