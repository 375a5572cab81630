// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Strips: signals over the last seconds, each on a canvas of its own, with values beside its title.
// They are drawn in turn, as many as a frame has time for: all at once would cost the frame rate.

import { HISTORY_S } from "./session.js";
import { label, line } from "./shapes.js";
import { fitted, theme } from "./theme.js";
import { number } from "./words.js";

const BUDGET_MS = 5;
const LEFT_PX = 44; // for the numbers of the scale

export class Strips {
  /** `signals`: what is drawn, see signals.js. */
  constructor(container, session, signals) {
    this.session = session;
    this.turn = 0;
    container.replaceChildren();
    this.strips = signals.map((signal) => new (signal.ticks ? Ticks : Strip)(container, session, signal));
  }

  /** Draw the strips whose turn it is, of one axis. */
  draw(axis) {
    const until_ms = performance.now() + BUDGET_MS;
    for (let i = 0; i < this.strips.length; i += 1) {
      this.strips[this.turn].turned(axis);
      this.strips[this.turn].draw(axis);
      this.turn = (this.turn + 1) % this.strips.length;
      if (performance.now() > until_ms) return;
    }
  }
}

/** The frame of a strip: title, unit, values, canvas. */
class Frame {
  constructor(container, session, signal) {
    Object.assign(this, { session, signal, given: signal, axis: 0 });
    const section = document.createElement("section");
    section.className = "strip";
    section.dataset.size = signal.size ?? "";
    const header = document.createElement("header");
    this.title = document.createElement("h3");
    this.name();
    this.legend = document.createElement("div");
    this.legend.className = "legend";
    header.append(this.title, this.legend);
    this.canvas = document.createElement("canvas");
    this.canvas.setAttribute("role", "img");
    this.canvas.setAttribute("aria-label", `${signal.title} over the last ${signal.window_s ?? HISTORY_S} seconds`);
    section.append(header, this.canvas);
    container.append(section);
  }

  /** Write title and unit: of axes 4 to 6 those of a turn. */
  name() {
    this.signal = { ...this.given, ...(this.axis > 2 ? this.given.turn : {}) };
    const unit = document.createElement("span");
    unit.className = "unit";
    unit.textContent = ` ${this.signal.unit}`;
    this.title.replaceChildren(this.signal.title, unit);
  }

  /** Show another axis. */
  turned(axis) {
    if (axis === this.axis) return;
    this.axis = axis;
    this.name();
  }

  /** An entry of the legend; returns the element that takes the value. */
  entry({ name, colour, dash, silent }) {
    const item = document.createElement("span");
    const key = document.createElement("span");
    key.className = "key";
    key.style.setProperty("border-color", `var(--${colour})`);
    if (dash) key.dataset.dash = "";
    const value = document.createElement("b");
    item.append(key, `${name} `, ...(silent ? [] : [value]));
    this.legend.append(item);
    return value;
  }
}

class Strip extends Frame {
  constructor(container, session, signal) {
    super(container, session, signal);
    this.low = 0;
    this.high = signal.least;
    this.written_ms = 0;
    this.shown = signal.lines.filter(({ hidden }) => !hidden);
    this.values = this.shown.map((each) => this.entry(each));
  }

  draw(axis) {
    const { session, signal } = this;
    const { context, width, height } = fitted(this.canvas);
    context.clearRect(0, 0, width, height);
    if (!session.length) return;
    this.range(axis);
    const span = this.high - this.low || 1;
    const y = (value) => 4 + (height - 8) * (1 - (value - this.low) / span);
    const now_s = session.time_s, from = session.columns.get("time_s");
    const x = (at) => width - (width - LEFT_PX) * ((now_s - session.rows[at + from]) / HISTORY_S);
    this.scale(context, width, y);
    context.save();
    context.beginPath();
    context.rect(LEFT_PX, 0, width - LEFT_PX, height);
    context.clip();
    for (const each of signal.lines) if (each.low) this.band(context, each, axis, x, y);
    for (const each of signal.lines) this.line(context, each, axis, x, y);
    context.restore();
    this.write(axis);
  }

  /** Follow the signals' range: widen at once, narrow slowly. */
  range(axis) {
    const { session, signal } = this;
    let low = signal.floor ?? Infinity, high = signal.floor === undefined ? -Infinity : signal.least;
    for (let age = 0; age < session.length; age += 1) {
      const at = session.start(age);
      for (const each of signal.lines) {
        const least = (each.low ?? each.value)(at, axis), most = (each.high ?? each.value)(at, axis);
        if (least < low) low = least;
        if (most > high) high = most;
      }
    }
    if (!(high >= low)) return;
    const middle = (low + high) / 2, half = Math.max((high - low) / 2, signal.least / 2) * 1.08;
    [low, high] = signal.floor === undefined ? [middle - half, middle + half] : [low < 0 ? low * 1.08 : 0, Math.max(high * 1.08, signal.least)];
    const [slow, fast] = [0.05, 1];
    this.low += (low < this.low ? fast : slow) * (low - this.low);
    this.high += (high > this.high ? fast : slow) * (high - this.high);
  }

