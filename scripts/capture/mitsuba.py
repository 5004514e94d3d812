#!/usr/bin/env python3
"""Captures a scene of Mitsuba 3 as a light-field dataset: cube maps of colour, depth, material and normals."""

# Mitsuba's package has this file's name: it must be found before the folder in which this file lies.
import argparse
import importlib.machinery
import importlib.util
import pathlib
import re
import sys
import types
from typing import Any

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))
import layout  # noqa: E402
import numpy as np  # noqa: E402
from layout import Array, Refused, Vector, View, run  # noqa: E402

sys.path[:] = [entry for entry in sys.path if pathlib.Path(entry or ".").resolve() != HERE]

ABOUT = """\
Renders a scene of Mitsuba 3 from the cameras of lightfold and writes what `lightfold encode` reads. Mitsuba comes with
  python3 -m pip install -c scripts/requirements.txt mitsuba numpy

  scripts/capture/mitsuba.py scene.xml --cameras cameras.json -o DIR
  scripts/capture/mitsuba.py scene.xml --cameras cameras.json -o DIR --size 1024 --samples 256 --aov depth,material
  scripts/capture/mitsuba.py shot.%04d.xml --cameras cameras.json -o DIR --frames 0-47
  scripts/capture/mitsuba.py shot.py --cameras cameras.json -o DIR --frames 0-47 --projection equirect

Frame f is the time f / --fps. A scene that moves is one file for each frame (%04d or #### in its name), an XML file that uses
$frame or $time, or Python with a function scene(time) that answers what mitsuba.load_dict takes. The scene's own integrator
renders; its sensors are not used. Depth, normals and materials are of the first surface on the ray: what is cut out by a mask of
less than a half is passed through. Material is that of perfect mirrors (reflect 1) and glass (Fresnel's reflect, and ior), and
0, 0, 1 elsewhere. Which noise a colour has may depend on the number of threads; nothing else does.
"""
# Surfaces with holes that one ray passes at most.
MAX_HOLES = 64
# Reflect, refract and ior of a surface that is no mirror and no glass.
NO_OPTICS = (0.0, 0.0, 1.0)
# lightfold's axes in the scene's, and back.
TO_SCENE = {"y": lambda x, y, z: (x, y, z), "z": lambda x, y, z: (x, -z, y)}
TO_WORLD = {"y": lambda x, y, z: (x, y, z), "z": lambda x, y, z: (x, z, -y)}


def arguments() -> argparse.Namespace:
    parser = layout.parser("scripts/capture/mitsuba.py", ABOUT)
    parser.add_argument("scene", metavar="SCENE", help="scene.xml, shot.%%04d.xml or shot.py")
    parser.add_argument("--fps", type=float, default=24.0, help="frames per second [default: 24]")
    parser.add_argument("--up", choices=["y", "z"], default="y",
                        help="which axis of the scene points up; with z, lightfold's x, y, z are its x, -z, y [default: y]")
    parser.add_argument("--unit", metavar="M", type=float, default=1.0, help="metres in a unit of the scene [default: 1]")
    parser.add_argument("-D", "--define", metavar="NAME=VALUE", action="append", default=[], help="a parameter of the XML file")
    parser.add_argument("--variant", default="scalar_rgb",
                        help="what renders colour; llvm_ad_rgb (LLVM 19 is new enough, 15 is not) and cuda_ad_rgb are faster "
                             "[default: scalar_rgb]")
    options = parser.parse_args()
    if not (options.fps > 0 and options.unit > 0):
        raise Refused("--fps and --unit must be above 0")
    return options


