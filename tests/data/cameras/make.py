"""Writes the camera files of this folder with the Python packages of the programs that define them.

    pip install pycolmap usd-core pygltflib && python make.py

Expected values, in expected.json, are those packages' own: eyes, and directions of the corners and the middle of the picture.
"""

import json
import math
import pathlib

import numpy
import pycolmap
import pygltflib
from pxr import Gf, Usd, UsdGeom

HERE = pathlib.Path(__file__).parent
SHARES = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.5)]


def unit(vector):
    return [float(part) for part in numpy.asarray(vector) / numpy.linalg.norm(vector)]


def colmap():
    """Two images of an off-centre pinhole, and one of a camera without distortion."""
    reconstruction = pycolmap.Reconstruction()
    cameras = [
        pycolmap.Camera(model="PINHOLE", width=640, height=480, params=[500.0, 510.0, 300.0, 250.0], camera_id=1),
        pycolmap.Camera(model="SIMPLE_RADIAL", width=320, height=240, params=[200.0, 160.0, 120.0, 0.0], camera_id=4),
    ]
    expected = []
    for camera in cameras:
        reconstruction.add_camera_with_trivial_rig(camera)
    poses = [
        (1, 1, [0.1, -0.2, 0.3], [0.5, -0.25, 2.0]),
        (2, 1, [1.0, 0.5, -0.4], [0.0, 1.0, -3.0]),
        (7, 4, [0.0, math.pi / 2, 0.0], [1.0, 2.0, 3.0]),
    ]
    for image_id, camera_id, turn, translation in poses:
        angle = float(numpy.linalg.norm(turn))
        axis = numpy.asarray(turn) / angle
        rotation = pycolmap.Rotation3d(numpy.append(axis * math.sin(angle / 2), math.cos(angle / 2)))
        world_to_camera = pycolmap.Rigid3d(rotation, numpy.asarray(translation))
        image = pycolmap.Image(name=f"frame {image_id:03}.png", camera_id=camera_id, image_id=image_id)
        reconstruction.add_image_with_trivial_frame(image, world_to_camera)
        camera = reconstruction.cameras[camera_id]
        camera_to_world = world_to_camera.inverse()
        directions = []
        for x, y in SHARES:
            plane = camera.cam_from_img(numpy.array([x * camera.width, y * camera.height]))
            directions.append(unit(camera_to_world.rotation.matrix() @ numpy.append(plane, 1.0)))
        eye = [float(part) for part in camera_to_world.translation]
        expected.append({"frame": None, "eye": eye, "directions": directions})
    folder = HERE / "colmap"
    folder.mkdir(exist_ok=True)
    reconstruction.write_text(str(folder))
    for name in ("points3D.txt", "rigs.txt", "frames.txt"):
        (folder / name).unlink(missing_ok=True)
    return expected


def usd():
    """A camera that is animated below a turned parent, and a still one with an off-axis window; centimetres, Z is up."""
    path = HERE / "shot.usda"
    stage = Usd.Stage.CreateNew(str(path))
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 0.01)
    stage.SetStartTimeCode(1)
    stage.SetEndTimeCode(4)
    rig = UsdGeom.Xform.Define(stage, "/rig")
    rig.AddTranslateOp().Set(Gf.Vec3d(100, 0, 0))
    rig.AddRotateXYZOp().Set(Gf.Vec3f(10, 20, 30))
    moving = UsdGeom.Camera.Define(stage, "/rig/moving")
    transform = moving.AddTransformOp()
    for time in (1, 3, 4):
        matrix = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 2, 0), 5.0 * time))
        transform.Set(matrix.SetTranslateOnly(Gf.Vec3d(10 * time, 20, -30)), time)
        moving.GetFocalLengthAttr().Set(30.0 + time, time)
    still = UsdGeom.Camera.Define(stage, "/still")
    still.AddTranslateOp().Set(Gf.Vec3d(0, -500, 150))
    still.AddRotateXOp().Set(80.0)
    still.GetHorizontalApertureAttr().Set(24.0)
    still.GetVerticalApertureAttr().Set(18.0)
    still.GetHorizontalApertureOffsetAttr().Set(2.0)
    still.GetVerticalApertureOffsetAttr().Set(-1.5)
    still.GetFocalLengthAttr().Set(28.0)
    stage.Save()
    # Z up and centimetres to Y up and metres.
    upright = Gf.Matrix4d().SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), -90))
    expected = []
    for prim, times in ((moving, (1, 2, 3, 4)), (still, (None,))):
        for time in times:
            code = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
            camera = prim.GetCamera(code)
            if time == 2:
                # Between samples the matrix is interpolated, and its axes are no longer of length 1 and at right angles.
                continue
            camera.transform = camera.transform * upright
            frustum = camera.frustum
            directions = []
            for x, y in SHARES:
                ray = frustum.ComputePickRay(Gf.Vec2d(2 * x - 1, 1 - 2 * y))
                directions.append(unit(list(ray.direction)))
            eye = [part * 0.01 for part in camera.transform.ExtractTranslation()]
            expected.append({"frame": time, "eye": eye, "directions": directions})
    return expected


