// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// What stands in a scene of three axes: shapes, the poses of their bodies, and where the devices of
// the users are in it. A session that describes no scene has a cube and a finger per user.

const FINGER_M = 0.008; // of an avatar that has no shape of its own
const UNTURNED = [1, 0, 0, 0];
const ALIKE = [0.5, 0.5, 0.5]; // the colour of what has none in its file

/** A vector turned by a unit quaternion w x y z. */
export function turned([w, x, y, z], [a, b, c]) {
  const [p, q, r] = [2 * (y * c - z * b), 2 * (z * a - x * c), 2 * (x * b - y * a)];
  return [a + w * p + y * r - z * q, b + w * q + z * p - x * r, c + w * r + x * q - y * p];
}

const sum = (a, b) => a.map((each, axis) => each + (b[axis] ?? 0));
const difference = (a, b) => a.map((each, axis) => each - b[axis]);

/** Half the edges of the box around a shape [m]. */
function halves({ kind, size: [a, b, c], points }) {
  if (kind === "mesh") return [0, 1, 2].map((axis) => points.reduce((most, point) => Math.max(most, Math.abs(point[axis])), 0));
  if (kind === "sphere") return [a, a, a];
  if (kind === "cylinder") return [a, a, b];
  return kind === "capsule" ? [a, a, a + b] : [a, b, c];
}

export class Bodies {
  constructor(session) {
    this.session = session;
    const { shapes = [], fixed = {}, origin = [0, 0, 0] } = session.scene;
    const plain = { at: [0, 0, 0], turned: UNTURNED, user: -1 }, half = session.object.size_m / 2;
    const finger = (user) => ({ ...plain, body: session.users[user].name, kind: "sphere", size: [FINGER_M], user });
    const held = (user) => shapes.find((shape) => shape.user === user)?.body;
    this.shapes = shapes.length ? [...shapes] : [{ ...plain, body: "object", kind: "box", size: [half, half, half] }];
    session.users.forEach((_, user) => { if (!held(user)) this.shapes.push(finger(user)); });
    for (const shape of this.shapes) shape.half = halves(shape);
    Object.assign(this, { fixed, origin, held: session.users.map(({ name }, user) => held(user) ?? name), offsets: [] });
    const moves = new Set(this.shapes.filter(({ body, user }) => user < 0 && !fixed[body]).map(({ body }) => body));
    this.carried = session.object.carried && moves.size === 1 ? [...moves][0] : null; // which a task may have a target for
  }

  /** Pose of a body: x y z [m], w x y z; null where it is not known. */
  pose(body) {
    if (this.fixed[body]) return this.fixed[body];
    const { session } = this, user = session.users.findIndex(({ name }) => name === body);
    let found;
    if (session.columns.has(`${body}.pose`)) found = Array.from({ length: 7 }, (_, i) => session.value(`${body}.pose`, i));
    else if (body === "object") found = [...session.vector("object.x_o"), ...UNTURNED];
    else found = [...sum(sum(session.vector(`${body}.x_s`), this.origin), [session.users[user].side * FINGER_M]), ...UNTURNED];
    return found.every(Number.isFinite) ? found : null;
  }

  /** From a place of a user's device or avatar to the middle of what it holds in the scene [m]. */
  offset(user) {
    const pose = this.pose(this.held[user]), x_s = this.session.vector(`${this.session.users[user].name}.x_s`);
    const found = pose && difference(pose.slice(0, 3), x_s);
    if (found?.every(Number.isFinite)) this.offsets[user] = found;
    return this.offsets[user] ?? this.origin;
  }

  /** Whether a user is at the server. */
  there(user) { return this.session.value(`${this.session.users[user].name}.presence`) !== 0; }

  /** Pose at which the task wants what is carried; null where it wants none, or it is there. */
  goal() {
    const pose = this.carried && this.pose(this.carried);
    if (!pose) return null;
    const way = difference(this.session.vector("object.target"), this.session.vector("object.x_o"));
    return Math.hypot(...way) > 1e-3 ? [...sum(pose.slice(0, 3), way), ...pose.slice(3)] : null;
  }

  /** Corners of a shape's box in the scene [m]: of each axis the lower one first. */
  corners(shape, pose) {
    const at = pose.slice(0, 3), way = pose.slice(3);
    return Array.from({ length: 8 }, (_, i) => {
      const corner = shape.half.map((each, axis) => ((i >> axis) & 1 ? each : -each));
      return sum(at, turned(way, sum(shape.at, turned(shape.turned, corner))));
    });
  }

  /** Corners of all shapes that have an end; of those that move, where `moving`. */
  extent(moving) {
    return this.shapes.flatMap((shape) => {
      const pose = shape.kind !== "plane" && !(moving && this.fixed[shape.body]) && this.pose(shape.body);
      return pose ? this.corners(shape, pose) : [];
    });
  }

  /** A shape's colour, red green blue alpha; null where the file gives it none. */
  colour({ rgba }) { return rgba && !ALIKE.every((each, i) => rgba[i] === each) ? rgba : null; }
}