class SceneFile:
    """A scene as it is at each frame."""

    def __init__(self, mi: Any, options: argparse.Namespace):
        self.mi = mi
        self.path = options.scene
        self.fps = options.fps
        self.pattern = bool(re.search(r"%0?\d*d|#+", pathlib.Path(self.path).name))
        self.defined = dict(self.definition(words) for words in options.define)
        self.module: Any = None
        self.uses: list[str] = []
        if self.path.endswith(".py"):
            self.module = self.python()
        elif not self.pattern:
            text = self.text()
            self.uses = [name for name in ("frame", "time") if re.search(rf"\${name}\b", text)]

    @staticmethod
    def definition(words: str) -> tuple[str, str]:
        name, equals, value = words.partition("=")
        if not (name and equals):
            raise Refused(f"-D {words}: NAME=VALUE was expected")
        return name, value

    def text(self) -> str:
        try:
            return pathlib.Path(self.path).read_text(encoding="utf-8", errors="replace")
        except OSError as error:
            raise Refused(f"{self.path}: the scene cannot be read: {error.strerror}") from error

    def python(self) -> types.ModuleType:
        self.text()
        loader = importlib.machinery.SourceFileLoader("captured_scene", self.path)
        spec = importlib.util.spec_from_loader(loader.name, loader)
        assert spec
        module = importlib.util.module_from_spec(spec)
        self.mi.set_variant("scalar_rgb")
        loader.exec_module(module)
        if not callable(getattr(module, "scene", None)):
            raise Refused(f"{self.path}: a function scene(time) was expected, which answers what mitsuba.load_dict takes")
        return module

    def moves(self) -> bool:
        return bool(self.pattern or self.module or self.uses)

    def file(self, frame: int) -> str:
        """The file of a frame."""
        if not self.pattern:
            return self.path
        name = pathlib.Path(self.path).name
        name = re.sub(r"#+", lambda found: f"{frame:0{len(found[0])}}", name) if "#" in name else name % frame
        return str(pathlib.Path(self.path).with_name(name))

    def frames(self) -> list[int]:
        """First and last frame that the scene has: those of its files, or 0 where one file has them all."""
        if not self.pattern:
            return [0, 0]
        folder, name = pathlib.Path(self.path).parent, pathlib.Path(self.path).name
        digits = re.compile(r"(\d+)".join(re.escape(part) for part in re.split(r"%0?\d*d|#+", name)))
        found = [digits.fullmatch(path.name) for path in folder.glob("*")]
        numbers = [int(match[1]) for match in found if match]
        if not numbers:
            raise Refused(f"{self.path}: there is no file of that name with a number in it")
        return [min(numbers), max(numbers)]

    def load(self, frame: int, variant: str) -> Any:
        """The scene of a frame, in a variant, which is then the one in use."""
        self.mi.set_variant(variant)
        try:
            if self.module:
                found = self.module.scene(frame / self.fps)
                return self.mi.load_dict(found) if isinstance(found, dict) else found
            known = {"frame": str(frame), "time": repr(frame / self.fps)}
            return self.mi.load_file(self.file(frame), **self.defined, **{name: known[name] for name in self.uses})
        except (RuntimeError, OSError) as error:
            raise Refused(f"{self.file(frame)}: Mitsuba cannot load it: {' '.join(str(error).split())}") from error


