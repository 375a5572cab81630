// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The hand of the person at this page: which handle it holds, and where it wants it to be.
// A held target is sent by a timer also while nothing moves: silence means that the hand let go.

const LEAST_MS = 12; // between two targets

export class Hand {
  /** `refused` is called with the reason where a handle cannot be taken. */
  constructor(socket, session, refused) {
    Object.assign(this, { socket, session, refused });
    this.index = null; // of the user in session.users
    this.target = null; // [m], while held
    this.by = null; // the means that holds: pointer, keys, gamepad
    this.sent_ms = 0;
    this.moves = []; // functions (dt) -> displacement [m], asked at every heartbeat
    this.before_ms = performance.now();
    this.timer = setInterval(() => this.beat(), 1e3 * session.heartbeat_s);
  }

  get held() { return this.target !== null; }

  get user() { return this.index === null ? null : this.session.users[this.index]; }

  /** Take hold of a handle at the place where it is; where that is not known, there is none. */
  async take(index, by) {
    const user = this.session.users[index];
    if (!user?.remote || !this.session.place(user.name)) return;
    if (this.held && this.index === index) { this.by = by; return; }
    if (this.index !== null && this.index !== index) this.free();
    this.pending = by;
    if (user.holder !== "you") {
      const answer = await this.socket.request("take", { user: user.name });
      if (!answer.done) { this.pending = null; this.refused(answer.text); return; }
      user.holder = "you";
    }
    this.index = index;
    if (this.pending !== by) return; // let go meanwhile
    this.pending = null;
    this.target = this.session.place(user.name);
    if (!this.held) return; // its master fell silent meanwhile
    this.by = by;
    this.send();
  }

  /** Move the target by a displacement [m]. */
  move(displacement) {
    if (!this.held) return;
    const { workspace_m } = this.user;
    this.target = this.target.map((each, axis) => {
      const wanted = each + (displacement[axis] ?? 0);
      return workspace_m ? Math.max(-workspace_m, Math.min(workspace_m, wanted)) : wanted;
    });
    if (performance.now() - this.sent_ms >= LEAST_MS) this.send();
  }

  /** Let go; the handle stays reserved for this page. */
  release(by = null) {
    if (by && this.pending === by) this.pending = null;
    if (!this.held || (by && this.by !== by)) return;
    this.target = this.by = null;
    this.socket.send("target", { user: this.user.name, position: null });
  }

  /** Let go and leave the handle to others. */
  free() {
    this.pending = null;
    if (this.index === null) return;
    this.target = this.by = null;
    this.socket.send("let_go", { user: this.user.name });
    this.user.holder = null;
    this.index = null;
  }

  /** The connection is gone: the hand has let go, and reserves nothing. */
  lost() { this.target = this.by = this.pending = this.index = null; }

  close() { clearInterval(this.timer); this.lost(); }

  beat() {
    const now_ms = performance.now(), dt = Math.min(0.05, 1e-3 * (now_ms - this.before_ms));
    this.before_ms = now_ms;
    for (const move of this.moves) {
      const displacement = move(dt);
      if (displacement) this.move(displacement);
    }
    if (this.held && now_ms - this.sent_ms >= LEAST_MS) this.send();
  }

  send() {
    this.sent_ms = performance.now();
    this.socket.send("target", { user: this.user.name, position: this.target });
  }
}
