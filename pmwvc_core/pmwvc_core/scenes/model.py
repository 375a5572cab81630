# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A MuJoCo model from a scene file, with what each user holds: a finger, or a handle of the scene.

A finger is a sphere of a gram on three slides and, of six axes, a ball, weightless. A handle is a
body of the scene that is fixed to the world, or mocap; it gets the same joints, is weightless, and
is taken where it is.

What a scene usually lacks to be held is written into the model where the file has MuJoCo's own
default: elliptic friction cones with impratio 100, as a finger creeps out of a pyramid. Contacts
with what users hold are hard, whatever the other geom says; their friction is the other geom's.
"""

import math
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from pmwvc_core.errors import ParameterError
from pmwvc_core.numeric import AXES, Array
from pmwvc_core.params.names import hint
from pmwvc_core.plugins import refused
from pmwvc_core.scenes.description import files_of
from pmwvc_core.server.black_box import EnvironmentSetup, matrices_of

FINGER_KG = 1e-3
MOCAP_KG = 0.05  # of a handle that was a mocap body: what is welded to it gives way 0.6 mm/N
EVERYTHING = 0x7FFFFFFF  # kinds of geoms that a finger touches
SUB_STEP_S = 1e-3  # longest step of the contact solver: what is hit is noticed in the next one
IMPRATIO = 100.0
SOLREF = (4e-3, 1.0)  # twice as slow as the fastest that the solver allows
SOLIMP = (0.998, 0.9995, 0.001, 0.5, 2.0)  # 2 N sink 0.06 mm
OVERRIDES = 1e6  # weight of a contact's parameters against those of the other geom
ROUNDING = 1e-9
LARGEST_RATIO = 1e4  # of two masses


class Grasp(NamedTuple):
    """What a user holds."""

    qpos: slice  # of the three slides
    ball: slice  # likewise, its quaternion; empty where it does not turn
    dofs: slice
    geoms: list[int]
    home: Array | None  # (3,) [m] of a finger: where it is for a device at zero
    axes: Array  # (3, 3) of the slides, in columns: those of the impedance
    body: int
    start: Array  # (3, 3) how it is turned while its ball is not


def import_mujoco() -> Any:
    """Return the package; ParameterError says how to get it."""
    try:
        import mujoco
    except ImportError as error:
        text = f"server.environment = 'mujoco': {error}: pip install mujoco (or '.[mujoco]')"
        raise ParameterError(text) from None
    mujoco.set_mju_user_warning(lambda text: None)  # MuJoCo's own would write a file here
    return mujoco


def scene_model(setup: EnvironmentSetup) -> tuple[Any, list[Grasp], int, dict[str, Any]]:
    """Compile the scene of a setup: return the model, what each user holds, the first body that
    moves (0, the world, where none does), and ``files`` and the ``options`` written into the model
    beside them. ParameterError with the reason where it cannot be used.
    """
    mujoco, server = import_mujoco(), setup.server
    if setup.dof not in (3, 6):
        raise ParameterError(f"dof = {setup.dof}: a scene has 3 or 6 axes")
    where = f"server.scene = {server.scene!r}"
    file = Path(server.scene).expanduser()
    spec = _read(mujoco, file, where)
    movable = next((body for body in spec.bodies[1:] if body.joints), spec.worldbody)
    bodies = _handles(spec, setup)
    for user in range(0 if bodies else setup.users):
        with refused(where, cannot_be="used"):  # a body of that name is there
            bodies.append(spec.worldbody.add_body(name=f"pmwvc_user{user + 1}"))
    slide, ball = mujoco.mjtJoint.mjJNT_SLIDE, mujoco.mjtJoint.mjJNT_BALL
    plain = mujoco.MjSpec()  # what is added has nothing of the file's defaults
    for body in bodies:
        if not server.handles or body.mocap:
            group = int(spec.compiler.inertiagrouprange[0])
            kg, touched = (MOCAP_KG, 0) if body.mocap else (FINGER_KG, EVERYTHING)
            body.add_geom(
                plain.default, type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[server.finger_m, 0.0, 0.0],
                mass=kg, contype=touched, conaffinity=touched, friction=[0.0] * 3, group=group,
            )  # fmt: skip
        body.mocap = False  # a hand moves it, no program
        for n, kind in enumerate([slide] * 3 + [ball] * (setup.dof == AXES)):
            body.add_joint(plain.default, type=kind, axis=np.eye(3)[n % 3])
        body.gravcomp = 1.0  # with none when it is compiled, MuJoCo looks at none later
    options = _set_options(mujoco, spec.option, setup.period_s)
    with refused(where, cannot_be="compiled"):
        model = spec.compile()
    _check_masses(model, {body.id for body in bodies}, where)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    held: list[Grasp] = []
    for body, axes in zip(bodies, _axes(setup), strict=True):
        at, start = model.body(body.id), data.xmat[body.id].reshape(3, 3).copy()
        model.jnt_axis[at.jntadr[0] :][:3] = axes.T @ start  # in axes of the body
        whole = model.body_weldid == body.id  # with what is welded to it
        geoms = np.flatnonzero(whole[model.geom_bodyid])
        model.body_gravcomp[whole], model.geom_solmix[geoms] = 1.0, OVERRIDES
        model.geom_solref[geoms], model.geom_solimp[geoms] = SOLREF, SOLIMP
        model.geom_condim[geoms] = np.maximum(model.geom_condim[geoms], 3 + (setup.dof == AXES))
        model.geom_group[geoms] *= bool(server.handles)  # fingers are drawn
        first, dof = int(model.jnt_qposadr[at.jntadr[0]]), int(at.dofadr[0])
        home = None if server.handles else np.zeros(3)
        turn = slice(first + 3, first + (7 if setup.dof == AXES else 3))
        joints = slice(first, first + 3), turn, slice(dof, dof + setup.dof)
        held.append(Grasp(*joints, geoms.tolist(), home, axes, body.id, start))
    return model, held, movable.id, {"files": files_of(file), "options": options}


def _axes(setup: EnvironmentSetup) -> list[Array]:
    """Return the slides' axes of every user; armature has one number along each."""
    impedances = matrices_of(np.array(setup.impedances or [1.0] * setup.users), setup.dof)
    for b in impedances:
        turning = b - b[-1, -1] * np.eye(setup.dof)
        if np.abs(turning[3:]).max(initial=0.0) > ROUNDING * np.abs(b).max():
            text = "in a scene of MuJoCo axes 4 to 6 have one number, coupled with nothing"
            raise ParameterError(f"impedance_matrix: {text}: a ball resists alike about all axes")
    return [np.linalg.eigh(b[:3, :3])[1] for b in impedances]