def gltf():
    """A node that an animation moves, with a camera below it, and a still one."""
    times = numpy.array([0.0, 2 / 24], dtype="<f4")
    places = numpy.array([[0, 1, 0], [2, 1, -4]], dtype="<f4")
    data = times.tobytes() + places.tobytes()
    half = math.sqrt(0.5)
    document = pygltflib.GLTF2(
        scene=0,
        scenes=[pygltflib.Scene(nodes=[0, 2])],
        nodes=[
            pygltflib.Node(name="rig", children=[1], translation=[9.0, 9.0, 9.0]),
            pygltflib.Node(name="moving", camera=0, rotation=[0.0, half, 0.0, half]),
            pygltflib.Node(name="still", camera=1, translation=[0.0, 1.5, 3.0], scale=[2.0, 2.0, 2.0]),
        ],
        cameras=[
            pygltflib.Camera(type="perspective", perspective=pygltflib.Perspective(yfov=0.8, aspectRatio=1.5, znear=0.1)),
            pygltflib.Camera(type="perspective", perspective=pygltflib.Perspective(yfov=1.0, znear=0.1, zfar=100.0)),
        ],
        animations=[
            pygltflib.Animation(
                channels=[
                    pygltflib.AnimationChannel(
                        sampler=0, target=pygltflib.AnimationChannelTarget(node=0, path="translation")
                    )
                ],
                samplers=[pygltflib.AnimationSampler(input=0, output=1, interpolation="LINEAR")],
            )
        ],
        accessors=[
            pygltflib.Accessor(bufferView=0, componentType=5126, count=2, type="SCALAR", min=[0.0], max=[float(times[1])]),
            pygltflib.Accessor(bufferView=1, componentType=5126, count=2, type="VEC3"),
        ],
        bufferViews=[
            pygltflib.BufferView(buffer=0, byteOffset=0, byteLength=8),
            pygltflib.BufferView(buffer=0, byteOffset=8, byteLength=24),
        ],
        buffers=[pygltflib.Buffer(byteLength=len(data))],
    )
    document.set_binary_blob(data)
    document.save_binary(str(HERE / "shot.glb"))

    def directions(yfov, aspect, turn):
        v = math.tan(yfov / 2)
        return [unit(turn((2 * x - 1) * v * aspect, (1 - 2 * y) * v, -1.0)) for x, y in SHARES]

    left = directions(0.8, 1.5, lambda x, y, z: (z, y, -x))
    expected = [{"frame": at, "eye": [1.0 * at, 1.0, -2.0 * at], "directions": left} for at in range(3)]
    ahead = directions(1.0, 1.0, lambda x, y, z: (x, y, z))
    return expected + [{"frame": None, "eye": [0.0, 1.5, 3.0], "directions": ahead}]


def main():
    expected = {"colmap": colmap(), "shot.usda": usd(), "shot.glb": gltf()}
    (HERE / "expected.json").write_text(json.dumps(expected, indent=1) + "\n")


main()
