#!/usr/bin/python3
"""Checks the models in assets/: reads each GLB back and says what is wrong with it."""
import argparse
import json
import pathlib
import struct
import sys

import numpy as np

import holes
from skeleton import REST

LIMITS = {  # triangles, bytes
    "martial_artist": (120_000, 3_000_000),
    "dojo": (36_000, 2_500_000),
    "studio": (26_000, 600_000),
    "cube": (4_000, 300_000),
    "bracket": (4_000, 200_000),
    "stick": (6_000, 200_000),
    "stick_lacquer": (6_000, 200_000),
    "earring": (4_000, 150_000),
    "peg": (4_000, 150_000),
}
MOST_SEEN_THROUGH = 4  # mm2: less than a pixel of a close-up
_TYPES = {5126: "<f4", 5121: "u1", 5123: "<u2", 5125: "<u4"}
_WIDTH = {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}


class Glb:
    """A GLB file's JSON and the arrays of its accessors."""

    def __init__(self, path):
        data = path.read_bytes()
        magic, _, size = struct.unpack("<4sII", data[:12])
        assert magic == b"glTF" and size == len(data), "header"
        length = struct.unpack("<I", data[12:16])[0]
        self.json = json.loads(data[20 : 20 + length])
        self.data = data[28 + length :]

    def array(self, index):
        accessor = self.json["accessors"][index]
        view = self.json["bufferViews"][accessor["bufferView"]]
        width = _WIDTH[accessor["type"]]
        kind = _TYPES[accessor["componentType"]]
        out = np.frombuffer(self.data, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
        return out / np.float32(255) if accessor.get("normalized") else out


def _faults_of_mesh(glb, mesh, bones):
    primitive = mesh["primitives"][0]
    arrays = {name: glb.array(k) for name, k in primitive["attributes"].items()}
    points, normals = arrays["POSITION"], arrays["NORMAL"]
    triangles = glb.array(primitive["indices"]).reshape(-1, 3).astype(np.int64)
    if not all(np.isfinite(a).all() for a in arrays.values()):
        yield "a value is not finite"
    if triangles.max() >= len(points):
        yield "an index is out of range"
        return
    if len(np.unique(triangles)) != len(points):
        yield "a vertex is not used"
    if np.abs(np.linalg.norm(normals, axis=1) - 1).max() > 1e-3:
        yield "a normal is not of unit length"
    corners = points[triangles].astype(float)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if (np.linalg.norm(cross, axis=1) < 1e-12).any():
        yield "a triangle has no area"
    facing = np.sum(cross * normals[triangles].sum(axis=1), axis=1) / (np.linalg.norm(cross, axis=1) + 1e-30)
    against = facing < -0.3  # of 3: three unit normals
    if against.mean() > 0.02:
        yield f"{against.mean():.1%} of the triangles face against their normals"
    half = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    _, count = np.unique(half, axis=0, return_counts=True)
    if (count > 1).mean() > 0.02:  # where folds touch, a net's cells do too
        yield f"{(count > 1).sum()} edges have two triangles on one side"
    if bones:
        weights, joints = arrays["WEIGHTS_0"], arrays["JOINTS_0"]
        if weights.min() < 0 or np.abs(weights.sum(axis=1) - 1).max() > 1e-5:
            yield "weights do not sum to 1"
        if joints.max() >= bones:
            yield "a joint index is out of range"
        repeated = (joints[:, :, None] == joints[:, None, :]) & (weights[:, :, None] > 0) & (weights[:, None, :] > 0)
        if repeated.sum(axis=(1, 2)).max() > (weights > 0).sum(axis=1).max():
            yield "a joint is named twice for a vertex"


def _faults_of_skeleton(glb):
    nodes = glb.json["nodes"]
    joints = [nodes[k] for k in glb.json["skins"][0]["joints"]]
    if [j["name"] for j in joints] != REST.names:
        yield "the joints are not those of the rest skeleton, in its order"
        return
    at, parents = {}, {c: n["name"] for n in nodes for c in n.get("children", [])}
    for k, node in enumerate(joints):
        at[node["name"]] = np.array(node["translation"]) + at.get(parents.get(k), 0)
        if np.abs(at[node["name"]] - REST.head[node["name"]]).max() > 1e-9:
            yield f"{node['name']} is not at its rest position"
    names = [n["name"] for n in nodes]
    if len(set(names)) != len(names):
        yield "two nodes have the same name"


def _holes_in_head(glb):
    """Backs of surfaces that are seen first from round the head: nothing is drawn there, and the scenery shows."""
    points, triangles, count = [], [], 0
    for mesh in glb.json["meshes"]:
        primitive = mesh["primitives"][0]
        if glb.json["materials"][primitive["material"]]["name"] == "Lash":
            continue  # a hair is a blade: its back hides nothing
        points.append(glb.array(primitive["attributes"]["POSITION"]).astype(float))
        triangles.append(glb.array(primitive["indices"]).reshape(-1, 3).astype(np.int64) + count)
        count += len(points[-1])
    points, triangles = np.concatenate(points), np.concatenate(triangles)
    low, high = np.array([-0.30, 1.45, -0.30]), np.array([0.30, 1.90, 0.30])
    near = np.all((points[triangles] > low) & (points[triangles] < high), axis=(1, 2))
    seen = 0
    for eye in holes.directions(24, -0.25):
        behind = holes.seen_from_behind(points, triangles[near], eye)
        seen = max(seen, np.sum(behind[:, 1] > 1.54))
    if seen > MOST_SEEN_THROUGH:
        yield f"Head: {seen} mm2 are seen through from one side"


def faults(path):
    """What is wrong with a file, in words; and its numbers of vertices and triangles."""
    glb, out = Glb(path), []
    skinned = "skins" in glb.json
    if skinned:
        out += _faults_of_skeleton(glb)
        out += _holes_in_head(glb)
    vertices = triangles = 0
    for mesh in glb.json["meshes"]:
        primitive = mesh["primitives"][0]
        vertices += len(glb.array(primitive["attributes"]["POSITION"]))
        triangles += len(glb.array(primitive["indices"])) // 3
        out += [f"{mesh['name']}: {f}" for f in _faults_of_mesh(glb, mesh, len(REST.names) if skinned else 0)]
    most, size = LIMITS[path.stem]
    if triangles > most:
        out.append(f"{triangles} triangles, at most {most}")
    if path.stat().st_size > size:
        out.append(f"{path.stat().st_size} bytes, at most {size}")
    return out, vertices, triangles


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    folder = pathlib.Path(__file__).resolve().parent.parent
    parser.add_argument("files", nargs="*", type=pathlib.Path, default=[folder / f"{m}.glb" for m in LIMITS])
    bad = False
    for path in parser.parse_args().files:
        out, vertices, triangles = faults(path)
        print(f"{path.name}: {vertices} vertices, {triangles} triangles" + "".join(f"\n  {f}" for f in out))
        bad |= bool(out)
    return int(bad)


if __name__ == "__main__":
    sys.exit(main())
