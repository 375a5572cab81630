// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A card per user: who holds the handle, the state of the master in a word, the force, and the
// buttons to take hold and to let go. Below them the price of the delay, while things are at rest.

import { disturbed, milli, number, spaced, stateOf } from "./words.js";

const HOLDERS = { you: "you", other: "another browser" };
const WRITE_MS = 200;
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
      this.cards[index].price.replaceChildren(...priceOf(this.session, user));
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
    card.button.hidden = !user.remote || user.holder === "other";
    card.button.textContent = mine ? "Let go" : again ? "Take hold again" : "Take hold";
    card.button.setAttribute("aria-label", `${card.button.textContent}: ${spaced(user.name)}`);
  }
}

/** The price of the delay: device ahead of its avatar, and at rest what F tau/(2b) says of it. */
function priceOf(session, { name, impedance, side }) {
  const ahead_m = -side * (session.value(`${name}.x_m`) - session.value(`${name}.x_s`));
  if (!Number.isFinite(ahead_m)) return [];
  const amount = document.createElement("b");
  amount.textContent = `${milli(Math.abs(ahead_m))} mm`;
  const found = ["device ", amount, ahead_m < 0 ? " behind its avatar" : " ahead of its avatar"];
  const moving = Math.max(session.size(`${name}.xd_m`), session.size(`${name}.xd_s`)) > REST_M_S;
  const shaking = session.value(`${name}.f_max`) - session.value(`${name}.f_min`) > REST_N;
  const force_n = session.value(`${name}.f_applied`), tau_s = session.value(`${name}.lag`);
  const expected_m = (-side * force_n * tau_s) / (2 * impedance);
  if (Number.isFinite(expected_m) && !moving && !shaking) found.push(`; F\u202f\u03c4/2b says ${milli(expected_m)} mm`);
  return found;
}
