"""A film that the tests decode, and its source."""

import numpy as np

import lightfold

SIDE, FRAMES = 32, 4


def depth_of(face, frame):
    """A disc that moves before a wall, in metres."""
    y, x = np.mgrid[:SIDE, :SIDE]
    center = 8 + 4 * frame + lightfold.FACES.index(face)
    return np.where(np.hypot(x - center, y - 16) < 6, 2.0, 5.0).astype(np.float32)


def color_of(face, frame):
    """The disc bright, the wall a ramp, as linear light."""
    ramp = np.linspace(0, 0.5, SIDE)[:, None, None] * np.array([1, 0.5, 0.25])
    wall = np.broadcast_to(ramp, (SIDE, SIDE, 3))
    return np.where(depth_of(face, frame)[..., None] < 3, 0.8, wall).astype(np.float32)


def frames(image):
    return {face: np.stack([image(face, frame) for frame in range(FRAMES)]) for face in lightfold.FACES}


def write(path, **settings):
    probe = lightfold.Probe("00", position=(0, 1.5, 0))
    return lightfold.encode(path, [probe], color=[frames(color_of)], depth=[frames(depth_of)], **settings)
