//! Cameras of USD text files, `.usda` (openusd.org, UsdGeomCamera and UsdGeomXformable): prims of type `Camera`, static or with
//! time samples. They look along −Z with +Y up; apertures and focal length have the same unit.
//!
//! A time code is a frame. Values between samples are interpolated linearly, as USD defines it, except rotations, including those
//! in matrices, which use slerp, since linear interpolation of matrices would shear. Metres per unit and the up axis of the file
//! are applied.

use std::fmt::Write as _;

use glam::{DMat4, DQuat, DVec3};

use super::document::{Content, FileCamera, WriteSettings, Written, axes_of, check_count, matrix_of, of_camera};
use super::poses::{Track, poses, tracks};
use super::usda::{Prim, Value, parse};
use codec::error::{Error, Result};
use codec::image::FrameRange;
use codec::math::Camera;
use render::camera_path::TimedCamera;

/// Defaults for values that a file does not state.
const METRES_PER_UNIT: f64 = 0.01;
const HORIZONTAL_APERTURE: f64 = 20.955;
const VERTICAL_APERTURE: f64 = 15.2908;
const FOCAL_LENGTH: f64 = 50.0;
/// Width of 36 mm film in tenths of a metre.
const WRITTEN_APERTURE: f64 = 0.36;

pub fn is_of(bytes: &[u8]) -> bool {
    bytes.starts_with(b"#usda") || bytes.starts_with(b"PXR-USDC")
}

pub fn read(content: &Content<'_>) -> Result<Vec<FileCamera>> {
    if content.bytes.starts_with(b"PXR-USDC") {
        return Err(Error::unsupported("a binary USD file: write it as text first, with the program usdcat"));
    }
    let root = parse(content.text()?)?;
    let unit_m = root.attribute("metersPerUnit").map_or(Ok(METRES_PER_UNIT), number)?;
    let scale = DMat4::from_scale(DVec3::splat(unit_m));
    let to_world = match root.attribute("upAxis") {
        Some(Value::Text(axis)) if axis == "Z" => DMat4::from_rotation_x(-std::f64::consts::FRAC_PI_2) * scale,
        _ => scale,
    };
    let mut cameras = Vec::new();
    find(&root, &mut Vec::new(), &to_world, &mut cameras)?;
    Ok(cameras)
}

/// Adds the cameras below a prim; `chain` holds the prims on the path to it.
fn find<'a>(prim: &'a Prim, chain: &mut Vec<&'a Prim>, to_world: &DMat4, cameras: &mut Vec<FileCamera>) -> Result<()> {
    for child in prim.children.iter().filter(|child| child.is_defined) {
        chain.push(child);
        if child.kind == "Camera" {
            add(child, chain, to_world, cameras).map_err(of_camera(&child.name))?;
        }
        find(child, chain, to_world, cameras)?;
        chain.pop();
    }
    Ok(())
}

/// Attributes that define the field of view.
const LENS: [&str; 5] =
    ["focalLength", "horizontalAperture", "verticalAperture", "horizontalApertureOffset", "verticalApertureOffset"];

