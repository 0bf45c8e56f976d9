// Limits of a rig: the largest amplitude of a sine over its frequency at several forces, and the tests of a plan in it.
import { h, number } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";
const [WIDTH, HEIGHT, LEFT, RIGHT, TOP, BOTTOM] = [640, 400, 58, 66, 12, 44];
const COLOURS = ["blue", "vermillion", "green", "purple", "orange", "sky"];
const STEPS = [1, 2, 5];

export function envelope(plan) {
  const tests = plan.tests.filter((one) => one.frequency_Hz > 0);
  const { frequency, limits } = plan.envelope;
  const heights = [...Object.values(limits).flat(), ...tests.map((one) => one.position_mm)].filter((one) => one > 0);
  const x = scale([frequency[0], frequency.at(-1)], [LEFT, WIDTH - RIGHT]);
  const y = scale([Math.min(...heights) * 0.8, Math.max(...heights) * 1.3], [HEIGHT - BOTTOM, TOP]);
  const label = `The largest sine that the rig can do at each frequency, and ${tests.length} tests; ${tests.filter((one) => one.refusal).length} of them are refused.`;
  const svg = make("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "img", "aria-label": label });
  svg.append(...grid(x, y), ...lines(frequency, limits, x, y));
  const volts = [...new Set(tests.map((one) => one.voltage_V))].sort((a, b) => a - b);
  for (const one of tests) {
    const k = volts.indexOf(one.voltage_V);
    svg.append(mark(one, k, x(one.frequency_Hz) + 11 * (k - (volts.length - 1) / 2), y(one.position_mm)));
  }
  return h("figure", { class: "envelope" }, h("div", { class: "legend" }, volts.map((volt, k) => legend(`${number(volt)} V`, k))), svg,
    h("figcaption", {}, "Lines: the largest sine against a braking force. Points: the tests, side by side for each voltage, by their farthest position and the frequency of a sine of that amplitude and peak speed; crossed out where the rig cannot do them."));
}

function scale([low, high], [from, to]) {
  const [a, b] = [Math.log(low), Math.log(high)];
  const place = (value) => from + ((Math.log(value) - a) / (b - a)) * (to - from);
  place.range = [low, high];
  return place;
}

function ticks([low, high]) {
  const values = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++)
    for (const step of STEPS) values.push(step * 10 ** power);
  return values.filter((one) => one >= low && one <= high);
}

function grid(x, y) {
  const across = ticks(x.range).flatMap((value) => [line(x(value), TOP, x(value), HEIGHT - BOTTOM), words(x(value), HEIGHT - BOTTOM + 16, number(value), "middle")]);
  const up = ticks(y.range).flatMap((value) => [line(LEFT, y(value), WIDTH - RIGHT, y(value)), words(LEFT - 6, y(value) + 4, number(value), "end")]);
  const side = words(0, 0, "amplitude [mm]", "middle");
  side.setAttribute("transform", `translate(14 ${(HEIGHT - BOTTOM) / 2}) rotate(-90)`);
  return [...across, ...up, words((LEFT + WIDTH - RIGHT) / 2, HEIGHT - 8, "frequency [Hz]", "middle"), side];
}

function lines(frequency, limits, x, y) {
  const named = [];
  return Object.entries(limits).reverse().flatMap(([force, amplitudes], j) => {
    const k = Object.keys(limits).length - 1 - j;
    const points = amplitudes.map((one, i) => [x(frequency[i]), y(Math.max(one, y.range[0]))]);
    const path = make("path", { class: "limit", d: `M${points.map(([a, b]) => `${a.toFixed(1)} ${b.toFixed(1)}`).join("L")}`, "stroke-width": String(2.4 - 0.5 * k) });
    const [, last] = points.at(-1);
    named.push(Math.min(last, (named.at(-1) ?? Infinity) - 13));
    return [path, words(WIDTH - RIGHT + 4, named.at(-1) + 4, `${force} N`, "start")];
  });
}

function mark(test, k, x, y) {
  const group = make("g", { "data-test": test.name });
  const shape = make("circle", { cx: x, cy: y, r: 4.5 });
  shape.style.fill = `var(--${COLOURS[k % COLOURS.length]})`;
  const title = make("title", {});
  title.textContent = `${test.name}: ${test.words}${test.refusal ? " — refused" : ""}`;
  group.append(shape, title);
  if (test.refusal) group.append(make("path", { class: "refused", d: `M${x - 5} ${y - 5}l10 10m0 -10l-10 10` }));
  return group;
}

function legend(name, k) {
  const swatch = h("span", { class: "swatch dot" });
  swatch.style.color = `var(--${COLOURS[k % COLOURS.length]})`;
  return h("span", { class: "name" }, swatch, name);
}

const line = (x1, y1, x2, y2) => make("line", { class: "gridline", x1, y1, x2, y2 });

function words(x, y, content, anchor) {
  const text = make("text", { x, y, "text-anchor": anchor });
  text.textContent = content;
  return text;
}

function make(tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}
