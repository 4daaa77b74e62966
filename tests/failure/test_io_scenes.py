"""Damaged and hostile scenes of glTF and 3MF are refused in one sentence."""

import io
import json
import struct
import zipfile
from pathlib import Path

import pytest

from fuzz.targets import feed
from support.messages import missing
from support.scene_files import gltf, threemf

TREE = json.loads(gltf())
GLB = (Path(__file__).parents[1] / "fuzz" / "corpus" / "glb" / "trimesh.glb").read_bytes()
ACCESSOR = TREE["accessors"]
BOMB = io.BytesIO()
with zipfile.ZipFile(BOMB, "w", zipfile.ZIP_DEFLATED) as archive:
    archive.writestr("3D/3dmodel.model", b"<model>" + b" " * (1 << 27) + b"</model>")


def accessors(k: int, **changes: object) -> bytes:
    """The scene with one accessor changed."""
    return gltf(accessors=[{**entry, **changes} if i == k else entry for i, entry in enumerate(ACCESSOR)])


@pytest.mark.parametrize(
    ("target", "data", "words"),
    [
        ("glb", GLB[:-5], "says ... bytes, of which"),
        ("glb", b"glTX" + GLB[4:], "no header of GLB"),
        ("glb", GLB[:4] + struct.pack("<I", 1) + GLB[8:], "version 1 of glTF; only version 2"),
        ("gltf", gltf(asset={"version": "1.1"}), "version 1 of glTF; only version 2"),
        ("glb", GLB[:12] + struct.pack("<I", 1 << 30) + GLB[16:], "chunk ends after the file"),
        ("gltf", gltf()[:-9], "not a whole glTF file"),
        ("gltf", b"[" * 100_000, "not a whole glTF file"),
        ("gltf", accessors(0, count=5), "accessor 0 reaches beyond its buffer"),
        ("gltf", accessors(0, count=1 << 60), "reaches beyond"),
        ("gltf", accessors(0, byteOffset=-4), "no index"),
        ("gltf", accessors(3, bufferView=9), "not a whole glTF file"),
        ("gltf", accessors(0, sparse={}), "sparse accessor"),
        ("gltf", accessors(3, componentType=5126, count=3), "no whole numbers"),
        ("gltf", gltf(nodes=[{"children": [0]}]), "circle"),
        ("gltf", gltf(nodes=[{"children": [1]}, {"mesh": 0, "scale": [1e400, 1, 1]}]), "not finite"),
        ("gltf", gltf(nodes=[{}]), "no triangles"),
        (
            "gltf",
            gltf(buffers=[{"byteLength": 9, "uri": "a.bin"}]),
            "keeps its data in another file: ... a.bin: there is no such file",
        ),
        (
            "gltf",
            gltf(buffers=[{"byteLength": 9, "uri": "http://a.b/a.bin"}]),
            "keeps its data in http://a.b/a.bin ... .glb",
        ),
        ("gltf", gltf(buffers=[{"byteLength": 9, "uri": "/dev/zero"}]), "keeps its data in /dev/zero ... .glb"),
        ("gltf", gltf(extensionsRequired=["KHR_draco_mesh_compression"]), "compressed by KHR_draco"),
        ("3mf", threemf()[:-30], "not a whole 3MF archive"),
        ("3mf", threemf(item='<item objectid="7"/>'), "object 7 is named and does not exist"),
        ("3mf", threemf(item='<item objectid="1" p:path="/a.model"/>'), "names the file 'a.model'"),
        ("3mf", threemf(item="<component/>"), "no attribute 'objectid'"),
        ("3mf", threemf(item='<item objectid="1" transform="1 2"/>'), "no whole 3MF model"),
        ("3mf", threemf(item="<item>"), "no whole 3MF model"),
        ("3mf", threemf(item='<item objectid="1"/>' * 9000), "too often"),
        ("3mf", threemf(head='<!DOCTYPE model [<!ENTITY a "aaaa">]>'), "document type"),
        ("3mf", BOMB.getvalue(), "unpacks to far more"),
    ],
)
def test_refused(target: str, data: bytes, words: str) -> None:
    """Truncated files, offsets beyond the data, circles, entities and bombs are refused with the reason."""
    assert not missing(feed(target, data) or "", words)
