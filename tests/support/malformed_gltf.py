"""Malformed glTF files made by hand: the one source for the loader's unit test and for service tests.

cases() yields Case(name, data, code, pointer): the bytes of one file, the error code that must come back, and the JSON
pointer that must be among the places named ("" for the file as a whole). valid() gives the sound file they all derive from.
Run as a program with a folder as argument, it writes every file there and an index "cases.tsv".
"""

import base64
import copy
import json
import os
import struct
import sys
import zlib
from typing import NamedTuple


class Case(NamedTuple):
    name: str
    data: bytes
    code: str
    pointer: str


def png(width, height, rgba=(255, 128, 64, 255), stored_rows=None):
    """A PNG of one colour; `stored_rows` fewer than the header says makes it a cut or a bomb."""
    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))
    rows = height if stored_rows is None else stored_rows
    pixels = (b"\0" + bytes(rgba) * (width if rows else 0)) * rows
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)) +
            chunk(b"IDAT", zlib.compress(pixels)) + chunk(b"IEND", b""))


def floats(*values):
    return struct.pack(f"<{len(values)}f", *values)


def shorts(*values):
    return struct.pack(f"<{len(values)}H", *values)


# meshoptimizer's encoding of the square's four positions, and of its six indices.
MESHOPT_POSITIONS = bytes.fromhex(
    "a000000133000000ffff01330000007e7d0000010c000000ff010c0000007e" + "00" * 36)
MESHOPT_INDICES = bytes.fromhex("e0f000007687566778a9866589689801690000")

# The parts of the binary buffer, in the order of the buffer views.
PARTS = [
    ("positions", floats(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0)),
    ("normals", floats(*[0, 0, 1] * 4)),
    ("uvs", floats(0, 1, 1, 1, 1, 0, 0, 0)),
    ("indices", shorts(0, 1, 2, 0, 2, 3)),
    ("sparse_indices", shorts(2)),
    ("sparse_values", floats(2, 2, 0)),
    ("joints", bytes([0, 0, 0, 0] * 4)),
    ("weights", floats(*[1, 0, 0, 0] * 4)),
    ("inverse_bind", floats(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1)),
    ("png", png(2, 2)),
    ("meshopt_positions", MESHOPT_POSITIONS),
    ("times", floats(0, 1, 2, 3)),
]
VIEW = {name: i for i, (name, _) in enumerate(PARTS)}
ACCESSOR = {name: i for i, name in enumerate(
    ["positions", "normals", "uvs", "indices", "sparse", "joints", "weights", "inverse_bind", "meshopt", "times"])}


