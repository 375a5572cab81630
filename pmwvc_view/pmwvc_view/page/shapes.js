// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The shapes that the scene is made of; positions in CSS pixels.

import { theme } from "./theme.js";

export function line(context, points, colour, { width = 1, dash = [] } = {}) {
  context.strokeStyle = colour;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.beginPath();
  points.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
  context.stroke();
  context.setLineDash([]);
}

export function disc(context, x, y, radius, { fill = null, stroke = null, width = 2, dash = [] } = {}) {
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  if (fill) { context.fillStyle = fill; context.fill(); }
  if (!stroke) return;
  context.strokeStyle = stroke;
  context.lineWidth = width;
  context.setLineDash(dash);
  context.stroke();
  context.setLineDash([]);
}

/** A force: an arrow that grows with it, and no arrow below three pixels. */
export function arrow(context, x, y, dx, dy, colour) {
  const length = Math.hypot(dx, dy);
  if (!(length > 3)) return;
  const [ux, uy] = [dx / length, dy / length];
  const head = Math.min(9, length);
  const [ex, ey] = [x + dx, y + dy];
  const [bx, by] = [ex - head * ux, ey - head * uy];
  line(context, [[x, y], [bx, by]], colour, { width: 3 });
  context.fillStyle = colour;
  context.beginPath();
  context.moveTo(ex, ey);
  context.lineTo(bx - 0.5 * head * uy, by + 0.5 * head * ux);
  context.lineTo(bx + 0.5 * head * uy, by - 0.5 * head * ux);
  context.fill();
}

/** A text; with `width`, the whole of it between 0 and there. */
export function label(context, text, x, y, { colour = theme.soft, size = 12, align = "left", weight = 400, width = Infinity } = {}) {
  context.font = `${weight} ${size}px ${theme.font}`;
  context.textAlign = align;
  context.textBaseline = "middle";
  context.fillStyle = colour;
  const { actualBoundingBoxLeft: left, actualBoundingBoxRight: right } = context.measureText(text);
  const at = width === Infinity ? x : Math.max(left, Math.min(x, width - right));
  Object.assign(context, { strokeStyle: theme.paper, lineWidth: 3, lineJoin: "round" });
  if (colour !== theme.paper) context.strokeText(text, at, y); // it may stand in front of something
  context.fillText(text, at, y);
}

const FACES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];

/** A box by its eight corners [m]; a square where there are less than three axes. */
export function box(context, camera, points, place, { fill, stroke, dash = [], width = 1.5 }) {
  const corners = points.map((point) => {
    const at = camera.project(point);
    return [place.x + at.x, place.y + at.y, at.scale];
  });
  const nearness = (face) => face.reduce((sum, i) => sum + corners[i][2], 0);
  const faces = camera.dof > 2 ? [...FACES].sort((a, b) => nearness(a) - nearness(b)) : [FACES[0]];
  context.lineJoin = "round";
  for (const face of faces.slice(fill ? -3 : 0)) {
    const outline = [...face, face[0]].map((i) => corners[i]);
    if (fill) {
      context.fillStyle = fill;
      context.beginPath();
      outline.forEach(([x, y], i) => (i ? context.lineTo(x, y) : context.moveTo(x, y)));
      context.fill();
    }
    line(context, outline, stroke, { width, dash });
  }
}
