// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The session in words: the verdict, the price of the delay, and what a screen reader reads out. It
// hears of a change of state or verdict soon, of the force only now and then.

import { milli, number, spaced, stateOf } from "./words.js";

const at = (id) => document.getElementById(id);
const TONES = { bad: "alarm", caution: "caution", good: "quiet", unknown: "quiet" };
const STATE_MS = 1000, FORCE_MS = 8000;
const REST_M_S = 0.01, REST_N = 0.05;

export class Spoken {
  constructor(session) {
    Object.assign(this, { session, states: "", said_ms: 0, priced_ms: 0, force: NaN });
    this.told();
  }

  /** The server's own sentences: verdict and notices. */
  told() {
    const { verdict, level, notices } = this.session.text;
    at("verdict").textContent = verdict || "Waiting for the first seconds.";
    at("verdict").dataset.tone = TONES[level] ?? "quiet";
    notice(notices.join(" "));
  }

  draw() {
    const now_ms = performance.now();
    if (now_ms - this.priced_ms > 250) { this.priced_ms = now_ms; this.price(); }
    if (now_ms - this.said_ms > STATE_MS) this.speak(now_ms);
  }

  /** Device ahead of its avatar, against F tau/(2b), which holds at rest only. */
  price() {
    const { session } = this;
    const parts = session.users.map((user) => priceOf(session, user)).filter(Boolean);
    at("price").replaceChildren(...parts.flatMap((part, i) => (i ? [" \u2003", part] : [part])));
  }

  speak(now_ms) {
    const { session } = this;
    const states = [session.text.verdict, ...session.users.map(({ name, remote }) => {
      const { state, reason } = stateOf(session, name);
      return `${spaced(name)} ${reason || state}${remote ? (session.held(name) ? ", held" : ", not held") : ""}`;
    })].join(". ");
    const forces = session.users.map(({ name }) => session.size(`${name}.f_applied`));
    const most = Math.max(0, ...forces.filter(Number.isFinite));
    const felt = Math.abs(most - this.force) > 0.3 || Number.isNaN(this.force);
    if (states === this.states && !(felt && now_ms - this.said_ms > FORCE_MS)) return;
    Object.assign(this, { states, force: most, said_ms: now_ms });
    const words = session.users.map(({ name }, i) => `${spaced(name)} ${number(forces[i], 1)} newtons`);
    at("spoken").textContent = `${states}. Force: ${words.join(", ")}.`;
  }
}

/** Show a sentence that a person has to see; none hides it. */
export function notice(text) {
  at("notice").textContent = text;
  at("notice").hidden = !text;
}

function priceOf(session, { name, impedance, side }) {
  const ahead = session.vector(`${name}.x_m`).map((x, axis) => x - session.value(`${name}.x_s`, axis));
  const speeds = [session.size(`${name}.xd_m`), session.size(`${name}.xd_s`)];
  const force = session.vector(`${name}.f_applied`);
  const least = session.value(`${name}.f_min`), most = session.value(`${name}.f_max`);
  const still = speeds.every((speed) => speed < REST_M_S) && most - least < REST_N;
  const first = document.createElement("span");
  const amount = document.createElement("b");
  const ahead_m = -side * ahead[0];
  amount.textContent = `${milli(Math.abs(ahead_m))} mm`;
  first.append(`${spaced(name)}: device `, amount, ahead_m < 0 ? " behind its avatar" : " ahead of its avatar");
  const expected_m = (-side * force[0] * session.value(`${name}.lag`)) / (2 * impedance);
  if (still && Number.isFinite(expected_m)) first.append(`; F\u202f\u03c4/2b says ${milli(expected_m)} mm`);
  return Number.isFinite(ahead[0]) ? first : null;
}
