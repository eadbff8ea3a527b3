"""Where a method's mean is not the reference: the maps of a comparison's rows."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, List, Optional

from ._files import OutputFile, Path
from ._optional import needed
from .shapes import WelchBlock, WelchMap

if TYPE_CHECKING:
    import numpy
    import numpy.typing


class BiasMap:
    """Of one row and one layer, block by block of pixels: how far the mean luminance of the seeds is from the reference's,
    relative to that, and whether chance explains it, the blocks of the image judged together [Jung et al. 2020]. Shown in a
    notebook, it is its picture."""

    def __init__(self, data: WelchMap, png: bytes) -> None:
        #: The whole object as the daemon sent it.
        self.data = data
        #: The picture, as the dashboard shows it.
        self.png = png

    @property
    def text(self) -> str:
        """What it comes to, in a sentence."""
        return self.data["text"]

    @property
    def is_heavy_tailed(self) -> bool:
        """Whether rare bright samples make its tests unreliable."""
        return self.data["heavy_tailed"]

    @property
    def blocks(self) -> List[List[WelchBlock]]:
        """Row by row, the top one first."""
        width, blocks = self.data["width"], self.data["blocks"]
        return [blocks[first:first + width] for first in range(0, len(blocks), width)]

    @property
    def differences(self) -> List[List[Optional[float]]]:
        """Of the mean of the seeds, relative to the reference, block by block; None where a block has none."""
        return [[block["difference"] for block in row] for row in self.blocks]

    @property
    def found(self) -> List[List[bool]]:
        """Where chance does not explain the difference, block by block."""
        return [[block["found"] for block in row] for row in self.blocks]

    def array(self) -> "numpy.typing.NDArray[numpy.floating[Any]]":
        """`differences` as ndarray, height x width in blocks; NaN where a block has none."""
        numpy = needed("numpy", "an array")
        return numpy.array(self.differences, dtype=float)  # type: ignore[no-any-return]

    def save(self, path: Path) -> None:
        """The picture."""
        with OutputFile(path) as output:
            output.write(self.png)
            output.publish()

    def _repr_png_(self) -> bytes:
        return self.png

    def __repr__(self) -> str:
        return f"<BiasMap of {self.data['label']}, {self.data['layer']}: {self.text}>"
