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
const VERTEX = `#version 300 es
in vec3 position, normal;
uniform mat4 modelMatrix, viewMatrix, projectionMatrix;
out vec3 across, place;
void main() {
  vec4 at = modelMatrix * vec4(position, 1.0);
  across = mat3(modelMatrix) * normal;
  place = at.xyz;
  gl_Position = projectionMatrix * viewMatrix * at;
}`;
const FRAGMENT = `#version 300 es
precision highp float;
in vec3 across, place;
uniform vec3 cameraPosition, colour;
uniform float alpha;
out vec4 seen;
const vec3 LAMP = normalize(vec3(0.4, -0.6, 1.0));
void main() {
  vec3 eye = normalize(cameraPosition - place), n = normalize(across);
  n = dot(n, eye) < 0.0 ? -n : n;
  float light = 0.6 + 0.12 * n.z + 0.32 * max(dot(n, LAMP), 0.0);
  float shine = 0.18 * pow(max(dot(n, normalize(LAMP + eye)), 0.0), 40.0);
  seen = vec4(colour * light + shine, alpha);
}`;

let renderer; // of the page's canvas, once one was made; null: there is no WebGL

function rendererOf(canvas) {
  if (renderer === undefined) {
    const asked = { depth: true, antialias: true, alpha: false };
    renderer = canvas.getContext("webgl2", asked) ? new Renderer({ ...asked, canvas, dpr: 1 }) : null;
    canvas.removeAttribute("style"); // its size is the style sheet's
    canvas.addEventListener("webglcontextlost", () => { renderer = null; });
  }
  return renderer;
}

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
    const program = (transparent) => new Program(gl, {
      vertex: VERTEX, fragment: FRAGMENT, cullFace: false, transparent, depthWrite: !transparent,
      uniforms: { colour: { value: [0, 0, 0] }, alpha: { value: 1 } },
    });
    this.programs = [program(false), program(true)];
    this.nodes = canvas.bodies = new Map(); // by the name of their body
    for (const shape of bodies.shapes) this.add(shape, this.node(shape.body));
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

  mesh({ position, normal }, look, alpha, mode = this.gl.TRIANGLES) {
    const data = (of) => ({ size: 3, data: new Float32Array(of) });
    const geometry = new Geometry(this.gl, { position: data(position), normal: data(normal) });
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

  /** The colour of a shape: of its user, of its file, or one of the page's. */
  look(shape) {
    if (shape.user >= 0) return rgb(theme.users[shape.user % 8]);
    return this.bodies.colour(shape)?.slice(0, 3) ?? rgb(this.bodies.fixed[shape.body] ? theme.grid : theme.body);
  }

  /** A floor of squares below all that there is. */
  floor(middle, reach_m) {
    const step = 10 ** Math.ceil(Math.log10(reach_m / 4)) / 2, count = Math.ceil((2 * reach_m) / step);
    const low = Math.min(...this.bodies.extent().map(([, , z]) => z)) - 1e-3;
    const [x0, y0] = middle.map((each) => Math.round(each / step) * step);
    const position = [];
    for (let i = -count; i <= count; i += 1) {
      const [a, b] = [i * step, count * step];
      position.push(x0 + a, y0 - b, low, x0 + a, y0 + b, low, x0 - b, y0 + a, low, x0 + b, y0 + a, low);
    }
    const normal = position.map((_, i) => Number(i % 3 === 2));
    this.grid = this.mesh({ position, normal }, () => rgb(theme.target), GHOST, this.gl.LINES);
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
    renderer.render({ scene: this.root, camera: this.eye });
  }

  place(node, pose) {
    node.visible = pose !== null;
    if (!pose) return;
    const [x, y, z, w, a, b, c] = pose;
    node.position.set(x, y, z);
    node.quaternion.set(a, b, c, w);
  }
}
