// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The session as the server declares it, and the rows of the last seconds: SI units throughout.

export const HISTORY_S = 10;
const PACKETS = 8192;

export class Session {
  constructor(declared) {
    Object.assign(this, declared);
    this.columns = new Map();
    this.width = 0;
    for (const [name, count] of declared.layout.columns) {
      this.columns.set(name, this.width);
      this.width += count;
    }
    this.packetWidth = declared.layout.packet.reduce((sum, [, count]) => sum + count, 0);
    this.capacity = Math.ceil((HISTORY_S + 1) / declared.snapshot_s);
    this.rows = new Float64Array(this.capacity * this.width);
    this.packets = new Float64Array(PACKETS * this.packetWidth);
    this.text = { verdict: "", level: "unknown", users: {}, notices: [] };
    this.clear();
  }

  /** Forget what was before: time was turned back. */
  clear() {
    this.count = 0;
    this.packetCount = 0;
  }

  /** Take a snapshot in; return its number and the packets that came with it. */
  take(numbers) {
    const time_s = numbers[this.columns.get("time_s")];
    if (this.count && time_s < this.time_s) this.clear();
    const again = this.count > 0 && time_s === this.time_s; // paused: the same row again
    if (!again) this.count += 1;
    this.rows.set(numbers.subarray(0, this.width), this.start(0));
    const packets = [];
    for (let at = this.width; at < numbers.length; at += this.packetWidth) {
      const [link, , sent, arrived, fate] = numbers.subarray(at, at + this.packetWidth);
      this.packets.set(numbers.subarray(at, at + this.packetWidth), this.packetStart(this.packetCount++));
      packets.push({ link, sent, arrived, fate });
    }
    return { seq: numbers[this.columns.get("seq")], packets };
  }

  /** Where the row `age` snapshots ago begins. */
  start(age) { return ((this.count - 1 - age) % this.capacity) * this.width; }

  packetStart(number) { return (number % PACKETS) * this.packetWidth; }

  /** Rows that can be read: the newest has age 0. */
  get length() { return Math.min(this.count, this.capacity); }

  get packetsFrom() { return Math.max(0, this.packetCount - PACKETS); }

  get time_s() { return this.count ? this.rows[this.start(0) + this.columns.get("time_s")] : NaN; }

  /** Newest value of a column; NaN where it is not known or there is no row yet. */
  value(column, axis = 0) {
    return this.count ? this.rows[this.start(0) + this.columns.get(column) + axis] : NaN;
  }

  /** A vector in space; of six axes the last three are a turn. */
  vector(column, axes = Math.min(this.dof, 3)) {
    return Array.from({ length: axes }, (_, axis) => this.value(column, axis));
  }

  /** Contacts in a scene: points [m], and forces on one of both bodies [N]. */
  contacts() {
    if (!this.columns.has("contacts")) return [];
    const at = (from) => Array.from({ length: 3 }, (_, axis) => this.value("contacts", from + axis));
    return Array.from({ length: 8 }, (_, i) => ({ point: at(6 * i), force: at(6 * i + 3) })).filter(({ point }) => Number.isFinite(point[0]));
  }

  /** Where a user's handle is [m]; null where that is not known: its master sent nothing yet, or nothing any more. */
  place(user) {
    const found = this.vector(`${user}.x_m`, this.dof);
    return found.every(Number.isFinite) ? found : null;
  }

  /** Energy into a direction of a user's link less energy out of it [J], `age` snapshots ago. */
  balance(user, way, age = 0) {
    const at = this.count ? this.start(age) : NaN;
    return this.rows[at + this.columns.get(`${user}.energy_${way}_in`)]
      - this.rows[at + this.columns.get(`${user}.energy_${way}_out`)];
  }

  /** Length of a vector, not known where one of its values is not. */
  size(column) { return Math.hypot(...this.vector(column)); }

  held(user) { return this.value(`${user}.held`) === 1; }
}