fn add(prim: &Prim, chain: &[&Prim], to_world: &DMat4, cameras: &mut Vec<FileCamera>) -> Result<()> {
    if matches!(prim.attribute("projection"), Some(Value::Text(kind)) if kind == "orthographic") {
        return Err(Error::unsupported("it is orthographic, but a perspective camera was expected"));
    }
    let at = |time: f64| -> Result<Camera> {
        let mut placed = DMat4::IDENTITY;
        for prim in chain {
            let (local, is_reset) = local(prim, time)?;
            placed = if is_reset { local } else { placed * local };
        }
        let (eye, axes) = axes_of(&(*to_world * placed))?;
        let mut lens = [FOCAL_LENGTH, HORIZONTAL_APERTURE, VERTICAL_APERTURE, 0.0, 0.0];
        for (name, value) in LENS.iter().zip(&mut lens) {
            if let Some(stated) = value_at(prim, name, time) {
                *value = number(&stated)?;
            }
        }
        let [focal, width, height, right, up] = lens;
        Camera::with_window(eye, axes, [width, height].map(|size| size / 2.0 / focal), [right / focal, -up / focal])
    };
    let of = |camera: Camera, frames: Option<FrameRange>| FileCamera {
        name: prim.name.clone(),
        size: None,
        timed: TimedCamera { camera, frames },
    };
    let Some([first, last]) = sampled(prim, chain) else {
        cameras.push(of(at(0.0)?, None));
        return Ok(());
    };
    let [first, last] = [(first - 1e-6).ceil(), (last + 1e-6).floor()];
    if first < 0.0 || last > f64::from(u32::MAX) || first > last {
        return Err(Error::unsupported(format!(
            "its time samples are between {first} and {last}: time codes that are frames, from 0 on, were expected"
        )));
    }
    check_count(cameras.len(), last - first + 1.0)?;
    for frame in first as u32..=last as u32 {
        cameras.push(of(at(f64::from(frame))?, Some(FrameRange { first: frame, last: frame })));
    }
    Ok(())
}

/// Returns the first and last time code of samples that move a camera or change its lens.
fn sampled(prim: &Prim, chain: &[&Prim]) -> Option<[f64; 2]> {
    let of = |prim: &&Prim, names: &dyn Fn(&str) -> bool| -> Option<[f64; 2]> {
        let ends = |(name, value): &(String, Value)| match value {
            Value::Samples(samples) if name.strip_suffix(".timeSamples").is_some_and(names) => {
                Some([samples.first()?.0, samples.last()?.0])
            }
            _ => None,
        };
        prim.attributes.iter().filter_map(ends).reduce(join)
    };
    let moved = chain.iter().filter_map(|prim| of(prim, &|name| name.starts_with("xformOp:")));
    moved.chain(of(&prim, &|name| LENS.contains(&name))).reduce(join)
}

fn join([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a.min(c), b.max(d)]
}

/// Returns the matrix from a prim to its parent, and whether it ignores the transforms of its parents.
fn local(prim: &Prim, time: f64) -> Result<(DMat4, bool)> {
    let Some(Value::List(order)) = prim.attribute("xformOpOrder") else { return Ok((DMat4::IDENTITY, false)) };
    let (mut matrix, mut is_reset) = (DMat4::IDENTITY, false);
    for op in order {
        let Value::Text(op) = op else { return Err(Error::invalid("\"xformOpOrder\" lists names")) };
        if op == "!resetXformStack!" {
            (matrix, is_reset) = (DMat4::IDENTITY, true);
            continue;
        }
        let name = op.strip_prefix("!invert!").unwrap_or(op);
        let value = value_at(prim, name, time);
        let value = value.ok_or_else(|| Error::invalid(format!("{name} of \"xformOpOrder\" has no value")))?;
        let step = transform(name, &value).map_err(|error| error.context(name))?;
        matrix *= if name.len() < op.len() { step.inverse() } else { step };
    }
    Ok((matrix, is_reset))
}

