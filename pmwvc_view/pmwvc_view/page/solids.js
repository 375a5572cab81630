// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Shapes as triangles: corners [m] and normals, about the shape's middle, z along its axis.

const AROUND = 24; // corners of what is round
const ENDLESS_M = 2; // half of a plane that has no end
const CUBE = [[0, 2, 3, 1], [5, 7, 6, 4], [1, 5, 4, 0], [2, 6, 7, 3], [0, 4, 6, 2], [3, 7, 5, 1]];

/** Positions and normals of a shape, and the triangles of them. */
export function solid(shape) {
  const { kind, size: [a, b], points, faces } = shape;
  if (kind === "mesh") return flat(points, faces);
  if (kind === "capsule") return lathe([...arc(a, 0, 1, b), ...arc(a, 1, 2, -b)]);
  if (kind === "cylinder") return lathe([[0, b], [a, b], [a, -b], [0, -b]], true);
  if (kind === "sphere") return lathe(arc(a, 0, 2, 0));
  if (kind === "ellipsoid") return stretched(lathe(arc(1, 0, 2, 0)), shape.size);
  if (kind === "plane") return flat([[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([x, y]) => [x * (a || ENDLESS_M), y * (b || ENDLESS_M), 0]), [[0, 1, 2], [0, 2, 3]]);
  const corners = Array.from({ length: 8 }, (_, i) => shape.size.map((each, axis) => ((i >> axis) & 1 ? each : -each)));
  return flat(corners, CUBE.flatMap(([p, q, r, s]) => [[p, q, r], [p, r, s]]));
}

/** Quarters of a circle in the plane of an axis: radius and height, from its top on. */
function arc(radius, from, to, height) {
  const count = (AROUND / 4) * (to - from);
  return Array.from({ length: count + 1 }, (_, i) => {
    const angle = (Math.PI / 2) * (from + (i / count) * (to - from));
    return [radius * Math.sin(angle), height + radius * Math.cos(angle)];
  });
}

/** Triangles of plane faces, each with a normal of its own. */
function flat(points, faces) {
  const position = [], normal = [];
  for (const face of faces) {
    const [p, q, r] = face.map((i) => points[i]);
    const [u, v] = [q, r].map((each) => each.map((value, axis) => value - p[axis]));
    const across = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    const length = Math.hypot(...across) || 1;
    for (const point of [p, q, r]) {
      position.push(...point);
      normal.push(...across.map((each) => each / length));
    }
  }
  return { position, normal, index: [...Array(position.length / 3).keys()] };
}

/** A profile of radius and height, from the top on, turned about the axis; `edged`: with its edges, else smooth. */
function lathe(profile, edged = false) {
  const position = [], normal = [], index = [], last = profile.length - 1;
  const slope = (from, to) => [profile[from][1] - profile[to][1], profile[to][0] - profile[from][0]];
  const ring = ([r, z], [out, up]) => {
    const first = position.length / 3, length = Math.hypot(out, up);
    for (let k = 0; k <= AROUND; k += 1) {
      const [c, s] = [Math.cos, Math.sin].map((of) => of((2 * Math.PI * k) / AROUND));
      position.push(r * c, r * s, z);
      normal.push((out * c) / length, (out * s) / length, up / length);
    }
    return first;
  };
  const smooth = edged ? [] : profile.map((point, i) => ring(point, slope(Math.max(0, i - 1), Math.min(last, i + 1))));
  for (let i = 0; i < last; i += 1) {
    const [top, bottom] = edged ? [i, i + 1].map((at) => ring(profile[at], slope(i, i + 1))) : [smooth[i], smooth[i + 1]];
    for (let k = 0; k < AROUND; k += 1) index.push(top + k, bottom + k, bottom + k + 1, top + k, bottom + k + 1, top + k + 1);
  }
  return { position, normal, index };
}

function stretched({ position, normal, index }, by) {
  return { position: position.map((each, i) => each * by[i % 3]), normal: normal.map((each, i) => each / by[i % 3]), index };
}
