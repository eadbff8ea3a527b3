"""Files in and out: what is sent for a scene or an image named by path, and results written whole or not at all."""

from __future__ import annotations

import json
import os
import pathlib
import posixpath
import urllib.parse
import uuid
from typing import Any, BinaryIO, Dict, Iterator, List, Optional, Union

from ._http import CHUNK_BYTES
from .errors import BadFile

Path = Union[str, "os.PathLike[str]"]

SCENE_SUFFIXES = (".glb", ".gltf", ".zip")
IMAGE_SUFFIXES = {".exr": "image/x-exr", ".hdr": "image/vnd.radiance"}


class FilesBody:
    """Texts and files one after the other, as one body; files are streamed, never held."""

    def __init__(self, content_type: str) -> None:
        self.content_type = content_type
        self.size_bytes = 0
        self.name = ""  # what it is of, without its suffix
        self._parts: List[Union[bytes, pathlib.Path]] = []
        self._sizes: List[int] = []

    def add_text(self, text: str) -> None:
        self._add(text.encode(), len(text.encode()))

    def add_file(self, file: pathlib.Path) -> None:
        try:
            with open(file, "rb"):
                size = file.stat().st_size
        except OSError as error:
            raise BadFile(f"cannot read {file}: {error.strerror}") from error
        if not file.is_file():
            raise BadFile(f"{file} is no regular file")
        self._add(file, size)

    def _add(self, part: Union[bytes, pathlib.Path], size: int) -> None:
        self._parts.append(part)
        self._sizes.append(size)
        self.size_bytes += size

    def chunks(self) -> Iterator[bytes]:
        for part, size in zip(self._parts, self._sizes):
            if isinstance(part, bytes):
                yield part
                continue
            try:
                source = open(part, "rb")
            except OSError as error:
                raise BadFile(f"cannot read {part}: {error.strerror}") from error
            with source:
                yield from _whole(source, size, part)


def _whole(source: BinaryIO, size: int, file: pathlib.Path) -> Iterator[bytes]:
    while size > 0:
        try:
            chunk = source.read(min(CHUNK_BYTES, size))
        except OSError as error:
            raise BadFile(f"cannot read {file}: {error.strerror}") from error
        if not chunk:
            raise BadFile(f"{file} became shorter while it was sent")
        size -= len(chunk)
        yield chunk


def looks_like_scene_path(text: str) -> bool:
    """Whether a scene given as text is meant as a path: something lies there, or it is written like one. Built-in scenes of
    a family have one slash within their names.

    >>> from photond._files import looks_like_scene_path
    >>> [looks_like_scene_path(t) for t in ("room.glb", "details/room.GLTF", "./room", "~/room", "rooms/", "a/b/c", "/a/b")]
    [True, True, True, True, True, True, True]
    >>> [looks_like_scene_path(t) for t in ("room", "cornell-box", "details/books", "hard-case/thin-wall-1e-3")]
    [False, False, False, False]
    """
    of_family = text.count("/") == 1 and text[0] not in "./~" and not text.endswith("/") and not os.path.exists(text)
    return text.lower().endswith(SCENE_SUFFIXES) or ("/" in text and not of_family) or os.path.isdir(text)


def scene_upload(path: Path) -> FilesBody:
    """`path`: .glb, .zip, .gltf (sent with every file it refers to), or a folder that holds one of these. Raises BadFile
    naming every file that is missing or lies outside the .gltf's own folder."""
    given = pathlib.Path(path)
    if not given.exists():
        raise BadFile(f"{given}: no such file or folder")
    file = _scene_file_in(given) if given.is_dir() else given
    suffix = file.suffix.lower()
    if suffix not in SCENE_SUFFIXES:
        raise BadFile(f"{file} is no scene: .glb, .gltf, .zip or a folder with one is")
    if suffix == ".gltf":
        upload = _gltf_upload(file)
    else:
        upload = FilesBody("model/gltf-binary" if suffix == ".glb" else "application/zip")
        upload.add_file(file)
    upload.name = file.stem
    return upload


