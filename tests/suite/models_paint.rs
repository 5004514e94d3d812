//! Materials, textures and lights of mesh files.

use glam::{DVec2, DVec3};
use scene::mesh::Wrap;
use scene::{MeshMaterial, Model, Optics, Window, trace};
use serde_json::{Value, json};

use crate::model_files::{Gltf, TRIANGLE, base64, png};
use crate::models::{HALF, first, on_node, open, open_beside};

fn material(value: &Value) -> (MeshMaterial, Vec<String>) {
    let mut file = Gltf::new();
    let positions = file.floats("VEC3", &TRIANGLE);
    file.push("materials", value.clone());
    let mesh = file.mesh(json!({ "attributes": { "POSITION": positions }, "material": 0 }));
    file.root_node(json!({ "mesh": mesh }));
    let (model, notes) = open(&file);
    let mesh = first(&model);
    (mesh.materials[mesh.material_of[0] as usize].clone(), notes)
}

#[test]
fn materials_become_what_rays_are_shaded_with() {
    let rough = |base: f64, metallic: f64, roughness: f64| json!({ "pbrMetallicRoughness": { "baseColorFactor": [base, base, base, 1.0], "metallicFactor": metallic, "roughnessFactor": roughness } });
    // Plastic: reflectance of 4% at normal incidence, exponent (2/α² − 2)/4 with α = 0.25.
    let (plastic, _) = material(&rough(0.5, 0.0, 0.5));
    assert_eq!((plastic.plain.base_color, plastic.optics), (DVec3::splat(0.5), Optics::Opaque));
    assert!(
        (plastic.phong.exponent - 7.5).abs() < 1e-9 && (plastic.phong.weight.x - 0.04).abs() < 1e-9,
        "{:?}",
        plastic.phong
    );
    let (steel, _) = material(&rough(0.5, 1.0, 0.5));
    assert_eq!((steel.plain.base_color, steel.phong.weight), (DVec3::ZERO, DVec3::splat(0.5)));
    let (mirror, _) = material(&rough(0.5, 1.0, 0.0));
    assert_eq!((mirror.optics, mirror.plain.base_color), (Optics::Mirror { tint: DVec3::splat(0.5) }, DVec3::ZERO));
    let (matt, _) = material(&rough(1.0, 0.0, 1.0));
    assert_eq!(matt.phong.exponent, 1.0);
    let mut glass = rough(1.0, 0.0, 0.0);
    glass["extensions"] =
        json!({ "KHR_materials_transmission": { "transmissionFactor": 0.9 }, "KHR_materials_ior": { "ior": 1.33 } });
    let Optics::Glass { ior, tint } = material(&glass).0.optics else { panic!("glass") };
    assert!((ior - 1.33).abs() < 1e-6 && tint == DVec3::ONE);
    glass["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = json!(0.4);
    assert_eq!(material(&glass).0.optics, Optics::Opaque);
    let (lamp, _) = material(
        &json!({ "emissiveFactor": [1.0, 0.5, 0.0], "extensions": { "KHR_materials_emissive_strength": { "emissiveStrength": 8.0 } } }),
    );
    assert_eq!(lamp.plain.emission, DVec3::new(8.0, 4.0, 0.0));
    let (sign, _) = material(
        &json!({ "extensions": { "KHR_materials_unlit": {} }, "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.5, 0.25, 1.0] } }),
    );
    assert_eq!(
        (sign.plain.unlit, sign.plain.base_color, sign.phong.weight),
        (true, DVec3::new(1.0, 0.5, 0.25), DVec3::ZERO)
    );
    let (masked, notes) = material(&json!({ "alphaMode": "MASK", "alphaCutoff": 0.25 }));
    assert_eq!((masked.plain.alpha_cutoff, notes.len()), (Some(0.25), 0));
    let (veil, notes) = material(
        &json!({ "name": "veil", "alphaMode": "BLEND", "pbrMetallicRoughness": { "baseColorFactor": [1.0, 1.0, 1.0, 0.75] } }),
    );
    assert_eq!((veil.plain.alpha_cutoff, veil.plain.alpha), (Some(0.5), 0.75));
    assert!(notes.len() == 1 && notes[0].contains("veil"), "{notes:?}");
    let glossy = json!({ "extensions": { "KHR_materials_pbrSpecularGlossiness": { "diffuseFactor": [0.5, 0.5, 0.5, 1.0], "specularFactor": [0.25, 0.25, 0.25], "glossinessFactor": 0.5 } } });
    let (glossy, _) = material(&glossy);
    assert_eq!((glossy.plain.base_color, glossy.phong.weight), (DVec3::splat(0.5), DVec3::splat(0.25)));
    let (odd, _) = material(&json!({ "pbrMetallicRoughness": { "baseColorFactor": [7.0, -1.0, 0.5, 1.0] } }));
    assert_eq!(odd.phong.weight, DVec3::new(1.0, 0.0, 0.5), "of a metal, as the file says nothing else");
}

#[test]
fn highlights_are_about_as_wide_as_those_of_microfacets() {
    for roughness in [0.3_f64, 0.6] {
        let (metal, _) = material(&json!({ "pbrMetallicRoughness": { "roughnessFactor": roughness } }));
        // Angle at which a lobe cosⁿ about the mirror direction falls to half of its peak.
        let phong = 0.5_f64.powf(metal.phong.exponent.recip()).acos();
        // GGX is half of its peak at an angle h of the half vector where (cos²h (α² − 1) + 1)² = 2 α⁴; the ray is then 2 h from
        // the mirror direction.
        let squared = roughness.powi(4);
        let half = ((1.0 - 2.0_f64.sqrt() * squared) / (1.0 - squared)).sqrt().acos();
        let ratio = phong / (2.0 * half);
        // The exponent about the half vector, four times as large, would give a ratio of 0.65.
        assert!((0.85..1.35).contains(&ratio), "roughness {roughness}: {ratio}");
    }
}

#[test]
fn textures_are_where_their_coordinates_say() {
    let pixels = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 0], [255; 4]];
    let file = |info: Value, sampler: Value| {
        let mut file = Gltf::new();
        let picture = file.view(&png(2, 2, &pixels));
        file.push("images", json!({ "bufferView": picture }));
        file.push("samplers", sampler);
        file.push("textures", json!({ "source": 0, "sampler": 0 }));
        let mut base = json!({ "index": 0 });
        base.as_object_mut().unwrap().extend(info.as_object().unwrap().clone());
        file.push("materials", json!({ "pbrMetallicRoughness": { "baseColorTexture": base, "metallicFactor": 0.0 } }));
        let positions = file.floats("VEC3", &TRIANGLE);
        let set0 = file.floats("VEC2", &[0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
        let set1 = file.floats("VEC2", &[0.5; 6]);
        let mesh = file.mesh(
            json!({ "attributes": { "POSITION": positions, "TEXCOORD_0": set0, "TEXCOORD_1": set1 }, "material": 0 }),
        );
        file.root_node(json!({ "mesh": mesh }));
        open(&file)
    };
    let uvs = |info: Value| {
        let (model, notes) = file(info, json!({ "wrapS": 33071, "wrapT": 33648 }));
        assert!(notes.is_empty(), "{notes:?}");
        let mesh = first(&model);
        let texture = mesh.materials[1].plain.base_texture.clone().unwrap();
        assert_eq!((texture.wrap, texture.pixels.as_slice()), ([Wrap::Clamp, Wrap::Mirror], &pixels[..]));
        assert_eq!(texture.sample(DVec2::new(0.25, 0.25)), (DVec3::X, 1.0), "the first pixel is the top left one");
        assert_eq!(mesh.uv(0, DVec2::X), mesh.uvs[1].as_dvec2());
        mesh.uvs.iter().map(|uv| uv.to_array()).collect::<Vec<_>>()
    };
    assert_eq!(uvs(json!({})), [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
    assert_eq!(uvs(json!({ "texCoord": 1 })), [[0.5; 2]; 3]);
    let moved = json!({ "offset": [0.25, 0.5], "scale": [2.0, 4.0] });
    assert_eq!(
        uvs(json!({ "extensions": { "KHR_texture_transform": moved } })),
        [[0.25, 0.5], [2.25, 0.5], [0.25, 4.5]]
    );
    // A rotation by 90° counter-clockwise with v pointing down: right becomes up.
    let turned = uvs(json!({ "extensions": { "KHR_texture_transform": { "rotation": std::f32::consts::FRAC_PI_2 } } }));
    for (uv, expected) in turned.iter().zip([[0.0, 0.0], [0.0, -1.0], [1.0, 0.0]]) {
        assert!((uv[0] - expected[0]).abs() < 1e-6 && (uv[1] - expected[1]).abs() < 1e-6, "{turned:?}");
    }
    let other = json!({ "texCoord": 0, "extensions": { "KHR_texture_transform": { "texCoord": 1 } } });
    assert_eq!(uvs(other), [[0.5; 2]; 3]);
}

#[test]
fn a_texture_that_is_missing_broken_or_too_large_is_a_note() {
    let mut bomb = png(1, 1, &[[0; 4]]);
    // The header claims 60,000 × 60,000 pixels and has a valid CRC-32.
    bomb[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]);
    let crc = crc32fast::hash(&bomb[12..29]).to_be_bytes();
    bomb[29..33].copy_from_slice(&crc);
    let mut torn = png(2, 2, &[[9; 4]; 4]);
    torn.truncate(50);
    let inside = |bytes: &[u8]| format!("data:image/png;base64,{}", base64(bytes));
    let cases = [
        ("none.png".to_string(), "none.png"),
        ("../a.png".to_string(), "leads out"),
        ("%2e%2e/a.png".to_string(), "leads out"),
        ("/etc/passwd".to_string(), "absolute"),
        ("http://example.com/a.png".to_string(), "remote"),
        ("file:///etc/passwd".to_string(), "remote"),
        ("data:image/png;base64,????".to_string(), "base64"),
        ("data:,".to_string(), "base64"),
        (inside(b"GIF89a"), "this is no PNG, JPEG, BMP, TGA, WebP or KTX2 image"),
        (inside(&bomb), "the image"),
        (inside(&torn), "damaged"),
    ];
    for (uri, expected) in cases {
        let mut file = Gltf::new();
        file.push("images", json!({ "uri": uri }));
        file.push("textures", json!({ "source": 0 }));
        let painted = json!({ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0 } });
        file.push("materials", painted.clone());
        file.push("materials", painted);
        let positions = file.floats("VEC3", &TRIANGLE);
        let mesh = file.mesh(json!({ "attributes": { "POSITION": positions }, "material": 1 }));
        file.root_node(json!({ "mesh": mesh }));
        let (model, notes) = open(&file);
        assert!(notes.len() == 2 && notes[0].contains(expected) && notes[0].starts_with("image 0"), "{uri}: {notes:?}");
        assert!(notes[1].starts_with("the material material 0 was left out"), "{notes:?}");
        let mesh = first(&model);
        assert!(
            mesh.materials[2].plain.base_texture.is_none() && mesh.materials[2].plain.base_color == DVec3::splat(0.5)
        );
    }
}

#[test]
fn lights_become_suns_and_lamps() {
    let mut file = on_node(&json!({}));
    file.root["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "intensity": std::f32::consts::PI, "color": [1.0, 0.5, 0.0] },
        { "type": "point", "intensity": 2.0 * std::f32::consts::PI },
        { "type": "spot", "range": 7.0, "spot": { "innerConeAngle": 0.0, "outerConeAngle": std::f32::consts::FRAC_PI_3 } }] } });
    let on = |light: usize| json!({ "KHR_lights_punctual": { "light": light } });
    // −Z rotated by −90° around X points down, so the sun is above.
    file.root_node(json!({ "rotation": [-HALF, 0.0, 0.0, HALF], "extensions": on(0) }));
    file.root_node(json!({ "translation": [1, 2, 3], "extensions": on(1) }));
    let spot = file.root_node(json!({ "extensions": on(2), "scale": [5, 5, 5] }));
    let light = open(&file).0.at(0.0).light.clone();
    let [sun] = light.suns[..] else { panic!("one sun") };
    assert!((sun.direction - DVec3::Y).length() < 1e-6 && (sun.radiance - DVec3::new(1.0, 0.5, 0.0)).length() < 1e-6);
    let [lamp, spot_lamp] = light.lamps[..] else { panic!("two lamps") };
    assert_eq!((lamp.position, lamp.reach, lamp.cone), (DVec3::new(1.0, 2.0, 3.0), f64::INFINITY, None));
    assert!((lamp.radiance - DVec3::splat(2.0)).length() < 1e-6);
    let cone = spot_lamp.cone.unwrap();
    assert!((cone.axis + DVec3::Z).length() < 1e-12 && cone.cos_inner == 1.0 && (cone.cos_outer - 0.5).abs() < 1e-6);
    assert_eq!((spot_lamp.reach, spot_lamp.window), (7.0, Window::Punctual));
    // A moving lamp above a static triangle.
    let times = file.floats("SCALAR", &[0.0, 1.0]);
    let output = file.floats("VEC3", &[0.0, 0.0, 0.0, 8.0, 0.0, 0.0]);
    file.animate(spot, "translation", json!({ "input": times, "output": output }));
    let (model, _) = open(&file);
    assert_eq!((model.duration_s(), model.at(0.5).light.lamps[1].position), (1.0, DVec3::X * 4.0));
    assert_eq!(model.at(0.5).meshes.len(), 1);
}

