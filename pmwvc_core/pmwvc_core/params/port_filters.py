# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Parameters of what stands around the wave port of a master: velocity filter (App. D), filter
bank with local model (App. E), position feedback.
"""

from dataclasses import dataclass

from pmwvc_core.params.fields import Validated, disordered, fixed, has, lacks, parameter


@dataclass(frozen=True)
class VelocityFilterParams(Validated):
    """Velocity filter by feeding back the high-pass part of the outgoing wave (App. D).

    At most one of ``alpha`` and ``cutoff_hz``; without either they follow from the anti-aliasing
    filter.
    """

    kind: str = fixed(
        "none", ("none", "equivalent", "exact", "complementary"),
        "which form; complementary: with low-pass filters both ways, passive by itself",
    )  # fmt: skip
    order: int = fixed(2, "1..8", "order of the high-pass filter")
    share: float = fixed(0.5, "> 0 and <= 1", "share of the high-pass wave fed back (App. D)")
    alpha: float | None = fixed(None, "> 0 and < 1", "order 1: pole of (z - 1)/(z - alpha)")
    cutoff_hz: float | None = fixed(None, "> 0 and <= 10000 Hz", "Butterworth: its -3 dB")

    is_on = lacks("kind", "none")
    in_force = has("kind", "equivalent")  # whether the force is filtered and not the wave
    splits = has("kind", "complementary")  # whether waves both ways are low-pass filtered, too

    def conflicts(self) -> list[str]:
        """Check that the filter is given once, and that not the whole wave is answered at once."""
        if self.alpha is not None and self.cutoff_hz is not None:
            return ["alpha and cutoff_hz are given: a velocity filter takes one of them"]
        if self.alpha is not None and (self.order != 1 or self.splits):
            return [f"alpha = {self.alpha}: needs order = 1 and kind = equivalent or exact"]
        if self.in_force and self.share > 0.5:
            return [f"share = {self.share}: must be <= 0.5 with kind = equivalent, 1 - 2 share H"]
        whole = self.order == 1 and self.kind == "exact" and self.cutoff_hz is None
        if whole and self.share >= 1.0:
            return [f"share = {self.share}: must be < 1 for (z - 1)/(z - alpha)"]
        return []


@dataclass(frozen=True)
class LocalModelParams(Validated):
    """A spring and damper to ground."""

    stiffness: float = parameter(500.0, "0..1e6 N/m", "stiffness")
    damping: float = parameter(1.0, "0..10000 N s/m", "damping")
    acts: str = parameter(
        "everywhere", ("everywhere", "above", "below"),
        "everywhere, or while the device is above or below begins_m along axis 0",
    )  # fmt: skip
    begins_m: float = parameter(0.0, "-10..10 m", "position of the device at which it begins")


@dataclass(frozen=True)
class BankParams(Validated):
    """Filter bank with a local model on its high-pass wave (App. E; edges of its Table 1)."""

    kind: str = fixed(
        "none",
        ("none", "dissertation", "complementary"),
        "dissertation: HP to the local model, LP2 on its way back; complementary: a pair of "
        "filters that is passive by construction",
    )
    high_stop_hz: float = fixed(40.0, "> 0 Hz", "HP: edge of the stop band")
    high_stop_db: float = fixed(40.0, "> 0 dB", "HP: attenuation at high_stop_hz")
    high_pass_hz: float = fixed(70.0, "> 0 Hz", "HP: edge of the pass band")
    high_pass_db: float = fixed(20.0, "> 0 dB", "HP: attenuation at high_pass_hz")
    low_pass_hz: float = fixed(300.0, "> 0 Hz", "LP2: edge of the pass band")
    low_pass_db: float = fixed(1.0, "> 0 dB", "LP2: attenuation at low_pass_hz")
    low_stop_hz: float = fixed(
        600.0, "> 0 Hz", "LP2: edge of the stop band; above half the tick rate for the order only"
    )
    low_stop_db: float = fixed(40.0, "> 0 dB", "LP2: attenuation at low_stop_hz")
    split_rad_s: float = fixed(20.0, "> 0 and <= 2000 rad/s", "complementary: pole of both")

    is_on = lacks("kind", "none")
    as_published = has("kind", "dissertation")  # not passive by construction

    @property
    def lag_s(self) -> float:
        """Time by which the pair of filters delays slow motion once around [s]."""
        return 2.0 / float(self.split_rad_s) if self.kind == "complementary" else 0.0

    def conflicts(self) -> list[str]:
        """Check that the edges are in order."""
        return disordered(
            self, ("high_stop_hz", "high_pass_hz"), ("low_pass_hz", "low_stop_hz"),
            ("high_pass_db", "high_stop_db"), ("low_pass_db", "low_stop_db"),
        )  # fmt: skip


@dataclass(frozen=True)
class PositionParams(Validated):
    """Position feedback on the returning wave, v_m - K_p (x_m - x_s) (App. E, Eq. 3)."""

    feedback: str = fixed(
        "budgeted",
        ("none", "printed", "budgeted", "integral"),
        "none; printed: without regard to energy; budgeted: no more than the energy tank holds; "
        "integral: likewise, towards the integral of the waves",
    )
    gain: float = parameter(0.0, "0..200 sqrt(W)/m", "K_p (0: off)")
    adapts: bool = parameter(
        False,
        "-",
        "budgeted, integral: K_p = 0.5 sqrt(2b)/tau, tau the measured round trip, up to twice "
        "that as the stored energy falls (strict channel); gain holds until the first answer",
    )
    storage_j: float = fixed(
        0.0, "0..1 J", "budgeted, integral: energy lent at the start, E0, the port's storage"
    )
    most_j: float = parameter(
        0.05, "0..10 J", "budgeted, integral: largest tank (0.05 J move 0.25 kg with 0.6 m/s)"
    )

    def conflicts(self) -> list[str]:
        """Check that the storage fits into what may be kept, and who adapts."""
        found = []
        if self.storage_j > self.most_j:
            found.append(f"storage_j = {self.storage_j}: must be <= most_j = {self.most_j}")
        if self.as_published and self.adapts:
            found.append("adapts = true: needs feedback = budgeted or integral")
        return found

    @property
    def is_on(self) -> bool:
        """Tell whether anything is fed back, in any run."""
        return self.feedback != "none" and (self.adapts or bool(self.gain > 0.0))

    @property
    def is_paid(self) -> bool:
        """Whether what is fed back is paid out of an account of energy; not as published."""
        return self.is_on and not self.as_published

    as_published = has("feedback", "printed")  # as in the dissertation: it pays for nothing
    of_residual = has("feedback", "integral")  # of displacements, not the position error
