// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// What the canvases take from the style sheet and from the person's preferences, kept up to date.

const NAMES = ["paper", "ink", "soft", "grid", "object", "target", "alarm", "cube", "body", "good", "wash"];
const dark = matchMedia("(prefers-color-scheme: dark)");
const still = matchMedia("(prefers-reduced-motion: reduce)");

export const theme = { users: [], still: still.matches, font: "" };

function read() {
  const style = getComputedStyle(document.documentElement);
  for (const name of NAMES) theme[name] = style.getPropertyValue(`--${name}`).trim();
  theme.users = Array.from({ length: 8 }, (_, i) => style.getPropertyValue(`--u${i}`).trim());
  theme.font = getComputedStyle(document.body).fontFamily;
}

dark.addEventListener("change", read);
still.addEventListener("change", () => { theme.still = still.matches; });
read();

/** Fit a canvas to its size on the screen; return its context in CSS pixels, and that size. */
export function fitted(canvas) {
  const ratio = Math.min(devicePixelRatio || 1, 2);
  const width = canvas.clientWidth, height = canvas.clientHeight;
  const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  return { context, width, height };
}
