"""Writes parts as a binary glTF 2.0 file.

Skins follow what importers agree on: float weights, one skin, mesh nodes at the scene's root with
names that no joint has.
"""
import json
import struct

import numpy as np

FLOAT, BYTE, SHORT, INT = 5126, 5121, 5123, 5125
VERTICES, INDICES = 34962, 34963


class _Buffer:
    def __init__(self):
        self.data, self.views, self.accessors = bytearray(), [], []

    def put(self, array, component, kind, target=None, bounds=False, normalized=False):
        array = np.ascontiguousarray(array)
        self.data += b"\0" * (-len(self.data) % 4)
        view = {"buffer": 0, "byteOffset": len(self.data), "byteLength": array.nbytes}
        if target:
            view["target"] = target
        accessor = {
            "bufferView": len(self.views),
            "componentType": component,
            "count": array.size // {"SCALAR": 1, "VEC3": 3, "VEC4": 4, "MAT4": 16}[kind],
            "type": kind,
        }
        if normalized:
            accessor["normalized"] = True
        if bounds:
            accessor["min"], accessor["max"] = array.min(0).tolist(), array.max(0).tolist()
        self.views.append(view)
        self.data += array.tobytes()
        self.accessors.append(accessor)
        return len(self.accessors) - 1


def _primitive(buffer, part, material, skinned):
    attributes = {
        "POSITION": buffer.put(part.points.astype("<f4"), FLOAT, "VEC3", VERTICES, bounds=True),
        "NORMAL": buffer.put(part.normals.astype("<f4"), FLOAT, "VEC3", VERTICES),
    }
    rgba = np.concatenate([np.clip(part.colors, 0, 1), np.ones((len(part.points), 1))], axis=1)
    attributes["COLOR_0"] = buffer.put(
        np.round(rgba * 255).astype("u1"), BYTE, "VEC4", VERTICES, normalized=True
    )
    if skinned:
        attributes["JOINTS_0"] = buffer.put(part.joints.astype("u1"), BYTE, "VEC4", VERTICES)
        attributes["WEIGHTS_0"] = buffer.put(part.weights.astype("<f4"), FLOAT, "VEC4", VERTICES)
    small = len(part.points) < 65536
    indices = part.triangles.reshape(-1).astype("<u2" if small else "<u4")
    return {
        "attributes": attributes,
        "indices": buffer.put(indices, SHORT if small else INT, "SCALAR", INDICES),
        "material": material,
    }


def _joints(skeleton):
    nodes = []
    for name in skeleton.names:
        parent = skeleton.parent[name]
        offset = skeleton.head[name] - (skeleton.head[parent] if parent else 0)
        node = {"name": name, "translation": offset.tolist()}
        children = [skeleton.index(c) for c in skeleton.children(name)]
        if children:
            node["children"] = children
        nodes.append(node)
    return nodes


def _skin(buffer, skeleton):
    inverse = np.tile(np.eye(4, dtype="<f4"), (len(skeleton.names), 1, 1))
    for k, name in enumerate(skeleton.names):
        inverse[k, 3, :3] = -skeleton.head[name]  # column-major
    return {
        "joints": list(range(len(skeleton.names))),
        "inverseBindMatrices": buffer.put(inverse.reshape(-1, 16), FLOAT, "MAT4"),
        "skeleton": 0,
    }


def write(path, parts, materials, skeleton=None):
    """materials: name -> (linear base colour, roughness, metallic). Only those in use are written."""
    buffer = _Buffer()
    nodes = _joints(skeleton) if skeleton else []
    roots = [0] if skeleton else []
    used = [m for m in materials if any(p.material == m for p in parts)]
    meshes = []
    for part in parts:
        primitive = _primitive(buffer, part, used.index(part.material), skeleton is not None)
        meshes.append({"name": part.name, "primitives": [primitive]})
        node = {"name": "Mesh" + part.name, "mesh": len(meshes) - 1}
        if skeleton:
            node["skin"] = 0
        roots.append(len(nodes))
        nodes.append(node)
    gltf = {
        "asset": {"version": "2.0", "generator": "taut assets/make", "copyright": "MIT"},
        "scene": 0,
        "scenes": [{"nodes": roots}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": [
            {
                "name": name,
                "pbrMetallicRoughness": {
                    "baseColorFactor": [*color, 1.0],
                    "roughnessFactor": roughness,
                    "metallicFactor": metallic,
                },
                "doubleSided": True,
            }
            for name, (color, roughness, metallic) in materials.items()
            if name in used
        ],
    }
    if skeleton:
        gltf["skins"] = [_skin(buffer, skeleton)]
    gltf["bufferViews"], gltf["accessors"] = buffer.views, buffer.accessors
    gltf["buffers"] = [{"byteLength": len(buffer.data) + -len(buffer.data) % 4}]
    text = json.dumps(gltf, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    data = bytes(buffer.data) + b"\0" * (-len(buffer.data) % 4)
    with open(path, "wb") as out:
        out.write(struct.pack("<III", 0x46546C67, 2, 28 + len(text) + len(data)))
        out.write(struct.pack("<II", len(text), 0x4E4F534A) + text)
        out.write(struct.pack("<II", len(data), 0x004E4942) + data)
