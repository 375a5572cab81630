// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// From metres to pixels: one axis as a line, two as a plane, three in a perspective that can be
// turned. Axes: x to the right, y up (two axes) or into the picture (three), z up.

const LEAST_DISTANCE_M = 0.7; // of the eye, for three axes
const ZOOMS = [0.3, 8];
const LEAST_REACH_M = 0.12;

export class Camera {
  constructor(dof) {
    this.dof = dof;
    this.yaw = dof > 2 ? 0.35 : 0;
    this.pitch = dof > 2 ? 0.4 : 0;
    this.middle = [0, 0, 0]; // that it looks at [m]
    this.reach_m = LEAST_REACH_M;
    this.scale = this.zoomed = 1;
  }

  get distance_m() { return Math.max(LEAST_DISTANCE_M, 4 * this.reach_m); }

  /** Show what stands up to `reach_m` from the middle; nothing of `size_m` gets taller than `height`. */
  fit(width, height, reach_m, size_m) {
    const wanted = Math.max(LEAST_REACH_M, reach_m + 0.025);
    this.reach_m += 0.06 * (wanted - this.reach_m);
    this.scale = this.zoomed * Math.min(width / (2 * this.reach_m), height / size_m);
  }

  zoom(factor) { this.zoomed = Math.max(ZOOMS[0], Math.min(ZOOMS[1], factor * this.zoomed)); }

  turn(dx, dy) {
    if (this.dof < 3) return;
    this.yaw += 0.008 * dx;
    this.pitch = Math.max(-0.2, Math.min(1.4, this.pitch + 0.008 * dy));
  }

  /** The directions on the screen, in metres of the world: right, up, away. */
  axes() {
    const [cy, sy, cp, sp] = [Math.cos(this.yaw), Math.sin(this.yaw), Math.cos(this.pitch), Math.sin(this.pitch)];
    if (this.dof < 3) return [[1, 0, 0], [0, 1, 0], [0, 0, 1]];
    return [[cy, sy, 0], [-sy * sp, cy * sp, cp], [-sy * cp, cy * cp, -sp]];
  }

  /** Pixels of a point [m], from the middle of the picture, and the scale there [px/m]. */
  project(point) {
    const [right, up, away] = this.axes().map((axis) => dot(axis, point) - dot(axis, this.middle));
    const d = this.distance_m, scale = this.dof > 2 ? (this.scale * d) / Math.max(0.1 * d, d + away) : this.scale;
    return { x: right * scale, y: -up * scale, scale };
  }

  /** Displacement [m] in the plane of the screen for pixels, where a metre is `scale` pixels. */
  inPlane(dx, dy, scale) {
    const [right, up] = this.axes();
    const all = right.map((_, axis) => (right[axis] * dx - up[axis] * dy) / scale);
    return all.slice(0, this.dof);
  }

  /** Turn of six axes for pixels: of what is near, to where they go; of the last three axes a metre is `scale` pixels. */
  turning(dx, dy, scale) {
    const [right, up] = this.axes();
    return [0, 0, 0, ...right.map((_, axis) => (up[axis] * dx + right[axis] * dy) / scale)];
  }

  /** Displacement [m] away from the eye. */
  inDepth(distance_m) { return this.axes()[2].map((each) => each * distance_m); }
}

function dot(axis, point) {
  let sum = 0;
  for (let i = 0; i < point.length && i < 3; i += 1) sum += axis[i] * point[i];
  return sum;
}