def document():
    """A document that uses a little of everything, and its binary chunk."""
    binary, views = b"", []
    for _, data in PARTS:
        binary += b"\0" * (-len(binary) % 4)
        views.append({"buffer": 0, "byteOffset": len(binary), "byteLength": len(data)})
        binary += data
    source = dict(views[VIEW["meshopt_positions"]])
    views.append({"buffer": 1, "byteLength": 48, "byteStride": 12, "extensions": {"EXT_meshopt_compression": {
        **source, "byteStride": 12, "count": 4, "mode": "ATTRIBUTES"}}})
    accessors = [
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"},
        {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "sparse": {
            "count": 1, "indices": {"bufferView": VIEW["sparse_indices"], "componentType": 5123},
            "values": {"bufferView": VIEW["sparse_values"]}}},
        {"bufferView": VIEW["joints"], "componentType": 5121, "count": 4, "type": "VEC4"},
        {"bufferView": VIEW["weights"], "componentType": 5126, "count": 4, "type": "VEC4"},
        {"bufferView": VIEW["inverse_bind"], "componentType": 5126, "count": 1, "type": "MAT4"},
        {"bufferView": len(PARTS), "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": VIEW["times"], "componentType": 5126, "count": 4, "type": "SCALAR"},
    ]
    textured = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": 2}
    doc = {
        "asset": {"version": "2.0"},
        "extensionsUsed": ["KHR_lights_punctual", "EXT_meshopt_compression", "KHR_texture_transform"],
        "extensionsRequired": ["EXT_meshopt_compression"],
        "buffers": [{"byteLength": len(binary)},
                    {"byteLength": 48, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}],
        "bufferViews": views,
        "accessors": accessors,
        "images": [{"bufferView": VIEW["png"], "mimeType": "image/png"}],
        "samplers": [{"magFilter": 9729, "minFilter": 9987, "wrapS": 10497, "wrapT": 33071}],
        "textures": [{"source": 0, "sampler": 0}],
        "materials": [{
            "name": "all",
            "pbrMetallicRoughness": {
                "baseColorFactor": [1, 1, 1, 1], "metallicFactor": 0, "roughnessFactor": 0.5,
                "baseColorTexture": {"index": 0, "extensions": {
                    "KHR_texture_transform": {"offset": [0, 0], "rotation": 0.1, "scale": [2, 2]}}}},
            "normalTexture": {"index": 0, "scale": 0.5},
            "emissiveFactor": [1, 1, 1],
            "alphaMode": "MASK", "alphaCutoff": 0.5,
            "extensions": {
                "KHR_materials_emissive_strength": {"emissiveStrength": 2},
                "KHR_materials_ior": {"ior": 1.4},
                "KHR_materials_specular": {"specularFactor": 0.5, "specularColorFactor": [1, 1, 1]},
                "KHR_materials_transmission": {"transmissionFactor": 0.5},
                "KHR_materials_volume": {"thicknessFactor": 1, "attenuationDistance": 1,
                                         "attenuationColor": [1, 0.5, 0.5]}}}],
        "meshes": [
            {"name": "square", "primitives": [{"attributes": textured, "indices": 3, "material": 0}]},
            {"primitives": [{"attributes": {"POSITION": 4, "JOINTS_0": 5, "WEIGHTS_0": 6}, "indices": 3}]},
            {"primitives": [{"attributes": {"POSITION": 8}, "indices": 3,
                             "targets": [{"POSITION": 0}]}], "weights": [0.5]},
        ],
        "skins": [{"joints": [3], "inverseBindMatrices": 7, "skeleton": 3}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}},
                    {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 10}}],
        "extensions": {"KHR_lights_punctual": {"lights": [
            {"type": "spot", "intensity": 5, "color": [1, 1, 1], "range": 10,
             "spot": {"innerConeAngle": 0.2, "outerConeAngle": 0.5}}]}},
        "nodes": [
            {"name": "root", "children": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, 1, 1]},
            {"mesh": 0, "translation": [0, 0, 1]},
            {"mesh": 1, "skin": 0},
            {"name": "joint", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
            {"camera": 0}, {"camera": 1},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}},
            {"mesh": 2, "weights": [0.25]},
        ],
        "scenes": [{"nodes": [0, 4, 5, 6, 7]}],
        "scene": 0,
        "animations": [{"samplers": [{"input": 9, "output": 1}],
                        "channels": [{"sampler": 0, "target": {"node": 6, "path": "translation"}}]}],
    }
    return doc, binary


def glb(doc, binary, version=2, length=None, json_type=b"JSON"):
    text = doc if isinstance(doc, bytes) else json.dumps(doc).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    body = struct.pack("<I", len(text)) + json_type + text + struct.pack("<I", len(binary)) + b"BIN\0" + binary
    return b"glTF" + struct.pack("<II", version, 12 + len(body) if length is None else length) + body


def valid():
    return glb(*document())


def at(doc, pointer):
    """The container and key that a pointer leads to."""
    tokens = pointer.split("/")[1:]
    for token in tokens[:-1]:
        doc = doc[int(token) if isinstance(doc, list) else token]
    return doc, int(tokens[-1]) if isinstance(doc, list) else tokens[-1]


REMOVE = object()
HUGE = 1 << 60


