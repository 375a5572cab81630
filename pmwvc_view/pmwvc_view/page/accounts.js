// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The energy account of every user and direction: a bar to either side of zero. Below zero it is
// red, hatched, with a note; the lowest value so far stays in words.

import { energy, spaced } from "./words.js";

const WAYS = { up: "up", down: "down", hand: "total" };
const OF_WAYS = "energy into each direction less energy out of it; never below zero: passive";
const OF_LINK = "energy into a user's link from both ends less energy out of it; never below zero: passive";
const WRITE_MS = 120;
const LEAST_J = 2e-3; // full length of a bar at least
const ROUNDING_J = 1e-5; // below zero by less is arithmetic

export class Accounts {
  constructor(container, session) {
    this.session = session;
    this.written_ms = 0;
    this.full_j = LEAST_J;
    const users = session.users.map(({ name }, index) => Object.keys(WAYS).map((way) => this.row(name, index, way)));
    this.rows = users.flat();
    container.replaceChildren(...users.map((rows) => {
      const group = document.createElement("div");
      group.append(...rows.map(({ root }) => root));
      return group;
    }));
  }

  row(name, index, way) {
    const root = document.createElement("div");
    root.className = "account";
    root.innerHTML = '<span class="who"><span class="dot"></span><span></span></span>'
      + '<span class="track"><span class="level"></span><span class="zero"></span></span><output></output>';
    const [who, track, output] = root.children;
    who.firstChild.style.setProperty("background", `var(--u${index % 8})`);
    who.lastChild.textContent = `${spaced(name)} ${WAYS[way]}`;
    return { root, name, way, level: track.firstChild, output };
  }

  draw() {
    const now_ms = performance.now();
    if (now_ms - this.written_ms < WRITE_MS) return;
    this.written_ms = now_ms;
    const found = this.rows.map(({ name, way }) => ({
      now: this.session.balance(name, way), least: this.session.value(`${name}.energy_${way}_min`),
    }));
    const most = Math.max(LEAST_J, ...found.map(({ now }) => (Number.isFinite(now) ? Math.abs(now) : 0)));
    if (most > this.full_j || most < 0.3 * this.full_j) this.full_j = 1.6 * most;
    found.forEach((each, i) => this.write(this.rows[i], each));
    const shown = this.rows.filter(({ root }) => !root.hidden);
    const what = shown.some(({ way }) => way !== "hand") ? OF_WAYS : OF_LINK;
    document.getElementById("accounts-what").textContent = shown.length ? what : "not known yet";
  }

  write({ root, level, output }, { now, least }) {
    root.hidden = !Number.isFinite(now); // without waves there is no account of either direction
    const ratio = Number.isFinite(now) ? Math.min(1, Math.abs(now) / this.full_j) : 0;
    const below = now < -ROUNDING_J;
    level.style.setProperty("width", `${50 * ratio}%`);
    level.style.setProperty("left", `${below ? 50 - 50 * ratio : 50}%`);
    level.dataset.sign = below ? "negative" : "";
    const was = least < -ROUNDING_J;
    output.dataset.sign = was ? "negative" : "";
    output.textContent = Number.isFinite(now) ? `${energy(now)}${was && least < 1.02 * now ? `, lowest ${energy(least)}` : ""}` : "not known";
  }
}