  scale(context, width, y) {
    const step = rounded((this.high - this.low) / 4.5);
    const decimals = Math.max(0, -Math.floor(Math.log10(step * this.signal.factor) + 1e-9));
    for (let i = Math.ceil(this.low / step); i * step <= this.high; i += 1) {
      const at = Math.round(y(i * step)) + 0.5;
      line(context, [[LEFT_PX, at], [width, at]], i === 0 ? theme.target : theme.grid);
      label(context, number(i * step * this.signal.factor, decimals), LEFT_PX - 7, at, { size: 11, align: "right" });
    }
  }

  /** Least and greatest value of each row: what happens within it cannot hide between two rows. */
  band(context, each, axis, x, y) {
    const { session } = this;
    context.fillStyle = theme[each.colour] ?? theme.users[Number(each.colour.slice(1))];
    context.globalAlpha = 0.3;
    context.beginPath();
    for (let age = session.length - 1; age >= 0; age -= 1) {
      const at = session.start(age);
      context.lineTo(x(at), y(each.high(at, axis)));
    }
    for (let age = 0; age < session.length; age += 1) {
      const at = session.start(age);
      context.lineTo(x(at), y(each.low(at, axis)));
    }
    context.fill();
    context.globalAlpha = 1;
  }

  line(context, each, axis, x, y) {
    const { session } = this;
    const colour = theme[each.colour] ?? theme.users[Number(each.colour.slice(1))];
    let points = [], red = null;
    const flush = () => {
      if (points.length) line(context, points, red ? theme.alarm : colour, { width: red ? 2.4 : 1.6, dash: each.dash ? [2, 3] : [] });
    };
    for (let age = session.length - 1; age >= 0; age -= 1) {
      const at = session.start(age), value = each.value(at, axis);
      const below = Boolean(this.signal.alarm && value < -this.signal.alarm);
      if (Number.isFinite(value) && below !== red) {
        const joint = points.at(-1);
        flush();
        points = joint ? [joint] : [];
        red = below;
      }
      if (Number.isFinite(value)) points.push([x(at), y(value)]);
      else { flush(); points = []; }
    }
    flush();
  }

  /** Values beside the title, four times a second: figures that flicker cannot be read. */
  write(axis) {
    const now_ms = performance.now();
    if (now_ms - this.written_ms < 250) return;
    this.written_ms = now_ms;
    const { session, signal } = this;
    const at = session.start(0);
    this.shown.forEach((each, i) => { this.values[i].textContent = number(signal.factor * each.value(at, axis), signal.decimals); });
  }
}

/** One tick per packet: delivered ones short, others tall and in the colour of the alarm. */
class Ticks extends Frame {
  constructor(container, session, signal) {
    super(container, session, signal);
    this.count = document.createElement("span");
    this.legend.append(this.count);
    this.canvas.style.setProperty("height", `${Math.max(54, 24 * session.users.length)}px`);
    this.written_ms = 0;
  }

  draw() {
    const { session, signal } = this;
    const { context, width, height } = fitted(this.canvas);
    context.clearRect(0, 0, width, height);
    const links = 2 * session.users.length, row = height / links;
    const colours = session.users.map((_, i) => theme.users[i]);
    let lost = 0, all = 0;
    session.users.forEach((_, user) => ["up", "down"].forEach((way, i) => {
      if (row >= 9) label(context, `${user + 1} ${way}`, 0, (2 * user + i + 0.5) * row, { size: 11 });
    }));
    for (let number = session.packetCount - 1; number >= session.packetsFrom; number -= 1) {
      const at = session.packetStart(number);
      const [link, , sent, arrived] = session.packets.subarray(at, at + session.packetWidth);
      const age_s = session.time_s - sent;
      if (age_s > 3 * signal.window_s) break;
      const x = Math.round(width - (width - LEFT_PX) * (age_s / signal.window_s));
      if (x < LEFT_PX) continue;
      const fine = Number.isFinite(arrived);
      all += 1;
      if (!fine) lost += 1;
      context.fillStyle = fine ? colours[link >> 1] : theme.alarm;
      context.globalAlpha = fine ? 0.5 : 1;
      const tall = fine ? 0.4 * row : 0.9 * row;
      context.fillRect(x, (link + 0.5) * row - tall / 2, fine ? 1 : 2.5, tall);
    }
    context.globalAlpha = 1;
    const now_ms = performance.now();
    if (now_ms - this.written_ms < 500) return;
    this.written_ms = now_ms;
    this.count.textContent = all ? `${lost} of ${all} did not arrive` : "none known";
  }
}

/** A step of 1, 2 or 5 times a power of ten, not below `step`. */
function rounded(step) {
  const power = 10 ** Math.floor(Math.log10(step));
  return power * [1, 2, 5, 10].find((each) => each * power >= 0.999 * step);
}
