// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Mouse, pen, touch and keyboard: how they take hold of a handle, move it and turn the view.

const GRAB_PX = 70; // from the middle of a handle, for the hand that comes nearest
const SPEED_M_S = 0.12; // of the arrow keys
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
  let drag = null;
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (drag || event.button > 0) return;
    const [x, y] = place(event);
    const handle = nearest(scene, session, x, y);
    if (!handle && session.dof < 3) return;
    canvas.setPointerCapture(event.pointerId);
    drag = { id: event.pointerId, x: event.clientX, y: event.clientY, now: event, handle };
    if (handle) { canvas.dataset.held = ""; hand.take(handle.user, "pointer").then(follow); }
  }, { signal });
  // Raw moves come as they happen, not once a frame; only pages of this machine or https get them.
  const moved = "onpointerrawupdate" in canvas ? "pointerrawupdate" : "pointermove";
  canvas.addEventListener(moved, (event) => {
    if (event.pointerId !== drag?.id) return;
    drag.now = event;
    follow();
  }, { signal });
  /** Go where the pointer is; while the handle is being taken its way is kept for later. */
  function follow() {
    if (!drag || (drag.handle && hand.by !== "pointer")) return;
    const dx = drag.now.clientX - drag.x, dy = drag.now.clientY - drag.y;
    if (drag.handle) hand.move(scene.camera.inPlane(dx, dy, drag.handle.scale));
    else scene.camera.turn(dx, dy);
    [drag.x, drag.y] = [drag.now.clientX, drag.now.clientY];
  }
  const end = (event) => {
    if (event.pointerId !== drag?.id) return;
    drag = null;
    delete canvas.dataset.held;
    hand.release("pointer");
  };
  for (const kind of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(kind, end, { signal });
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
