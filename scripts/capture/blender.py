#!/usr/bin/env python3
"""Captures a scene of Blender with Cycles as a light-field dataset: cube maps of colour, depth, material and normals."""

import argparse
import math
import pathlib
import sys
import tempfile
from typing import Any

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import layout  # noqa: E402
import exr  # noqa: E402
import numpy as np  # noqa: E402
from exr import Array  # noqa: E402
from layout import Refused, Vector, View, run  # noqa: E402

ABOUT = """\
Renders a scene of Blender 4.2 or later with Cycles from the cameras of lightfold and writes what `lightfold encode` reads. It is
run by Blender itself, or by a Python 3.11 with the package bpy (python3 -m pip install bpy==4.2.23):

  blender -b scene.blend -P scripts/capture/blender.py -- --cameras cameras.json -o DIR
  python3.11 scripts/capture/blender.py scene.blend --cameras cameras.json -o DIR
  blender -b scene.blend -P scripts/capture/blender.py -- --cameras cameras.json -o DIR --frames 1-48 --size 1024 --samples 256
  blender -b scene.blend -P scripts/capture/blender.py -- --cameras cameras.json -o DIR --cycles-device OPTIX

lightfold's x, y, z are Blender's x, z, -y, in metres: a scene's unit scale is heeded. Frames are Blender's own. Depth, normals
and materials are rendered apart from colour, with one ray for a pixel. Motion blur, depth of field, compositing and adaptive
sampling are off; colour is what Cycles renders of the first view layer in use, before any view transform. Material is that of
nodes that make perfect mirrors (reflect 1) and glass (Fresnel's reflect, and ior), and 0, 0, 1 elsewhere.
"""
DEVICES = ["CPU", "CUDA", "OPTIX", "HIP", "METAL", "ONEAPI"]
# Cycles writes 1e10 as the depth where nothing is.
NOTHING = 1e9
# Rougher surfaces are no mirrors and no glass.
MAX_ROUGHNESS = 0.05
PASSES = ["combined", "z", "mist", "position", "normal", "vector", "uv", "object_index", "material_index", "shadow",
          "ambient_occlusion", "emit", "environment", "diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct",
          "glossy_indirect", "glossy_color", "transmission_direct", "transmission_indirect", "transmission_color",
          "subsurface_direct", "subsurface_indirect", "subsurface_color", "cryptomatte_object", "cryptomatte_material",
          "cryptomatte_asset"]


def arguments() -> argparse.Namespace:
    parser = layout.parser("scripts/capture/blender.py", ABOUT)
    parser.add_argument("scene", metavar="SCENE", nargs="?", help="scene.blend; none where Blender has opened it")
    parser.add_argument("--denoise", action="store_true", help="denoise colour with OpenImageDenoise")
    parser.add_argument("--cycles-device", metavar="TYPE", help="what renders: CPU, CUDA, OPTIX, HIP, METAL or ONEAPI")
    if "--" not in sys.argv:
        # Cycles reads its option itself, behind such a mark.
        sys.argv.insert(1, "--")
    options = parser.parse_args(sys.argv[sys.argv.index("--") + 1:])
    device = options.cycles_device
    # Cycles would render with what is set without a word.
    if device and device.removesuffix("+CPU") not in DEVICES:
        raise Refused(f"--cycles-device {device}: one of {', '.join(DEVICES)} was expected, +CPU behind it to have both")
    return options


def opened(bpy: Any, options: argparse.Namespace) -> Any:
    """The scene to render."""
    if bpy.app.version < (4, 2, 0):
        raise Refused(f"this is Blender {bpy.app.version_string}: 4.2 or later was expected")
    if options.scene:
        layout.scene_stamp(options.scene)
        try:
            bpy.ops.wm.open_mainfile(filepath=str(pathlib.Path(options.scene).resolve()), load_ui=False)
        except RuntimeError as error:
            raise Refused(f"{options.scene}: Blender cannot open it: {' '.join(str(error).split())}") from error
    elif not bpy.data.filepath:
        raise Refused("no scene is open: name a .blend file")
    space = getattr(getattr(bpy.data, "colorspace", None), "working_space", "Linear Rec.709")
    if space != "Linear Rec.709":
        raise Refused(f"the working space of the file is {space}: Linear Rec.709 was expected")
    return bpy.context.scene


