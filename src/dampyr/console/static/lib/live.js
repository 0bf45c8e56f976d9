// The live charts of the bench: strips of the last seconds, and loops of force over displacement and velocity.
import { h } from "./dom.js";
import { loop, strip } from "./strip.js";

const SPAN = 12; // s in the strips
const LOOPS = 4; // s in the loops
const RECENT = 1; // s of a loop that are drawn strongly
const LEAST = { x: 2, force: 50, voltage: 0.5, temperature: 2, velocity: 10 }; // spans below which noise would fill a chart
const NAMES = ["time", "x_low", "x_high", "force_low", "force_high", "voltage_low", "voltage_high", "temperature", "velocity",
  "x_first", "force_first", "x_second", "force_second"];

export function live() {
  const strips = h("div", { class: "strips" });
  const rings = h("div", { class: "loops" });
  const over = (words, unit, least, colour, last = false) =>
    strip(strips, { label: `${words} over the last ${SPAN} seconds, live`, y: { words, unit, least }, series: [{ name: words, colour }], height: last ? 132 : 98, bare: !last });
  const loopOver = (words, unit, least) =>
    loop(rings, { label: `Force over ${words}, the last ${LOOPS} seconds, live`, x: { words, unit, least }, y: { words: "force", unit: "N", least: LEAST.force }, series: [{ name: "force", colour: "blue" }, { name: "reference", colour: "orange" }], height: 212 });
  const parts = {
    x: over("position", "mm", LEAST.x, "blue"), force: over("force", "N", LEAST.force, "vermillion"), voltage: over("coil", "V", LEAST.voltage, "purple"),
    temperature: over("damper", "°C", LEAST.temperature, "green", true), fx: loopOver("displacement", "mm", LEAST.x), fv: loopOver("velocity", "mm/s", LEAST.velocity),
  };
  const key = h("p", { class: "soft key", hidden: true }, h("span", { class: "swatch reference" }), " reference");
  rings.append(key);
  const element = h("div", { class: "live" }, strips, rings);
  let bounds = "";
  let reference = null;
  const data = Object.fromEntries(NAMES.map((name) => [name, []]));

  /** Take the new bins of a frame. */
  function take(bins) {
    if (bins) {
      const latest = data.time.at(-1) ?? -1;
      const from = bins.time.findIndex((t, k) => t > latest || bins.force_low[k] === null);
      if (from >= 0) for (const name of NAMES) data[name].push(...bins[name].slice(from));
      const last = data.time.at(-1) ?? 0;
      let drop = 0;
      while (drop < data.time.length && data.time[drop] < last - SPAN) drop++;
      if (drop) for (const name of NAMES) data[name].splice(0, drop);
    }
    if (element.isConnected) draw();
  }

  /** Every chart up to the same moment. */
  function draw() {
    const now = data.time.at(-1) ?? 0;
    const over = (part, low, high) => parts[part].set({ now, span: SPAN, lines: [{ time: data.time, low: data[low], high: data[high] }] });
    over("x", "x_low", "x_high");
    over("force", "force_low", "force_high");
    over("voltage", "voltage_low", "voltage_high");
    over("temperature", "temperature", "temperature");
    loops(now);
  }

  function loops(now) {
    const since = (span) => Math.max(0, data.time.findLastIndex((t) => t < now - span) + 1);
    const [from, recent] = [since(LOOPS), 2 * (since(RECENT) - since(LOOPS))];
    const y = pairs("force_first", "force_second", from);
    const more = (x) => (reference ? [{ x: reference[x], y: reference.force }] : []);
    parts.fx.set({ lines: [{ x: pairs("x_first", "x_second", from), y, recent }, ...more("x")] });
    parts.fv.set({ lines: [{ x: speeds(from), y, recent }, ...more("velocity")] });
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

  /** Draw the limits of the rig, SI: { force, travel, voltage, temperature }. */
  function limits(given) {
    const now = JSON.stringify(given);
    if (now === bounds) return;
    bounds = now;
    const both = (value, words) => [{ value, words: `${words} ±` }, { value: -value, words: "" }];
    parts.x.limits(both(given.travel * 1e3, "end of travel"));
    parts.force.limits(both(given.force, "limit"));
    parts.voltage.limits([{ value: given.voltage, words: "limit" }]);
    parts.temperature.limits([{ value: given.temperature, words: "limit" }]);
  }

  /** Draw a reference's loop, { x mm, force N, velocity mm/s }, over the live ones; null: none. */
  function overlay(loop) {
    reference = loop;
    key.hidden = !loop;
    draw();
  }

  function clear() {
    for (const part of Object.values(parts)) part.clear();
  }
  return { element, take, limits, overlay, clear };
}
