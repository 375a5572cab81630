# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""What is shown of a scene: its contacts, what is constant in it, as plain JSON, and its files by
content: with those of a recording a scene can be made again on any machine.
"""

import base64
from collections.abc import Sequence
from pathlib import Path
from posixpath import dirname, join, normpath
from typing import Any
from xml.etree import ElementTree

import numpy as np

from pmwvc_core.numeric import Flags, Integers

MOST_CONTACTS = 16  # shown in a step
FIRST_HIDDEN = 3  # group of geoms that MuJoCo's own pictures leave out, and those above
KINDS = {0: "plane", 2: "sphere", 3: "capsule", 4: "ellipsoid", 5: "cylinder", 6: "box", 7: "mesh"}
NO_COLOR = (0.5, 0.5, 0.5, 1.0)  # what a geom without one has in MuJoCo


def described(model: Any, data: Any, names: Sequence[str], whose: Sequence[int]) -> dict[str, Any]:
    """Return shapes and fixed bodies of a compiled model: ``names`` of its bodies, and which user
    holds each geom (-1: nobody).
    """
    poses = zip(names, data.xpos.tolist(), data.xquat.tolist(), model.body_weldid, strict=True)
    return {
        "shapes": [
            _shape(model, geom, names) | {"user": int(whose[geom])}
            for geom, kind in enumerate(model.geom_type.tolist())
            if kind in KINDS and model.geom_group[geom] < FIRST_HIDDEN
        ],
        "fixed": {name: [*at, *turned] for name, at, turned, moves in poses if not moves},
    }


def _shape(model: Any, geom: int, names: Sequence[str]) -> dict[str, Any]:
    kind, color = KINDS[int(model.geom_type[geom])], model.geom_rgba[geom]
    if (material := int(model.geom_matid[geom])) >= 0 and np.allclose(color, NO_COLOR):
        color = model.mat_rgba[material]
    shape = {
        "body": names[model.geom_bodyid[geom]], "kind": kind,
        "size": model.geom_size[geom].tolist(),
        "at": model.geom_pos[geom].tolist(),
        "turned": model.geom_quat[geom].tolist(),
        "rgba": color.round(3).tolist(),
    }  # fmt: skip
    if kind == "mesh":
        mesh = model.mesh(model.geom_dataid[geom])
        points = model.mesh_vert[mesh.vertadr[0] :][: mesh.vertnum[0]]
        shape["points"] = points.astype(float).round(6).tolist()
        shape["faces"] = model.mesh_face[mesh.faceadr[0] :][: mesh.facenum[0]].tolist()
    return shape


def strongest(data: Any, place: Integers, held: Flags) -> tuple[list[float], Integers]:
    """Return the strongest contacts of the last sub-step, first those of ``held`` geoms: two
    bodies, by ``place`` of geoms (-1: fixed), point [m], force on the second [N], 8 numbers each;
    and the geoms of all that press, ``(n, 2)``.
    """
    contact, forces = data.contact, np.append(data.efc_force, np.zeros(3))
    first, axes = contact.efc_address[:, None], np.arange(3)  # normal first: elliptic cones
    along = forces[first + axes] * (first >= 0) * (axes < contact.dim[:, None])
    order = np.lexsort((-along[:, 0], ~held[contact.geom].any(axis=1)))
    order = order[along[order, 0] > 0.0][:MOST_CONTACTS]
    force = np.einsum("ni,nij->nj", along[order], contact.frame[order].reshape(-1, 3, 3))
    rows = np.hstack([place[contact.geom[order]], contact.pos[order], force])
    return list(rows.ravel().tolist()), contact.geom[along[:, 0] > 0.0]


def files_of(file: Path) -> dict[str, str]:
    """Return a scene file and all that it names but textures, by path from its folder (base64):
    what it includes, its meshes and height fields.
    """
    folder, texts, places, named = file.parent, [file.name], {""}, {file.name}
    for text in texts:  # grows: what is included may include
        try:
            elements = [*ElementTree.fromstring((folder / text).read_bytes()).iter()]
        except (ElementTree.ParseError, OSError):  # MuJoCo reads more than is XML
            continue
        for each in elements:
            if each.tag == "compiler":
                places |= {each.get(name, "") for name in ("meshdir", "assetdir")}
            elif each.tag != "texture" and (name := each.get("file")):
                beside = join(dirname(text), name)
                named |= {name, beside}
                if each.tag in ("include", "model"):
                    at = beside if (folder / beside).is_file() else name
                    texts += [at] if at not in texts else []
    paths = {normpath(join(place, name)) for name in named for place in places}
    there = (path for path in paths if (folder / path).is_file())
    found = sorted(there, key=lambda path: (path != file.name, path))
    return {path: base64.b64encode((folder / path).read_bytes()).decode() for path in found}
