// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The picture of the session: above, the hands with their handles; below, the server with avatars,
// cube and target; between them the delay line of every user, with packets on their way. With three
// axes and WebGL one picture of the server's scene, in which the handles are, too.

import { Bodies } from "./bodies.js";
import { Camera } from "./camera.js";
import { SLOWER } from "./packets.js";
import { arrow, box, disc, label, line } from "./shapes.js";
import { Space } from "./space.js";
import { fitted, theme } from "./theme.js";
import { milli } from "./words.js";

const HANDLE_PX = 14;
const AVATAR_PX = 9;
const DOCK_PX = 24; // from the top: where the link of a hand begins, where handles are in the scene
const LANE_PX = 36; // between users of one side, where there is one axis
const LONGEST_PX = 84; // of a force arrow: the user's limit
const LEAST_N = 0.05;
const GRID_M = 0.05;
const AROUND = 1.3; // how much more is shown than moves

const added = (a, b) => a.map((each, axis) => each + (b[axis] ?? 0));

export class Scene {
  /** `behind`: the canvas on which solids are drawn. */
  constructor(canvas, session, behind) {
    this.canvas = canvas;
    this.session = session;
    this.camera = new Camera(session.dof);
    this.bodies = session.dof > 2 ? new Bodies(session) : null;
    this.space = this.bodies && Space.of(behind, this.bodies);
    this.behind = behind;
    this.handles = []; // {user, x, y, scale} as last drawn, of users whose place is known
    this.lanes = session.users.map((user) => {
      const side = session.users.filter((each) => each.side === user.side);
      const apart_px = Math.min(LANE_PX, 105 / side.length);
      return session.dof > 1 ? 0 : apart_px * (side.indexOf(user) - (side.length - 1) / 2);
    });
  }

  draw(hand, flow, now_s) {
    const { context, width, height } = fitted(this.canvas);
    const { session, camera } = this;
    Object.assign(this, { context, width });
    context.clearRect(0, 0, width, height);
    const size_m = session.object.size_m || 0.06;
    const deep = session.dof > 1;
    if (this.space?.lost) this.space = null;
    this.behind.hidden = !this.space;
    document.body.toggleAttribute("data-space", Boolean(this.space));
    if (this.bodies) camera.fit(width, (this.space ? 0.95 : 0.5) * height, this.look(), 2 * camera.reach_m);
    else camera.fit(width, (deep ? 0.17 : 0.27) * height, this.reach(), size_m);
    this.above = { x: width / 2, y: 0.22 * height };
    this.below = { x: width / 2, y: height * (deep ? 0.72 : 0.75) };
    if (this.space) {
      this.above = this.below = { x: width / 2, y: height / 2 };
      this.space.draw(camera, width, height);
    } else this.ground(width, height);
    const where = session.users.map((user, i) => this.places(user.name, i, hand));
    where.forEach((place, i) => this.link(session.users[i].name, i, place, flow, now_s));
    if (this.bodies && !this.space) this.outlines();
    if (!this.bodies) this.server(size_m);
    if (this.space) this.contacts();
    where.forEach((place, i) => this.avatar(session.users[i], i, place));
    where.forEach((place, i) => this.handle(session.users[i], i, place, hand));
    const all = where.map(({ handle }, user) => ({ user, ...handle }));
    this.handles = this.canvas.handles = all.filter(({ user }) => session.place(session.users[user].name));
    this.canvas.dataset.users = this.handles.length;
    this.captions(width, height, flow);
  }

  /** How far from the middle anything stands [m]. */
  reach() {
    const { session } = this;
    const points = session.users.flatMap(({ name }) => [session.vector(`${name}.x_m`), session.vector(`${name}.x_s`)]);
    points.push(session.vector("object.x_o"), session.vector("object.target"));
    const distances = points.flat().filter(Number.isFinite).map(Math.abs);
    return distances.reduce((a, b) => Math.max(a, b), 0);
  }

