// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Mouse, pen, touch and keyboard: how they take hold of a handle, move it and turn the view.

const GRAB_PX = 70; // from the middle of a handle, for the hand that comes nearest
const SPEED_M_S = 0.12; // of the arrow keys
const WHEEL = 1.5e-3, WHEEL_M = 5e-5; // of a step of the wheel: how much nearer, and how far a held handle goes [m]
const KEYS = {
  ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0],
  PageUp: [0, 0, 1], PageDown: [0, 0, -1],
};

/** The user whose handle is nearest to a point of the canvas, where it can be taken. */
function nearest(scene, session, x, y) {
  let found = null, least = GRAB_PX;
  for (const handle of scene.handles) {
    const { remote, holder } = session.users[handle.user];
    const distance = Math.hypot(handle.x - x, handle.y - y);
    if (remote && holder !== "other" && distance < least) [found, least] = [handle, distance];
  }
  return found;
}

export function pointers(canvas, scene, hand, session, signal) {
  const { camera } = scene, down = new Map(); // pointers, by id: where they were, and what they hold
  const moved = (pointer) => [pointer.now.clientX - pointer.x, pointer.now.clientY - pointer.y];
  const apart = ([a, b], of) => Math.hypot(of(a)[0] - of(b)[0], of(a)[1] - of(b)[1]);
  canvas.addEventListener("pointerdown", (event) => {
    const box = canvas.getBoundingClientRect();
    const free = event.button === 0 && ![...down.values()].some(({ handle }) => handle);
    const handle = free ? nearest(scene, session, event.clientX - box.left, event.clientY - box.top) : null;
    if (!handle && session.dof < 3) return;
    canvas.setPointerCapture(event.pointerId);
    down.set(event.pointerId, { x: event.clientX, y: event.clientY, now: event, handle });
    if (handle) { canvas.dataset.held = ""; hand.take(handle.user, "pointer").then(follow); }
  }, { signal });
  // Raw moves come as they happen, not once a frame; only pages of this machine or https get them.
  const kind = "onpointerrawupdate" in canvas ? "pointerrawupdate" : "pointermove";
  canvas.addEventListener(kind, (event) => {
    if (!down.has(event.pointerId)) return;
    down.get(event.pointerId).now = event;
    follow();
  }, { signal });
  /** Go where the pointers are; while a handle is being taken their way is kept for later. */
  function follow() {
    const every = [...down.values()], others = every.filter(({ handle }) => !handle);
    const holding = every.find(({ handle }) => handle);
    if (holding && hand.by !== "pointer") return;
    const turns = session.dof > 3 && holding?.now.shiftKey;
    if (holding) hand.move(camera[turns ? "turning" : "inPlane"](...moved(holding), holding.handle.scale));
    for (const other of others) {
      const [dx, dy] = moved(other);
      if (holding) hand.move(camera.inDepth(-dy / holding.handle.scale));
      else camera.turn(dx / others.length, dy / others.length);
    }
    if (others.length === 2 && !holding) {
      camera.zoom(apart(others, ({ now }) => [now.clientX, now.clientY]) / Math.max(1, apart(others, ({ x, y }) => [x, y])));
    }
    for (const pointer of every) [pointer.x, pointer.y] = [pointer.now.clientX, pointer.now.clientY];
  }
  const end = (event) => {
    const { handle } = down.get(event.pointerId) ?? {};
    down.delete(event.pointerId);
    if (!handle) return;
    delete canvas.dataset.held;
    hand.release("pointer");
  };
  for (const each of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(each, end, { signal });
  if (session.dof < 3) return;
  canvas.addEventListener("contextmenu", (event) => event.preventDefault(), { signal });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    if (hand.held) hand.move(camera.inDepth(-WHEEL_M * event.deltaY));
    else camera.zoom(Math.exp(-WHEEL * event.deltaY));
  }, { signal, passive: false });
}

export function keyboard(canvas, scene, hand, session, signal) {
  const down = new Set();
  let slow = false;
  canvas.addEventListener("keydown", (event) => {
    slow = event.shiftKey;
    if (event.key === " " || event.key === "Enter") {
      if (hand.held) hand.release();
      else hand.take(hand.index ?? free(session), "keys");
    } else if (event.key === "Escape") hand.release();
    else if (event.key in KEYS) down.add(event.key);
    else return;
    event.preventDefault();
  }, { signal });
  canvas.addEventListener("keyup", (event) => { down.delete(event.key); slow = event.shiftKey; }, { signal });
  canvas.addEventListener("blur", () => down.clear(), { signal });
  hand.moves.push((dt) => {
    if (!down.size) return null;
    const speed = slow ? SPEED_M_S / 6 : SPEED_M_S;
    return [...down].map((key) => KEYS[key]).reduce((sum, way) => sum.map((each, i) => each + way[i] * speed * dt), [0, 0, 0]);
  });
}

/** The first user whose handle nobody has and whose place is known; null where there is none. */
export function free(session) {
  const index = session.users.findIndex(({ name, remote, holder }) => remote && holder !== "other" && session.place(name));
  return index < 0 ? null : index;
}

/** Leaving the page lets go: another window, another tab, a phone that is put away. */
export function leaving(hand, signal) {
  window.addEventListener("blur", () => hand.release(), { signal });
  window.addEventListener("pagehide", () => hand.free(), { signal });
  document.addEventListener("visibilitychange", () => { if (document.hidden) hand.release(); }, { signal });
}