/// Returns the colour of a ray straight down to the triangle at (x, y), if it hits. x and y are the barycentric weights of the
/// second and third corners.
fn above(model: &Model, x: f64, y: f64) -> Option<DVec3> {
    let hit = trace(&model.at(0.0), DVec3::new(x, y, 1.0), DVec3::NEG_Z);
    hit.distance.is_finite().then_some(hit.color)
}

/// Opens a triangle with these colours at its corners, stored as the given kind of accessor.
fn colored(kind: &str, colors: [[f32; 4]; 3], material: &Value) -> (Model, Vec<String>) {
    let mut file = Gltf::new();
    let positions = file.floats("VEC3", &TRIANGLE);
    let plain = colors.as_flattened();
    let whole = |most: f32| plain.iter().map(move |value| (value * most).round());
    let accessor = match kind {
        "bytes" => {
            let view = file.view(&whole(255.0).map(|value| value as u8).collect::<Vec<_>>());
            json!({ "bufferView": view, "componentType": 5121, "normalized": true, "count": 3, "type": "VEC4" })
        }
        "shorts" => {
            let view = file.view(&whole(65_535.0).flat_map(|value| (value as u16).to_le_bytes()).collect::<Vec<_>>());
            json!({ "bufferView": view, "componentType": 5123, "normalized": true, "count": 3, "type": "VEC4" })
        }
        _ => Value::Null,
    };
    let colors = match kind {
        "three floats" => file.floats("VEC3", &colors.map(|[r, g, b, _]| [r, g, b]).concat()),
        "four floats" => file.floats("VEC4", plain),
        _ => file.push("accessors", accessor),
    };
    file.push("materials", material.clone());
    let mesh = file.mesh(json!({ "attributes": { "POSITION": positions, "COLOR_0": colors }, "material": 0 }));
    file.root_node(json!({ "mesh": mesh }));
    open(&file)
}