def _read(mujoco: Any, file: Path, where: str) -> Any:
    if not file.is_file():
        looked = f"there is no such file (looked in {Path.cwd()})"
        raise ParameterError(f"{where}: {looked}; name the scene's MJCF file (.xml)")
    with refused(where, cannot_be="read"):
        spec = mujoco.MjSpec.from_file(str(file))
    for material in spec.materials:
        material.textures = [""] * len(material.textures)
    for light in spec.lights:
        light.texture = ""
    for each in (*spec.textures, *spec.keys):  # keys have the file's joints only
        spec.delete(each)
    return spec


def _handles(spec: Any, setup: EnvironmentSetup) -> list[Any]:
    text = setup.server.handles
    names = [name.strip() for name in text.split(",") if name.strip()]
    if names and len(names) != setup.users:
        wrong = f"server.handles = {text!r}: {len(names)} bodies for {setup.users} users"
        raise ParameterError(f"{wrong}; name one for each, or none for fingers")
    found = []
    for name in names:
        body = spec.body(name)
        if body is None:
            near = hint(name, [body.name for body in spec.bodies if body.name])
            raise ParameterError(f"server.handles = {text!r}: no body is named {name!r}{near}")
        if body.joints or body.parent is not spec.worldbody:
            needed = "must be a child of worldbody without joints: it gets its own"
            raise ParameterError(f"server.handles: {name!r} {needed}")
        found.append(body)
    return found


def _set_options(mujoco: Any, option: Any, period_s: float) -> dict[str, Any]:
    """Write what the file leaves as MuJoCo has it, and shorter steps; return what was written."""
    written: dict[str, Any] = {}
    if option.cone == mujoco.mjtCone.mjCONE_PYRAMIDAL:
        option.cone, written["cone"] = mujoco.mjtCone.mjCONE_ELLIPTIC, "elliptic"
    if option.impratio == 1.0:
        option.impratio = written["impratio"] = IMPRATIO
    steps = math.ceil(period_s / min(SUB_STEP_S, option.timestep) - 1e-9)
    if not math.isclose(option.timestep, period_s / steps):
        option.timestep = written["timestep"] = period_s / steps
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    return written | {"autoreset": "disable", "solref of what users hold": list(SOLREF)}


def _check_masses(model: Any, held: set[int], where: str) -> None:
    """Refuse masses that are too far apart, of bodies that move and touch; welded ones are one."""
    masses = np.bincount(model.body_weldid, model.body_mass, model.nbody)
    felt = np.maximum(masses, 1.0 / np.maximum(model.body_invweight0[:, 0], ROUNDING))  # by joints
    touching = model.geom_bodyid[(model.geom_contype | model.geom_conaffinity) > 0]
    bodies = {*model.body_weldid[touching].tolist()} - {0}
    if bodies - held:  # b makes these heavy
        heavy = max(bodies, key=masses.__getitem__)
        light = min(bodies - held, key=felt.__getitem__)
        if (ratio := masses[heavy] / felt[light]) > LARGEST_RATIO:
            names = [repr(model.body(n).name or f"body{n}") for n in (heavy, light)]
            text = f"{names[0]} has {ratio:.3g} times the mass of {names[1]}; above"
            raise ParameterError(f"{where}: {text} {LARGEST_RATIO:g} contacts are not solved")