def edits():
    """(pointer to change, new value, code, pointer expected or None for the same)."""
    bad, unsupported = "bad_scene", "unsupported"
    yield "/asset", REMOVE, bad, None
    yield "/asset", [], bad, "/asset"
    yield "/asset/version", REMOVE, bad, None
    yield "/asset/version", 2.0, bad, None
    yield "/asset/version", "1.0", unsupported, None
    yield "/asset/minVersion", "2.1", unsupported, None
    yield "/extensionsRequired/0", "KHR_draco_mesh_compression", unsupported, None
    yield "/extensionsRequired/0", "VENDOR_unheard_of", unsupported, None
    yield "/extensionsRequired/0", 7, bad, None
    yield "/extensionsRequired", {}, bad, None
    yield "/extensionsUsed", "KHR_lights_punctual", bad, None

    yield "/buffers", {}, bad, None
    yield "/buffers", REMOVE, bad, "/bufferViews/0/buffer"
    yield "/buffers/0", 3, bad, None
    yield "/buffers/0/byteLength", REMOVE, bad, None
    yield "/buffers/0/byteLength", 0, bad, None
    yield "/buffers/0/byteLength", -5, bad, None
    yield "/buffers/0/byteLength", 12.5, bad, None
    yield "/buffers/0/byteLength", "many", bad, None
    yield "/buffers/0/byteLength", 1 << 30, bad, None
    yield "/buffers/0/byteLength", HUGE, bad, None
    yield "/buffers/0/byteLength", 100, bad, "/bufferViews/2"
    yield "/buffers/0/uri", 5, bad, None
    for uri in ["../secret.bin", "/etc/passwd", "file:///etc/passwd", "http://localhost/x.bin", "%2e%2e/secret.bin",
                "sub/../../secret.bin", "..%2fsecret.bin", "C:\\secret.bin", "\\\\host\\share", "bad%zzescape", "%",
                "nul%00byte", "", ".", "missing.bin", "sub/missing.bin", "~/missing.bin"]:
        yield "/buffers/0/uri", uri, bad, None
    for uri in ["data:", "data:,", "data:application/octet-stream;base64", "data:;base64,A", "data:;base64,!!!!",
                "data:;base64,AAAA====", "data:application/octet-stream,plain"]:
        yield "/buffers/0/uri", uri, bad, None
    yield "/buffers/0/uri", "data:;base64,AAAA", bad, "/buffers/0/byteLength"

    yield "/bufferViews/0/buffer", REMOVE, bad, None
    yield "/bufferViews/0/buffer", 2, bad, None
    yield "/bufferViews/0/buffer", -1, bad, None
    yield "/bufferViews/0/buffer", 0.5, bad, None
    yield "/bufferViews/0/buffer", 1, bad, "/bufferViews/0"
    yield "/bufferViews/0/byteOffset", -4, bad, None
    yield "/bufferViews/0/byteOffset", 1 << 40, bad, "/bufferViews/0"
    yield "/bufferViews/0/byteOffset", 9007199254740993, bad, None
    yield "/bufferViews/0/byteLength", REMOVE, bad, None
    yield "/bufferViews/0/byteLength", 0, bad, None
    yield "/bufferViews/0/byteLength", 1 << 47, bad, "/bufferViews/0"
    yield "/bufferViews/0/byteLength", 47, bad, "/accessors/0"
    yield "/bufferViews/0/byteStride", 3, bad, None
    yield "/bufferViews/0/byteStride", 13, bad, None
    yield "/bufferViews/0/byteStride", 256, bad, None
    yield "/bufferViews/0/byteStride", 8, bad, "/accessors/0"
    yield "/bufferViews/0/byteStride", 16, bad, "/accessors/0"

    meshopt = f"/bufferViews/{len(PARTS)}/extensions/EXT_meshopt_compression"
    yield meshopt, [], bad, None
    yield meshopt, REMOVE, bad, f"/bufferViews/{len(PARTS)}"
    yield meshopt + "/buffer", 9, bad, None
    yield meshopt + "/byteOffset", 1 << 30, bad, meshopt
    yield meshopt + "/byteStride", 6, bad, None
    yield meshopt + "/byteStride", 0, bad, None
    yield meshopt + "/byteStride", 260, bad, None
    yield meshopt + "/count", 5, bad, None
    yield meshopt + "/count", 1 << 31, bad, None
    yield meshopt + "/mode", "POINTS", bad, None
    yield meshopt + "/mode", REMOVE, bad, None
    yield meshopt + "/mode", "TRIANGLES", bad, meshopt + "/byteStride"
    yield meshopt + "/filter", "SHARPEN", bad, None
    yield meshopt + "/filter", "OCTAHEDRAL", bad, meshopt + "/byteStride"
    yield meshopt + "/byteLength", 10, bad, meshopt
    yield meshopt + "/byteOffset", 0, bad, meshopt

    yield "/accessors/0/bufferView", 99, bad, None
    yield "/accessors/0/bufferView", "first", bad, None
    yield "/accessors/0/byteOffset", 4, bad, "/accessors/0"
    yield "/accessors/0/byteOffset", 1 << 47, bad, "/accessors/0"
    yield "/accessors/0/count", 0, bad, None
    yield "/accessors/0/count", 5, bad, "/accessors/0"
    yield "/accessors/0/count", 4294967295, bad, "/accessors/0"
    yield "/accessors/0/count", 1e300, bad, None
    yield "/accessors/0/count", REMOVE, bad, None
    yield "/accessors/0/count", 3, bad, "/meshes/0/primitives/0/attributes"
    yield "/accessors/0/componentType", 5124, bad, None
    yield "/accessors/0/componentType", REMOVE, bad, None
    yield "/accessors/0/componentType", 5123, bad, "/meshes/0/primitives/0/attributes/POSITION"
    yield "/accessors/0/type", "VEC5", bad, None
    yield "/accessors/0/type", "VEC2", bad, "/accessors/0/min"
    yield "/accessors/0/min", [0, 0], bad, None
    yield "/accessors/0/max", [1, "x", 0], bad, "/accessors/0/max/1"
    yield "/accessors/0/normalized", True, bad, None
    yield "/accessors/0/normalized", "yes", bad, None
    yield "/accessors/4/sparse/count", 0, bad, None
    yield "/accessors/4/sparse/count", 5, bad, None
    yield "/accessors/4/sparse/count", 2, bad, "/accessors/4/sparse/indices"
    yield "/accessors/4/sparse/indices", REMOVE, bad, None
    yield "/accessors/4/sparse/indices/componentType", 5126, bad, None
    yield "/accessors/4/sparse/indices/bufferView", 77, bad, None
    yield "/accessors/4/sparse/indices/byteOffset", 2, bad, "/accessors/4/sparse/indices"
    yield "/accessors/4/sparse/values/bufferView", VIEW["sparse_indices"], bad, "/accessors/4/sparse/values"

    yield "/images/0/bufferView", 4096, bad, None
    yield "/images/0/bufferView", VIEW["positions"], "bad_image", "/images/0"
    yield "/images/0/uri", "both.png", bad, "/images/0"
    yield "/images/0", {}, bad, None
    yield "/images/0", {"uri": "../up.png"}, bad, "/images/0/uri"
    yield "/images/0", {"uri": "data:image/png;base64,AAAA"}, "bad_image", "/images/0"
    yield "/samplers/0/wrapS", 1, bad, None
    yield "/samplers/0/magFilter", 9987, bad, None
    yield "/samplers/0/minFilter", "LINEAR", bad, None
    yield "/textures/0/source", 1, bad, None
    yield "/textures/0/sampler", 1, bad, None

    pbr = "/materials/0/pbrMetallicRoughness"
    extensions = "/materials/0/extensions/KHR_materials_"
    yield "/materials", 1, bad, None
    yield pbr, 1, bad, None
    yield pbr + "/baseColorFactor", [1, 1, 1], bad, None
    yield pbr + "/baseColorFactor/2", 1.5, bad, None
    yield pbr + "/baseColorFactor/0", -0.5, bad, None
    yield pbr + "/metallicFactor", 2, bad, None
    yield pbr + "/roughnessFactor", "rough", bad, None
    yield pbr + "/baseColorTexture/index", 1, bad, None
    yield pbr + "/baseColorTexture/index", REMOVE, bad, None
    yield pbr + "/baseColorTexture/texCoord", -1, bad, None
    transform = pbr + "/baseColorTexture/extensions/KHR_texture_transform"
    yield transform + "/scale", [1], bad, None
    yield transform + "/rotation", 1e308, bad, None
    yield "/materials/0/normalTexture/scale", None, bad, None
    yield "/materials/0/emissiveFactor/1", -1, bad, None
    yield "/materials/0/alphaMode", "DITHER", bad, None
    yield "/materials/0/alphaCutoff", -1, bad, None
    yield "/materials/0/doubleSided", 1, bad, None
    yield extensions + "emissive_strength/emissiveStrength", -1, bad, None
    yield extensions + "ior/ior", 0.5, bad, None
    yield extensions + "specular/specularFactor", 1.01, bad, None
    yield extensions + "transmission/transmissionFactor", -0.1, bad, None
    yield extensions + "volume/attenuationDistance", 0, bad, None
    yield extensions + "volume/attenuationColor", [2, 0, 0], bad, extensions + "volume/attenuationColor/0"

    primitive = "/meshes/0/primitives/0"
    yield "/meshes/0/primitives", [], bad, None
    yield "/meshes/0/primitives", REMOVE, bad, None
    yield primitive + "/attributes", REMOVE, bad, None
    yield primitive + "/attributes", {}, bad, None
    yield primitive + "/attributes/POSITION", 1000, bad, None
    yield primitive + "/attributes/POSITION", ACCESSOR["uvs"], bad, None
    yield primitive + "/attributes/NORMAL", ACCESSOR["indices"], bad, None
    yield primitive + "/attributes/TEXCOORD_0", ACCESSOR["positions"], bad, None
    yield primitive + "/attributes/TEXCOORD_2", ACCESSOR["uvs"], bad, primitive + "/attributes"
    yield primitive + "/attributes/TEXCOORD_x", ACCESSOR["uvs"], bad, primitive + "/attributes"
    yield primitive + "/attributes/NORMAL", ACCESSOR["times"], bad, None
    yield primitive + "/indices", 64, bad, None
    yield primitive + "/indices", ACCESSOR["positions"], bad, None
    yield primitive + "/mode", 7, bad, None
    yield primitive + "/material", 1, bad, None
    yield "/meshes/1/primitives/0/attributes/JOINTS_0", ACCESSOR["weights"], bad, None
    yield "/meshes/1/primitives/0/attributes/WEIGHTS_0", REMOVE, bad, "/meshes/1/primitives/0/attributes"
    yield "/meshes/2/weights", [1, 2], bad, None
    yield "/meshes/2/primitives/0/targets/0/POSITION", ACCESSOR["normals"] + 50, bad, None

    yield "/skins/0/joints", [], bad, None
    yield "/skins/0/joints/0", 8, bad, None
    yield "/skins/0/inverseBindMatrices", ACCESSOR["positions"], bad, None
    yield "/skins/0/joints", [3, 3], bad, "/skins/0/inverseBindMatrices"
    yield "/cameras/0/type", "fisheye", bad, None
    yield "/cameras/0/perspective", REMOVE, bad, None
    yield "/cameras/0/perspective/yfov", 0, bad, None
    yield "/cameras/0/perspective/yfov", 4, bad, None
    yield "/cameras/1/orthographic/ymag", 0, bad, None
    light = "/extensions/KHR_lights_punctual/lights/0"
    yield light + "/type", "area", bad, None
    yield light + "/intensity", -1, bad, None
    yield light + "/color", [1, 1], bad, None
    yield light + "/range", 0, bad, None
    yield light + "/spot", REMOVE, bad, None
    yield light + "/spot/outerConeAngle", 0.1, bad, light + "/spot"
    yield light + "/spot/outerConeAngle", 3, bad, None

    yield "/nodes/1/mesh", 3, bad, None
    yield "/nodes/1/mesh", -1, bad, None
    yield "/nodes/2/skin", 1, bad, None
    yield "/nodes/1/skin", 0, bad, None
    yield "/nodes/4/camera", 2, bad, None
    yield "/nodes/6/extensions/KHR_lights_punctual/light", 1, bad, None
    yield "/nodes/0/children/0", 8, bad, None
    yield "/nodes/0/children/1", 1, bad, None
    yield "/nodes/1/children", [0], bad, "/nodes/0/children"
    yield "/nodes/7/children", [7], bad, "/nodes/7/children"
    yield "/nodes/0/rotation", [0, 0, 0, 0], bad, None
    yield "/nodes/0/rotation/3", 5, bad, None
    yield "/nodes/0/scale", [1, 1, 1e39], bad, "/nodes/0/scale/2"
    yield "/nodes/0/scale", [1e38, 1e38, 1e38], bad, None
    yield "/nodes/0/translation", "up", bad, None
    yield "/nodes/3/matrix", [1] * 15, bad, None
    yield "/nodes/3/matrix/15", 2, bad, "/nodes/3/matrix"
    yield "/nodes/3/scale", [1, 1, 1], bad, "/nodes/3"
    yield "/nodes/1/matrix", [1e38] * 3 + [0] + [1e38] * 3 + [0] + [1e38] * 3 + [0, 3e38, 0, 0, 1], bad, "/nodes/1"
    yield "/nodes/7/weights", [1, 2], bad, None
    yield "/scene", 1, bad, None
    yield "/scenes/0/nodes/0", 8, bad, None
    yield "/scenes/0/nodes/1", 1, bad, None
    yield "/scenes/0/nodes/1", 0, bad, None
    yield "/animations/0/samplers/0/input", 20, bad, None
    yield "/animations/0/channels/0/sampler", 1, bad, None
    yield "/animations/0/samplers/0/input", 0, bad, None
    yield "/animations/0/samplers/0/output", 3, bad, None
    yield "/animations/0/samplers/0/output", 9, bad, None
    yield "/animations/0/samplers/0/interpolation", "CUBIC", bad, None
    yield "/animations/0/samplers/0/interpolation", "CUBICSPLINE", bad, "/animations/0/samplers/0/output"
    yield "/animations/0/channels/0/target/node", 8, bad, None
    yield "/animations/0/channels/0/target/node", 3, bad, "/animations/0/channels/0/target"
    yield "/animations/0/channels/0/target/path", "pointer", bad, "/animations/0/channels/0/target"
    yield "/animations/0/channels/0/target/path", "weights", bad, "/animations/0/channels/0/target"
    yield "/animations/0/channels", REMOVE, bad, None