#[test]
fn colours_of_corners_are_multiplied_into_the_base_colour() {
    let unlit = json!({ "extensions": { "KHR_materials_unlit": {} }, "pbrMetallicRoughness": { "baseColorFactor": [0.5, 1.0, 1.0, 1.0] } });
    let rgb = [[1.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 1.0], [0.0, 0.0, 1.0, 1.0]];
    for kind in ["bytes", "shorts", "three floats", "four floats"] {
        let (model, notes) = colored(kind, rgb, &unlit);
        assert!(notes.is_empty(), "{notes:?}");
        let seen = above(&model, 0.2, 0.3).unwrap();
        assert!((seen - DVec3::new(0.25, 0.2, 0.3)).length() < 1e-6, "{kind}: {seen}");
    }
    // A glTF material is a metal by default, and the base colour of a metal is the colour of its highlight.
    let red = [[1.0, 0.0, 0.0, 1.0]; 3];
    let metal =
        above(&colored("bytes", red, &json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.5 } })).0, 0.2, 0.3);
    assert!(metal.is_some_and(|seen| seen.x > 0.01 && seen.y.abs() < 1e-12), "{metal:?}");
    let mirror = json!({ "pbrMetallicRoughness": { "roughnessFactor": 0.0 } });
    let mirror = above(&colored("bytes", red, &mirror).0, 0.2, 0.3);
    assert!(mirror.is_some_and(|seen| seen.x > 0.01 && seen.y.abs() < 1e-12), "{mirror:?}");
    // Alpha at corners makes holes only if the material has a mask.
    let fading = [[1.0; 4], [1.0, 1.0, 1.0, 0.0], [1.0; 4]];
    let masked = colored("bytes", fading, &json!({ "alphaMode": "MASK" })).0;
    assert!(above(&masked, 0.4, 0.1).is_some() && above(&masked, 0.6, 0.1).is_none());
    assert!(above(&colored("bytes", fading, &json!({})).0, 0.6, 0.1).is_some());
}