  /** Look at the middle of what moves in a scene; return how far from it anything shall be seen [m]. */
  look() {
    const { bodies, camera, session } = this;
    const devices = session.users.map(({ name }, user) => added(session.vector(`${name}.x_m`), bodies.offset(user)));
    const points = [...bodies.extent(true), ...devices.filter((each) => each.every(Number.isFinite))];
    if (!this.seen && points.length) {
      const ends = [Math.min, Math.max].map((most) => [0, 1, 2].map((axis) => most(...points.map((each) => each[axis]))));
      camera.middle = ends[0].map((low, axis) => (low + ends[1][axis]) / 2);
      this.seen = true;
    }
    return AROUND * points.reduce((most, point) => Math.max(most, Math.hypot(...point.map((each, axis) => each - camera.middle[axis]))), 0);
  }

  /** Rails, plane or floor of either side. */
  ground(width, height) {
    const { context, camera, session } = this;
    context.fillStyle = theme.wash;
    const [top, bottom] = session.dof > 1 ? [0.44, 0.5] : [0.4, 0.54];
    context.fillRect(0, top * height, width, (bottom - top) * height);
    for (const place of [this.above, this.below]) {
      if (session.dof === 1) this.rail(place, width);
      else this.plane(place);
    }
    if (session.dof === 1) label(context, "50 mm", this.above.x + 0.5 * GRID_M * camera.scale, this.above.y + 49, { align: "center", size: 11 });
  }

  rail(place, width) {
    const { context, camera } = this;
    line(context, [[0, place.y], [width, place.y]], theme.grid, { width: 2 });
    const step = GRID_M * camera.scale, most = Math.floor(width / 2 / step);
    for (let i = -most; i <= most; i += 1) {
      line(context, [[place.x + i * step, place.y + 34], [place.x + i * step, place.y + 40]], theme.target);
    }
    if (place === this.above) line(context, [[place.x, place.y + 37], [place.x + step, place.y + 37]], theme.target);
  }

  plane(place) {
    const { context, camera, session } = this;
    const low = session.dof > 2 ? [-0.05] : [];
    for (let i = -2; i <= 2; i += 1) {
      for (const ends of [[[i, -2], [i, 2]], [[-2, i], [2, i]]]) {
        const points = ends.map((end) => {
          const at = camera.project(added([...end.map((each) => each * GRID_M), ...low], camera.middle));
          return [place.x + at.x, place.y + at.y];
        });
        line(context, points, theme.grid);
      }
    }
  }

  /** Pixels of a user's handle, avatar and target, and of the handle as seen on the server's side. */
  places(name, index, hand) {
    const { session } = this;
    const lane = this.lanes[index];
    const at = (point, place) => {
      const { x, y, scale } = this.camera.project(point);
      return { x: place.x + x, y: place.y + y + lane, scale };
    };
    const from = this.bodies?.offset(index) ?? [0, 0, 0];
    const [x_m, x_s] = ["x_m", "x_s"].map((which) => added(session.vector(`${name}.${which}`), from));
    const target = added(hand.index === index && hand.target ? hand.target : session.vector(`${name}.target`), from);
    return {
      handle: at(x_m, this.above), avatar: at(x_s, this.below),
      device: at(x_m, this.below), target: at(target, this.above),
    };
  }

  link(name, index, { handle, avatar }, flow, now_s) {
    if (!Number.isFinite(handle.x + avatar.x)) return;
    const { context, session } = this;
    const colour = theme.users[index % 8];
    const count = session.users.length, [x, y] = this.space ? [(this.width * (index + 1)) / (count + 1), DOCK_PX] : [handle.x, handle.y];
    if (this.space) this.badge(x, y, index, colour);
    for (const [way, shift] of [["up", -6], ["down", 6]]) {
      const top = [x + shift, y + HANDLE_PX + 4], bottom = [avatar.x + shift, avatar.y - AVATAR_PX - 4];
      context.globalAlpha = 0.35;
      line(context, [top, bottom], colour);
      context.globalAlpha = 1;
      const wave = session.size(`${name}.${way === "up" ? "u_m" : "v_m"}`);
      const size = 2.6 + 2.6 * Math.min(1, (wave || 0) / 0.5);
      const [from, to] = way === "up" ? [top, bottom] : [bottom, top];
      flow.draw(context, 2 * index + (way === "up" ? 0 : 1), colour, size, from, to, now_s);
    }
  }

