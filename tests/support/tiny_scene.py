"""Small, good glTF scenes made in memory, for tests of everything around them."""

import base64
import io
import json
import struct
import zipfile


def triangle(seed=0):
    """(document without buffers' place, binary buffer): one lit triangle; `seed` makes scenes differ."""
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1 + seed, 0)
    indices = struct.pack("<3H", 0, 1, 2)
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": [{"mesh": 0}, {"camera": 0, "name": "front", "translation": [0.3, 0.3, 2]}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.01}}],
        "materials": [{"emissiveFactor": [1, 1, 1], "doubleSided": True}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0],
                       "max": [1, 1 + seed, 0]},
                      {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 36},
                        {"buffer": 0, "byteOffset": 36, "byteLength": 6}],
        "buffers": [{"byteLength": 42}],
    }
    return document, positions + indices


def glb(seed=0):
    return packed(*triangle(seed))


def dark_glb():
    """The triangle without light and without a camera."""
    document, binary = triangle()
    document["materials"] = [{"pbrMetallicRoughness": {"baseColorFactor": [0.8, 0.2, 0.2, 1]}, "doubleSided": True}]
    document["scenes"], document["nodes"] = [{"nodes": [0]}], document["nodes"][:1]
    del document["cameras"]
    return packed(document, binary)


def packed(document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def gltf_files(seed=0, folder="data"):
    """{relative path: bytes} of a .gltf with its buffer beside it."""
    document, binary = triangle(seed)
    document["buffers"][0]["uri"] = f"{folder}/mesh.bin"
    return {"scene.gltf": json.dumps(document).encode(), f"{folder}/mesh.bin": binary}


def gltf_with_data_uri(seed=0):
    document, binary = triangle(seed)
    document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
    return json.dumps(document).encode()


def zipped(files):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return buffer.getvalue()


def form(files, fields=None):
    """(content type, body) of multipart/form-data."""
    boundary = "photond-test-boundary"
    parts = []
    for name, value in (fields or {}).items():
        parts.append(f'--{boundary}\r\nContent-Disposition: form-data; name="{name}"\r\n\r\n{value}\r\n'.encode())
    for name, content in files.items():
        parts.append(f'--{boundary}\r\nContent-Disposition: form-data; name="file"; filename="{name}"\r\n'
                     "Content-Type: application/octet-stream\r\n\r\n".encode() + content + b"\r\n")
    return f"multipart/form-data; boundary={boundary}", b"".join(parts) + f"--{boundary}--\r\n".encode()
