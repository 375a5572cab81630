// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The settings of the running session. A change is a proposal first: the exact model says at once
// what it would mean; it is applied by a button, or by Enter, and the answer is shown.

import { number, shown } from "./words.js";

const ASK_MS = 120; // between two questions
const FIRST = /preset$|delay_s$|jitter_s$|loss$|contact_stiffness$|impedance$|controller$|channel$/; // the others: on demand

export class Settings {
  /** `notify` shows a sentence to the person. */
  constructor(session, socket, notify) {
    Object.assign(this, { session, socket, notify, proposed: new Map(), fields: new Map(), asked: 0 });
    const at = (id) => document.getElementById(id);
    Object.assign(this, { form: at("settings-form"), proposal: at("proposal"), answer: at("answer"), button: at("apply") });
    at("settings").hidden = !session.controls.length;
    const [first, more] = [true, false].map((wanted) => session.controls
      .filter(({ path }) => FIRST.test(path) === wanted).map((control) => this.field(control)));
    this.form.replaceChildren(...first);
    at("more-settings").replaceChildren(...more);
    at("more").hidden = !more.length;
    this.form.onsubmit = (event) => { event.preventDefault(); this.apply(); };
    this.button.onclick = () => this.apply();
    at("discard").onclick = () => this.discard();
    this.show();
  }

  field(control) {
    const root = document.createElement("div");
    root.className = "setting";
    root.dataset.path = control.path;
    const name = document.createElement("label");
    const id = `setting-${control.path.replaceAll(".", "-")}`;
    name.textContent = control.label;
    name.htmlFor = id;
    const value = document.createElement("output");
    value.htmlFor = id;
    const input = control.choices ? this.choice(control) : this.slider(control);
    input.id = id;
    root.append(name, value, input);
    this.fields.set(control.path, { root, value, input, control });
    return root;
  }

  slider(control) {
    const input = document.createElement("input");
    input.type = "range";
    const [factor] = shown(control.unit, control.path);
    const [least, most] = control.slider.map((end) => end * factor);
    const step = [0.1, 0.5, 1, 5, 10, 50].find((each) => (most - least) / each <= 120) ?? 100;
    Object.assign(input, { min: least, max: Math.max(most, (control.value ?? 0) * factor), step });
    input.addEventListener("input", () => this.propose(control, Number(input.value) / factor));
    return input;
  }

  choice(control) {
    const input = document.createElement("select");
    if (!control.choices.some(({ name }) => name === control.value)) input.append(new Option("\u2013", ""));
    for (const { name, words } of control.choices) {
      const short = control.path === "controller" && words?.includes(":") ? words.split(":")[0] : name;
      const option = new Option(short.replaceAll("_", " "), name);
      if (words) option.title = words;
      input.append(option);
    }
    input.addEventListener("change", () => this.propose(control, input.value));
    return input;
  }

  propose(control, value) {
    if (value === control.value || value === "") this.proposed.delete(control.path);
    else this.proposed.set(control.path, value);
    this.show();
    if (!this.proposed.size) return;
    this.report("quiet", "Asking the model \u2026");
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.ask(), ASK_MS);
  }

  async ask() {
    if (!this.session.can.includes("ask")) { this.report("quiet", "No model of this session."); return; }
    const question = (this.asked += 1);
    const found = await this.socket.request("ask", { values: Object.fromEntries(this.proposed) });
    if (question !== this.asked || !this.proposed.size) return; // asked again meanwhile
    if (found.kind !== "prediction") { this.report("alarm", found.text); return; }
    this.report(found.stable === false ? "alarm" : "quiet", predicted(found));
  }

  async apply() {
    if (this.button.hidden) return;
    const values = Object.fromEntries(this.proposed);
    const again = [...this.proposed.keys()].some((path) => this.fields.get(path).control.restart);
    this.discard();
    if (again) {
      const answer = await this.socket.request("restart", { values });
      if (!answer.done) this.notify(answer.text);
      return;
    }
    for (const [path, value] of Object.entries(values)) {
      const answer = await this.socket.request("set", { path, value });
      if (!answer.done) this.notify(answer.text);
    }
  }

  discard() {
    this.proposed.clear();
    this.asked += 1;
    clearTimeout(this.timer);
    this.show();
  }

  /** Values of the running session changed, by anybody. */
  changed(values) {
    for (const [path, value] of Object.entries(values)) {
      const field = this.fields.get(path);
      if (!field) continue;
      field.control.value = value;
      if (this.proposed.get(path) === value) this.proposed.delete(path);
    }
    this.show();
  }

  show() {
    for (const [path, { root, value, input, control }] of this.fields) {
      const now = this.proposed.get(path) ?? control.value;
      const [factor, unit] = shown(control.unit, path);
      const decimals = String(input.step ?? "").includes(".") ? 1 : 0;
      if (input.type === "range") {
        if (document.activeElement !== input || !this.proposed.has(path)) input.value = now * factor;
        value.textContent = `${number(now * factor, decimals)} ${unit}`;
        input.setAttribute("aria-valuetext", value.textContent);
      } else input.value = now ?? "";
      root.toggleAttribute("data-changed", this.proposed.has(path));
      input.disabled = !this.session.can.includes("ask") && !this.applies(control);
    }
    this.proposal.hidden = !this.proposed.size;
    const controls = [...this.proposed.keys()].map((path) => this.fields.get(path).control);
    const again = controls.some(({ restart }) => restart);
    this.button.textContent = again ? "Apply and start again" : "Apply";
    this.button.hidden = !controls.every((control) => this.applies(control));
  }

  /** Whether this session serves a change of a setting: what was recorded stays as it was. */
  applies(control) { return this.session.can.includes(control.restart ? "restart" : "set"); }

  report(tone, text) {
    this.answer.dataset.tone = tone;
    this.answer.textContent = text;
  }
}

/** A prediction in a sentence, and what it depends on. */
function predicted({ stable, rendered_stiffness, mass, lines }) {
  const verdict = stable === null ? "Not known whether stable" : stable ? "Stable" : "Not stable";
  const stiffness = Number.isFinite(rendered_stiffness) && rendered_stiffness !== null ? `, rendered stiffness ${number(rendered_stiffness, 0)} N/m` : "";
  const weight = Number.isFinite(mass) && mass !== null ? `, rendered mass in free space ${number(mass, 2)} kg` : "";
  const [first = "", ...others] = lines ?? []; // it begins with the same verdict
  const more = [first.replace(/^(not )?stable: s/i, "S"), ...others].join(" ");
  return `The exact model: ${verdict.toLowerCase()}${stable === false ? "" : stiffness + weight}. ${more}`;
}
