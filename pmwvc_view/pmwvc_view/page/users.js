// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A card per user: who holds the handle, the state of the master in a word, the force, and the
// buttons to take hold and to let go. Below them the price of the delay, while things are at rest,
// and what the hand has felt in the newest seconds.

import { disturbed, milli, number, spaced, stateOf } from "./words.js";

const HOLDERS = { you: "you", other: "another browser" };
const WRITE_MS = 200;
const SHOWN_M = 5e-5;
const REST_M_S = 0.01, REST_N = 0.1; // below: at rest, where F tau/(2b) holds

export class Users {
  constructor(container, session, hand) {
    Object.assign(this, { session, hand, written_ms: 0 });
    this.cards = session.users.map((user, index) => this.card(user, index));
    container.replaceChildren(...this.cards.map(({ root }) => root));
  }

  card(user, index) {
    const make = (tag, name, parent) => {
      const element = document.createElement(tag);
      element.className = name;
      parent.append(element);
      return element;
    };
    const root = document.createElement("div");
    root.className = "user";
    root.dataset.user = user.name;
    make("span", "dot", root).style.setProperty("background", `var(--u${index % 8})`);
    const name = make("span", "name", root), state = make("span", "state", root);
    const button = make("button", "", root);
    button.type = "button";
    button.addEventListener("click", () => this.pressed(index));
    const price = make("span", "price", root);
    return { root, name, state, button, price };
  }

  pressed(index) {
    const { hand } = this;
    if (hand.held && hand.index === index) hand.free();
    else hand.take(index, "keys");
    document.getElementById("scene").focus({ preventScroll: true });
  }

  draw() {
    const now_ms = performance.now();
    if (now_ms - this.written_ms < WRITE_MS) return;
    this.written_ms = now_ms;
    this.session.users.forEach((user, index) => {
      this.write(user, index);
      const { felt } = stateOf(this.session, user.name);
      this.cards[index].price.replaceChildren(...priceOf(this.session, user), felt ? `; ${felt}` : "");
    });
  }

  write(user, index) {
    const { session, hand } = this, card = this.cards[index];
    const { state, reason, note } = stateOf(session, user.name);
    const held = session.held(user.name);
    const other = session.mode === "recorded" ? "" : user.remote ? "free" : "with a hand of its own";
    const who = HOLDERS[user.holder] ?? other;
    const rest = document.createElement("span");
    rest.className = "soft";
    rest.textContent = who;
    card.name.replaceChildren(`${spaced(user.name)} `, rest);
    const force = number(session.size(`${user.name}.f_applied`), 2);
    const grip = user.remote ? (held ? ", held" : ", not held") : "";
    card.state.textContent = `${reason || state}${grip} \u00b7 ${force} N${note ? ` \u00b7 ${note}` : ""}`;
    card.state.dataset.tone = disturbed(state) ? "alarm" : "";
    const mine = hand.held && hand.index === index;
    const again = user.holder === "you" && !mine;
    card.button.hidden = !user.remote || user.holder === "other" || !(mine || session.place(user.name));
    card.button.textContent = mine ? "Let go" : again ? "Take hold again" : "Take hold";
    card.button.setAttribute("aria-label", `${card.button.textContent}: ${spaced(user.name)}`);
  }
}

/** The price of the delay: device ahead of its avatar, and at rest what F tau/(2b) gives for it; with
 * several axes both along the line from avatar to device. */
function priceOf(session, { name, side }) {
  const column = (which) => session.vector(`${name}.${which}`);
  const [place, avatar, force] = [column("x_m"), column("x_s"), column("f_applied")];
  const offset = place.map((each, axis) => each - avatar[axis]);
  const length = Math.hypot(...offset);
  if (!Number.isFinite(length)) return [];
  const onto = session.dof < 2 ? [-side] : offset.map((each) => each / (length || 1));
  const along = (vector) => vector.reduce((sum, each, axis) => sum + each * onto[axis], 0);
  const ahead_m = session.dof < 2 ? along(offset) : length;
  const amount = document.createElement("b");
  amount.textContent = `${milli(Math.abs(ahead_m))} mm`;
  const near = session.dof > 1 || Math.abs(ahead_m) < SHOWN_M; // "0.0 mm": on neither side
  const where = near ? "from" : ahead_m < 0 ? "behind" : "ahead of";
  const found = ["device ", amount, ` ${where} its avatar`];
  const moving = Math.max(session.size(`${name}.xd_m`), session.size(`${name}.xd_s`)) > REST_M_S;
  const swings = column("f_max").map((each, axis) => each - column("f_min")[axis]);
  const expected_m = (along(force) * session.value(`${name}.lag`)) / (2 * session.value(`${name}.impedance`));
  const still = !moving && !swings.some((each) => each > REST_N);
  if (Number.isFinite(expected_m) && still && !disturbed(stateOf(session, name).state)) found.push(`; F\u202f\u03c4/2b gives ${milli(expected_m)} mm`);
  return found;
}
