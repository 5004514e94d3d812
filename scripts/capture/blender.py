#!/usr/bin/env python3
"""Captures a scene of Blender with Cycles as a light-field dataset: cube maps of colour, depth, material and normals."""

import math
import pathlib
import sys
import tempfile
from array import array

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import exr  # noqa: E402
import layout  # noqa: E402
from layout import Refused, run  # noqa: E402

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
# What Cycles gives as the depth of nothing is 1e10.
NOTHING = 1e9
# Rougher surfaces are no mirrors and no glass.
MAX_ROUGHNESS = 0.05
PASSES = ["combined", "z", "mist", "position", "normal", "vector", "uv", "object_index", "material_index", "shadow",
          "ambient_occlusion", "emit", "environment", "diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct",
          "glossy_indirect", "glossy_color", "transmission_direct", "transmission_indirect", "transmission_color",
          "subsurface_direct", "subsurface_indirect", "subsurface_color", "cryptomatte_object", "cryptomatte_material",
          "cryptomatte_asset"]


def arguments():
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


def package():
    try:
        import bpy
    except ImportError as error:
        raise Refused("this is run by Blender (blender -b scene.blend -P scripts/capture/blender.py -- …), or by Python 3.11 "
                      f"with bpy: python3.11 -m pip install bpy==4.2.23 ({error})") from error
    return bpy


def opened(bpy, options):
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


def metres_per_unit(scene):
    """Metres in one of the scene's units."""
    return scene.unit_settings.scale_length if scene.unit_settings.system != "NONE" else 1.0


def give(target, **values):
    """Sets those attributes that this release has."""
    for name, value in values.items():
        if hasattr(target, name):
            setattr(target, name, value)


