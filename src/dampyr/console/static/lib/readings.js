// The live readings in large type with their extremes, and the table's place in its stroke.
import { h, number } from "./dom.js";

const MINUS = "−";
const fixed = (value, digits) => value.toFixed(digits).replace("-", MINUS);

/** What is shown of each reading: name, unit, factor from SI, decimals. */
export const READINGS = {
  position: { name: "position", unit: "mm", factor: 1e3, digits: 2 },
  velocity: { name: "velocity", unit: "mm/s", factor: 1e3, digits: 1 },
  force: { name: "force", unit: "N", factor: 1, digits: 0 },
  voltage: { name: "coil", unit: "V", factor: 1, digits: 3 },
  temperature: { name: "damper", unit: "°C", factor: 1, digits: 1 },
};
const SHOWN = ["position", "force", "voltage", "temperature"];

/** Tiles; show(state, age) fills them, age in s is that of the readings, null where there are none. */
export function readings() {
  const tiles = Object.fromEntries(SHOWN.map((key) => [key, tile(READINGS[key])]));
  const old = h("p", { class: "old", role: "status", hidden: true });
  const list = h("dl", { class: "readings", id: "readings" }, SHOWN.map((key) => tiles[key].element));
  const element = h("div", { class: "readout" }, list, old);

  function show(state, age) {
    const { live, extremes, homed, rig } = state;
    for (const key of SHOWN) tiles[key].show(live ? live[key] : null, extremes[key], key === "position" && !homed, beyond(key, live, rig));
    const stale = live !== null && (age === null || age > 1);
    element.classList.toggle("stale", stale || live === null);
    old.hidden = !stale;
    if (stale) old.textContent = `These values are ${age === null ? "old" : `${spoken(age)} old`}.`;
  }
  return { element, show };
}

/** Whether a reading is within a tenth of its limit. */
function beyond(key, live, rig) {
  if (!live || !rig) return false;
  const limit = { position: rig.limits.travel, force: rig.limits.force, voltage: rig.limits.voltage, temperature: rig.limits.temperature }[key];
  return Math.abs(live[key]) > 0.9 * limit;
}

const spoken = (seconds) => (seconds < 120 ? `${Math.round(seconds)} s` : `${Math.round(seconds / 60)} min`);

function tile({ name, unit, factor, digits }) {
  const value = h("span", {});
  const small = h("small", {}, ` ${unit}`);
  const range = h("dd", { class: "peaks" });
  const element = h("div", {}, h("dt", {}, name), h("dd", {}, value, small), range);
  function show(now, extreme, unknown, near) {
    value.textContent = now === null ? "–" : unknown ? "not homed" : fixed(now * factor, digits);
    small.hidden = unknown || now === null;
    element.classList.toggle("near", near && !unknown);
    element.classList.toggle("words", unknown);
    const text = extreme && !unknown ? `${fixed(extreme.low * factor, digits)} … ${fixed(extreme.high * factor, digits)}` : "";
    if (range.textContent !== text) range.textContent = text;
  }
  return { element, show };
}

const [WIDTH, HEIGHT] = [600, 46];

/** The place of the table in its stroke, with the ends of the travel and of the stroke. */
export function strokeBar() {
  const ns = "http://www.w3.org/2000/svg";
  const make = (tag, attributes, text) => {
    const made = document.createElementNS(ns, tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };
  const svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", class: "stroke-bar", preserveAspectRatio: "none" });
  const marker = make("rect", { class: "marker", width: 6, height: 20, y: 2, rx: 2 });
  let drawn = "";
  const element = h("div", { class: "stroke" }, svg);

  function draw(stroke, travel) {
    const x = (metres) => WIDTH / 2 + (metres / (0.54 * stroke)) * (WIDTH / 2);
    const texts = [[-stroke / 2, "start"], [0, "middle"], [stroke / 2, "end"]];
    svg.replaceChildren(
      make("rect", { class: "hard", x: x(-stroke / 2), width: x(stroke / 2) - x(-stroke / 2), y: 6, height: 12 }),
      make("rect", { class: "soft-travel", x: x(-travel), width: x(travel) - x(-travel), y: 6, height: 12 }),
      make("line", { class: "middle", x1: x(0), x2: x(0), y1: 3, y2: 21 }),
      marker,
    );
    element.replaceChildren(svg, h("div", { class: "scale" }, texts.map(([at]) => h("span", {}, `${number(at * 1e3)}${at ? "" : " mm"}`))));
    return x;
  }

  let place = null;
  function show(state, stale) {
    const { rig, live, homed } = state;
    element.hidden = !rig;
    if (!rig) return;
    const wanted = `${rig.stroke} ${rig.limits.travel}`;
    if (drawn !== wanted) {
      drawn = wanted;
      place = draw(rig.stroke, rig.limits.travel);
    }
    const known = homed && live !== null;
    marker.setAttribute("visibility", known ? "visible" : "hidden");
    if (known) marker.setAttribute("x", place(live.position) - 3);
    element.classList.toggle("stale", stale);
    svg.setAttribute("aria-label", known ? `The table stands at ${fixed(live.position * 1e3, 1)} mm of ±${number(rig.limits.travel * 1e3, 3)} mm`
      : "The table is not homed: its place in the stroke is not known");
  }
  return { element, show };
}