def metres_per_unit(scene: Any) -> float:
    """Metres in one of the scene's units."""
    return scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0


def give(target: Any, **values: Any) -> None:
    """Sets those attributes that this release has."""
    for name, value in values.items():
        if hasattr(target, name):
            setattr(target, name, value)


class Renderer:
    """Renders images of views, for layout.capture."""

    def __init__(self, bpy: Any, scene: Any, options: argparse.Namespace, work: str):
        self.bpy = bpy
        self.scene = scene
        self.options = options
        self.work = pathlib.Path(work)
        self.unit = metres_per_unit(scene)
        self.layer = next((layer for layer in scene.view_layers if layer.use), scene.view_layers[0])
        self.materials: dict[int, tuple[str | None, float]] = {}
        self.prepare()

    def prepare(self) -> None:
        scene, bpy = self.scene, self.bpy
        for layer in scene.view_layers:
            layer.use = layer == self.layer
        self.lens = bpy.data.cameras.new("lightfold")
        self.camera = bpy.data.objects.new("lightfold", self.lens)
        scene.collection.objects.link(self.camera)
        scene.camera = self.camera
        # Markers would choose other cameras.
        scene.timeline_markers.clear()
        self.lens.clip_start, self.lens.clip_end = 1e-4 / self.unit, 1e9 / self.unit
        self.lens.sensor_fit = "VERTICAL"
        render = scene.render
        give(render, engine="CYCLES", resolution_percentage=100, pixel_aspect_x=1.0, pixel_aspect_y=1.0, use_border=False,
             use_multiview=False, use_motion_blur=False, use_compositing=False, use_sequencer=False, use_freestyle=False,
             use_stamp=False, use_persistent_data=True, use_overwrite=True, use_placeholder=False, use_file_extension=True)
        if self.options.threads:
            render.threads_mode, render.threads = "FIXED", self.options.threads
        give(scene.cycles, use_adaptive_sampling=False, use_animated_seed=False, time_limit=0.0, sample_offset=0,
             use_sample_subset=False)
        # Multi-part files where Blender 5 would write them are written as one part.
        give(render.image_settings, media_type="MULTI_LAYER_IMAGE")
        give(render.image_settings, file_format="OPEN_EXR_MULTILAYER", exr_codec="NONE", color_depth="32",
             use_exr_interleave=True)
        for at, material in enumerate(bpy.data.materials, 1):
            material.pass_index = at if at <= 32767 else 0
            self.materials[material.pass_index] = optics_of(material)
        self.bounces = scene.cycles.max_bounces

    def frame(self, number: int) -> None:
        self.scene.frame_set(number)

    def images(self, view: View) -> dict[str, list[Array]]:
        self.pose(view)
        found = {}
        if "color" in view.kinds:
            give(self.scene.cycles, samples=self.options.samples, seed=view.seed, pixel_filter_type="BOX", filter_width=1.0,
                 use_denoising=self.options.denoise, denoiser="OPENIMAGEDENOISE", max_bounces=self.bounces)
            planes = self.render([])
            found["color"] = view.mirror([planes[f"Combined.{channel}"] for channel in "RGB"])
        if view.kinds != ["color"]:
            # One ray, whose place in the pixel is within a two-hundredth of the middle.
            give(self.scene.cycles, samples=1, seed=0, pixel_filter_type="GAUSSIAN", filter_width=0.01, use_denoising=False,
                 max_bounces=0)
            more = ["normal"] if view.kinds[-1] in ("normal", "material") else []
            planes = self.render(["z"] + more + (["material_index"] if "material" in view.kinds else []))
            found.update(self.surfaces(view, planes))
        return found

    def pose(self, view: View) -> None:
        """Puts the camera where the view is, looking forward; left and right are exchanged later."""
        import mathutils
        width, height = view.size
        render, lens = self.scene.render, self.lens
        render.resolution_x, render.resolution_y = width, height
        if view.projection == "equirect":
            # Blender 5 has the panorama in the camera itself, releases before it in what Cycles adds.
            lens.type = "PANO"
            where = lens if hasattr(lens, "panorama_type") else lens.cycles
            where.panorama_type = "EQUIRECTANGULAR"
            where.latitude_min, where.latitude_max = -math.pi / 2, math.pi / 2
            where.longitude_min, where.longitude_max = -math.pi, math.pi
        else:
            lens.type = "PERSP"
            lens.sensor_height = 36.0
            lens.sensor_width = 36.0 * width / height
            lens.lens = 18.0 / view.tangents[1]
        right = times(-1, view.right) if view.mirrored else view.right
        columns = [to_blender(right), to_blender(view.up), to_blender(times(-1, view.forward)), self.place(view)]
        self.camera.matrix_world = mathutils.Matrix([[column[row] for column in columns] for row in range(3)] + [[0, 0, 0, 1]])

    def place(self, view: View) -> Vector:
        """Where the camera stands, in the scene's axes and units."""
        x, y, z = view.camera.position
        return to_blender((x / self.unit, y / self.unit, z / self.unit))

    def render(self, passes: list[str]) -> dict[str, Array]:
        """Planes of the passes by the end of their name, such as Depth.Z."""
        for name in PASSES:
            give(self.layer, **{f"use_pass_{name}": name in passes or name == "combined"})
        path = self.work / "passes.exr"
        path.unlink(missing_ok=True)
        self.scene.render.filepath = str(path)
        try:
            self.bpy.ops.render.render(write_still=True, scene=self.scene.name)
        except RuntimeError as error:
            raise Refused(f"Blender cannot render: {str(error).strip().splitlines()[0].removeprefix('Error: ')}") from error
        if not path.is_file():
            raise Refused("Blender wrote no image: see what it said above")
        channels = exr.read(path)
        height, width = next(iter(channels.values())).shape
        expected = (self.scene.render.resolution_x, self.scene.render.resolution_y)
        if (width, height) != expected:
            raise Refused(f"Blender rendered {width}x{height} pixels: {expected[0]}x{expected[1]} were expected")
        return {".".join(name.split(".")[-2:]): plane for name, plane in channels.items()}

    def surfaces(self, view: View, planes: dict[str, Array]) -> dict[str, list[Array]]:
        images = {"depth": view.mirror([self.distances(view, planes["Depth.Z"])])}
        if "Normal.X" not in planes:
            return images
        # Blender's x, y, z are lightfold's x, -z, y.
        images["normal"] = facing(view.mirror([planes["Normal.X"], planes["Normal.Z"], -planes["Normal.Y"]]), view)
        if "material" in view.kinds:
            index = planes["IndexMA.X"] if "IndexMA.X" in planes else planes["Material Index.X"]
            images["material"] = self.optics(view, view.mirror([index])[0], images["normal"])
        return images

    def distances(self, view: View, depth: Array) -> Array:
        """Metres along rays; Cycles writes planar depth in perspective and distances in panoramas."""
        metres = depth.astype(np.float64) * self.unit
        if view.projection != "equirect":
            u, v = view.pixels()
            metres *= np.sqrt(1 + (u * view.tangents[0]) ** 2 + (v * view.tangents[1]) ** 2)
        return np.where(depth < NOTHING, metres, math.inf)

    def optics(self, view: View, index: Array, normals: list[Array]) -> list[Array]:
        """Planes of reflect, refract and ior, by the numbers of materials and normals."""
        found = np.zeros((3, *index.shape))
        found[2] = 1
        number = index.round().astype(int)
        directions = view.directions()
        cosines = np.minimum(1.0, np.abs(dots(directions, normals)))
        for material, (kind, ior) in self.materials.items():
            pixels = number == material
            if kind == "mirror":
                found[0][pixels] = 1
            elif kind == "glass":
                for row, column in np.argwhere(pixels):
                    inside = self.is_inside(view, tuple(directions[row, column].tolist()))
                    found[:, row, column] = layout.glass(float(cosines[row, column]), ior, inside)
        return list(found)

    def is_inside(self, view: View, direction: Vector) -> bool:
        """True if a ray first meets a surface from behind; Cycles' normals face the camera always."""
        toward = to_blender(direction)
        graph = self.bpy.context.evaluated_depsgraph_get()
        found, _, normal, *_ = self.scene.ray_cast(graph, self.place(view), toward)
        return bool(found and sum(a * b for a, b in zip(normal, toward)) > 0)


