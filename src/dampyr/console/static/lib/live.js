// The live charts of the bench: strips of the last seconds, and loops of force over displacement and velocity.
import { choice, h } from "./dom.js";
import { drafts } from "./drafts.js";
import { loop, strip } from "./strip.js";

const SPANS = [6, 12, 30, 60]; // s in the strips
export const HELD = SPANS.at(-1);
const LOOPS = 4; // s in the loops
const RECENT = 1; // s of a loop that are drawn strongly
const LEAST = { x: 2, force: 50, voltage: 0.5, temperature: 2, velocity: 10 }; // spans below which noise would fill a chart
const NAMES = ["time", "x_low", "x_high", "force_low", "force_high", "voltage_low", "voltage_high", "temperature", "velocity",
  "x_first", "force_first", "x_second", "force_second", "target"];
const remembered = drafts("charts");

export function live() {
  const strips = h("div", { class: "strips" });
  const rings = h("div", { class: "loops" });
  const over = (words, unit, least, colour, { last = false, more = [] } = {}) =>
    strip(strips, { label: `${words} over the last seconds, live`, y: { words, unit, least }, series: [{ name: more.length ? "measured" : words, colour }, ...more], height: last ? 132 : 98, bare: !last });
  const loopOver = (words, unit, least) =>
    loop(rings, { label: `Force over ${words}, the last ${LOOPS} seconds, live`, x: { words, unit, least }, y: { words: "force", unit: "N", least: LEAST.force }, series: [{ name: "force", colour: "blue" }, { name: "reference", colour: "orange" }], height: 212 });
  const parts = {
    x: over("position", "mm", LEAST.x, "blue", { more: [{ name: "commanded", colour: "ink", dash: [3, 4] }] }), force: over("force", "N", LEAST.force, "vermillion"), voltage: over("coil", "V", LEAST.voltage, "purple"),
    temperature: over("damper", "°C", LEAST.temperature, "green", { last: true }), fx: loopOver("displacement", "mm", LEAST.x), fv: loopOver("velocity", "mm/s", LEAST.velocity),
  };
  const key = h("p", { class: "soft key", hidden: true }, h("span", { class: "swatch reference" }), " reference");
  rings.append(key);
  let span = SPANS.includes(remembered.read("span")) ? remembered.read("span") : 12;
  const spans = choice(SPANS.map((seconds) => [String(seconds), `${seconds} s`]), { id: "span", value: String(span), "aria-label": "Time span of the strips" });
  spans.addEventListener("change", () => {
    span = Number(spans.value);
    remembered.keep("span", span);
    draw();
  });
  strips.append(h("label", { class: "span" }, "Last ", spans));
  const element = h("div", { class: "live" }, strips, rings);
  let lag = 0;
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
      while (drop < data.time.length && data.time[drop] < last - HELD) drop++;
      if (drop) for (const name of NAMES) data[name].splice(0, drop);
    }
    if (element.isConnected) draw();
  }

  /** Every chart up to the same moment. */
  function draw() {
    const now = data.time.at(-1) ?? 0;
    const from = since(now, span);
    const part = (name) => data[name].slice(from);
    const time = part("time");
    const line = (low, high) => ({ time, low: part(low), high: part(high) });
    const over = (strip, low, high, ...more) => parts[strip].set({ now, span, lines: [line(low, high), ...more] });
    over("x", "x_low", "x_high", ...(part("target").some((value) => value !== null) ? [line("target", "target")] : []));
    over("force", "force_low", "force_high");
    over("voltage", "voltage_low", "voltage_high");
    over("temperature", "temperature", "temperature");
    loops(now);
  }

  /** The first bin of the last `seconds`. */
  const since = (now, seconds) => Math.max(0, data.time.findLastIndex((t) => t < now - seconds) + 1);

  function loops(now) {
    const [from, recent] = [since(now, LOOPS), since(now, RECENT) - since(now, LOOPS)];
    const more = (x) => (reference ? [{ x: reference[x], y: reference.force }] : []);
    parts.fx.set({ lines: [{ x: pairs("x_first", "x_second", from), y: pairs("force_first", "force_second", from), recent: 2 * recent }, ...more("x")] });
    // a bin's velocity comes `lag` bins later, and is that of its middle
    const speed = data.velocity.slice(from + lag);
    const force = data.force_low.slice(from, from + speed.length).map((low, k) => (low === null ? null : (low + data.force_high[from + k]) / 2));
    parts.fv.set({ lines: [{ x: speed, y: force, recent: Math.max(0, recent - lag) }, ...more("velocity")] });
  }

  function pairs(first, second, from) {
    const values = [];
    for (let k = from; k < data.time.length; k++) values.push(data[first][k], data[second][k]);
    return values;
  }

  /** Draw the limits of the rig, SI: { force, travel, speed, voltage, temperature }; its velocity is late by `bins`. */
  function limits(given, bins) {
    lag = bins;
    const now = JSON.stringify(given);
    if (now === bounds) return;
    bounds = now;
    const both = (value, words) => [{ value, words: `${words} ±` }, { value: -value, words: "" }];
    parts.x.limits(both(given.travel * 1e3, "travel"));
    parts.force.limits(both(given.force, "limit"));
    parts.voltage.limits([{ value: given.voltage, words: "limit" }]);
    parts.temperature.limits([{ value: given.temperature, words: "limit" }]);
    const walls = (value, words) => both(value, words).map((bound) => ({ ...bound, across: true }));
    const force = both(given.force, "limit");
    parts.fx.limits([...force, ...walls(given.travel * 1e3, "travel")]);
    parts.fv.limits([...force, ...walls(given.speed * 1e3, "limit")]);
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