def image_upload(path: Path) -> FilesBody:
    file = pathlib.Path(path)
    media_type = IMAGE_SUFFIXES.get(file.suffix.lower())
    if media_type is None:
        raise BadFile(f"{file} is no image the daemon takes: .exr or .hdr is")
    upload = FilesBody(media_type)
    upload.add_file(file)
    upload.name = file.stem
    return upload


def _scene_file_in(folder: pathlib.Path) -> pathlib.Path:
    """A .gltf before a .glb before a .zip; two of the foremost kind are a question back."""
    for suffix in (".gltf", ".glb", ".zip"):
        found = sorted(file for file in folder.iterdir() if file.is_file() and file.suffix.lower() == suffix)
        if len(found) == 1:
            return found[0]
        if found:
            raise BadFile(f"{folder} holds {len(found)} files *{suffix}: which one is meant? For example {found[0]}")
    raise BadFile(f"{folder} holds no .gltf, .glb or .zip")


def _referenced_files(gltf: Dict[str, Any]) -> List[str]:
    """Every `uri` of the buffers and images that names a file, decoded, each once."""
    files: Dict[str, None] = {}
    for kind in ("buffers", "images"):
        items = gltf.get(kind)
        for item in items if isinstance(items, list) else []:
            uri = item.get("uri") if isinstance(item, dict) else None
            if isinstance(uri, str) and not uri.startswith("data:"):
                files[posixpath.normpath(urllib.parse.unquote(uri))] = None
    return list(files)


def _gltf_upload(file: pathlib.Path) -> FilesBody:
    try:
        gltf = json.loads(file.read_bytes())
    except OSError as error:
        raise BadFile(f"cannot read {file}: {error.strerror}") from error
    except ValueError:
        gltf = None
    if not isinstance(gltf, dict):
        raise BadFile(f"{file} is not a JSON object, so it is no .gltf")
    others = _referenced_files(gltf)
    faults = []
    for other in others:
        if other.startswith(("/", "../")) or other == ".." or ":/" in other:
            faults.append(f"\n  {other}: lies outside the folder of the .gltf")
        elif not (file.parent / other).is_file():
            faults.append(f"\n  {other}: no such file in {file.parent}")
    if faults:
        raise BadFile(f"{file} refers to files that cannot be sent:" + "".join(faults))

    boundary = f"photond-python-{uuid.uuid4().hex}"
    upload = FilesBody(f"multipart/form-data; boundary={boundary}")
    for name in [file.name, *others]:
        quoted = name.replace("\\", "\\\\").replace('"', '\\"')
        kind = "model/gltf+json" if name == file.name else "application/octet-stream"
        upload.add_text(f'--{boundary}\r\nContent-Disposition: form-data; name="file"; filename="{quoted}"\r\n'
                        f"Content-Type: {kind}\r\n\r\n")
        upload.add_file(file.parent / name)
        upload.add_text("\r\n")
    upload.add_text(f"--{boundary}--\r\n")
    return upload


class OutputFile:
    """Written beside its place and renamed when whole, so that nobody reads half a file.

        with OutputFile(path) as output:
            output.write(...)
            output.publish()
    """

    def __init__(self, path: Path) -> None:
        self.path = pathlib.Path(path)
        self._beside = ""
        self._file: Optional[BinaryIO] = None

    def __enter__(self) -> "OutputFile":
        self._beside = f"{self.path}.part{uuid.uuid4().hex[:8]}"
        descriptor = os.open(self._beside, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
        self._file = open(descriptor, "wb")
        return self

    def __exit__(self, *_: object) -> None:
        if self._file is not None:
            self._file.close()
            os.unlink(self._beside)

    def restart(self) -> None:
        assert self._file is not None
        self._file.seek(0)
        self._file.truncate()

    def write(self, data: bytes) -> None:
        assert self._file is not None
        self._file.write(data)

    def publish(self) -> None:
        assert self._file is not None
        self._file.flush()
        os.fsync(self._file.fileno())
        os.replace(self._beside, self.path)
        self._file.close()
        self._file = None
