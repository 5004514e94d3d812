//! Simplified scenes drawn on the GPU, compared with the CPU: images, counts, commands, refusals.

use std::sync::Arc;

use codec::monitor::Silent;
use gpu::quads::GpuQuads;
use gpu::selftest::drawings::{self, DrawingCase};
use kernels::Drawing;
use libtest_mimic::Failed;
use lightfold::Error;
use scene::mesh::ImageTexture;
use simplify::raster::{Compositing, draw};

use crate::{lightfold, with_gpu};

/// Tests all images of a drawing.
pub fn drawing(drawing: &'static Drawing) -> Result<(), Failed> {
    with_gpu(|gpu| {
        let report = drawings::test_drawing(gpu, drawing).map_err(|error| error.to_string())?;
        match report.mismatches {
            0 if report.inputs > 5 => Ok(()),
            count => Err(format!("{count} pixels differ on {}: {:?}", gpu.info.name, report.first).into()),
        }
    })
}

fn case(label: &str, compositing: Compositing) -> Result<DrawingCase, Failed> {
    let cases = drawings::cases(compositing).map_err(|error| error.to_string())?;
    Ok(cases.into_iter().find(|case| case.label == label).ok_or("no such case")?)
}

/// The later of two triangles at the same depth is shown; counts of layers are exact, and too many layers are refused.
pub fn equal_depths_and_many_layers() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let said = |error: Error| error.to_string();
        for compositing in [Compositing::Painter, Compositing::ZBuffer] {
            let mut case = case("room", compositing)?;
            let triangles = case.scene.mesh.triangles.clone();
            for _ in 0..9 {
                case.scene.mesh.triangles.extend(&triangles);
            }
            let found = drawings::run(gpu, &case).map_err(said)?;
            println!("{compositing:?}: {:?}", found.agreement);
            if found.agreement.mismatches() > 0 || found.on_device.max_fragments != found.on_cpu.max_fragments {
                return Err(format!("{compositing:?} on {}: {:?}", gpu.info.name, found.agreement).into());
            }
            // More than 2048 copies of the tile that covers most pixels.
            let tile = triangles.chunks(2).max_by_key(|tile| {
                case.scene.mesh.triangles = tile.to_vec();
                draw(&case.scene, &case.camera, case.settings.size).fragments
            });
            case.scene.mesh.triangles = tile.ok_or("no tile")?.repeat(2100);
            case.settings.size = [4, 4];
            let refused = drawings::run(gpu, &case).map_err(said).err().unwrap_or_default();
            if !refused.contains("2048 triangles") {
                return Err(format!("{compositing:?} on {}: it said '{refused}'", gpu.info.name).into());
            }
        }
        Ok(())
    })
}

/// Sizes above the device's limit are refused with a message, for atlases and for images.
pub fn refusals() -> Result<(), Failed> {
    with_gpu(|gpu| {
        let most = gpu.device.limits().max_texture_dimension_2d;
        let mut case = case("room", Compositing::Painter)?;
        case.settings.size = [most + 1, 1];
        let said = |result: Result<(), Error>| result.err().map(|error| error.to_string()).unwrap_or_default();
        let quads = GpuQuads::new(gpu, &case.scene).map_err(|error| error.to_string())?;
        let of_picture = said(quads.draw(&case.camera, &case.settings, &Silent).map(|_| ()));
        let texture = ImageTexture {
            width: most + 1,
            height: 1,
            pixels: vec![[0; 4]; most as usize + 1],
            wrap: case.scene.texture.wrap,
        };
        case.scene.texture = Arc::new(texture);
        let of_atlas = said(GpuQuads::new(gpu, &case.scene).map(|_| ()));
        match [&of_picture, &of_atlas].iter().all(|said| said.contains(&most.to_string()) && said.contains("CPU")) {
            true => Ok(()),
            false => Err(format!("it said '{of_picture}' and '{of_atlas}'").into()),
        }
    })
}

/// `render` reports the same figures on the GPU and on the CPU, for both methods.
pub fn commands() -> Result<(), Failed> {
    let folder = tempfile::tempdir()?;
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (room, quads) = (path("room"), path("quads.glb"));
    let positions = ["--position=0,1.5,0", "--position=0.3,1.5,0.1"];
    lightfold(&[
        "capture",
        "interior",
        positions[0],
        positions[1],
        "--size",
        "48",
        "--frames",
        "0",
        "-q",
        "-o",
        &room,
    ])?;
    lightfold(&["simplify", &room, "-o", &quads, "--triangles", "1500", "--effort", "fast", "-q"])?;
    for method in ["painter", "z-buffer"] {
        let report = |device: &str| -> Result<serde_json::Value, Failed> {
            let line =
                ["render", &quads, "--reference", &room, "--method", method, "--device", device, "--null", "--json"];
            Ok(serde_json::from_str(&lightfold(&line)?)?)
        };
        let (on_device, on_cpu) = (report("gpu")?, report("cpu")?);
        for (key, bound) in
            [("/reference/psnr_db", 2e-3), ("/reference/ssim", 1e-3), ("/overdraw_mean", 1e-2), ("/pixels", 0.0)]
        {
            let [found, wanted] =
                [&on_device, &on_cpu].map(|report| report.pointer(key).and_then(|value| value.as_f64()));
            let (Some(found), Some(wanted)) = (found, wanted) else { return Err(format!("no {key}").into()) };
            println!("{method} {key}: {found} on {}, {wanted} on the CPU", on_device["device"]);
            if (found - wanted).abs() > bound * wanted {
                return Err(format!("{method} {key}: {found}, on the CPU {wanted}").into());
            }
        }
        if on_device["device"] == on_cpu["device"] {
            return Err(format!("{method} ran on {}", on_device["device"]).into());
        }
    }
    Ok(())
}
