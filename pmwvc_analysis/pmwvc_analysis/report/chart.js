// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Draws a report's figures, with zoom, pan and cursor; all panels of time move together.
// Without a script there are pictures instead. Nothing is loaded from elsewhere.
"use strict";
(() => {
  const store = document.getElementById("chart-data");
  if (!store) return;
  const data = JSON.parse(store.textContent);
  const arrays = data.arrays.map((entry) => {
    const text = atob(entry), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++) bytes[i] = text.charCodeAt(i);
    return new Float32Array(bytes.buffer);
  });
  const LEFT = 56, RIGHT = 10, TOP = 6, BOTTOM = 34;
  const MARKS = {
    dot: "h0", cross: "m-3-3l6 6m0-6l-6 6", plus: "m-3 0h6m-3-3v6",
    ring: "m-3 0a3 3 0 1 0 6 0a3 3 0 1 0-6 0",
  };
  const full = data.span;
  let range = [...full], panels = [], queued = false;
  const paint = (name) => `var(--c-${name})`;
  const safe = (text) => String(text).replace(/[&<>"]/g, (c) => `&#${c.charCodeAt(0)};`);
  const clamp = (value, low, high) => Math.min(high, Math.max(low, value));

  function axis(low, high, start, end, log) {
    const at = log
      ? (v) => start + Math.log(Math.max(v, 1e-300) / low) / Math.log(high / low) * (end - start)
      : (v) => start + (v - low) / (high - low) * (end - start);
    const back = (place) => low + (place - start) / (end - start) * (high - low);
    return { low, high, start, end, log, at, back };
  }
  function ticks(a, wanted) {
    const found = [];
    if (a.log) {
      for (let p = Math.ceil(Math.log10(a.low)); p <= Math.log10(a.high); p++) {
        found.push([10 ** p, String(+(10 ** p).toPrecision(6))]);
      }
      return found;
    }
    const raw = (a.high - a.low) / Math.max(1, wanted), base = 10 ** Math.floor(Math.log10(raw));
    const step = base * [1, 2, 5, 10].find((s) => base * s >= raw * (1 - 1e-9));
    const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    for (let n = Math.ceil(a.low / step - 1e-9); n <= a.high / step + 1e-9; n++) {
      found.push([n * step, (n * step).toFixed(digits).replace("-", "−")]);
    }
    return found.length ? found : ticks(a, wanted + 1); // round values further apart than the axis is long
  }
  // First place in sorted values that is not below the wanted one.
  function place(values, wanted) {
    let low = 0, high = values.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (values[middle] < wanted) low = middle + 1; else high = middle;
    }
    return low;
  }
  function within(x, a) {
    if (a.log) return [0, x.length];
    return [Math.max(0, place(x, a.low) - 1), Math.min(x.length, place(x, a.high) + 1)];
  }
  function ySpan(panel, x) {
    let low = Infinity, high = -Infinity;
    const see = (v) => {
      if (Number.isFinite(v) && (v > 0 || !panel.y_log)) { low = Math.min(low, v); high = Math.max(high, v); }
    };
    const scan = (xs, ys) => {
      const sorted = panel.of_time, [from, to] = sorted ? within(xs, x) : [0, xs.length];
      for (let i = from; i < to; i++) if (!sorted || (xs[i] >= x.low && xs[i] <= x.high)) see(ys[i]);
    };
    for (const each of [...panel.lines, ...panel.dots]) if (!panel.hidden.has(each.label)) scan(arrays[each.x], arrays[each.y]);
    panel.levels.forEach((level) => see(level.y));
    if (panel.with_zero) see(0);
    if (low > high) return panel.y_log ? [0.1, 1] : [0, 1];
    if (panel.y_log) return [low / 1.1, Math.max(high * 1.1, low * 10)];
    const flat = high - low <= 1e-9 * Math.max(Math.abs(low), Math.abs(high), 1e-6);
    const room = flat ? 0.5 * Math.max(Math.abs(high), 1e-3) : 0.05 * (high - low);
    return [low - room, high + room];
  }
  // Per column of the picture: first, lowest, highest, last.
  function linePath(line, x, y) {
    const xs = arrays[line.x], ys = arrays[line.y], [from, to] = within(xs, x);
    const pixel = (x.high - x.low) / (x.end - x.start);
    const gap = line.period > 0 && !x.log ? Math.max(1.5 * line.period, pixel) : Infinity;
    const out = [];
    let open = false, column = NaN, first, lowest, highest, last;
    const point = (i) => { out.push(open ? "L" : "M", x.at(xs[i]).toFixed(1), " ", y.at(ys[i]).toFixed(1)); open = true; };
    const flush = () => {
      if (first === undefined) return;
      for (const i of [...new Set([first, lowest, highest, last])].sort((a, b) => a - b)) point(i);
      first = undefined;
    };
    const end = () => { const single = first !== undefined && first === last && !open; flush(); if (single) out.push("h.6"); open = false; column = NaN; };
    for (let i = from; i < to; i++) {
      if (!Number.isFinite(ys[i])) { end(); continue; }
      if (last !== undefined && i > from && xs[i] - xs[i - 1] > gap) end();
      const c = x.log ? i : Math.floor(x.at(xs[i]));
      if (c !== column) { flush(); column = c; }
      if (first === undefined) first = lowest = highest = i;
      if (ys[i] < ys[lowest]) lowest = i;
      if (ys[i] > ys[highest]) highest = i;
      last = i;
    }
    end();
    return out.join("");
  }
  function dotsPath(dots, x, y) {
    const xs = arrays[dots.x], ys = arrays[dots.y], seen = new Set();
    const grid = { dot: 1.5, ring: 0.1 }[dots.mark] ?? 4.5;
    for (let i = 0; i < xs.length; i++) {
      if (xs[i] < x.low || xs[i] > x.high || !Number.isFinite(ys[i])) continue;
      const a = Math.round(x.at(xs[i]) / grid) * grid, b = Math.round(y.at(ys[i]) / grid) * grid;
      seen.add(`M${a.toFixed(1)} ${b.toFixed(1)}${MARKS[dots.mark]}`);
    }
    return [...seen].join("");
  }
  function draw(panel) {
    const width = Math.max(280, panel.svg.parentElement.clientWidth || 1000);
    const bottom = TOP + panel.height, labelled = panel.labelled;
    const span = panel.of_time ? range : panel.own;
    const x = axis(...span, LEFT, width - RIGHT, panel.x_log);
    const y = axis(...ySpan(panel, x), bottom, TOP, panel.y_log);
    panel.x = x;
    const out = [`<g style="fill:${paint("soft")}">`];
    const rule = (d) => out.push(`<path class="grid" style="stroke:${paint("grid")}" d="${d}"/>`);
    for (const [value, text] of ticks(y, Math.round(panel.height / 36))) {
      rule(`M${LEFT} ${y.at(value).toFixed(1)}H${x.end}`);
      out.push(`<text x="${LEFT - 6}" y="${(y.at(value) + 4).toFixed(1)}" text-anchor="end">${text}</text>`);
    }
    for (const [value, text] of ticks(x, Math.max(2, Math.round(width / 100)))) {
      const at = x.at(value).toFixed(1);
      rule(`M${at} ${TOP}V${bottom}`);
      if (labelled) out.push(`<text x="${at}" y="${bottom + 15}" text-anchor="middle">${text}</text>`);
    }
    if (labelled) out.push(`<text x="${(LEFT + x.end) / 2}" y="${bottom + 30}" text-anchor="middle">${safe(panel.x_label)}</text>`);
    const w = x.end - LEFT;
    out.push(`</g><svg x="${LEFT}" y="${TOP}" width="${w}" height="${panel.height}" viewBox="${LEFT} ${TOP} ${w} ${panel.height}">`);
    for (const { span: [a, b], label, tint } of panel.bands) {
      out.push(`<rect class="band" x="${x.at(a).toFixed(1)}" y="${TOP}" width="${Math.max(1, x.at(b) - x.at(a)).toFixed(1)}" height="${panel.height}" style="fill:${paint(tint)}" opacity=".18"><title>${safe(label)}</title></rect>`);
    }
    const level = (at, style) => out.push(`<path class="line" style="${style}" d="M${LEFT} ${y.at(at).toFixed(1)}H${x.end}"/>`);
    if (panel.with_zero) level(0, `stroke:${paint("object")};stroke-width:.9`);
    for (const { y: at, tint } of panel.levels) level(at, `stroke:${paint(tint)};stroke-dasharray:2 3`);
    for (const each of panel.lines) {
      if (panel.hidden.has(each.label)) continue;
      const dash = each.dash.length ? `;stroke-dasharray:${each.dash.join(" ")}` : "";
      out.push(`<path class="line" style="stroke:${paint(each.tint)};stroke-width:${each.width}${dash}" d="${linePath(each, x, y)}"/>`);
    }
    for (const each of panel.dots) {
      if (!panel.hidden.has(each.label)) out.push(`<path class="dots ${each.mark}" style="stroke:${paint(each.tint)}" d="${dotsPath(each, x, y)}"/>`);
    }
    if (panel.of_time) {
      let free = -Infinity;
      for (const [time, number, text] of data.events) {
        const at = x.at(time);
        if (at < LEFT - 1 || at > x.end + 1) continue;
        out.push(`<path class="ev" style="stroke:${paint("soft")};stroke-dasharray:1 4" d="M${at.toFixed(1)} 0V9999"><title>${safe(text)}</title></path>`);
        if (at < free) continue;
        out.push(`<text class="ev" x="${(at + 3).toFixed(1)}" y="${TOP + 10}" style="fill:${paint("soft")};font-size:10px">${safe(number)}<title>${safe(text)}</title></text>`);
        free = at + 16;
      }
    }
    out.push(`<rect class="chosen" y="0" height="9999" width="0" style="fill:${paint("soft")}" opacity=".2"/>`);
    out.push(`<path class="cursor" d="" style="stroke:${paint("ink")};stroke-width:.8"/></svg>`);
    const height = bottom + (labelled ? BOTTOM : 4);
    panel.svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    panel.svg.innerHTML = out.join("");
  }
  function drawAll() {
    queued = false;
    for (const panel of panels) draw(panel);
    const shown = document.getElementById("range");
    if (shown) shown.textContent = `${range[0].toFixed(3)} to ${range[1].toFixed(3)} s`;
  }
  const later = () => { if (!queued) { queued = true; requestAnimationFrame(drawAll); } };
  function show(low, high) {
    const length = clamp(high - low, 0.002, full[1] - full[0]);
    low = clamp(low, full[0], full[1] - length);
    range = [low, low + length];
    later();
  }
  const zoom = (factor, at = (range[0] + range[1]) / 2) => show(at + (range[0] - at) * factor, at + (range[1] - at) * factor);
  const pan = (share) => show(range[0] + share * (range[1] - range[0]), range[1] + share * (range[1] - range[0]));

  function value(panel, each, time) {
    const xs = arrays[each.x];
    let i = place(xs, time);
    if (i > 0 && (i === xs.length || time - xs[i - 1] < xs[i] - time)) i--;
    const far = each.period > 0 && Math.abs(xs[i] - time) > 1.5 * each.period;
    const v = each.low === undefined ? arrays[each.y][i] : arrays[each.high][i] - arrays[each.low][i];
    return far || !Number.isFinite(v) ? "–" : v.toPrecision(4).replace("-", "−");
  }
  function point(time) {
    for (const panel of panels) {
      if (!panel.of_time) continue;
      const cursor = panel.svg.querySelector(".cursor");
      if (cursor) cursor.setAttribute("d", time === null ? "" : `M${panel.x.at(time).toFixed(1)} 0V9999`);
      for (const [label, output] of panel.outputs) {
        const each = panel.lines.find((line) => line.label === label);
        output.textContent = time === null || !each ? "" : value(panel, each, time);
      }
    }
    const shown = document.getElementById("cursor");
    if (shown) shown.textContent = time === null ? "" : `cursor ${time.toFixed(4)} s`;
  }
  function attend(panel) {
    const svg = panel.svg;
    let from = null, before = null;
    const timeOf = (event) => {
      const box = svg.getBoundingClientRect(), scale = svg.viewBox.baseVal.width / box.width;
      return clamp(panel.x.back((event.clientX - box.left) * scale), ...range);
    };
    svg.addEventListener("pointerdown", (event) => {
      from = timeOf(event);
      before = event.shiftKey || event.pointerType === "touch" ? { x: event.clientX, range: [...range] } : null;
      if (event.pointerType !== "touch") svg.setPointerCapture(event.pointerId);
    });
    svg.addEventListener("pointermove", (event) => {
      const time = timeOf(event);
      if (from !== null && before) {
        const shift = (event.clientX - before.x) / svg.getBoundingClientRect().width * (before.range[1] - before.range[0]);
        show(before.range[0] - shift, before.range[1] - shift);
      } else if (from !== null) {
        const [a, b] = [panel.x.at(from), panel.x.at(time)], chosen = svg.querySelector(".chosen");
        chosen.setAttribute("x", Math.min(a, b));
        chosen.setAttribute("width", Math.abs(a - b));
      }
      point(time);
    });
    svg.addEventListener("pointerup", (event) => {
      const to = timeOf(event);
      if (from !== null && !before && Math.abs(panel.x.at(from) - panel.x.at(to)) > 5) show(Math.min(from, to), Math.max(from, to));
      else later();
      from = before = null;
    });
    svg.addEventListener("pointercancel", () => { from = before = null; });
    svg.addEventListener("pointerleave", () => { if (from === null) point(null); });
    svg.addEventListener("dblclick", () => show(...full));
    svg.addEventListener("wheel", (event) => {
      if (!event.ctrlKey && !event.altKey) return;
      event.preventDefault();
      zoom(Math.exp(event.deltaY * 0.002), timeOf(event));
    }, { passive: false });
    svg.addEventListener("keydown", (event) => {
      const does = { ArrowLeft: () => pan(-0.2), ArrowRight: () => pan(0.2), "+": () => zoom(0.5), "-": () => zoom(2), 0: () => show(...full), Escape: () => show(...full) }[event.key];
      if (does) { event.preventDefault(); does(); }
    });
  }
  // The mark of a legend, 26 by 12.
  function sample(each) {
    if (each.mark) return `<path class="dots ${each.mark}" style="stroke:${paint(each.tint)}" d="M13 6${MARKS[each.mark]}"/>`;
    const dash = each.dash.length ? `;stroke-dasharray:${each.dash.join(" ")}` : "";
    return `<path class="sample" style="stroke:${paint(each.tint)};stroke-width:${each.width}${dash}" d="M0 6H26"/>`;
  }
  function build(panel, heading) {
    const once = (all, label) => [...new Map(all.map((each) => [label(each), each]).reverse()).values()].reverse();
    const key = panel.title ? [`<strong style="color:${paint(panel.tint)}">${safe(panel.title)}</strong>`] : [];
    key.push(`<span class="unit">${safe(panel.y_label)}</span>`);
    for (const each of once([...panel.lines, ...panel.dots], (one) => one.label)) {
      key.push(`<button class="entry" data-label="${safe(each.label)}" aria-pressed="true"><svg viewBox="0 0 26 12">${sample(each)}</svg><span>${safe(each.label)}</span><output></output></button>`);
    }
    for (const { label, tint } of once(panel.bands, (band) => band.label)) {
      key.push(`<span><span class="swatch" style="background:${paint(tint)}"></span>${safe(label)}</span>`);
    }
    for (const { label } of once(panel.levels, (level) => level.label)) key.push(`<span>· · · ${safe(label)}</span>`);
    const element = document.createElement("div");
    element.className = "panel";
    element.innerHTML = `<div class="key">${key.join("")}</div><svg class="plot" tabindex="0" role="img" aria-label="${safe(`${heading} ${panel.title} ${panel.y_label}`)}"></svg>`;
    return element;
  }
  for (const chart of data.charts) {
    const figure = document.getElementById(chart.name);
    if (!figure) continue;
    chart.panels.forEach((panel, i) => {
      const element = build(panel, chart.heading);
      figure.insertBefore(element, figure.querySelector("figcaption"));
      panel.svg = element.querySelector("svg.plot");
      panel.labelled = !panel.of_time || i === chart.panels.length - 1;
      panel.hidden = new Set();
      panel.outputs = [];
      if (!panel.of_time) {
        const xs = [...panel.lines, ...panel.dots].flatMap((each) => Array.from(arrays[each.x])).filter((v) => v > 0 || !panel.x_log);
        const [low, high] = [xs.reduce((a, b) => Math.min(a, b)), xs.reduce((a, b) => Math.max(a, b))];
        panel.own = panel.x_log ? [low / 1.1, Math.max(high * 1.1, low * 10)] : [low, high];
      }
      for (const button of element.querySelectorAll(".entry")) {
        const label = button.dataset.label;
        panel.outputs.push([label, button.querySelector("output")]);
        button.addEventListener("click", () => {
          if (!panel.hidden.delete(label)) panel.hidden.add(label);
          button.setAttribute("aria-pressed", String(!panel.hidden.has(label)));
          later();
        });
      }
      if (panel.of_time) attend(panel);
      panels.push(panel);
    });
  }
  const tools = { "zoom-in": () => zoom(0.5), "zoom-out": () => zoom(2), earlier: () => pan(-0.25), later: () => pan(0.25), whole: () => show(...full) };
  for (const [id, act] of Object.entries(tools)) document.getElementById(id)?.addEventListener("click", act);
  document.body.classList.add("live");
  drawAll();
  new ResizeObserver(later).observe(document.querySelector("main"));
})();
