// SPDX-FileCopyrightText: 2026 PMWVC contributors
// SPDX-License-Identifier: Apache-2.0
// Which signals the strips show: title, unit, and lines as functions of a row's start and an axis.

/** A strip. `factor`: SI to the unit shown; `least`: smallest range [SI]; `floor`: begins at zero. */
export function signalsOf(session) {
  const { columns, rows } = session;
  const column = (name) => {
    const from = columns.get(name);
    return (at, axis) => rows[at + from + axis];
  };
  const scalar = (name) => {
    const from = columns.get(name);
    return (at) => rows[at + from];
  };
  const { waves } = session;
  const channel = session.controls.find(({ path }) => path === "channel")?.value;
  const ways = waves && channel !== "strict"; // the strict channel keeps one account, of both ways
  const perUser = (make) => session.users.flatMap(({ name }, i) => make(name, `u${i}`, String(i + 1)));
  const balance = (name, way) => {
    const into = scalar(`${name}.energy_${way}_in`), out = scalar(`${name}.energy_${way}_out`);
    return (at) => into(at) - out(at);
  };
  return [
    {
      title: "Force", unit: "N", factor: 1, decimals: 2, least: 1,
      turn: { title: "Torque", unit: "N m", factor: session.lever_m, decimals: 4 },
      lines: perUser((name, colour, text) => [{
        name: text, colour, value: column(`${name}.f_applied`),
        low: column(`${name}.f_min`), high: column(`${name}.f_max`),
      }]),
    },
    {
      title: "Position", unit: "mm, dotted: avatar", factor: 1e3, decimals: 1, least: 0.02,
      turn: { title: "Turn", unit: "deg, dotted: avatar", factor: 180 / Math.PI / session.lever_m },
      lines: [
        { name: "target", colour: "target", dash: true, silent: true, value: column("object.target") },
        { name: session.scene.shapes ? "body" : "cube", colour: "ink", value: column("object.x_o") },
        ...perUser((name, colour, text) => [
          { name: text, colour, value: column(`${name}.x_m`) },
          { colour, dash: true, hidden: true, value: column(`${name}.x_s`) },
        ]),
      ],
    },
    {
      title: "Energy account", unit: ways ? "mJ, dotted: down" : "mJ, hand to object",
      factor: 1e3, decimals: 1, least: 2e-3, floor: 0, alarm: 1e-5,
      lines: perUser((name, colour, text) => (ways ? [
        { name: text, colour, value: balance(name, "up") },
        { colour, dash: true, hidden: true, value: balance(name, "down") },
      ] : [{ name: text, colour, value: balance(name, "hand") }])),
    },
    {
      title: "Round trip", unit: "ms", factor: 1e3, decimals: 1, least: 0.01, floor: 0,
      lines: perUser((name, colour, text) => [{ name: text, colour, value: scalar(`${name}.round_trip`) }]),
    },
    waves && {
      title: "Waves", unit: "\u221aW, u; dotted: v", factor: 1, decimals: 2, least: 0.2,
      lines: perUser((name, colour, text) => [
        { name: text, colour, value: column(`${name}.u_m`) },
        { colour, dash: true, hidden: true, value: column(`${name}.v_m`) },
      ]),
    },
    { title: "Packets", unit: "last 2 s", ticks: true, window_s: 2, size: "thin" },
    session.mode !== "simulated" && {
      title: "Lateness of the 1 kHz loop", unit: "ms", factor: 1e3, decimals: 2, least: 5e-4, floor: 0, size: "thin",
      lines: perUser((name, colour, text) => [{ name: text, colour, value: scalar(`${name}.lateness`) }]),
    },
  ].filter(Boolean);
}