class Renderer:
    """Renders images of views, for layout.capture. Rays of depth are cast in scalar_rgb, whatever renders colour."""

    def __init__(self, mi: Any, options: argparse.Namespace, scenes: SceneFile):
        self.mi = mi
        self.options = options
        self.scenes = scenes
        self.colored: Any = None
        self.traced: Any = None
        self.surfaces: dict[Any, Surface] = {}

    def frame(self, number: int) -> None:
        if self.traced and not self.scenes.moves():
            return
        self.surfaces = {}
        self.traced = self.scenes.load(number, "scalar_rgb")
        self.colored = self.traced
        if self.options.variant != "scalar_rgb":
            self.colored = self.scenes.load(number, self.options.variant)

    def to_scene(self, vector: Vector) -> Vector:
        return TO_SCENE[self.options.up](*vector)

    def place(self, view: View) -> Vector:
        x, y, z = view.camera.position
        unit = self.options.unit
        return self.to_scene((x / unit, y / unit, z / unit))

    def images(self, view: View) -> dict[str, list[Array]]:
        found = {}
        if "color" in view.kinds:
            self.mi.set_variant(self.options.variant)
            found["color"] = self.color(view)
        if view.kinds != ["color"]:
            self.mi.set_variant("scalar_rgb")
            found.update(self.surfaces_of(view))
        return found

    # ---- colour

    def color(self, view: View) -> list[Array]:
        mi = self.mi
        image = mi.render(self.colored, sensor=self.sensor(view), spp=self.options.samples, seed=view.seed)
        width, height = view.size
        if image.shape[:2] != (height, width) or image.shape[2] < 3:
            raise Refused(f"the scene's integrator answers images of {image.shape}: red, green and blue were expected")
        values = np.array(image.array, np.float32).reshape(image.shape)
        return view.mirror([values[..., channel] for channel in range(3)])

    def sensor(self, view: View) -> Any:
        mi = self.mi
        width, height = view.size
        film = {"type": "hdrfilm", "width": width, "height": height, "pixel_format": "rgb", "component_format": "float32",
                "rfilter": {"type": "box"}}
        # Mitsuba's cameras have +X to the left, +Y up and look along +Z.
        left = [-value for value in self.to_scene(view.right)]
        if view.mirrored:
            left = [-value for value in left]
        axes = (left, self.to_scene(view.up), self.to_scene(view.forward), self.place(view))
        matrix = [[axis[row] for axis in axes] for row in range(3)] + [[0, 0, 0, 1]]
        to_world = mi.ScalarTransform4f(matrix)
        if view.projection == "equirect":
            mi.register_sensor("lightfold_equirect", equirect_class(mi))
            return mi.load_dict({"type": "lightfold_equirect", "to_world": to_world, "film": film,
                                 "sampler": {"type": "independent"}})
        return mi.load_dict({"type": "perspective", "fov": view.fov_y_deg, "fov_axis": "y", "to_world": to_world, "film": film,
                             "near_clip": 1e-4 / self.options.unit, "far_clip": 1e9 / self.options.unit,
                             "sampler": {"type": "independent"}})

    # ---- depth, normals, materials

    def surfaces_of(self, view: View) -> dict[str, list[Array]]:
        """Planes of what lies on the ray through the middle of each pixel."""
        mi, to_world = self.mi, TO_WORLD[self.options.up]
        origin = mi.Point3f(*self.place(view))
        width, height = view.size
        # Distance, normal, reflect, refract and ior.
        found = np.empty((height * width, 7))
        more = view.kinds[-1] in ("normal", "material")
        for pixel, (x, y, z) in zip(found, view.directions().reshape(-1, 3).tolist()):
            toward = mi.Vector3f(*self.to_scene((x, y, z)))
            distance, met, surface = self.first(origin, toward)
            normal, optics = ((0.0, 0.0, 0.0), NO_OPTICS) if met is None or not more else self.look(met, surface, toward)
            pixel[:] = distance * self.options.unit, *to_world(*normal), *optics
        planes = list(found.T.reshape(7, height, width))
        return {"depth": planes[:1], "normal": planes[1:4], "material": planes[4:]}

    def first(self, origin: Any, toward: Any) -> tuple[float, Any, Any]:
        """(distance, intersection, surface) of what a ray meets first; +inf, None, None where that is nothing."""
        ray = self.mi.Ray3f(origin, toward)
        for hole in range(MAX_HOLES):
            met = self.traced.ray_intersect(ray)
            if not met.is_valid():
                break
            surface = self.surface(met.bsdf(ray))
            if not (surface.holes and surface.transmits(met)):
                return (met.t if not hole else self.length(met.p - origin)), met, surface
            ray = met.spawn_ray(toward)
        return float("inf"), None, None

    @staticmethod
    def length(vector: Any) -> float:
        return float(vector.x ** 2 + vector.y ** 2 + vector.z ** 2) ** 0.5

    def surface(self, bsdf: Any) -> "Surface":
        found = self.surfaces.get(bsdf)
        if found is None:
            found = self.surfaces[bsdf] = Surface(self.mi, bsdf)
        return found

    def look(self, met: Any, surface: "Surface", toward: Any) -> tuple[Vector, Vector]:
        """Normal that faces the camera, in the scene's axes, and reflect, refract, ior."""
        normal = met.sh_frame.n
        cosine = normal.x * toward.x + normal.y * toward.y + normal.z * toward.z
        if cosine > 0:
            normal = -normal
        geometric = met.n
        inside = geometric.x * toward.x + geometric.y * toward.y + geometric.z * toward.z > 0
        return (normal.x, normal.y, normal.z), surface.optics(min(abs(cosine), 1.0), inside)


