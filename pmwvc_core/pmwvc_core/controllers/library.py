# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Controllers by name: the library, and entry points of the group ``pmwvc.controllers``, each a
:class:`.record.Controller`.
"""

from dataclasses import replace
from typing import Any

from pmwvc_core.account import Entry
from pmwvc_core.controllers import accounts
from pmwvc_core.controllers import record as rules
from pmwvc_core.controllers.record import HELD, Controller
from pmwvc_core.law.without_waves.couplings import AvatarSeen, Direct, Held, VirtualCoupling
from pmwvc_core.law.without_waves.pspm import ModulatedSpring, Pspm
from pmwvc_core.law.without_waves.tdpa import Tdpa, TdpaEnd
from pmwvc_core.params import MasterParams, ServerParams
from pmwvc_core.params.server import TdpaParams
from pmwvc_core.plugins import Records
from pmwvc_core.server.couplings import COMPENSATIONS, COUPLINGS

PMWVC = Controller(
    name="pmwvc",
    words="Wave variables: stable at any constant delay where the gains of both ends prove it.",
    waves=True,
    linear="pmwvc",
    # what position feedback may spend before it is paid; none as published
    storage_j=lambda master, _: float(master.position.storage_j * master.position.is_paid),
    accounts=accounts.OF_WAVES,
)


def tdpa_law(params: TdpaParams, tick_s: float) -> Tdpa:
    """Return the law for a tick [s]."""
    kept = 1.0 / (1.0 + tick_s / params.fade_s) if params.fade_s > 0.0 else 0.0
    return Tdpa(params.damping, params.damping_max, kept, params.drift_share)


DIRECT = Controller(
    name="direct",
    words="Direct coupling: nothing keeps it passive as delay or stiffness grows.",
    waves=False,
    law=lambda p, tick_s: Direct(0),
    device_rest=lambda p, axes: Held((0.0,) * axes),
    linear="direct",
    coupling=replace(HELD, moves=None),
)
VIRTUAL_COUPLING = Controller(
    name="virtual_coupling",
    words="Virtual coupling: stable where its rules are met; energy is not monitored.",
    waves=False,
    law=lambda p, tick_s: VirtualCoupling(p.stiffness, p.damping),
    device_rest=lambda p, axes: AvatarSeen((0.0,) * axes, (0.0,) * axes),
    linear="virtual_coupling",
    coupling=HELD,
    rule=rules.check_virtual_coupling,
)
TDPA = Controller(
    name="tdpa",
    words="Time-domain passivity control: energy that the link generated is dissipated "
    "later; a device at rest dissipates none.",
    waves=False,
    law=tdpa_law,
    device_rest=lambda p, axes: TdpaEnd((0.0,) * axes),
    avatar_rest=lambda p, axes: TdpaEnd(()),
    linear=None,  # without its dissipation nothing of it is left
    rule=rules.check_tdpa,
    coupling=replace(HELD, moves="forward_euler"),
    accounts=accounts.OF_TDPA,
)
PSPM = Controller(
    name="pspm",
    words="Set-position modulation: neither end releases more energy than its tank holds.",
    waves=False,
    law=lambda p, tick_s: Pspm(p.stiffness, p.damping, p.cap_j),
    device_rest=lambda p, axes: ModulatedSpring((0.0,) * axes, p.initial_j),
    avatar_rest=lambda p, axes: ModulatedSpring((0.0,) * axes, p.initial_j),
    linear="virtual_coupling",  # with tanks that are never empty
    coupling=HELD,
    rule=rules.check_pspm,
    storage_j=lambda _, baseline: 2.0 * float(baseline.pspm.initial_j),  # [J] of both tanks
    accounts=accounts.OF_PSPM,
)

RECORDS: Records[Controller] = Records(
    Controller, (PMWVC, DIRECT, VIRTUAL_COUPLING, TDPA, PSPM), group="pmwvc.controllers",
    parameter="controller", what="a controller",
)  # fmt: skip
STRICT, PLAIN, ZEROING = CHANNELS = ("strict", "plain", "zeroing")
LIBRARY, names, record_of = RECORDS.library, RECORDS.names, RECORDS.of


def entries() -> dict[str, Entry]:
    """Return every account by name that a controller or a compensation keeps: of the library, and
    of those of other packages that were asked for.
    """
    records: list[Any] = [*RECORDS.met.values(), *COMPENSATIONS.met.values()]
    return {entry.name: entry for record in records for entry in record.accounts}


def has_waves(controller: str) -> bool:
    """Tell whether a controller, by name, joins its ends by wave variables."""
    return record_of(controller).waves


def proofs_hold(controller: str) -> bool:
    """Tell whether the proofs of wave ports hold: only for the library's own."""
    return controller in LIBRARY and has_waves(controller)


def is_strict(controller: str, channel: str) -> bool:
    """Tell whether it runs on the strict channel; only the library's waves can."""
    return channel == STRICT and controller == PMWVC.name


def is_zeroing(controller: str, channel: str) -> bool:
    """Tell whether it counts every wave once; only waves can."""
    return channel == ZEROING and has_waves(controller)


def accounts_of_user(controller: str, channel: str, master: MasterParams) -> tuple[Entry, ...]:
    """Return the accounts of a user's port behind the energies of any port."""
    record = record_of(controller)
    if record.device is not None or not record.waves:
        return record.accounts
    strict, position = is_strict(controller, channel), master.position
    velocity, lent = master.velocity_filter, strict or position.as_published
    of_velocity = accounts.FORCE_FILTER if velocity.in_force else accounts.VELOCITY_FILTER
    kept = (
        (strict, accounts.OF_STRICT),
        (velocity.is_on, (of_velocity,)),
        (master.bank.is_on, accounts.OF_BANK),
        (position.is_on, accounts.OF_POSITION[: 1 if lent else None]),
    )
    return tuple(entry for is_on, of in kept if is_on for entry in of)


def accounts_of_server(controller: str, channel: str, server: ServerParams) -> tuple[Entry, ...]:
    """Return the accounts of the environment."""
    record = record_of(controller)
    if record.avatar is not None or not record.waves:
        return record.accounts
    found: tuple[Entry, ...] = ()
    if COUPLINGS.of(server.coupling).black_box:
        found = accounts.OF_BLACK_BOX + COMPENSATIONS.of(server.compensation).accounts
    return (*found, accounts.BRAKES) if is_strict(controller, channel) else found