  server(size_m) {
    const { context, camera, session, below } = this;
    const x_o = session.vector("object.x_o"), target = session.vector("object.target");
    const cube = (middle, size) => Array.from({ length: 8 }, (_, i) => [0, 1, 2].map((axis) => (middle[axis] ?? 0) + (((i >> axis) & 1) - 0.5) * size));
    if (target.every(Number.isFinite)) box(context, camera, cube(target, 1.04 * size_m), below, { stroke: theme.target, dash: [5, 4] });
    if (x_o.every(Number.isFinite)) box(context, camera, cube(x_o, size_m), below, { fill: theme.cube, stroke: theme.object });
  }

  /** The boxes around the shapes of a scene, where there is no WebGL; of fingers the avatars stand. */
  outlines() {
    const { context, camera, bodies, below } = this;
    const goal = bodies.goal();
    const shown = bodies.shapes.filter(({ kind, user }) => kind !== "plane" && (kind !== "sphere" || user < 0));
    const near = ([corner]) => camera.project(corner).scale;
    const boxes = shown.flatMap((shape) => {
      const pose = bodies.pose(shape.body), wanted = goal && shape.body === bodies.carried;
      if (wanted) box(context, camera, bodies.corners(shape, goal), below, { stroke: theme.target, dash: [5, 4] });
      return pose ? [[bodies.corners(shape, pose), shape]] : [];
    });
    for (const [corners, { body, user }] of boxes.sort(([a], [b]) => near(a) - near(b))) {
      const fill = user < 0 && !bodies.fixed[body] ? theme.cube : undefined;
      box(context, camera, corners, below, { fill, stroke: user >= 0 ? theme.users[user % 8] : fill ? theme.object : theme.target });
    }
  }

  /** Forces between the bodies of a scene, where they touch. */
  contacts() {
    const { context, camera, session, below } = this;
    const most_n = Math.max(...session.users.map(({ force_limit }) => force_limit || 0));
    for (const { point, force } of session.contacts()) {
      const { x, y } = camera.project(point), at = { x: below.x + x, y: below.y + y };
      disc(context, at.x, at.y, 2.5, { fill: theme.object });
      this.force(at, force, most_n, theme.object, -2);
    }
  }

  avatar({ name, force_limit }, index, { avatar, device }) {
    if (!Number.isFinite(avatar.x)) return;
    const { context, session } = this;
    const colour = theme.users[index % 8];
    const there = session.value(`${name}.presence`) !== 0;
    if (this.space) {
      line(context, [[device.x, device.y], [avatar.x, avatar.y]], colour, { width: 2, dash: [2, 3] });
      if (session.value(`${name}.contact`) === 1) disc(context, avatar.x, avatar.y, 4, { fill: theme.paper, stroke: colour });
      return;
    }
    disc(context, device.x, device.y, AVATAR_PX, { stroke: colour, width: 1.5, dash: [2, 3] });
    line(context, [[device.x, device.y], [avatar.x, avatar.y]], colour, { width: 2, dash: [2, 3] });
    context.globalAlpha = there ? 1 : 0.3;
    disc(context, avatar.x, avatar.y, AVATAR_PX, { fill: theme.paper, stroke: colour, width: 3 });
    context.globalAlpha = 1;
    this.force(avatar, session.vector(`${name}.f_s`), force_limit, colour, AVATAR_PX);
  }