def edited_cases():
    base, binary = document()
    for number, (pointer, value, code, expected) in enumerate(edits()):
        doc = copy.deepcopy(base)
        container, key = at(doc, pointer)
        if pointer.startswith("/nodes/1/matrix"):
            container.pop("translation")
        if value is REMOVE:
            del container[key]
        else:
            container[key] = value
        if pointer == "/nodes/0/scale" and value == [1e38, 1e38, 1e38]:
            # Each number is fine; the product with the child's is not.
            doc["nodes"][1]["scale"] = [1e38, 1, 1]
            expected = "/nodes/1"
        shown = "removed" if value is REMOVE else json.dumps(value)[:40]
        name = f"{number:03d}_{pointer.strip('/').replace('/', '.')}_{shown}"
        yield Case("".join(c if c.isalnum() or c in "._-" else "_" for c in name), glb(doc, binary), code,
                   pointer if expected is None else expected)


def patched_binary_cases():
    """Sound JSON over contents that are not."""
    doc, binary = document()

    def patch(part, data, offset=0):
        start = doc["bufferViews"][VIEW[part]]["byteOffset"] + offset
        return glb(doc, binary[:start] + data + binary[start + len(data):])
    primitive = "/meshes/0/primitives/0"
    for name, value in [("nan", float("nan")), ("infinity", float("inf")), ("minus_infinity", -float("inf"))]:
        yield Case("position_" + name, patch("positions", floats(value), 12), "bad_scene",
                   primitive + "/attributes/POSITION")
    yield Case("uv_nan", patch("uvs", floats(float("nan"))), "bad_scene", primitive + "/attributes/TEXCOORD_0")
    yield Case("index_out_of_range", patch("indices", shorts(4), 4), "bad_scene", primitive + "/indices")
    yield Case("index_restart", patch("indices", shorts(65535), 2), "bad_scene", primitive + "/indices")
    yield Case("sparse_index_out_of_range", patch("sparse_indices", shorts(4)), "bad_scene",
               "/accessors/4/sparse/indices")
    yield Case("joint_out_of_range", patch("joints", bytes([1])), "bad_scene",
               "/meshes/1/primitives/0/attributes/JOINTS_0")
    yield Case("weight_negative", patch("weights", floats(-1)), "bad_scene",
               "/meshes/1/primitives/0/attributes/WEIGHTS_0")
    yield Case("inverse_bind_nan", patch("inverse_bind", floats(float("nan"))), "bad_scene", "/skins/0/joints/0")
    yield Case("meshopt_garbage", patch("meshopt_positions", b"\xff" * 20), "bad_scene",
               f"/bufferViews/{len(PARTS)}/extensions/EXT_meshopt_compression")


