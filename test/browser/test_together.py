# SPDX-FileCopyrightText: 2026 PMWVC contributors
# SPDX-License-Identifier: Apache-2.0
"""Two people in two browsers: they carry the cube, and one of them goes away."""

import numpy as np
from playwright.sync_api import expect
from support.page_server import served
from support.pages import Pointer

SLEW_N_PER_TICK = 0.2  # a grip of 1 N let go at once would be a step five times as large


def test_two_browsers_carry_cube_and_one_that_closes_lets_go_gently(visit):
    with served(["safety.max_slew=200"]) as live:
        pages = [visit(live.address), visit(live.address)]
        pointers = [Pointer(page, user) for user, page in enumerate(pages)]
        for pointer, inwards_m in zip(pointers, (0.025, -0.025), strict=True):
            pointer.press()
            pointer.move(inwards_m)
        touching = ("user1.contact", "user2.contact")
        live.until(lambda: all(live.now(each) == 1.0 for each in touching), "a grip")
        start_m, since = live.now("object.x_o"), live.count
        for _ in range(20):
            for pointer in pointers:
                pointer.move(0.0035, steps=1)
        carried = lambda: live.now("object.x_o") > start_m + 0.05  # noqa: E731
        live.until(carried, "a cube 50 mm further on")
        rows = live.count - since
        way_m = np.diff(live.series("object.x_o", since)[:rows])
        held = live.series("user2.contact", since)[1:rows] == 1.0
        assert way_m[held].sum() > 0.005  # not pushed by one alone

        other = pages[0].locator("[data-user=user2] .name")
        expect(other).to_contain_text("another browser")
        expect(pages[0].locator("[data-user=user2] button")).to_be_hidden()
        pages[1].context.close()
        live.until(lambda: live.now("user2.held") == 0.0, "an open hand")
        expect(other).to_contain_text("free")
        live.until(lambda: abs(live.now("user2.f_applied")) < 0.1, "no force")
        for user in ("user1", "user2"):
            steps = np.abs(np.diff(live.forces(user)))
            assert 0.0 < steps.max() <= SLEW_N_PER_TICK * (1.0 + 1e-9)
