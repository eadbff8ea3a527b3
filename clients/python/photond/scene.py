"""Scenes and uploaded images."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Dict, List, Optional, Type, TypeVar, Union, cast

from ._daemon import Daemon
from ._files import Path, image_upload, scene_upload
from ._http import resource_path
from ._text import human_bytes, human_number
from .pixels import Pixels
from .shapes import Camera, Json, LookAt

if TYPE_CHECKING:
    import numpy
    import numpy.typing

R = TypeVar("R", bound="Resource")


class Resource:
    """An object of the daemon's and the path it is at."""

    kind = ""

    def __init__(self, client: Daemon, data: Json) -> None:
        self._client = client
        #: The whole object as the daemon sent it last.
        self.data = data

    @classmethod
    def fetch(cls: Type[R], client: Daemon, id: str) -> R:
        """The one of that id, as the daemon has it now. Raises NotFound."""
        return cls(client, client.get(resource_path(cls.kind, id)))

    @property
    def id(self) -> str:
        return str(self.data["id"])

    def _path(self, below: str = "") -> str:
        return resource_path(self.kind, self.id) + below

    def download(self, name: str, path: Optional[Path] = None, **query: Any) -> bytes:
        """A file below this resource, as `curve.csv` of a job; saved under `path` where one is given, else returned.
        Raises NothingYet where there is nothing to be had so far."""
        return self._client.download(self._path("/" + name), path, query)

    def _pixels(self, layer: str, precision: str) -> Pixels:
        reply = self._client.reply(self._path("/pixels"), {"layer": layer, "precision": precision})
        return Pixels.from_reply(reply.headers, reply.body, precision)


class Scene(Resource):
    """A scene the daemon holds; shown in a notebook, its thumbnail.

    >>> scene = client.scene("cornell-box")
    >>> scene
    <Scene cornell-box: 32 triangles, cameras camera>
    >>> scene.bounds["max"]
    [2.78, 5.488, 0.0]
    >>> scene.thumbnail()[:4]
    b'\\x89PNG'
    """

    kind = "scenes"

    @classmethod
    def upload(cls, client: Daemon, path: Path, name: Optional[str] = None) -> "Scene":
        """As Client.upload_scene()."""
        body = scene_upload(path)
        return cls(client, client.send_file("/v1/scenes", body, {"name": name or body.name}))

    @property
    def name(self) -> str:
        return str(self.data.get("name") or self.id)

    @property
    def cameras(self) -> List[str]:
        return [camera["name"] for camera in self.data["cameras"]]

    @property
    def motion(self) -> List[Dict[str, Any]]:
        """Its animations: `index`, `name`, `duration_seconds`, and what each `moves`, as counts."""
        return cast(List[Dict[str, Any]], self.data.get("motion") or [])

    @property
    def triangles(self) -> Optional[int]:
        return cast(Optional[int], self.data["triangles"])

    @property
    def bounds(self) -> Optional[Dict[str, List[float]]]:
        """`min` and `max`, metres."""
        return cast(Optional[Dict[str, List[float]]], self.data["bounds"])

    @property
    def warnings(self) -> List[str]:
        """What the loader could not take as it is."""
        return cast(List[str], self.data["warnings"])

    @property
    def builtin(self) -> bool:
        return bool(self.data["builtin"])

    def refresh(self) -> "Scene":
        self.data = self._client.get(self._path())
        return self

    def thumbnail(self) -> bytes:
        """A small PNG."""
        return self.download("thumbnail.png")

    @property
    def default_view(self) -> LookAt:
        """What a job that names no camera sees: eye, target, up, yfov."""
        if not self.data.get("default_view"):
            self.refresh()
        return cast(LookAt, self.data["default_view"])

    def preview(self, camera: Union[None, str, Camera] = None, *, width: Optional[int] = None,
                height: Optional[int] = None, passes: Optional[int] = None) -> bytes:
        """A quick PNG by one of its cameras or by `look_at(...)`, at most 512 pixels a side and 16 passes; the daemon keeps
        the scene ready for the next one.

        >>> client.scene("cornell-box").preview(photond.look_at([2.8, 2.7, 8], [2.8, 2.7, 0]), width=32, height=32)[:4]
        b'\\x89PNG'
        """
        query: Dict[str, Any] = {"width": width, "height": height, "passes": passes}
        if isinstance(camera, str):
            query["camera"] = camera
        elif camera is not None:
            for name, value in camera.get("look_at", {}).items():
                query[name] = ",".join(map(repr, value)) if isinstance(value, (list, tuple)) else value
        return self.download("preview.png", **query)

    def delete(self) -> None:
        """Raises WrongState while a job uses it."""
        self._client.send("DELETE", self._path())

    def __repr__(self) -> str:
        cameras = f", cameras {', '.join(self.cameras)}" if self.cameras else ""
        return f"<Scene {self.name}: {human_number(self.triangles)} triangles{cameras}>"

    def _repr_png_(self) -> bytes:
        return self.thumbnail()


class UploadedImage(Resource):
    """An EXR or HDR image the daemon holds, to measure against or to light scenes with."""

    kind = "images"

    @classmethod
    def upload(cls, client: Daemon, path: Path) -> "UploadedImage":
        """As Client.upload_image()."""
        return cls(client, client.send_file("/v1/images", image_upload(path)))

    @property
    def width(self) -> int:
        return int(self.data["width"])

    @property
    def height(self) -> int:
        return int(self.data["height"])

    @property
    def layers(self) -> List[str]:
        """Names that `pixels` takes; empty where the daemon is too old to say."""
        return [layer["name"] for layer in self.data.get("layers", [])]

    def pixels(self, layer: str = "beauty", *, precision: str = "float") -> Pixels:
        return self._pixels(layer, precision)

    def array(self, layer: str = "beauty", *, precision: str = "float"
              ) -> "numpy.typing.NDArray[numpy.floating[Any]]":
        """height x width x channels, float32; the top row first."""
        return self.pixels(layer, precision=precision).array()

    def save(self, path: Path) -> None:
        """The file as it was uploaded."""
        self.download("file", path)

    def __repr__(self) -> str:
        return f"<UploadedImage {self.id}: {self.width} x {self.height}, {human_bytes(self.data['bytes'])}>"