def image_cases():
    base, binary = document()

    def with_image(data):
        doc = copy.deepcopy(base)
        doc["images"][0] = {"uri": "data:image/png;base64," + base64.b64encode(data).decode()}
        return glb(doc, binary)
    exif = b"\xff\xd8\xff\xe1\x00\x10Exif" + b"\0" * 10
    frame = b"\xff\xc0\x00\x11\x08\xff\xff\xff\xff\x03\x01\x11\x00\x02\x11\x00\x03\x11\x00"
    scan = b"\xff\xda\x00\x0c\x03\x01\x00\x02\x00\x03\x00\x00\x3f\x00"
    images = {
        "empty_png": b"\x89PNG\r\n\x1a\n",
        "cut_png_header": png(2, 2)[:20],
        "cut_png_body": png(2, 2)[:50],
        "no_size_png": png(0, 2),
        "bomb_png_pixels": png(16384, 16384, stored_rows=0),
        "bomb_png_wide": png(1 << 30, 1, stored_rows=0),
        "bomb_png_ratio": png(8000, 8000, stored_rows=0),
        "short_png_rows": png(64, 64, stored_rows=3),
        "cut_jpeg": exif,
        "bomb_jpeg": b"\xff\xd8" + frame + scan + b"\xff\xd9",
        "endless_jpeg_scans": b"\xff\xd8\xff" + frame[1:5] + b"\0\x08\0\x08" + frame[9:] + scan * 200 + b"\xff\xd9",
        "gif": b"GIF89a\x01\x00\x01\x00\x00\x00\x00;",
        "tiff": b"II*\0\x08\0\0\0" + b"\0" * 32,
        "exr": b"\x76\x2f\x31\x01\x02\0\0\0" + b"\0" * 32,
        "text": b"#!/bin/sh\n",
    }
    for name, data in images.items():
        yield Case("image_" + name, with_image(data), "bad_image", "/images/0")


