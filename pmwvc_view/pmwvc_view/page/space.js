// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The bodies of a scene as solids, by WebGL, on a canvas behind that of the scene; seen by the
// scene's camera. Where there is no WebGL there is no space, and the scene draws outlines.

import { solid } from "./solids.js";
import { theme } from "./theme.js";
import { Camera } from "./vendor/ogl/core/Camera.js";
import { Geometry } from "./vendor/ogl/core/Geometry.js";
import { Mesh } from "./vendor/ogl/core/Mesh.js";
import { Program } from "./vendor/ogl/core/Program.js";
import { Renderer } from "./vendor/ogl/core/Renderer.js";
import { Transform } from "./vendor/ogl/core/Transform.js";

const GHOST = 0.3; // how much is seen of what is not there, or not yet
const SHADE = 0.16; // how dark a shadow is
const LAMP = [0.3, -0.4, 1]; // the way to it
const FLOOR_M = 0.02; // below all that there is
const VERTEX = `#version 300 es
in vec3 position, normal;
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
uniform float ground, shadow; // height on which a shadow falls; 1: this is one
out vec3 across;
void main() {
  vec4 at = modelMatrix * vec4(position, 1.0);
  at.xyz -= shadow * (at.z - ground) * vec3(${LAMP}) / ${LAMP[2].toFixed(1)};
  across = mat3(modelMatrix) * normal;
  gl_Position = projectionMatrix * viewMatrix * at;
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 across;
uniform vec3 colour;
uniform float alpha;
out vec4 seen;
void main() {
  vec3 n = normalize(across);
  float light = 0.58 + 0.1 * n.z + 0.32 * max(dot(n, normalize(vec3(${LAMP}))), 0.0);
  seen = vec4(colour * light, alpha);
}`;

let renderer; // of the page's canvas, once one was made; null: there is no WebGL

function rendererOf(canvas) {
  if (renderer === undefined) {
    const asked = { depth: true, stencil: true, antialias: devicePixelRatio < 2, alpha: false };
    renderer = canvas.getContext("webgl2", asked) ? new Renderer({ ...asked, canvas, dpr: 1 }) : null;
    canvas.removeAttribute("style"); // its size is the style sheet's
    canvas.addEventListener("webglcontextlost", () => { renderer = null; });
  }
  return renderer;
}

const ends = (points, most) => [0, 1, 2].map((axis) => most(...points.map((point) => point[axis])));
const rgb = (text) => [1, 3, 5].map((from) => Number.parseInt(text.slice(from, from + 2), 16) / 255);

export class Space {
  /** The space of a scene's bodies; null where there is no WebGL. */
  static of(canvas, bodies) {
    return rendererOf(canvas) ? new Space(canvas, bodies) : null;
  }

  constructor(canvas, bodies) {
    const { gl } = renderer;
    Object.assign(this, { canvas, bodies, gl, root: new Transform(), eye: new Camera(gl) });
    this.eye.matrixAutoUpdate = false;
    const program = (transparent, shadow = 0) => new Program(gl, {
      vertex: VERTEX, fragment: FRAGMENT, cullFace: gl.BACK, transparent, depthWrite: !transparent,
      uniforms: { colour: { value: [0, 0, 0] }, alpha: { value: 1 }, ground: { value: 0 }, shadow: { value: shadow } },
    });
    this.programs = [program(false), program(true)];
    this.shade = program(true, 1);
    this.shade.setStencilFunc(gl.EQUAL, 0, 255); // no place is darkened twice
    this.shade.setStencilOp(gl.KEEP, gl.KEEP, gl.INCR);
    this.nodes = canvas.bodies = new Map(); // by the name of their body
    for (const shape of bodies.shapes) {
      const mesh = this.add(shape, this.node(shape.body));
      if (!bodies.fixed[shape.body]) this.shadow(mesh, shape.body);
    }
    this.goal = new Transform();
    this.goal.setParent(this.root);
    for (const shape of bodies.shapes) if (shape.body === bodies.carried) this.add(shape, this.goal, GHOST);
    this.grid = null;
  }

  get lost() { return renderer === null; }

  node(body) {
    if (!this.nodes.has(body)) {
      this.nodes.set(body, new Transform());
      this.nodes.get(body).setParent(this.root);
    }
    return this.nodes.get(body);
  }

  add(shape, node, alpha = 1) {
    const mesh = this.mesh(solid(shape), () => this.look(shape), alpha * (this.bodies.colour(shape)?.[3] ?? 1));
    mesh.position.set(shape.at);
    const [w, x, y, z] = shape.turned;
    mesh.quaternion.set(x, y, z, w);
    mesh.setParent(node);
    return mesh;
  }

