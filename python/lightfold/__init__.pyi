"""Animated light fields (`.lfold`) as numpy arrays."""

from collections.abc import Iterable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, TypeAlias, final

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

__all__ = ["FACES", "Container", "Error", "Probe", "Stream", "__version__", "encode", "open"]

FACES: tuple[str, str, str, str, str, str]
__version__: str

_Frames: TypeAlias = Iterable[ArrayLike] | NDArray[Any]
_Entries: TypeAlias = Iterable[_Frames | Mapping[str, _Frames] | None]

class Error(ValueError): ...

@final
class Probe:
    def __new__(
        cls,
        name: str,
        position: tuple[float, float, float] = (0.0, 0.0, 0.0),
        orientation: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 1.0),
        intrinsics: tuple[float, float, float, float] | None = None,
    ) -> Probe: ...
    @property
    def name(self) -> str: ...
    @property
    def position(self) -> tuple[float, float, float]: ...
    @property
    def orientation(self) -> tuple[float, float, float, float]: ...
    @property
    def intrinsics(self) -> tuple[float, float, float, float] | None: ...

@final
class Stream:
    @property
    def kind(self) -> str: ...
    @property
    def probe(self) -> str: ...
    @property
    def face(self) -> str: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def shape(self) -> tuple[int, int] | tuple[int, int, int]: ...
    @property
    def dtype(self) -> np.dtype[Any]: ...
    @property
    def frames(self) -> range: ...
    @property
    def codec(self) -> str: ...
    @property
    def near_m(self) -> float | None: ...
    @property
    def far_m(self) -> float | None: ...
    @property
    def error_bound_codes(self) -> int | None: ...
    def decode(self, frame: int, dtype: DTypeLike | None = None, out: NDArray[Any] | None = None) -> NDArray[Any]: ...

@final
class Container:
    @property
    def name(self) -> str: ...
    @property
    def fps(self) -> float: ...
    @property
    def probes(self) -> list[Probe]: ...
    @property
    def streams(self) -> list[Stream]: ...
    def stream(self, kind: str, probe: str | None = None, face: str | None = None) -> Stream: ...
    def statistics(self) -> dict[str, Any]: ...

def open(path: str | PathLike[str]) -> Container: ...
def encode(
    path: str | PathLike[str],
    probes: Sequence[str | Probe] | None = None,
    *,
    color: _Entries | None = None,
    depth: _Entries | None = None,
    material: _Entries | None = None,
    alpha: _Entries | None = None,
    name: str | None = None,
    fps: float = 24.0,
    first_frame: int = 0,
    depth_codec: Literal["predictive", "quadtree", "aabb", "bc4w"] | None = None,
    depth_block: Literal["none", "bc5"] | None = None,
    max_error: int | None = None,
    max_error_relative: float | None = None,
    depth_domain: Literal["log", "linear", "inverse"] | None = None,
    optimize: Literal["quality", "size"] | None = None,
    min_children: int | None = None,
    near: float | None = None,
    far: float | None = None,
    invalid_depth: Literal["refuse", "far", "near"] | None = None,
    depth_window: int | None = None,
    update_threshold: int | None = None,
    max_aabbs: int | None = None,
    keyframe_interval: int | None = None,
    depth_tile: int | None = None,
    color_cell: int | None = None,
    color_block: Literal["none", "bc1", "bc7", "bc6h"] | None = None,
    color_codec: Literal["transform", "cells"] | None = None,
    color_chunk: int | None = None,
    quality: float | None = None,
    psnr: float | None = None,
    color_qp: int | None = None,
    psnr_final: float | None = None,
    lookahead: int | None = None,
    hdr: bool | None = None,
    transfer: Literal["srgb", "linear"] | None = None,
    exposure: float | None = None,
    white: float | None = None,
    material_block: Literal["none", "bc1"] | None = None,
    material_error: int | None = None,
    effort: Literal["fast", "normal", "exhaustive"] | None = None,
    lzma2: int | None = None,
    zstd: int | None = None,
    no_compression: bool | None = None,
    memory: int | None = None,
) -> dict[str, Any]: ...
