// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The page: joins connection, session, hand and pictures, and draws once a frame.

import { Accounts } from "./accounts.js";
import { gamepad } from "./gamepad.js";
import { Hand } from "./hand.js";
import { keyboard, leaving, pointers } from "./inputs.js";
import { PacketFlow } from "./packets.js";
import { Recording } from "./recording.js";
import { Scene } from "./scene.js";
import { Session } from "./session.js";
import { Settings } from "./settings.js";
import { signalsOf } from "./signals.js";
import { Socket } from "./socket.js";
import { ended, notice, Spoken } from "./spoken.js";
import { Strips } from "./strips.js";
import { Timeline } from "./timeline.js";
import { Users } from "./users.js";

const at = (id) => document.getElementById(id);
const GONE_TRIES = 4; // to connect again, some seconds
let page = null; // what shows the present session

/** Everything that shows one session; made anew when the session begins again. */
class Page {
  constructor(declared) {
    const session = (this.session = new Session(declared));
    this.hand = new Hand(socket, session, notice);
    this.flow = new PacketFlow(session.mode === "live");
    this.scene = new Scene(at("scene"), session, at("space"));
    this.strips = new Strips(at("strips"), session, signalsOf(session));
    this.accounts = new Accounts(at("accounts"), session);
    this.users = new Users(at("users"), session, this.hand);
    this.settings = new Settings(session, socket, notice);
    this.timeline = new Timeline(session, socket, notice);
    this.spoken = new Spoken(session);
    this.events = new AbortController();
    const { signal } = this.events;
    at("todo").hidden = !session.users.some(({ remote }) => remote);
    at("help").hidden = at("todo").hidden && session.dof < 3;
    pointers(at("scene"), this.scene, this.hand, session, signal);
    if (session.can.includes("take")) {
      keyboard(at("scene"), this.scene, this.hand, session, signal);
      leaving(this.hand, signal);
      gamepad(this.hand, session);
    }
    this.showAxes(session.dof);
    document.body.dataset.axes = Math.min(session.dof, 3);
    document.body.toggleAttribute("data-turns", session.dof > 3);
    document.body.dataset.mode = session.mode;
    at("scenario").textContent = session.name.replaceAll("_", " ");
    at("scenario").title = session.description;
  }

  /** Buttons for the axis that the strips show, where there are several. */
  showAxes(dof) {
    this.axis = 0;
    at("axes").hidden = dof < 2;
    const buttons = [..."xyzabc"].slice(0, dof).map((name, axis) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.onclick = () => { this.axis = axis; press(); };
      return button;
    });
    const press = () => buttons.forEach((each, axis) => each.setAttribute("aria-pressed", String(axis === this.axis)));
    at("axes").replaceChildren(...buttons);
    press();
  }

  close() {
    this.events.abort();
    this.hand.close();
  }

  draw(now_ms) {
    const now_s = now_ms / 1e3;
    this.scene.draw(this.hand, this.flow, now_s);
    this.accounts.draw();
    this.users.draw();
    this.timeline.draw();
    this.spoken.draw();
    this.strips.draw(this.axis);
  }
}

function connection(state, text) {
  at("connection").dataset.state = state;
  at("connection").textContent = text;
}

const held = at("recording"); // a page that is a file holds its session
const handlers = {
  open: () => connection("waiting", "connected"),
  session: (declared) => {
    page?.close();
    ended("");
    page = new Page(declared);
    connection("open", { live: "live", simulated: "simulated, in real time", recorded: "recorded" }[declared.mode]);
  },
  snapshot: (message) => {
    const { session } = page, { seq, packets } = session.take(held ? message : new Float64Array(message));
    page.flow.take(packets, performance.now() / 1e3, page.session.time_s);
    return seq;
  },
  users: ({ users }) => {
    for (const { name, holder } of users) page.session.users.find((user) => user.name === name).holder = holder;
  },
  values: ({ values }) => page.settings.changed(values),
  text: ({ kind: _, ...text }) => { page.session.text = text; page.spoken.report(); },
  play: (state) => page.timeline.played(state),
  ended: ({ text, report }) => {
    socket.end();
    page?.close();
    page = null; // its last picture stays
    ended(`The session is over: ${text}.${report ? ` Its report: ${report}` : ""}`);
    connection("closed", "over");
  },
  closed: (_, tries) => {
    if (socket.over) return;
    page?.hand.lost();
    if (tries >= GONE_TRIES && page) ended("The session's server does not answer any more: it has ended, or the network is down.");
    connection("closed", tries || page ? "not connected" : "connecting");
    if (tries > 1 && !page) at("verdict").textContent = "No session here: either it is over, or the address lacks its token.";
  },
};
const socket = held ? new Recording(handlers, JSON.parse(held.textContent)) : new Socket(handlers);

function frame(now_ms) {
  page?.draw(now_ms);
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);
