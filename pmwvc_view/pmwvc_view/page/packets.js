// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Packets on their way between hand and server, drawn slower than they are: one of many, so that
// as much of each link is seen as of the others. A packet that is lost ends half-way as a cross.
// What became of a packet is known later than the packet was sent in a live session: there all are
// drawn late by the same time, so they set out as evenly as they were sent.

import { disc, line } from "./shapes.js";
import { theme } from "./theme.js";

export const SLOWER = 25;
const SPACING_S = 0.22; // on the screen
const LEAST_S = 0.15; // of a journey on the screen
const FADE_S = 0.6; // of a lost one
const LATE_S = 0.15; // drawn after they were sent, in a live session; longer where it takes longer
const REPORT_S = 0.1; // between two reports of what became of packets

export class PacketFlow {
  constructor(live) {
    Object.assign(this, { live, shown: [], last: new Map(), delay_s: new Map() });
  }

  /** How late packets are drawn [s]. */
  get late_s() {
    if (!this.live) return 0;
    return Math.max(LATE_S, REPORT_S + Math.max(0, ...this.delay_s.values()));
  }

  /** Take packets in that came with a row of the session's time `time_s`. */
  take(packets, now_s, time_s) {
    const late_s = this.late_s;
    for (const { link, sent, arrived } of packets) {
      const arrives = Number.isFinite(arrived);
      if (arrives) this.delay_s.set(link, arrived - sent);
      const from_s = this.live ? Math.max(now_s, now_s + sent - time_s + late_s) : now_s;
      const since = from_s - (this.last.get(link) ?? -Infinity);
      if (since < SPACING_S && (arrives || since < SPACING_S / 2)) continue;
      const travel_s = Math.max(LEAST_S, SLOWER * (this.delay_s.get(link) ?? 0));
      this.last.set(link, from_s);
      this.shown.push({ link, from_s, travel_s, arrives });
    }
    this.shown = this.shown.filter((each) => now_s - each.from_s < each.travel_s + FADE_S);
  }

  /** Draw the packets of a link along a line from the sender (x0, y0) to the receiver. */
  draw(context, link, colour, size, [x0, y0], [x1, y1], now_s) {
    const flow = theme.still ? this.standing(link, now_s) : this.shown;
    for (const packet of flow) {
      if (packet.link !== link) continue;
      const way = (now_s - packet.from_s) / packet.travel_s;
      const at = packet.arrives ? way : Math.min(way, 0.5);
      if (at < 0 || at > 1 || (!packet.arrives && way > 1)) continue;
      const x = x0 + at * (x1 - x0), y = y0 + at * (y1 - y0);
      const tail = Math.min(at, 12 / Math.hypot(x1 - x0, y1 - y0)); // behind it: which way it goes
      line(context, [[x, y], [x - tail * (x1 - x0), y - tail * (y1 - y0)]], colour, { width: size });
      if (packet.arrives || way < 0.5) disc(context, x, y, size, { fill: colour });
      else cross(context, x, y, 1 - (way - 0.5) / 0.5);
    }
  }

  /** For who wants no motion: as many dots as packets are on their way, standing still. */
  standing(link, now_s) {
    const count = Math.min(12, Math.ceil((this.delay_s.get(link) ?? 0) / 0.008));
    return Array.from({ length: count }, (_, i) => (
      { link, from_s: now_s - (i + 0.5) / count, travel_s: 1, arrives: true }));
  }
}

function cross(context, x, y, strength) {
  context.globalAlpha = Math.max(0, strength);
  for (const way of [-5, 5]) line(context, [[x - 5, y - way], [x + 5, y + way]], theme.alarm, { width: 2 });
  context.globalAlpha = 1;
}
