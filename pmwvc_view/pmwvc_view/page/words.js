// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Numbers and states in words, the same everywhere on the page.

const MINUS = "\u2212";

/** A number with a fixed count of decimals, a true minus and a dash where it is not known. */
export function number(value, decimals = 1) {
  if (value === null || !Number.isFinite(value)) return "\u2013";
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? MINUS + text : text;
}

const POWERS = { m: [1e3, "mm"], s: [1e3, "ms"], J: [1e3, "mJ"] };

/** How a unit is shown: factor and name. */
export function shown(unit, path = "") {
  if (unit === "-" && /loss|duplicate|reorder/.test(path)) return [100, "%"];
  return POWERS[unit] ?? [1, unit === "-" ? "" : unit];
}

export const milli = (value, decimals = 1) => number(1e3 * value, decimals);

/** An energy [J] with its unit. */
export const energy = (value) => (Math.abs(value) < 1 ? `${milli(value)} mJ` : `${number(value, 2)} J`);

/** Name of a user as people read it: user1 -> user 1. */
export const spaced = (name) => name.replace(/(\D)(\d+)$/, "$1 $2");

/** State of a user's master: what the server reports of it, or the word of the number. */
export function stateOf(session, name) {
  const reported = session.text.users[name];
  if (reported?.state) return reported;
  const word = session.states.master[session.value(`${name}.state`)];
  return { state: word ?? "no data", reason: "", note: "", felt: "" };
}

/** True where a state is one that a person has to see. */
export const disturbed = (state) => /damping|fault/i.test(state);