  handle({ name, force_limit }, index, { handle, target }, hand) {
    if (!Number.isFinite(handle.x)) return;
    const { context, session } = this;
    const colour = theme.users[index % 8];
    const held = session.held(name);
    if (held && Number.isFinite(target.x)) {
      line(context, [[handle.x, handle.y], [target.x, target.y]], colour, { width: 1.5, dash: [4, 3] });
      disc(context, target.x, target.y, 4, { fill: theme.paper, stroke: colour, width: 1.5 });
    }
    if (hand.index === index && hand.held) disc(context, handle.x, handle.y, HANDLE_PX + 5, { stroke: colour, width: 1.5 });
    if (this.space) {
      disc(context, handle.x, handle.y, HANDLE_PX, { stroke: theme.paper, width: 5 }); // its body may have its colour
      disc(context, handle.x, handle.y, HANDLE_PX, { stroke: colour, width: 2.5 });
    } else this.badge(handle.x, handle.y, index, colour);
    const back = session.vector(`${name}.f_applied`).map((force) => -force); // on the hand
    this.force(handle, back, force_limit, colour, HANDLE_PX, true);
  }

  badge(x, y, index, colour) {
    disc(this.context, x, y, HANDLE_PX, { fill: colour });
    label(this.context, String(index + 1), x, y + 0.5, { colour: theme.paper, align: "center", size: 13, weight: 700 });
  }

  /** A force from a place on: an arrow from the rim, with the amount in newtons where asked. */
  force(place, force, limit, colour, rim, amount = false) {
    const { context, camera } = this;
    const size = Math.hypot(...force);
    if (!(size > LEAST_N)) return;
    const zero = camera.project([0, 0, 0].slice(0, camera.dof)), tip = camera.project(force.map((each) => (each / size) * 0.01));
    const [dx, dy] = [tip.x - zero.x, tip.y - zero.y].map((each) => each / (0.01 * camera.scale));
    const length = LONGEST_PX * Math.min(1, size / (limit || 8));
    const [x, y] = [place.x + (rim + 2) * dx, place.y + (rim + 2) * dy];
    arrow(context, x, y, length * dx, length * dy, colour);
    if (!amount) return;
    const beside = this.lanes.some((lane) => lane !== 0); // above it another handle may stand
    const outward = dx < 0 ? "right" : "left"; // away from the handle that it is pressed against
    const at = beside ? [x + (length + 6) * dx, place.y] : [place.x - 5 * dx, place.y - rim - 13];
    const align = beside || camera.dof === 1 ? outward : "center";
    label(context, `${size.toFixed(1)} N`, ...at, { colour: theme.ink, align, weight: 600, width: this.width });
  }

  captions(width, height, flow) {
    const { context, session } = this;
    const middle = this.space ? 40 : 0.47 * height;
    label(context, "HANDS", 14, 18, { size: 11, weight: 600 });
    label(context, "SERVER", 14, height - 16, { size: 11, weight: 600 });
    const delays = session.users.map(({ name }) => `${milli(session.value(`${name}.delay_up`), 0)} + ${milli(session.value(`${name}.delay_down`), 0)}`);
    const same = new Set(delays).size === 1;
    const known = session.users.some(({ name }) => Number.isFinite(session.value(`${name}.delay_up`) + session.value(`${name}.delay_down`)));
    const text = known ? `delay ${same ? delays[0] : delays.join(", ")} ms` : "delay not known yet";
    const few = same ? delays[0] : delays.length < 4 ? delays.join(", ") : "";
    if (width > 560 || few) label(context, width > 560 || !known ? text : `${few} ms`, 14, middle, { size: 12 });
    const late = flow.late_s ? `, ${flow.late_s.toFixed(2)} s late` : "";
    if (width > 560) label(context, theme.still ? "packets on their way" : `packets ${SLOWER} times slower${late}`, width - 14, this.space ? height - 16 : middle, { align: "right", size: 12 });
  }
}