class Surface:
    """Properties of a BSDF."""

    def __init__(self, mi: Any, bsdf: Any):
        self.bsdf = bsdf
        self.kind, self.ior, self.holes = "", 1.0, False
        if bsdf is None:
            return
        known = mi.BSDFFlags

        def has(*flags: Any) -> bool:
            return any(mi.has_flag(bsdf.flags(), flag) for flag in flags)

        self.holes = has(known.Null) and bsdf.class_name() != "ThinDielectric"
        if has(known.Diffuse, known.Glossy, known.Delta1D):
            return
        iors = [values for name, values in mi.traverse(bsdf) if name.split(".")[-1] == "eta"]
        thin = has(known.Null) and not self.holes
        if has(known.DeltaTransmission) or thin:
            if iors and isinstance(iors[0], float):
                self.kind, self.ior = "glass", iors[0]
        elif has(known.DeltaReflection):
            self.kind = "mirror"

    def transmits(self, met: Any) -> bool:
        through = self.bsdf.eval_null_transmission(met)
        return sum(through) / len(through) > 0.5

    def optics(self, cosine: float, inside: bool) -> Vector:
        if self.kind == "mirror":
            return 1.0, 0.0, 1.0
        if self.kind == "glass":
            return layout.glass(cosine, self.ior, inside)
        return NO_OPTICS


def equirect_class(mi: Any) -> Any:
    """A sensor that sees in all directions, which Mitsuba has not: of the variant that is in use."""
    import drjit as dr

    class Equirect(mi.Sensor):  # type: ignore[misc]
        def __init__(self, props: Any):
            super().__init__(props)
            self.frame = mi.Transform4f(props["to_world"].matrix) if hasattr(props["to_world"], "matrix") else props["to_world"]

        def sample_ray(self, time: Any, wavelength_sample: Any, position_sample: Any, aperture_sample: Any, active: Any = True) -> Any:
            lon = (2 * position_sample.x - 1) * dr.pi
            lat = (0.5 - position_sample.y) * dr.pi
            # +X is to the left, as in Mitsuba's own cameras.
            local = mi.Vector3f(-dr.sin(lon) * dr.cos(lat), dr.sin(lat), dr.cos(lon) * dr.cos(lat))
            interaction = dr.zeros(mi.SurfaceInteraction3f)
            wavelengths, weight = self.sample_wavelengths(interaction, wavelength_sample, active)
            ray = mi.Ray3f(self.frame @ mi.Point3f(0, 0, 0), dr.normalize(self.frame @ local), time, wavelengths)
            return ray, weight

        def sample_ray_differential(self, *sample: Any) -> Any:
            ray, weight = self.sample_ray(*sample)
            return mi.RayDifferential3f(ray), weight

    return Equirect


def main() -> None:
    options = arguments()
    mi = layout.package("mitsuba", "Mitsuba is not installed for this Python: python3 -m pip install -c "
                        f"{HERE.parent / 'requirements.txt'} mitsuba numpy")
    if options.variant not in mi.variants():
        raise Refused(f"--variant {options.variant}: this Mitsuba has {', '.join(mi.variants())}")
    if options.threads:
        import drjit
        drjit.set_thread_count(options.threads)
    mi.set_variant("scalar_rgb")
    mi.set_log_level(mi.LogLevel.Error)
    scenes = SceneFile(mi, options)
    frames = scenes.frames()
    stamp = layout.scene_stamp(scenes.file(frames[0]))
    stamp |= {"renderer": f"Mitsuba {mi.__version__} {options.variant}", "defined": scenes.defined, "up": options.up,
              "unit": options.unit}
    plan = layout.Plan(options, stamp, frames, options.fps)
    layout.capture(plan, Renderer(mi, options, scenes))


if __name__ == "__main__":
    run(main)
