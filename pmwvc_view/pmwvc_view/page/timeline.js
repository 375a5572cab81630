// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Time in the session: pause and start again where it runs, the time line where it was recorded.

import { number } from "./words.js";

const at = (id) => document.getElementById(id);

export class Timeline {
  constructor(session, socket, notify) {
    Object.assign(this, { session, socket, notify, paused: false, dragged: false });
    const can = (kind) => session.can.includes(kind);
    const recorded = session.mode === "recorded";
    at("timeline").hidden = !recorded;
    at("pause").hidden = recorded || !can("pause");
    at("restart").hidden = recorded || !can("restart");
    at("seek").max = session.duration_s ?? 0;
    at("pause").onclick = at("play").onclick = () => this.request("pause", { paused: !this.paused });
    at("restart").onclick = () => this.request("restart", { values: {} });
    at("speed").onchange = () => this.request("speed", { ratio: Number(at("speed").value) });
    at("seek").oninput = () => { this.dragged = true; this.request("seek", { time_s: Number(at("seek").value) }); };
    at("seek").onchange = () => { this.dragged = false; };
    this.show();
  }

  async request(kind, fields) {
    const answer = await this.socket.request(kind, fields);
    if (!answer.done) this.notify(answer.text);
  }

  played({ paused, ratio }) {
    this.paused = paused;
    if (ratio) at("speed").value = String(ratio);
    this.show();
  }

  show() {
    at("pause").textContent = this.paused ? "Go on" : "Pause";
    at("play").textContent = this.paused ? "Play" : "Pause";
    at("pause").setAttribute("aria-pressed", String(this.paused));
  }

  draw() {
    const { time_s, duration_s } = this.session;
    at("clock").textContent = `${number(time_s, 1)} s`;
    if (at("timeline").hidden) return;
    if (!this.dragged) at("seek").value = time_s;
    at("seek-time").textContent = `${number(time_s, 1)} of ${number(duration_s, 1)} s`;
  }
}