def container_cases():
    doc, binary = document()
    whole = glb(doc, binary)
    text = json.dumps(doc).encode()
    plain = {
        "empty": b"",
        "magic_only": b"glTF",
        "half_header": whole[:10],
        "cut_in_json": whole[:200],
        "cut_in_binary": whole[:-20],
        "version_1": glb(doc, binary, version=1),
        "length_too_large": glb(doc, binary, length=1 << 31),
        "length_too_small": glb(doc, binary, length=16),
        "length_inside_json": glb(doc, binary, length=400),
        "first_chunk_not_json": glb(doc, binary, json_type=b"JUNK"),
        "empty_json": glb(b"", binary),
        "json_chunk_too_long": whole[:12] + struct.pack("<I", 0xFFFFFFFF) + whole[16:],
        "not_json": b"this is not a scene",
        "json_null": b"null",
        "json_array": b"[]",
        "json_cut": text[:-1],
        "json_trailing": text + b"{}",
        "json_comment": b"/* comment */" + text,
        "json_nan": b'{"asset": NaN}',
        "json_overflow": b'{"asset": 1e999}',
        "json_bad_utf8": b'{"asset": "\xff\xfe"}',
        "json_lone_surrogate": b'{"asset": "\\ud800"}',
        "json_control": b'{"asset": "a\nb"}',
        "zip": b"PK\x03\x04" + b"\0" * 40,
    }
    for name, data in plain.items():
        yield Case("container_" + name, data, "bad_scene", "")
    depth = 100_000
    yield Case("deep_array_in_extras", b'{"extras":' + b"[" * depth + b"]" * depth + b"}", "bad_scene", "/extras" + "/0" * 63)
    yield Case("deep_object_in_extras", b'{"extras":' + b'{"a":' * depth + b"1" + b"}" * depth + b"}", "bad_scene",
               "/extras" + "/a" * 63)
    yield Case("deep_unclosed", b"[" * depth, "bad_scene", "/0" * 64)
    yield Case("duplicate_key", text[:-1] + b', "scene": 0}', "bad_scene", "/scene")
    yield Case("duplicate_key_nested", text.replace(b'"version": "2.0"', b'"version": "2.0", "version": "2.0"'),
               "bad_scene", "/asset/version")
    yield Case("duplicate_key_escaped", text.replace(b'"version": "2.0"', b'"version": "2.0", "v\\u0065rsion": "2.0"'),
               "bad_scene", "/asset/version")
    yield Case("too_many_values", b'{"extras":[' + b"0," * 4_100_000 + b"0]}", "bad_scene", "")
    no_chunk = copy.deepcopy(doc)
    yield Case("gltf_without_its_buffer", json.dumps(no_chunk).encode(), "bad_scene", "/buffers/0")


