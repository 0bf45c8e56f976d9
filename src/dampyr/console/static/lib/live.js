// The live charts of the bench: strips of the last seconds, and loops of force over displacement and velocity.
import { chart } from "./chart.js";
import { h } from "./dom.js";

const SPAN = 12; // s in the strips
const LOOPS = 4; // s in the loops
const SLOW = 5; // frames for one of the coil and the temperature
const NAMES = ["time", "x_low", "x_high", "force_low", "force_high", "voltage_low", "voltage_high", "temperature", "velocity",
  "x_first", "force_first", "x_second", "force_second"];

export function live() {
  const time = { words: "time", unit: "s" };
  const strip = (words, unit, last = false) =>
    chart({ label: `${words} over the last ${SPAN} seconds, live`, x: { ...time, bare: !last }, y: { words, unit }, height: last ? 176 : 130 });
  const loop = (words, unit) => chart({ label: `Force over ${words}, the last ${LOOPS} seconds, live`, x: { words, unit, pad: 0.05 }, y: { words: "force", unit: "N" }, height: 286 });
  const parts = {
    x: strip("position", "mm"), force: strip("force", "N"), voltage: strip("coil", "V"), temperature: strip("damper", "°C", true),
    fx: loop("displacement", "mm"), fv: loop("velocity", "mm/s"),
  };
  const element = h("div", { class: "live" },
    h("div", { class: "strips" }, parts.x.element, parts.force.element, parts.voltage.element, parts.temperature.element),
    h("div", { class: "loops" }, parts.fx.element, parts.fv.element));
  const data = Object.fromEntries(NAMES.map((name) => [name, []]));
  let wanted = false;
  let drawn = 0;

  /** Take the new bins of a frame. */
  function take(strips) {
    if (strips) {
      const latest = data.time.at(-1) ?? -1;
      const from = strips.time.findIndex((t, k) => t > latest || strips.force_low[k] === null);
      if (from >= 0) for (const name of NAMES) data[name].push(...strips[name].slice(from));
      const last = data.time.at(-1) ?? 0;
      let drop = 0;
      while (drop < data.time.length && data.time[drop] < last - SPAN) drop++;
      if (drop) for (const name of NAMES) data[name].splice(0, drop);
    }
    if (!wanted) {
      wanted = true;
      requestAnimationFrame(draw);
    }
  }

  function draw() {
    wanted = false;
    if (!element.isConnected) return;
    parts.x.set([band("x", "blue")]);
    parts.force.set([band("force", "vermillion")]);
    loops();
    if (drawn++ % SLOW) return;
    parts.voltage.set([band("voltage", "purple")]);
    parts.temperature.set([{ name: "temperature", colour: "green", x: data.time, y: data.temperature }]);
  }

  function loops() {
    const from = Math.max(0, data.time.findLastIndex((t) => t < data.time.at(-1) - LOOPS) + 1);
    parts.fx.set([{ name: "force", colour: "blue", x: pairs("x_first", "x_second", from), y: pairs("force_first", "force_second", from) }]);
    parts.fv.set([{ name: "force", colour: "blue", x: speeds(from), y: pairs("force_first", "force_second", from) }]);
  }

  /** From the least to the greatest of each bin: no peak is left out. */
  function band(name, colour) {
    return { name, colour, x: data.time.flatMap((t) => [t, t]), y: pairs(`${name}_low`, `${name}_high`, 0) };
  }

  /** Speeds at a quarter and at three quarters of each bin. */
  function speeds(from) {
    const values = [];
    for (let k = from; k < data.time.length; k++) {
      const now = data.velocity[k];
      for (const other of [data.velocity[k - 1] ?? now, data.velocity[k + 1] ?? now]) values.push(now === null ? null : 0.75 * now + 0.25 * (other ?? now));
    }
    return values;
  }

  function pairs(first, second, from) {
    const values = [];
    for (let k = from; k < data.time.length; k++) values.push(data[first][k], data[second][k]);
    return values;
  }

  function clear() {
    for (const part of Object.values(parts)) part.clear();
  }
  return { element, take, clear };
}
