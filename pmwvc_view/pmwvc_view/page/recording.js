// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A recorded session that stands in the page itself, in place of a connection: the same messages,
// without a server.

import { HISTORY_S } from "./session.js";

const FASTEST = 4;
const EPSILON_S = 1e-6;

const numbers = (text) => new Float32Array(Uint8Array.from(atob(text), (each) => each.charCodeAt(0)).buffer);

export class Recording {
  /** `on`: functions by kind of message; `recorded`: what the page holds. */
  constructor(on, { declared, texts, rows, packets }) {
    Object.assign(this, { on, declared, texts, isOpen: true, time_s: declared.start_s, ratio: 1, paused: true, shown: -1 });
    const values = (columns) => columns.reduce((sum, [, count]) => sum + count, 0);
    const { columns, packet } = declared.layout;
    const split = (all, width) => Array.from({ length: all.length / width }, (_, i) => all.subarray(i * width, (i + 1) * width));
    this.rows = split(numbers(rows), values(columns));
    this.packets = split(numbers(packets), values(packet)); // in the order of their sending
    this.seq = 0;
    const sent = packet.findIndex(([name]) => name === "sent"), time = columns.findIndex(([name]) => name === "time_s");
    let next = 0;
    this.ends = this.rows.map((row) => { // packets sent up to each row
      while (next < this.packets.length && this.packets[next][sent] <= row[time] + EPSILON_S) next += 1;
      return next;
    });
    setTimeout(() => this.begin());
  }

  begin() {
    this.on.open();
    this.on.session(this.declared);
    this.before_ms = performance.now();
    setInterval(() => this.tick(), 1e3 * this.declared.snapshot_s);
    this.tick();
    this.on.play({ paused: this.paused, ratio: this.ratio });
  }

  /** Let time pass, and show what came since. */
  tick() {
    const now_ms = performance.now(), { duration_s } = this.declared;
    if (!this.paused) {
      this.time_s = Math.min(duration_s, this.time_s + 1e-3 * (now_ms - this.before_ms) * this.ratio);
      if (this.time_s >= duration_s) this.play(true);
    }
    this.before_ms = now_ms;
    const last = this.at();
    if (this.shown > last) this.shown = last - 1; // time was turned back
    while (this.shown < last) this.show(this.shown += 1);
  }

  /** Number of the row at the present time. */
  at() { return Math.min(this.rows.length - 1, Math.floor(this.time_s / this.declared.snapshot_s + EPSILON_S)); }

  show(index) {
    const packets = this.packets.slice(this.ends[index - 1] ?? 0, this.ends[index]);
    const row = Float64Array.from([...this.rows[index], ...packets.flatMap((each) => [...each])]);
    row[0] = this.seq += 1;
    this.on.snapshot(row);
    const text = this.texts.findLast(([from]) => from <= index)[1];
    if (text !== this.text) this.on.text({ kind: "text", ...(this.text = text) });
  }

  play(paused) {
    this.paused = paused;
    this.on.play({ paused, ratio: this.ratio });
  }

  send() {}

  /** Do what the page asks for; a promise of the answer, as a connection gives it. */
  request(kind, fields) {
    const { duration_s } = this.declared;
    if (kind === "pause") {
      if (!fields.paused && this.time_s >= duration_s) this.time_s = 0;
      this.play(fields.paused);
    } else if (kind === "seek") {
      this.time_s = Math.max(0, Math.min(duration_s, fields.time_s));
      this.shown = Math.max(0, this.at() - Math.round(HISTORY_S / this.declared.snapshot_s)) - 1;
    } else if (kind === "speed") {
      this.ratio = Math.min(FASTEST, fields.ratio);
    } else return Promise.resolve({ done: false, text: "not in this session" });
    return Promise.resolve({ done: true, text: "" });
  }
}
