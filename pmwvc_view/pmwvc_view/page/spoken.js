// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The session in words: verdict and notices, and what a screen reader reads out: a change of state
// or verdict soon, the force only now and then.

import { number, spaced, stateOf } from "./words.js";

const at = (id) => document.getElementById(id);
const TONES = { bad: "alarm", caution: "caution", good: "quiet", unknown: "quiet" };
const STATE_MS = 1000, FORCE_MS = 8000, NOTICE_MS = 8000;

export class Spoken {
  constructor(session) {
    Object.assign(this, { session, states: "", spoken_ms: 0, force: NaN });
    this.report();
  }

  /** The server's own sentences: verdict and notices. */
  report() {
    const { verdict, level, notices } = this.session.text;
    at("verdict").textContent = verdict || "Waiting for the first seconds.";
    at("verdict").dataset.tone = TONES[level] ?? "quiet";
    lasting = notices.join(" ");
    show();
  }

  draw() {
    const now_ms = performance.now();
    if (now_ms - this.spoken_ms > STATE_MS) this.speak(now_ms);
  }

  speak(now_ms) {
    const { session } = this;
    const states = [session.text.verdict.replace(/\.$/, ""), ...session.users.map(({ name, remote }) => {
      const { state, reason } = stateOf(session, name);
      return `${spaced(name)} ${reason || state}${remote ? (session.held(name) ? ", held" : ", not held") : ""}`;
    })].join(". ");
    const forces = session.users.map(({ name }) => session.size(`${name}.f_applied`));
    const most = Math.max(0, ...forces.filter(Number.isFinite));
    const changed = Math.abs(most - this.force) > 0.3 || Number.isNaN(this.force);
    if (states === this.states && !(changed && now_ms - this.spoken_ms > FORCE_MS)) return;
    Object.assign(this, { states, force: most, spoken_ms: now_ms });
    const words = session.users.map(({ name }, i) => `${spaced(name)} ${Number.isFinite(forces[i]) ? `${number(forces[i], 1)} newtons` : "not known"}`);
    at("spoken").textContent = `${states}. Force: ${words.join(", ")}.`;
  }
}

let lasting = "", passing = "", over = "", timer = 0;

/** Show from now on that the session is over; "" where it goes on. */
export function ended(text) {
  over = text;
  document.body.toggleAttribute("data-over", Boolean(text));
  show();
}

/** Show for a while a sentence that a person has to see: why something was refused. */
export function notice(text) {
  passing = text;
  clearTimeout(timer);
  timer = setTimeout(() => { passing = ""; show(); }, NOTICE_MS);
  show();
}

function show() {
  const text = over || passing || lasting;
  at("notice").textContent = text;
  at("notice").hidden = !text;
}
