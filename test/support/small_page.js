// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// A page just large enough for chart.js: node small_page.js CHART_JS DATA. Writes the panels of
// every figure by name, each as legend and drawing, to standard output as JSON.
"use strict";
const fs = require("fs");
const [script, data] = process.argv.slice(2).map((path) => fs.readFileSync(path, "utf8"));
const made = {};
class Element {
  constructor() { Object.assign(this, { children: [], dataset: {}, parentElement: { clientWidth: 1000 }, classList: { add() {} } }); }
  set innerHTML(text) {
    this.text = text;
    this.plot = text.includes('class="plot"') ? new Element() : undefined;
  }
  querySelector(wanted) { return wanted === "svg.plot" ? this.plot : new Element(); }
  querySelectorAll() { return []; }
  insertBefore(element) { this.children.push(element); }
  addEventListener() {}
  setAttribute() {}
}
global.document = {
  getElementById: (id) => (id === "chart-data" ? { textContent: data } : (made[id] ??= new Element())),
  createElement: () => new Element(), querySelector: () => new Element(), body: new Element(),
};
global.ResizeObserver = class { observe() {} };
eval(script);
const panels = (name) => made[name].children.map((each) => [each.text, each.plot.text]);
console.log(JSON.stringify(Object.fromEntries(JSON.parse(data).charts.map((chart) => [chart.name, panels(chart.name)]))));
