"""Animated light fields (`.lfold`) as numpy arrays.

>>> film = lightfold.open("film.lfold")
>>> film.streams[0]
<Stream color of probe 00, face px, 32x32, frames 0-3, transform-8bit>
>>> film.stream("depth", face="px").decode(0).shape
(32, 32)

Work is shared among threads, as many as the environment variable RAYON_NUM_THREADS says, or one for each processor, and other
Python threads run meanwhile.
"""

from ._lightfold import FACES, Container, Error, Probe, Stream, __version__, encode, open

__all__ = ["FACES", "Container", "Error", "Probe", "Stream", "__version__", "encode", "open"]