class Renderer:
    """Answers images of views, for layout.capture."""

    def __init__(self, bpy, scene, options, work):
        self.bpy = bpy
        self.scene = scene
        self.options = options
        self.work = pathlib.Path(work)
        self.unit = metres_per_unit(scene)
        self.layer = next((layer for layer in scene.view_layers if layer.use), scene.view_layers[0])
        self.materials = {}
        self.prepare()

    def prepare(self):
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

    def frame(self, number):
        self.scene.frame_set(number)

    def images(self, view):
        self.pose(view)
        found = {}
        if "color" in view.kinds:
            give(self.scene.cycles, samples=self.options.samples, seed=view.seed, pixel_filter_type="BOX", filter_width=1.0,
                 use_denoising=self.options.denoise, denoiser="OPENIMAGEDENOISE", max_bounces=self.bounces)
            planes = self.render([])
            color = [planes[f"Combined.{channel}"] for channel in "RGB"]
            found["color"] = [view.mirror(plane) for plane in color] if view.mirrored else color
        if view.kinds != ["color"]:
            # One ray, whose place in the pixel is within a two-hundredth of the middle.
            give(self.scene.cycles, samples=1, seed=0, pixel_filter_type="GAUSSIAN", filter_width=0.01, use_denoising=False,
                 max_bounces=0)
            more = ["normal"] if view.kinds[-1] in ("normal", "material") else []
            planes = self.render(["z"] + more + (["material_index"] if "material" in view.kinds else []))
            found.update(self.surfaces(view, planes))
        return found

    def pose(self, view):
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
        right = [-value for value in view.right] if view.mirrored else view.right
        columns = [to_blender(right), to_blender(view.up), to_blender([-value for value in view.forward]),
                   to_blender([value / self.unit for value in view.camera.position])]
        self.camera.matrix_world = mathutils.Matrix([[column[row] for column in columns] for row in range(3)] + [[0, 0, 0, 1]])

    def render(self, passes):
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
        size, channels = exr.read(path)
        expected = (self.scene.render.resolution_x, self.scene.render.resolution_y)
        if size != expected:
            raise Refused(f"Blender rendered {size[0]}x{size[1]} pixels: {expected[0]}x{expected[1]} were expected")
        return {".".join(name.split(".")[-2:]): plane for name, plane in channels.items()}

    def surfaces(self, view, planes):
        depth = array("f", self.distances(view, planes["Depth.Z"]))
        images = {"depth": [view.mirror(depth) if view.mirrored else depth]}
        if "Normal.X" not in planes:
            return images
        # Blender's x, y, z are lightfold's x, -z, y.
        normals = [planes["Normal.X"], planes["Normal.Z"], array("f", [-value for value in planes["Normal.Y"]])]
        if view.mirrored:
            normals = [view.mirror(plane) for plane in normals]
        images["normal"] = facing(normals, view)
        index = planes.get("IndexMA.X", planes.get("Material Index.X"))
        if "material" in view.kinds:
            index = view.mirror(index) if view.mirrored else index
            images["material"] = self.optics(view, index, images["normal"])
        return images

    def distances(self, view, depth):
        """Metres along rays, of what Cycles gives: planar in perspective, distances in panoramas."""
        unit = self.unit
        if view.projection == "equirect":
            return [value * unit if value < NOTHING else math.inf for value in depth]
        wide, high = view.tangents
        return [value * unit * math.sqrt(1 + (u * wide) ** 2 + (v * high) ** 2) if value < NOTHING else math.inf
                for value, (u, v) in zip(depth, view.pixels())]

    def optics(self, view, index, normals):
        planes = [array("f"), array("f"), array("f")]
        for number, direction, *normal in zip(index, view.directions(), *normals):
            kind, ior = self.materials.get(round(number), (None, 1.0))
            values = (0.0, 0.0, 1.0)
            if kind == "mirror":
                values = (1.0, 0.0, 1.0)
            elif kind == "glass":
                values = layout.glass(min(1.0, abs(dot(direction, normal))), ior, self.is_inside(view, direction))
            for plane, value in zip(planes, values):
                plane.append(value)
        return planes


    def is_inside(self, view, direction):
        """Whether a ray first meets a surface from behind, which Cycles' normals do not tell: they face the camera."""
        origin = to_blender([value / self.unit for value in view.camera.position])
        toward = to_blender(direction)
        found, _, normal, *_ = self.scene.ray_cast(self.bpy.context.evaluated_depsgraph_get(), origin, toward)
        return found and dot(normal, toward) > 0


def dot(one, other):
    return one[0] * other[0] + one[1] * other[1] + one[2] * other[2]


def facing(normals, view):
    """Normals that face the camera."""
    turned = [array("f"), array("f"), array("f")]
    for direction, *normal in zip(view.directions(), *normals):
        sign = -1.0 if dot(direction, normal) > 0 else 1.0
        for plane, value in zip(turned, normal):
            # Adding 0 makes a zero that is not negative.
            plane.append(sign * value + 0.0)
    return turned


def to_blender(vector):
    x, y, z = vector
    return x, -z, y


def optics_of(material):
    """("mirror" or "glass" or None, ior) of a material, as far as its nodes say it without a texture."""
    tree = material.node_tree if material.use_nodes else None
    output = tree and next((node for node in tree.nodes if node.type == "OUTPUT_MATERIAL" and node.is_active_output), None)
    links = output.inputs["Surface"].links if output else ()
    if not links:
        return None, 1.0
    node = links[0].from_node

    def value(name):
        """Of an input that nothing is linked to; of others, what makes neither mirror nor glass."""
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


def main():
    options = arguments()
    bpy = package()
    scene = opened(bpy, options)
    stamp = layout.scene_stamp(bpy.data.filepath)
    stamp |= {"renderer": f"Blender {bpy.app.version_string} Cycles", "denoise": options.denoise}
    fps = scene.render.fps / scene.render.fps_base
    plan = layout.Plan(options, stamp, [scene.frame_start, scene.frame_end], fps)
    with tempfile.TemporaryDirectory(prefix="lightfold-") as work:
        layout.capture(plan, Renderer(bpy, scene, options, work))


if __name__ == "__main__":
    run(main)