  mesh({ position, normal, index }, look, alpha, mode = this.gl.TRIANGLES) {
    const data = (of) => ({ size: 3, data: new Float32Array(of) });
    const geometry = new Geometry(this.gl, { position: data(position), normal: data(normal), index: { data: new Uint32Array(index) } });
    const mesh = new Mesh(this.gl, { geometry, program: this.programs[0], mode, frustumCulled: false });
    mesh.seen = (there) => {
      mesh.alpha = there ? alpha : Math.min(alpha, GHOST);
      mesh.program = this.programs[Number(mesh.alpha < 1)];
    };
    mesh.seen(true);
    return mesh.onBeforeRender(() => {
      mesh.program.uniforms.colour.value = look();
      mesh.program.uniforms.alpha.value = mesh.alpha;
    });
  }

  /** The shadow of a mesh on what is below its body. */
  shadow({ geometry, position, quaternion, parent }, body) {
    const mesh = new Mesh(this.gl, { geometry, program: this.shade, frustumCulled: false });
    mesh.position.copy(position);
    mesh.quaternion.copy(quaternion);
    mesh.seen = (there) => { mesh.visible = there; };
    mesh.onBeforeRender(() => Object.assign(this.shade.uniforms, { ground: { value: this.below(body) }, alpha: { value: SHADE } }));
    mesh.setParent(parent);
  }

  /** Height of what a body is above: the highest fixed shape under its middle, or the floor. */
  below(body) {
    const { x, y, z } = this.nodes.get(body).position;
    return Math.max(this.low, ...this.tops.filter(({ from, to }) => from[0] < x && x < to[0] && from[1] < y && y < to[1] && to[2] < z).map(({ to }) => to[2])) + this.thin;
  }

  /** The colour of a shape: of its user, of its file, or one of the page's. */
  look(shape) {
    if (shape.user >= 0) return rgb(theme.users[shape.user % 8]);
    return this.bodies.colour(shape)?.slice(0, 3) ?? rgb(this.bodies.fixed[shape.body] ? theme.grid : theme.body);
  }

  /** A floor of squares: on the planes of the scene, or below all that there is. */
  floor(middle, reach_m) {
    const { bodies } = this;
    const fixed = bodies.shapes.filter(({ kind, body }) => kind !== "plane" && bodies.fixed[body]).map((shape) => bodies.corners(shape, bodies.fixed[shape.body]));
    this.tops = fixed.map((corners) => ({ from: ends(corners, Math.min), to: ends(corners, Math.max) }));
    const planes = bodies.shapes.filter(({ kind, body }) => kind === "plane" && bodies.pose(body)).map(({ body, at }) => at[2] + bodies.pose(body)[2]);
    this.low = planes.length ? Math.max(...planes) : ends(bodies.extent(), Math.min)[2] - FLOOR_M;
    this.thin = 1e-3 * reach_m;
    const low = this.low + this.thin / 2;
    const step = 10 ** Math.ceil(Math.log10(reach_m / 4)) / 2, count = Math.ceil((3 * reach_m) / step);
    const [x0, y0] = middle.map((each) => Math.round(each / step) * step);
    const position = [];
    for (let i = -count; i <= count; i += 1) {
      const [a, b] = [i * step, count * step];
      position.push(x0 + a, y0 - b, low, x0 + a, y0 + b, low, x0 - b, y0 + a, low, x0 + b, y0 + a, low);
    }
    const normal = position.map((_, i) => Number(i % 3 === 2));
    this.grid = this.mesh({ position, normal, index: [...Array(position.length / 3).keys()] }, () => rgb(theme.target), GHOST, this.gl.LINES);
    this.grid.setParent(this.root);
  }

  draw(camera, width, height) {
    const { gl, canvas, bodies } = this, ratio = Math.min(devicePixelRatio || 1, 2);
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [renderer.width, renderer.height] = [w, h];
    if (!this.grid && bodies.extent(true).length) this.floor(camera.middle, camera.reach_m);
    for (const [body, node] of this.nodes) this.place(node, bodies.pose(body));
    this.place(this.goal, bodies.goal());
    bodies.held.forEach((body, user) => this.nodes.get(body).children.forEach((mesh) => mesh.seen(bodies.there(user))));
    const [right, up, away] = camera.axes(), at = camera.middle.map((each, i) => each - away[i] * camera.distance_m);
    this.eye.matrix.set(...right, 0, ...up, 0, ...away.map((each) => -each), 0, ...at, 1);
    this.eye.worldMatrixNeedsUpdate = true;
    const fov = (360 / Math.PI) * Math.atan(height / 2 / (camera.scale * camera.distance_m));
    this.eye.perspective({ fov, aspect: width / height, near: 0.1 * camera.distance_m, far: 20 * camera.distance_m });
    gl.clearColor(...rgb(theme.paper), 1);
    if (this.grid) renderer.render({ scene: this.root, camera: this.eye });
  }

  place(node, pose) {
    node.visible = pose !== null;
    if (!pose) return;
    const [x, y, z, w, a, b, c] = pose;
    node.position.set(x, y, z);
    node.quaternion.set(a, b, c, w);
  }
}