def dots(directions: Array, normals: list[Array]) -> Array:
    """Dot products of the directions of pixels, in the last axis, and planes of normals."""
    return directions[..., 0] * normals[0] + directions[..., 1] * normals[1] + directions[..., 2] * normals[2]


def facing(normals: list[Array], view: View) -> list[Array]:
    """Normals that face the camera."""
    sign = np.where(dots(view.directions(), normals) > 0, -1.0, 1.0)
    # Adding 0 makes a zero that is not negative.
    return [(sign * plane + 0.0).astype(np.float32) for plane in normals]


def times(factor: float, vector: Vector) -> Vector:
    x, y, z = vector
    return factor * x, factor * y, factor * z


def to_blender(vector: Vector) -> Vector:
    x, y, z = vector
    return x, -z, y


def optics_of(material: Any) -> tuple[str | None, float]:
    """("mirror" or "glass" or None, ior) of a material, as far as its nodes say it without a texture."""
    tree = material.node_tree if material.use_nodes else None
    output = tree and next((node for node in tree.nodes if node.type == "OUTPUT_MATERIAL" and node.is_active_output), None)
    links = output.inputs["Surface"].links if output else ()
    if not links:
        return None, 1.0
    node = links[0].from_node

    def value(name: str) -> float:
        """The value of an input that nothing is linked to; NaN, which makes neither mirror nor glass, for others."""
        socket = node.inputs.get(name)
        return socket.default_value if socket and not socket.is_linked else math.nan

    smooth = value("Roughness") <= MAX_ROUGHNESS
    if node.type == "BSDF_GLASS" and smooth and value("IOR") > 0:
        return "glass", value("IOR")
    if node.type in ("BSDF_GLOSSY", "BSDF_ANISOTROPIC") and smooth:
        return "mirror", 1.0
    if node.type == "BSDF_PRINCIPLED" and smooth:
        if value("Metallic") >= 0.95:
            return "mirror", 1.0
        if value("Transmission Weight") >= 0.5 and value("IOR") > 0:
            return "glass", value("IOR")
    return None, 1.0


def main() -> None:
    options = arguments()
    bpy = layout.package("bpy", "this is run by Blender (blender -b scene.blend -P scripts/capture/blender.py -- …), or by Python 3.11 "
                         "with bpy: python3.11 -m pip install bpy==4.2.23")
    scene = opened(bpy, options)
    stamp = layout.scene_stamp(bpy.data.filepath)
    stamp |= {"renderer": f"Blender {bpy.app.version_string} Cycles", "denoise": options.denoise}
    fps = scene.render.fps / scene.render.fps_base
    plan = layout.Plan(options, stamp, [scene.frame_start, scene.frame_end], fps)
    with tempfile.TemporaryDirectory(prefix="lightfold-") as work:
        layout.capture(plan, Renderer(bpy, scene, options, work))


if __name__ == "__main__":
    run(main)
