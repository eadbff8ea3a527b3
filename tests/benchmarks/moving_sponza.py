#!/usr/bin/env python3
"""Hangs a swinging lamp into a glTF scene and lets a skinned figure walk below it, in one animation.

    tests/benchmarks/moving_sponza.py sponza_crytek.glb sponza_moving.glb

What the file has stays; its lights are dimmed, so that the lamp's light shows. The places fit Sponza's nave, whose floor
lies at y = 4 and which runs along x; options move them. The figure is a mesh of ours with 14 joints; its thighs, shins,
feet and arms turn as those of a person who makes 1.3 m in two steps of a second. The camera is called CameraWalk. The
standard library is enough.
"""

import argparse
import json
import math
import struct
from pathlib import Path

FLOAT, UNSIGNED_SHORT, UNSIGNED_BYTE = 5126, 5123, 5121
FORMATS = {FLOAT: "f", UNSIGNED_SHORT: "H", UNSIGNED_BYTE: "B"}
WIDTHS = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}
KEYS_A_SECOND = 16
SIDES = 10  # of a limb's cross-section


class Glb:
    """A binary glTF file that things are added to."""

    def __init__(self, data):
        if data[:4] != b"glTF":
            raise SystemExit("not a binary glTF file")
        self.json, self.binary = {}, bytearray()
        at = 12
        while at < len(data):
            size, kind = struct.unpack_from("<I4s", data, at)
            chunk = data[at + 8:at + 8 + size]
            if kind == b"JSON":
                self.json = json.loads(chunk)
            elif kind == b"BIN\0":
                self.binary = bytearray(chunk)
            at += 8 + size

    def add(self, kind, item):
        """The index in the list of that kind."""
        items = self.json.setdefault(kind, [])
        items.append(item)
        return len(items) - 1

    def accessor(self, rows, kind, component=FLOAT, bounds=False):
        values = [value for row in rows for value in (row if isinstance(row, (list, tuple)) else [row])]
        self.binary += b"\0" * (-len(self.binary) % 4)
        offset = len(self.binary)
        self.binary += struct.pack(f"<{len(values)}{FORMATS[component]}", *values)
        view = self.add("bufferViews", {"buffer": 0, "byteOffset": offset, "byteLength": len(self.binary) - offset})
        item = {"bufferView": view, "componentType": component, "count": len(values) // WIDTHS[kind], "type": kind}
        if bounds:
            columns = list(zip(*(row if isinstance(row, (list, tuple)) else [row] for row in rows)))
            # As they are stored: a bound that is no float would lie beside the values.
            item["min"], item["max"] = ([struct.unpack("<f", struct.pack("<f", pick(column)))[0] for column in columns]
                                        for pick in (min, max))
        return self.add("accessors", item)

    def use(self, extension):
        if extension not in self.json.setdefault("extensionsUsed", []):
            self.json["extensionsUsed"].append(extension)

    def bytes(self):
        self.binary += b"\0" * (-len(self.binary) % 4)
        self.json.setdefault("buffers", [{}])[0]["byteLength"] = len(self.binary)
        text = json.dumps(self.json, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


class Mesh:
    """Triangles with smooth normals, and the joints that each vertex goes by."""

    def __init__(self):
        self.points, self.joints, self.weights, self.triangles = [], [], [], []

    def tube(self, rings, along=(0, 1, 0)):
        """Rings (centre, half width, half depth, {joint: weight}), closed at both ends; the first lies where `along`
        comes from."""
        first = len(self.points)
        for (x, y, z), half_width, half_depth, weights in rings:
            names = sorted(weights)
            for i in range(SIDES):
                turn = 2 * math.pi * i / SIDES
                across, off = half_width * math.cos(turn), half_depth * math.sin(turn)
                self.points.append((x + across, y, z - off) if along[1] else (x + across, y + off, z))
                self.joints.append([*names, 0, 0, 0, 0][:4])
                self.weights.append([*(weights[name] for name in names), 0, 0, 0, 0][:4])
        for ring in range(len(rings) - 1):
            for i in range(SIDES):
                a, b = first + ring * SIDES + i, first + ring * SIDES + (i + 1) % SIDES
                self.triangles += [(a, b, b + SIDES), (a, b + SIDES, a + SIDES)]
        last = first + (len(rings) - 1) * SIDES
        for i in range(1, SIDES - 1):
            self.triangles += [(first, first + i + 1, first + i), (last, last + i, last + i + 1)]

    def normals(self):
        sums = [[0.0, 0.0, 0.0] for _ in self.points]
        for triangle in self.triangles:
            a, b, c = (self.points[i] for i in triangle)
            u, v = [b[k] - a[k] for k in range(3)], [c[k] - a[k] for k in range(3)]
            n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
            for i in triangle:
                for k in range(3):
                    sums[i][k] += n[k]
        lengths = [math.hypot(*n) or 1.0 for n in sums]
        return [tuple(x / length for x in n) for n, length in zip(sums, lengths)]

    def add_to(self, glb, material, skinned):
        attributes = {"POSITION": glb.accessor(self.points, "VEC3", bounds=True), "NORMAL": glb.accessor(self.normals(), "VEC3")}
        if skinned:
            attributes["JOINTS_0"] = glb.accessor(self.joints, "VEC4", UNSIGNED_BYTE)
            attributes["WEIGHTS_0"] = glb.accessor(self.weights, "VEC4")
        indices = glb.accessor([i for triangle in self.triangles for i in triangle], "SCALAR", UNSIGNED_SHORT)
        return glb.add("meshes", {"primitives": [{"attributes": attributes, "indices": indices, "material": material}]})


def matte(glb, name, colour):
    glb.use("KHR_materials_specular")
    return glb.add("materials", {
        "name": name, "pbrMetallicRoughness": {"baseColorFactor": [*colour, 1], "metallicFactor": 0, "roughnessFactor": 1},
        "extensions": {"KHR_materials_specular": {"specularFactor": 0}}})


def about_x(angle):
    return (math.sin(angle / 2), 0.0, 0.0, math.cos(angle / 2))


def about_y(angle):
    return (0.0, math.sin(angle / 2), 0.0, math.cos(angle / 2))


# The figure at rest, 1.75 m high, looks along +z: name, parent, where it lies in the figure's space.
JOINTS = [("hips", None, (0, 0.95, 0)), ("spine", "hips", (0, 1.08, 0)), ("head", "spine", (0, 1.50, 0.01))]
for side, sign in (("left", 1), ("right", -1)):
    JOINTS += [(side + " thigh", "hips", (0.10 * sign, 0.92, 0)), (side + " shin", side + " thigh", (0.10 * sign, 0.49, 0.01)),
               (side + " foot", side + " shin", (0.10 * sign, 0.09, 0)),
               (side + " upper arm", "spine", (0.21 * sign, 1.41, 0)), (side + " forearm", side + " upper arm", (0.25 * sign, 1.13, 0))]
JOINTS += [("neck", "spine", (0, 1.44, 0))]
INDEX = {name: i for i, (name, _, _) in enumerate(JOINTS)}
PLACE = {name: place for name, _, place in JOINTS}


def parts_of_figure():
    """Clothes, skin and legs as meshes of their own material."""
    def go_by(*names):
        return {INDEX[name]: 1 / len(names) for name in names}

    shirt, skin, trousers = Mesh(), Mesh(), Mesh()
    shirt.tube([((0, 0.90, 0), 0.165, 0.11, go_by("hips")), ((0, 1.02, 0), 0.15, 0.105, go_by("hips", "spine")),
                ((0, 1.16, 0), 0.16, 0.11, go_by("spine")), ((0, 1.32, 0), 0.19, 0.12, go_by("spine")),
                ((0, 1.42, 0), 0.17, 0.10, go_by("spine")), ((0, 1.46, 0), 0.07, 0.07, go_by("spine", "neck"))])
    skin.tube([((0, 1.43, 0), 0.05, 0.05, go_by("spine", "neck")), ((0, 1.52, 0.01), 0.05, 0.055, go_by("neck", "head")),
               ((0, 1.55, 0.02), 0.065, 0.08, go_by("head")), ((0, 1.62, 0.02), 0.08, 0.10, go_by("head")),
               ((0, 1.69, 0.01), 0.075, 0.095, go_by("head")), ((0, 1.75, 0), 0.035, 0.04, go_by("head"))])
    for side, sign in (("left", 1), ("right", -1)):
        thigh, shin, foot = side + " thigh", side + " shin", side + " foot"
        upper, fore = side + " upper arm", side + " forearm"
        x = 0.10 * sign
        trousers.tube([((x, 0.08, 0), 0.05, 0.055, go_by(shin, foot)), ((x, 0.30, -0.005), 0.06, 0.07, go_by(shin)),
                       ((x, 0.45, 0), 0.06, 0.065, go_by(shin)), ((x, 0.49, 0.01), 0.062, 0.068, go_by(shin, thigh)),
                       ((x, 0.54, 0.01), 0.066, 0.072, go_by(thigh)), ((x, 0.75, 0), 0.08, 0.09, go_by(thigh)),
                       ((x * 0.9, 0.95, 0), 0.085, 0.10, go_by(thigh, "hips"))])
        trousers.tube([((x, 0.05, -0.07), 0.035, 0.045, go_by(foot)), ((x, 0.055, 0), 0.045, 0.05, go_by(foot)),
                       ((x, 0.035, 0.12), 0.045, 0.03, go_by(foot)), ((x, 0.03, 0.19), 0.03, 0.02, go_by(foot))], along=(0, 0, 1))
        shirt.tube([((0.25 * sign, 1.10, 0), 0.043, 0.043, go_by(fore)), ((0.25 * sign, 1.13, 0), 0.045, 0.045, go_by(upper, fore)),
                    ((0.245 * sign, 1.17, 0), 0.047, 0.047, go_by(upper)), ((0.225 * sign, 1.32, 0), 0.055, 0.055, go_by(upper)),
                    ((0.205 * sign, 1.40, 0), 0.05, 0.06, go_by(upper, "spine")),
                    ((0.14 * sign, 1.445, 0), 0.05, 0.05, go_by("spine"))])
        skin.tube([((0.255 * sign, 0.80, 0.02), 0.02, 0.035, go_by(fore)), ((0.255 * sign, 0.87, 0.01), 0.03, 0.045, go_by(fore)),
                   ((0.255 * sign, 0.93, 0), 0.027, 0.03, go_by(fore)), ((0.25 * sign, 1.10, 0), 0.038, 0.038, go_by(fore))])
    return (("shirt", (0.55, 0.09, 0.07), shirt), ("skin", (0.62, 0.40, 0.30), skin), ("trousers", (0.10, 0.13, 0.30), trousers))


def walk_pose(cycles):
    """Angles about x of what turns, and how far the hips lie below their rest; a cycle is two steps."""
    pose = {}
    for side, phase in (("left", 0.0), ("right", 0.5)):
        turn = 2 * math.pi * (cycles + phase)
        swing = math.cos(turn)  # 1: the leg is in front
        # A knee bends while its leg comes forward, a little when it carries.
        bend = 0.12 + 0.85 * max(0.0, -math.sin(turn)) ** 2
        pose[side + " thigh"] = -(0.42 * swing + 0.08)
        pose[side + " shin"] = bend
        pose[side + " foot"] = 0.42 * swing + 0.08 - bend * 0.75
        pose[side + " upper arm"] = 0.45 * swing
        pose[side + " forearm"] = -(0.35 - 0.2 * swing)
    pose["spine"] = 0.04
    leg = 0.43 * math.cos(0.42) + 0.40 * math.cos(0.42 - 0.12)
    lowest = 0.83 - leg  # both feet on the ground, legs apart
    return pose, lowest * (0.5 + 0.5 * math.cos(4 * math.pi * cycles))


def add_figure(glb, start, goal, floor, seconds, channels):
    """Walks from (x, z) to (x, z); its channels go to `channels` as (node, path, kind, function of time)."""
    nodes = {}
    for name, parent, place in JOINTS:
        origin = PLACE[parent] if parent else (0, 0, 0)
        nodes[name] = glb.add("nodes", {"name": name, "translation": [p - o for p, o in zip(place, origin)]})
        if parent:
            glb.json["nodes"][nodes[parent]].setdefault("children", []).append(nodes[name])
    root = glb.add("nodes", {"name": "walker", "children": [nodes["hips"]],
                             "rotation": about_y(math.atan2(goal[0] - start[0], goal[1] - start[1]))})
    inverse = glb.accessor([(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *(-x for x in place), 1) for _, _, place in JOINTS], "MAT4")
    skin = glb.add("skins", {"joints": [nodes[name] for name, _, _ in JOINTS], "inverseBindMatrices": inverse})
    roots = [root]
    for name, colour, mesh in parts_of_figure():
        roots.append(glb.add("nodes", {"name": name, "skin": skin, "mesh": mesh.add_to(glb, matte(glb, name, colour), True)}))

    speed = 1.3  # metres in a cycle of one second

    def at(time):
        share = time / seconds
        return (start[0] + share * (goal[0] - start[0]), floor, start[1] + share * (goal[1] - start[1]))

    cycles_a_second = math.dist(start, goal) / speed / seconds
    channels.append((root, "translation", "VEC3", at))
    channels.append((nodes["hips"], "translation", "VEC3",
                     lambda time: (0, PLACE["hips"][1] - walk_pose(time * cycles_a_second)[1], 0)))
    for joint in walk_pose(0)[0]:
        channels.append((nodes[joint], "rotation", "VEC4",
                         lambda time, joint=joint: about_x(walk_pose(time * cycles_a_second)[0][joint])))
    return roots


def add_lamp(glb, pivot, length, intensity, channels):
    """A point light below a dark shade, on a rod that swings across the nave as a pendulum of its length does."""
    rod = Mesh()
    rod.tube([((0, 0.30 - length, 0), 0.22, 0.22, {}), ((0, 0.34 - length, 0), 0.20, 0.20, {}),
              ((0, 0.42 - length, 0), 0.03, 0.03, {}), ((0, 0, 0), 0.015, 0.015, {})])
    beam = Mesh()
    beam.tube([((0, 0.03, -2.8), 0.04, 0.04, {}), ((0, 0.03, 2.8), 0.04, 0.04, {})], along=(0, 0, 1))
    iron = matte(glb, "iron", (0.06, 0.06, 0.06))
    glb.use("KHR_lights_punctual")
    lights = glb.json.setdefault("extensions", {}).setdefault("KHR_lights_punctual", {}).setdefault("lights", [])
    lights.append({"type": "point", "name": "lamp", "color": [1, 0.72, 0.42], "intensity": intensity})
    light = glb.add("nodes", {"name": "lamp", "translation": [0, -length, 0],
                              "extensions": {"KHR_lights_punctual": {"light": len(lights) - 1}}})
    swing = glb.add("nodes", {"name": "pivot", "translation": list(pivot), "children": [light], "mesh": rod.add_to(glb, iron, False)})
    held = glb.add("nodes", {"name": "beam", "translation": list(pivot), "mesh": beam.add_to(glb, iron, False)})
    period = 2 * math.pi * math.sqrt(length / 9.81)
    channels.append((swing, "rotation", "VEC4", lambda time: about_x(0.75 * math.cos(2 * math.pi * time / period))))
    return [swing, held]


def add_animation(glb, channels, seconds):
    times = [i / KEYS_A_SECOND for i in range(math.ceil(seconds * KEYS_A_SECOND))] + [seconds]
    inputs = glb.accessor(times, "SCALAR", bounds=True)
    animation = {"name": "walk below a swinging lamp", "channels": [], "samplers": []}
    for node, path, kind, value in channels:
        glb.json["nodes"][node][path] = list(value(0))  # at rest as in the first moment
        animation["samplers"].append({"input": inputs, "output": glb.accessor([value(time) for time in times], kind)})
        animation["channels"].append({"sampler": len(animation["samplers"]) - 1, "target": {"node": node, "path": path}})
    glb.add("animations", animation)


def add_camera(glb, eye, target, yfov):
    back = [e - t for e, t in zip(eye, target)]
    yaw, pitch = math.atan2(back[0], back[2]), -math.asin(back[1] / math.hypot(*back))
    (_, sy, _, cy), (sx, _, _, cx) = about_y(yaw), about_x(pitch)
    camera = glb.add("cameras", {"type": "perspective", "name": "CameraWalk",
                                 "perspective": {"yfov": yfov, "aspectRatio": 16 / 9, "znear": 0.05}})
    return glb.add("nodes", {"name": "CameraWalk", "camera": camera, "translation": list(eye),
                             "rotation": (cy * sx, sy * cx, -sy * sx, cy * cx)})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("input", type=Path)
    parser.add_argument("output", type=Path)
    for name, count, default, text in (("--floor", 1, [3.98], "height of the floor [m]"),
                                       ("--start", 2, [-1.2, -0.3], "where the figure starts: x z"),
                                       ("--goal", 2, [3.4, -0.3], "where it comes to: x z"),
                                       ("--pivot", 3, [0.0, 8.4, -0.75], "where the lamp hangs from"),
                                       ("--eye", 3, [6.6, 5.6, 0.4], "where the camera is"),
                                       ("--look-at", 3, [-1.5, 5.2, -0.9], "what it looks at")):
        parser.add_argument(name, type=float, nargs=count, default=default, help=text)
    parser.add_argument("--rod", type=float, default=2.2, help="length of the lamp's rod [m]")
    parser.add_argument("--intensity", type=float, default=60.0, help="of the lamp [W/sr]")
    parser.add_argument("--daylight", type=float, default=0.15, help="factor on the lights that the file has")
    parser.add_argument("--seconds", type=float, default=3.7, help="length of the animation")
    options = parser.parse_args()

    glb = Glb(options.input.read_bytes())
    for light in glb.json.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", []):
        light["intensity"] = options.daylight * light.get("intensity", 1)
    channels = []
    roots = add_lamp(glb, options.pivot, options.rod, options.intensity, channels)
    roots += add_figure(glb, options.start, options.goal, options.floor[0], options.seconds, channels)
    roots.append(add_camera(glb, options.eye, options.look_at, 0.9))
    add_animation(glb, channels, options.seconds)
    scenes = glb.json.setdefault("scenes", [{}])
    scenes[glb.json.get("scene", 0)].setdefault("nodes", []).extend(roots)
    options.output.write_bytes(glb.bytes())


if __name__ == "__main__":
    main()