/// Returns the matrix of a transform operation, by its name and value.
fn transform(name: &str, value: &Value) -> Result<DMat4> {
    let kind = name.split(':').nth(1).unwrap_or_default();
    let turn = |axis: char, degrees: f64| match axis {
        'X' => DMat4::from_rotation_x(degrees.to_radians()),
        'Y' => DMat4::from_rotation_y(degrees.to_radians()),
        _ => DMat4::from_rotation_z(degrees.to_radians()),
    };
    match kind {
        "transform" => {
            let rows = numbers(value)?;
            let rows =
                <[f64; 16]>::try_from(rows).map_err(|_| Error::invalid("a matrix of 4 by 4 numbers was expected"))?;
            // USD matrices apply to row vectors, so the rows of the file are the columns of `DMat4`.
            Ok(DMat4::from_cols_array(&rows))
        }
        "translate" => Ok(DMat4::from_translation(three(value)?)),
        "scale" => Ok(DMat4::from_scale(three(value)?)),
        "orient" => match numbers(value)?[..] {
            [w, x, y, z] => Ok(DMat4::from_quat(DQuat::from_xyzw(x, y, z, w).normalize())),
            _ => Err(Error::invalid("a quaternion of four numbers was expected")),
        },
        "rotateX" | "rotateY" | "rotateZ" => Ok(turn(kind.chars().last().unwrap_or('X'), number(value)?)),
        "rotateXYZ" | "rotateXZY" | "rotateYXZ" | "rotateYZX" | "rotateZXY" | "rotateZYX" => {
            let degrees = three(value)?;
            let of = |axis: char| turn(axis, degrees[(axis as usize) - ('X' as usize)]);
            // The first axis is applied first.
            Ok(kind.chars().skip("rotate".len()).fold(DMat4::IDENTITY, |matrix, axis| of(axis) * matrix))
        }
        _ => Err(Error::unsupported("it is not a known operation")),
    }
}

/// Returns the value of an attribute at a time code: from its samples if it has any, else its default value.
fn value_at(prim: &Prim, name: &str, time: f64) -> Option<Value> {
    let samples = prim.attributes.iter().find(|(other, _)| other.strip_suffix(".timeSamples") == Some(name));
    let Some((_, Value::Samples(samples))) = samples else { return prim.attribute(name).cloned() };
    let behind = samples.partition_point(|(at, _)| *at <= time);
    match (behind.checked_sub(1).map(|at| &samples[at]), samples.get(behind)) {
        (Some((from_time, from)), Some((to_time, to))) => {
            let part = (time - from_time) / (to_time - from_time);
            Some(if part == 0.0 {
                from.clone()
            } else {
                mix(from, to, part, name.split(':').nth(1).unwrap_or_default())
            })
        }
        (Some((_, value)), None) | (None, Some((_, value))) => Some(value.clone()),
        (None, None) => None,
    }
}

/// Interpolates between two values of an attribute; `kind` is the kind of transform operation.
fn mix(from: &Value, to: &Value, part: f64, kind: &str) -> Value {
    let lists = (numbers(from), numbers(to));
    match (from, to) {
        (Value::Number(from), Value::Number(to)) => Value::Number(from + (to - from) * part),
        (Value::List(_), Value::List(_)) => match lists {
            (Ok(from), Ok(to)) if kind == "transform" && from.len() == 16 && to.len() == 16 => {
                let parts = |rows: &[f64]| DMat4::from_cols_slice(rows).to_scale_rotation_translation();
                let ((from_scale, from_turn, from_place), (to_scale, to_turn, to_place)) = (parts(&from), parts(&to));
                let matrix = DMat4::from_scale_rotation_translation(
                    from_scale.lerp(to_scale, part),
                    from_turn.slerp(to_turn, part),
                    from_place.lerp(to_place, part),
                );
                Value::List(matrix.to_cols_array().map(Value::Number).to_vec())
            }
            (Ok(from), Ok(to)) if kind == "orient" && from.len() == 4 && to.len() == 4 => {
                let of = |q: &[f64]| DQuat::from_xyzw(q[1], q[2], q[3], q[0]).normalize();
                let turn = of(&from).slerp(of(&to), part);
                Value::List([turn.w, turn.x, turn.y, turn.z].map(Value::Number).to_vec())
            }
            (Ok(from), Ok(to)) if from.len() == to.len() => {
                Value::List(from.iter().zip(&to).map(|(from, to)| Value::Number(from + (to - from) * part)).collect())
            }
            _ => Value::List(Vec::new()),
        },
        _ => from.clone(),
    }
}

fn number(value: &Value) -> Result<f64> {
    match value {
        Value::Number(number) => Ok(*number),
        _ => Err(Error::invalid("a number was expected")),
    }
}