def multiplying_cases():
    """Small files that promise much."""
    doc, binary = document()
    many = copy.deepcopy(doc)
    many["accessors"][3] = {"componentType": 5125, "count": 4294967295, "type": "SCALAR"}
    yield Case("four_billion_zero_indices", glb(many, binary), "bad_scene", "/nodes/1/mesh")
    sparse = copy.deepcopy(doc)
    del sparse["accessors"][4]["bufferView"]
    sparse["accessors"][4]["count"] = 500_000_000
    for key in ("JOINTS_0", "WEIGHTS_0"):
        del sparse["meshes"][1]["primitives"][0]["attributes"][key]
    del sparse["nodes"][2]["skin"]
    yield Case("sparse_over_half_a_billion_zeros", glb(sparse, binary), "bad_scene", "/accessors/4/count")
    for member, type_ in (("input", "SCALAR"), ("output", "VEC3")):
        keys = copy.deepcopy(doc)
        keys["accessors"].append({"componentType": 5126, "count": 4294967295, "type": type_})
        keys["animations"][0]["samplers"][0][member] = len(keys["accessors"]) - 1
        yield Case(f"four_billion_zero_keys_of_{member}", glb(keys, binary), "bad_scene", f"/animations/0/samplers/0/{member}")
    meshopt = copy.deepcopy(doc)
    view = meshopt["bufferViews"][len(PARTS)]
    meshopt["buffers"][1]["byteLength"] = view["byteLength"] = 12 * 300_000_000
    view["extensions"]["EXT_meshopt_compression"]["count"] = 300_000_000
    yield Case("meshopt_bomb", glb(meshopt, binary), "bad_scene",
               f"/bufferViews/{len(PARTS)}/extensions/EXT_meshopt_compression")


def cases():
    yield from edited_cases()
    yield from patched_binary_cases()
    yield from image_cases()
    yield from container_cases()
    yield from multiplying_cases()


def main(folder):
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "valid.glb"), "wb") as out:
        out.write(valid())
    with open(os.path.join(folder, "cases.tsv"), "w", encoding="utf-8") as index:
        for case in cases():
            with open(os.path.join(folder, case.name), "wb") as out:
                out.write(case.data)
            index.write(f"{case.name}\t{case.code}\t{case.pointer}\n")


if __name__ == "__main__":
    main(sys.argv[1])
