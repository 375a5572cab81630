// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A gamepad as the hand: while A (or the right trigger) is pressed the left stick moves the handle,
// the right stick along the third axis; the rumble is the force on the hand, and its change.

import { free } from "./inputs.js";

const HOLD = [0, 7]; // buttons: A, right trigger
const DEAD = 0.12; // of a stick at rest
const SPEED_M_S = 0.2;
const RUMBLE_S = 0.06;

const stick = (value) => (Math.abs(value) < DEAD ? 0 : value);

function pressed(pad) { return HOLD.some((button) => pad.buttons[button]?.pressed); }

export function gamepad(hand, session) {
  let rumbled_s = 0, before_n = 0;
  hand.moves.push((dt) => {
    const pad = [...navigator.getGamepads()].find((each) => each?.connected);
    if (!pad) { hand.release("gamepad"); return null; }
    if (!pressed(pad)) { hand.release("gamepad"); return null; }
    if (!hand.held && hand.pending !== "gamepad") hand.take(hand.index ?? free(session), "gamepad");
    if (hand.by !== "gamepad") return null;
    rumble(pad);
    const [x, y, , z] = [0, 1, 2, 3].map((axis) => stick(pad.axes[axis] ?? 0));
    return [x, -y, -z].map((each) => each * SPEED_M_S * dt);
  });

  function rumble(pad) {
    const now_s = performance.now() / 1e3;
    if (!pad.vibrationActuator?.playEffect || now_s - rumbled_s < RUMBLE_S) return;
    rumbled_s = now_s;
    const { name, force_limit } = hand.user;
    const force_n = session.size(`${name}.f_applied`) || 0;
    const change = Math.abs(force_n - before_n) / (force_limit || 8);
    before_n = force_n;
    pad.vibrationActuator.playEffect("dual-rumble", {
      duration: 1e3 * RUMBLE_S * 1.5, startDelay: 0,
      strongMagnitude: Math.min(1, force_n / (force_limit || 8)), weakMagnitude: Math.min(1, 4 * change),
    });
  }
}
