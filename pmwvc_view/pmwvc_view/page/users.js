// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A card per user: who holds the handle, the state of the master in a word, the force, and the
// buttons to take hold and to let go. Below them the price of the delay, while things are at rest.

import { disturbed, milli, number, spaced, stateOf } from "./words.js";

const HOLDERS = { you: "you", other: "another browser" };
const WRITE_MS = 200;

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
    return { root, name, state, button };
  }

  pressed(index) {
    const { hand, session } = this;
    if (hand.held && hand.index === index) hand.free();
    else if (session.users[index].holder === "you" && hand.index === index && disturbed(this.state(index))) hand.take(index, "keys");
    else hand.take(index, "keys");
    document.getElementById("scene").focus({ preventScroll: true });
  }

  state(index) { return stateOf(this.session, this.session.users[index].name).state; }

  draw() {
    const now_ms = performance.now();
    if (now_ms - this.written_ms < WRITE_MS) return;
    this.written_ms = now_ms;
    this.session.users.forEach((user, index) => this.write(user, index));
  }

  write(user, index) {
    const { session, hand } = this, card = this.cards[index];
    const { state, reason, note } = stateOf(session, user.name);
    const held = session.held(user.name);
    const who = HOLDERS[user.holder] ?? (user.remote ? "free" : "simulated hand");
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
    card.button.hidden = !user.remote;
    card.button.disabled = user.holder === "other";
    card.button.textContent = mine ? "Let go" : again ? "Take hold again" : "Take hold";
    card.button.setAttribute("aria-label", `${card.button.textContent}: ${spaced(user.name)}`);
  }
}