/// Returns the numbers of nested lists.
fn numbers(value: &Value) -> Result<Vec<f64>> {
    match value {
        Value::List(list) => Ok(list.iter().map(numbers).collect::<Result<Vec<_>>>()?.concat()),
        _ => number(value).map(|number| vec![number]),
    }
}

fn three(value: &Value) -> Result<DVec3> {
    let numbers = <[f64; 3]>::try_from(numbers(value)?);
    numbers.map(DVec3::from_array).map_err(|_| Error::invalid("three numbers were expected"))
}

pub fn write(cameras: &[FileCamera], settings: &WriteSettings) -> Result<Written> {
    let tracks = tracks(&poses(cameras)?);
    let frames = || tracks.iter().flat_map(|track| track.keys.iter().filter_map(|(frame, _)| *frame));
    let mut head = "    defaultPrim = \"Cameras\"\n    metersPerUnit = 1\n    upAxis = \"Y\"\n".to_owned();
    if let (Some(first), Some(last)) = (frames().min(), frames().max()) {
        let _ = writeln!(head, "    startTimeCode = {first}\n    endTimeCode = {last}");
        let _ = writeln!(head, "    timeCodesPerSecond = {0}\n    framesPerSecond = {0}", settings.fps);
    }
    let prims: String = tracks.iter().map(prim).collect();
    Ok(Written::File(format!("#usda 1.0\n(\n{head})\n\ndef Xform \"Cameras\"\n{{\n{prims}}}\n").into_bytes()))
}

fn prim(track: &Track) -> String {
    let focal = |camera: &Camera| WRITTEN_APERTURE / 2.0 / camera.half()[0];
    let lens = |camera: &Camera| {
        let ([_, half_v], [middle_u, middle_v], focal) = (camera.half(), camera.middle(), focal(camera));
        [focal, 2.0 * half_v * focal, middle_u * focal, -middle_v * focal]
    };
    const OF_LENS: [&str; 4] =
        ["focalLength", "verticalAperture", "horizontalApertureOffset", "verticalApertureOffset"];
    let mut text = format!("    def Camera \"{}\"\n    {{\n", track.name);
    if let Some((_, camera)) = track.keys.first().filter(|(_, camera)| camera.has_range()) {
        let [near_m, far_m] = camera.depth_m();
        let _ = writeln!(text, "        float2 clippingRange = ({near_m}, {})", far_m.min(1e30));
    }
    let _ = writeln!(text, "        float horizontalAperture = {WRITTEN_APERTURE}");
    for (at, name) in OF_LENS.into_iter().enumerate() {
        // Adding 0.0 turns a negative zero into a positive one.
        attribute(&mut text, &format!("float {name}"), track, |camera| (lens(camera)[at] + 0.0).to_string());
    }
    attribute(&mut text, "matrix4d xformOp:transform", track, |camera| {
        let rows = matrix_of(camera.eye(), camera.axes()).to_cols_array_2d();
        let row = |[a, b, c, d]: [f64; 4]| format!("({a}, {b}, {c}, {d})");
        format!("( {} )", rows.map(row).join(", "))
    });
    text + "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n"
}

/// Writes an attribute, with a single value or with time samples.
fn attribute(text: &mut String, name: &str, track: &Track, value: impl Fn(&Camera) -> String) {
    let keys: Vec<(Option<u32>, String)> = track.keys.iter().map(|(frame, camera)| (*frame, value(camera))).collect();
    let is_still = keys.windows(2).all(|pair| pair[0].1 == pair[1].1);
    match &keys[..] {
        // A moving camera always has samples of its transform, even if it does not change.
        [(frame, value), ..] if frame.is_none() || (is_still && !name.starts_with("matrix")) => {
            let _ = writeln!(text, "        {name} = {value}");
        }
        _ => {
            let _ = writeln!(text, "        {name}.timeSamples = {{");
            for (frame, value) in &keys {
                let _ = writeln!(text, "            {}: {value},", frame.unwrap_or(0));
            }
            let _ = writeln!(text, "        }}");
        }
    }
}
