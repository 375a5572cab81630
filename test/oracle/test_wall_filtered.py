# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""The noise experiment of App. D (Figs. 8 to 10), simulated: what each velocity filter makes of an
encoder's noise in the force, and of following the wall at 5 Hz. With the printed filter and the
inappropriate one: ``test_reproduction.py``.
"""

import numpy as np
import pytest
from support import plain as scenarios

from pmwvc_analysis.budget.energy import user_energies
from pmwvc_core.simulation.session import simulate

FREQUENCY_HZ = 5.0
SETTLED = 3000  # ticks at the end, whole periods
EXACT = ("order=2", "share=0.7")
PRINTED = ("order=1", "share=0.5", "alpha=0.929")
FORMS = {
    "none": ("kind=none",),
    "exact": ("kind=exact", *EXACT),
    "equivalent, as printed": ("kind=equivalent", *PRINTED),
    "complementary": ("kind=complementary", "order=1", "share=1.0"),
}


@pytest.fixture(scope="module")
def sessions():
    loaded = [
        scenarios.load(
            "wall_filtered", settings_texts=[f"master.velocity_filter.{text}" for text in texts]
        )
        for texts in FORMS.values()
    ]
    return dict(zip(FORMS, simulate(loaded), strict=True))


def noise(traces):
    """Return the power of the force above 50 Hz [N^2]; the wall answers at 50 Hz."""
    f = traces.users[0].f_m[-SETTLED:, 0] * np.hanning(SETTLED)
    spectrum = np.abs(np.fft.rfft(f)) ** 2
    return float(spectrum[np.fft.rfftfreq(SETTLED, 1e-3) > 50.0].sum())


def tracking(traces):
    """Return |F_m - F_s|/|F_s| at 5 Hz."""
    user, server = traces.users[0], traces.server
    time_s = user.time_s[-SETTLED:]
    step = np.searchsorted(server.time_s, time_s + 1e-9) - 1
    turn = np.exp(-2j * np.pi * FREQUENCY_HZ * time_s)
    f_m, f_s = (
        np.mean(values * turn) for values in (user.f_m[-SETTLED:, 0], server.f_s[0][step, 0])
    )
    return float(abs(f_m - f_s) / abs(f_s))


def test_noise_falls_at_least_tenfold_at_equal_tracking(sessions):
    plain, filtered = sessions["none"], sessions["exact"]
    assert noise(plain) / noise(filtered) > 25.0
    assert tracking(filtered) <= tracking(plain)
    (energy,) = user_energies(filtered)
    assert energy.passive


def test_the_equivalent_form_is_quieter_and_not_passive(sessions):
    found = sessions["equivalent, as printed"]
    assert noise(sessions["none"]) / noise(found) > 200.0
    assert tracking(found) < 0.5 * tracking(sessions["none"])
    (energy,) = user_energies(found)
    assert not energy.passive
    assert found.users[0].accounts["force_velocity_filter"][-1] < -0.05


def test_a_pair_that_is_passive_by_itself_is_quiet_and_follows_later(sessions):
    found = sessions["complementary"]
    assert noise(sessions["none"]) / noise(found) > 100.0
    assert found.users[0].accounts["velocity_filter"].min() >= 0.0
    assert tracking(found) > tracking(sessions["none"])
