"""Pixels as the daemon sends them: raw, little-endian, the top row first."""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, Mapping, NamedTuple, Tuple

from ._optional import needed
from .errors import ProtocolError

if TYPE_CHECKING:
    import numpy
    import numpy.typing

_FORMATS = {"float": ("<f4", "f", 4), "half": ("<f2", "e", 2)}


class Pixels:
    """One layer of an image, usable without numpy.

    >>> pixels = client.render("furnace", width=4, height=2, passes=1).pixels("emitted")
    >>> pixels.width, pixels.height, pixels.channels
    (4, 2, 3)
    >>> pixels.at(3, 1)
    (1.0, 1.0, 1.0)
    """

    def __init__(self, width: int, height: int, channels: int, precision: str, data: bytes, overflowed: int = 0) -> None:
        self.width = width
        self.height = height
        self.channels = channels
        self.precision = precision
        self.data = data
        #: Values too large for half precision, which are infinite here.
        self.overflowed = overflowed
        expected = width * height * channels * _FORMATS[precision][2]
        if len(data) != expected:
            raise ProtocolError(f"{width} x {height} x {channels} pixels of {precision} are {expected} bytes, "
                                f"{len(data)} came")

    @staticmethod
    def from_reply(headers: Mapping[str, str], data: bytes, precision: str) -> "Pixels":
        try:
            size = [int(headers[f"x-image-{name}"]) for name in ("width", "height", "channels")]
        except (KeyError, ValueError) as error:
            raise ProtocolError("pixels came without their size") from error
        return Pixels(size[0], size[1], size[2], precision, data, int(headers.get("x-image-overflowed", "0")))

    def at(self, x: int, y: int) -> Tuple[float, ...]:
        """The channels of one pixel; row 0 is the top one."""
        if not (0 <= x < self.width and 0 <= y < self.height):
            raise IndexError(f"pixel {x}, {y} is outside {self.width} x {self.height}")
        _, code, size = _FORMATS[self.precision]
        offset = (y * self.width + x) * self.channels * size
        values: Tuple[float, ...] = struct.unpack_from(f"<{self.channels}{code}", self.data, offset)
        return values

    def array(self) -> "numpy.typing.NDArray[numpy.floating[Any]]":
        """height x width x channels, float32 (float16 of half precision); height x width where there is one channel."""
        numpy = needed("numpy", "an image as ndarray")
        dtype = numpy.dtype(_FORMATS[self.precision][0])
        shape = (self.height, self.width) + ((self.channels,) if self.channels > 1 else ())
        array = numpy.frombuffer(self.data, dtype).reshape(shape)
        # A copy: one that can be written to, and in the machine's own byte order.
        return array.astype(dtype.newbyteorder("="))  # type: ignore[no-any-return]

    def __repr__(self) -> str:
        return f"<Pixels {self.width} x {self.height} x {self.channels} {self.precision}>"


class FlipMap(NamedTuple):
    """How different two images look, pixel by pixel, 0 to 1."""

    pixels: Pixels
    mean: float