#[test]
fn what_is_not_shown_is_said_once() {
    let mut file = on_node(&json!({}));
    let picture = file.view(&png(1, 1, &[[128, 128, 255, 255]]));
    file.push("images", json!({ "bufferView": picture }));
    file.push("textures", json!({ "source": 0 }));
    for double_sided in [true, false, false] {
        let material =
            json!({ "doubleSided": double_sided, "normalTexture": { "index": 0 }, "occlusionTexture": { "index": 0 } });
        file.push("materials", material);
    }
    let (_, notes) = open(&file);
    assert_eq!(notes.len(), 2 + 3, "{notes:?}");
    assert!(notes[2..].iter().all(|note| note.contains("nothing that is shown has it")), "{notes:?}");
    assert!(
        notes[0].contains("normal maps of 3 materials") && notes[1].starts_with("2 materials are single-sided"),
        "{notes:?}"
    );
}

#[test]
fn obj_files_have_parts_materials_and_their_textures() {
    let mtl = "newmtl red\nKd 1 0 0\nKs 0.5 0.5 0.5\nNs 98\nillum 2\nmap_Kd -clamp on -s 1 1 1 my pic.png\n\
        newmtl mirror\nKs 0.9 0.9 0.9\nillum 3\nnewmtl glass\nNi 1.4\nillum 7\nTf 0.5 1 1\nnewmtl leaf\nKd 1 1 1\nmap_d mask.png\n\
        newmtl lamp\nKe 3 2 1\nmap_Kd ../x.png\n";
    let obj = "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nvn 0 0 1\nusemtl red\nf 1/1/1 2/2/1 4/3/1\n\
        usemtl mirror\nf -4 -3 -2 -1\nusemtl glass\nf 1 2 3\nusemtl leaf\nf 1 2 3\nusemtl lamp\nf 1 2 3\nl 1 2 3\n";
    let picture = png(2, 1, &[[255, 255, 255, 255], [0, 0, 0, 255]]);
    let others: [(&str, &[u8]); 3] = [("a.mtl", mtl.as_bytes()), ("my pic.png", &picture), ("mask.png", &picture)];
    let (model, notes) = open_beside("a.obj", obj.as_bytes(), &others).unwrap();
    assert_eq!(notes.len(), 2, "{notes:?}");
    assert!(
        notes.iter().any(|note| note.contains("leads out")) && notes.iter().any(|note| note.starts_with("1 points")),
        "{notes:?}"
    );
    let mesh = first(&model);
    assert_eq!(mesh.triangles.len(), 6);
    let of = |triangle: usize| &mesh.materials[mesh.material_of[triangle] as usize];
    let names: Vec<&str> = (0..6).map(|triangle| of(triangle).plain.name.as_str()).collect();
    assert_eq!(names, ["red", "mirror", "mirror", "glass", "leaf", "lamp"]);
    let red = of(0);
    assert_eq!((red.plain.base_color, red.phong.exponent, red.phong.weight), (DVec3::X, 98.0, DVec3::splat(0.01)));
    let texture = red.plain.base_texture.as_ref().unwrap();
    assert_eq!(texture.wrap, [Wrap::Clamp; 2]);
    // In the file v points up.
    assert_eq!(mesh.uvs[mesh.triangles[0][2] as usize].to_array(), [0.0, 0.0]);
    assert_eq!(of(1).optics, Optics::Mirror { tint: DVec3::splat(f64::from(0.9f32)) });
    assert_eq!(of(3).optics, Optics::Glass { ior: f64::from(1.4f32), tint: DVec3::new(0.5, 1.0, 1.0) });
    let leaf = of(4);
    let alphas: Vec<u8> = leaf.plain.base_texture.as_ref().unwrap().pixels.iter().map(|pixel| pixel[3]).collect();
    assert_eq!((leaf.plain.alpha_cutoff, alphas), (Some(0.5), vec![255, 0]));
    assert_eq!((of(5).plain.emission, of(5).plain.base_texture.is_none()), (DVec3::new(3.0, 2.0, 1.0), true));
}
