// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// The connection to the server: messages in either direction, answers to requests, coming back
// after a break. Snapshots are acknowledged here, so that a page that is blocked gets no queue.

const SEEN_EVERY = 2; // snapshots; the server sends eight before it waits
const RETRY_MS = [250, 500, 1000, 2000];

export class Socket {
  /** `on`: functions by kind of message, and `snapshot`, `open`, `closed`. */
  constructor(on) {
    this.on = on;
    this.requests = new Map();
    this.next = 1;
    this.tries = 0;
    this.taken = 0;
    this.open();
  }

  open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/socket${location.search}`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => { this.tries = 0; this.on.open(); };
    this.socket.onmessage = (event) => this.receive(event.data);
    this.socket.onclose = (event) => this.closed(event);
  }

  get isOpen() { return this.socket.readyState === WebSocket.OPEN; }

  receive(data) {
    if (typeof data !== "string") {
      const seq = this.on.snapshot(data);
      this.taken += 1;
      if (this.taken % SEEN_EVERY === 0) this.send("seen", { seq });
      return;
    }
    const message = JSON.parse(data);
    if (message.kind === "answer" || message.kind === "prediction") {
      const settle = this.requests.get(message.id);
      this.requests.delete(message.id);
      if (settle) settle(message);
    } else if (this.on[message.kind]) {
      this.on[message.kind](message);
    }
  }

  /** The session is over: do not come back. */
  end() { this.over = true; }

  closed(event) {
    for (const settle of this.requests.values()) settle({ done: false, text: "not connected" });
    this.requests.clear();
    if (this.over) return;
    const wait_ms = RETRY_MS[Math.min(this.tries, RETRY_MS.length - 1)];
    this.on.closed(event, this.tries++);
    setTimeout(() => this.open(), wait_ms);
  }

  send(kind, fields) {
    if (this.isOpen) this.socket.send(JSON.stringify({ kind, ...fields }));
  }

  /** Send a request and return a promise of its answer; it is never rejected. */
  request(kind, fields) {
    if (!this.isOpen) return Promise.resolve({ done: false, text: "not connected" });
    const id = this.next++;
    this.send(kind, { ...fields, id });
    return new Promise((resolve) => this.requests.set(id, resolve));
  }
}
