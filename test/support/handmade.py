# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""A session made by hand, with every answer known: two users press a resting object.

User i presses with s_i F(t); F rises from 0 to ``FORCE_N`` between 0.5 s and 1.5 s and is the same
for all ticks of a frame. The channel is a pure delay of d frames each way; a master sends the mean
of the frame just over and holds what it gets; the object gives back what it gets, and no energy.
With a = F/sqrt(2b), per user, frame by frame::

    u_m(n) = a(n)    u_s(n) = a(n - 1 - d)    v_s(n) = -a(n - 1 - d)    v_m(n) = -a(n - 1 - 2 d)

so at rest F_m = F_s = F, and the device stands F (2d + 1) T / (2b) ahead of its avatar. In flight
are d frames of |a|^2 T/2 on the way up and d + 1 on the way down.
"""

from typing import Any

import numpy as np

from pmwvc_core.scenario.reader import parse_scenario
from pmwvc_core.scenario.scenario import Scenario
from pmwvc_core.traces import FateTraces, PacketTraces, ServerTraces, SessionTraces, UserTraces
from support.marred import oscillating, without_blocks, without_steps

__all__ = ["oscillating", "without_blocks", "without_steps"]

IMPEDANCE = 25.0
FORCE_N = 1.0
TICK_S = 0.001
TICKS = 8
FRAME_S = TICK_S * TICKS
DELAY_FRAMES = 2
SIDES = (1.0, -1.0)
START_NS = 1_700_000_000_000_000_000
IN_FLIGHT_J = FORCE_N**2 / (2 * IMPEDANCE) * FRAME_S / 2  # of one frame at rest
DRIFT_M = FORCE_N * (2 * DELAY_FRAMES + 1) * FRAME_S / (2 * IMPEDANCE)


def scenario(**overrides: Any) -> Scenario:
    """The scenario of that session; ``overrides`` by dotted name with ``__`` for the dots."""
    return parse_scenario(
        {
            "name": "press",
            "description": "Two users press a resting object from both sides.",
            "duration_s": 4.0,
            "controller": "pmwvc",
            "channel": "plain",
            "users": 2,
            "master": {
                "impedance": IMPEDANCE,
                "hold": "zoh",
                "filter": {"kind": "integrate_and_dump"},
            },
            "operator": {"kind": "constant"},
            "server": {"contact": "bilateral", "coupling": "implicit"},
            "task": {"kind": "free"},
            "link": {"delay_s": DELAY_FRAMES * FRAME_S},
        },
        overrides={name.replace("__", "."): value for name, value in overrides.items()},
    )


def force(frames: np.ndarray) -> np.ndarray:
    """F of a frame, 0 before the session."""
    share = np.clip(frames * FRAME_S - 0.5, 0.0, 1.0)
    return FORCE_N * 0.5 * (1.0 - np.cos(np.pi * share))


def session(
    *, duration_s: float = 4.0, users: int = 2, dof: int = 1, gain: float = 1.0
) -> SessionTraces:
    """The session; ``gain`` other than 1 makes the way up give out ``gain``^2 times the energy."""
    frames = np.arange(round(duration_s / FRAME_S))
    names = [f"user{i + 1}" for i in range(users)]
    signs = [SIDES[i % 2] for i in range(users)]
    waves = [_waves(frames, sign, dof, gain) for sign in signs]
    traces = SessionTraces(
        source="simulated",
        duration_s=len(frames) * FRAME_S,
        users=[_user(name, wave) for name, wave in zip(names, waves, strict=True)],
        server=_server(names, frames, waves, dof),
    )
    for place, (name, wave) in enumerate(zip(names, waves, strict=True)):
        _add_network(traces, name, place, frames, wave)
    for topic, packets in traces.packets.items():
        traces.counts[topic] = {"messages": len(packets.seq), "missing": 0}
    return traces


def _waves(frames: np.ndarray, sign: float, dof: int, gain: float) -> dict[str, np.ndarray]:
    def a(shift: int) -> np.ndarray:
        values = np.zeros((len(frames), dof))
        values[:, 0] = sign * force(frames - shift) / np.sqrt(2 * IMPEDANCE)
        return values

    d = DELAY_FRAMES
    return {
        "u_m": a(0),
        "u_tx": a(1),
        "u_s": gain * a(1 + d),
        "v_s": -a(1 + d),
        "v_m": -a(1 + 2 * d),
    }


def _port(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return (u + v) / np.sqrt(2 * IMPEDANCE), (u - v) * np.sqrt(IMPEDANCE / 2)


def _energy(wave: np.ndarray, period_s: float) -> np.ndarray:
    return np.cumsum(np.sum(wave**2, axis=-1)) * period_s / 2


def _user(name: str, wave: dict[str, np.ndarray]) -> UserTraces:
    u_m, v_m = (np.repeat(wave[key], TICKS, axis=0) for key in ("u_m", "v_m"))
    xd_m, f_m = _port(u_m, v_m)
    ticks = np.arange(len(u_m))
    blocks = len(wave["u_m"])
    work = np.cumsum(np.sum(f_m * xd_m, axis=-1)) * TICK_S
    return UserTraces(
        name=name,
        tick_s=TICK_S,
        time_s=ticks * TICK_S,
        tick=ticks,
        x_m=np.cumsum(xd_m, axis=0) * TICK_S - xd_m * TICK_S,
        xd_m=xd_m,
        f_h=f_m.copy(),
        f_m=f_m,
        f_applied=f_m.copy(),
        u_m=u_m,
        u_m_lp=u_m.copy(),
        v_m=v_m,
        lateness_s=np.zeros(len(ticks)),
        looked_ns=np.zeros(len(ticks), dtype=np.int64),
        compute_s=np.zeros(len(ticks)),
        block_time_s=(np.arange(blocks) + 1) * FRAME_S,
        state=np.ones(blocks, dtype=np.int64),
        reason=[""] * blocks,
        block_number=np.arange(blocks) + 1,
        changes=np.zeros(blocks, dtype=np.int64),
        epoch=np.full(blocks, int(name.removeprefix("user")), dtype=np.uint64),
        energy={
            "u_m": _energy(wave["u_m"], FRAME_S),
            "u_tx": _energy(wave["u_tx"], FRAME_S),
            "v_rx": _energy(wave["v_m"], FRAME_S),
            "v_m": _energy(wave["v_m"], FRAME_S),
            "device": work[TICKS - 1 :: TICKS],
            "hand": work[TICKS - 1 :: TICKS],
        },
    )


def _server(
    names: list[str], frames: np.ndarray, waves: list[dict[str, np.ndarray]], dof: int
) -> ServerTraces:
    ports = [_port(wave["u_s"], wave["v_s"]) for wave in waves]
    still = np.zeros((len(frames), dof))
    return ServerTraces(
        users=names,
        periods_s=np.full(len(frames), FRAME_S),
        time_s=frames * FRAME_S,
        step=frames + 1,
        looked_ns=np.zeros(len(frames), dtype=np.int64),
        x_o=still.copy(),
        xd_o=still.copy(),
        target=still.copy(),
        x_s=[np.cumsum(xd_s, axis=0) * FRAME_S for xd_s, _ in ports],
        xd_s=[xd_s for xd_s, _ in ports],
        f_s=[f_s for _, f_s in ports],
        u_s=[wave["u_s"] for wave in waves],
        v_s=[wave["v_s"] for wave in waves],
        contact=[np.ones(len(frames), dtype=bool) for _ in names],
        state=[np.full(len(frames), 2, dtype=np.int64) for _ in names],
        energy_u_s=[_energy(wave["u_s"], FRAME_S) for wave in waves],
        energy_v_s=[_energy(wave["v_s"], FRAME_S) for wave in waves],
        kinetic=np.zeros(len(frames)),
        potential=np.zeros(len(frames)),
        dissipated=np.zeros(len(frames)),
        changes=np.zeros(len(frames), dtype=np.int64),
    )


def _add_network(
    traces: SessionTraces, name: str, place: int, frames: np.ndarray, wave: dict[str, np.ndarray]
) -> None:
    sent_ns = frames.astype(np.int64) * round(FRAME_S * 1e9)
    delay_ns = round(DELAY_FRAMES * FRAME_S * 1e9)
    ways = (
        ("up", f"/{name}/wave_up", f"/server/{name}/wave_up", "u_tx", place + 1),
        ("down", f"/server/{name}/wave_down", f"/{name}/wave_down", "v_s", 1000 + place),
    )
    x_m, x_s = traces.users[place].x_m[::TICKS], traces.server.x_s[place]
    place_of = {"up": x_m.copy(), "down": x_s.copy()}
    for way, before, behind, key, epoch in ways:
        out_ns = sent_ns + delay_ns
        arrived = out_ns < round(traces.duration_s * 1e9)
        for topic, rows, times in (
            (before, slice(None), sent_ns),
            (behind, arrived, out_ns[arrived]),
        ):
            traces.packets[topic] = PacketTraces(
                topic=topic,
                time_s=times * 1e-9,
                epoch=np.full(len(times), epoch, dtype=np.uint64),
                seq=(frames + 1)[rows],
                sent_ns=sent_ns[rows],
                period_s=np.full(len(times), FRAME_S),
                wave=wave[key][rows],
                integral=(np.cumsum(wave[key], axis=0) * FRAME_S)[rows],
                energy=_energy(wave[key], FRAME_S)[rows],
                position=place_of[way][rows],
                orientation=np.zeros((len(times), 0)),
            )
        traces.fates[f"{name}/{way}"] = FateTraces(
            link=f"{name}/{way}",
            number=frames + 1,
            epoch=np.full(len(frames), epoch, dtype=np.uint64),
            seq=frames + 1,
            size_bytes=np.full(len(frames), 140, dtype=np.int64),
            time_in_ns=sent_ns,
            time_due_ns=out_ns,
            time_out_ns=np.where(arrived, out_ns, 0),
            fate=np.zeros(len(frames), dtype=np.int64),
            cause=np.zeros(len(frames), dtype=np.int64),
        )
