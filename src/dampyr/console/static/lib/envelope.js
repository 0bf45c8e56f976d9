// Limits of a rig: the largest amplitude of a sine over its frequency at several forces, and the tests of a plan in it.
import { charts, COLOURS } from "./chart.js";
import { h, number } from "./dom.js";

const DASHES = [undefined, "long", "dashed", "dotted"];
const [DOT, RING] = [7, 6]; // px: the mark of the first voltage, and by how much that of each further one is larger
let last = null;

/** envelope(plan): a figure. A plan that is drawn anew takes the place of the one before. */
export function envelope(plan) {
  last?.clear();
  const tests = plan.tests.filter((test) => test.frequency_Hz > 0 && test.position_mm > 0);
  const refused = tests.filter((test) => test.refusal);
  const volts = [...new Set(tests.map((test) => test.voltage_V))].sort((a, b) => a - b);
  last = charts([{
    label: `The largest sine that the rig can do at each frequency, and ${tests.length} tests; ${refused.length} of them are refused.`,
    height: 400, x: { words: "frequency", unit: "Hz", log: true, pad: 0.03 }, y: { words: "amplitude", unit: "mm", log: true, pad: 0.06 },
    series: [...limits(plan.envelope), ...volts.map((volt, k) => marks(`${number(volt)} V`, tests.filter((test) => test.voltage_V === volt), COLOURS[k % COLOURS.length], DOT + RING * k)), ...crosses(refused, volts)],
  }]);
  return h("figure", { class: "envelope" }, last.element,
    h("figcaption", {}, "Lines: the largest sine against a braking force. Points: the tests, by their farthest position and the frequency of a sine of that amplitude and peak speed; tests of several voltages at one place are rings about each other. ✕: the rig cannot do it."));
}

/** The limits, the least force first: each force has its own dashes. */
function limits({ frequency, limits: all }) {
  return Object.entries(all).sort(([a], [b]) => Number(a) - Number(b)).map(([force, amplitudes], k) => {
    const some = frequency.map((f, i) => [f, amplitudes[i]]).filter(([, amplitude]) => amplitude > 0);
    return { name: `limit at ${force} N`, colour: "muted", dash: DASHES[k % DASHES.length], width: 1.8, always: true, x: some.map(([f]) => f), y: some.map(([, amplitude]) => amplitude) };
  });
}

/** The tests of one voltage, each place once. */
function marks(name, tests, colour, size) {
  const places = Map.groupBy(tests, (test) => `${test.frequency_Hz} ${test.position_mm}`);
  const some = [...places.values()];
  const words = (all) => (all.length > 3 ? [`${all.length} tests`, all[0].words] : all.map((job) => `${job.name}: ${job.words}${job.refusal ? " — refused" : ""}`));
  return { name, colour, points: true, shape: size === DOT ? "circle" : "ring", size, always: true,
    x: some.map(([test]) => test.frequency_Hz), y: some.map(([test]) => test.position_mm), tips: some.map(words) };
}

/** A cross over every place with a refused test, larger than the rings below it. */
function crosses(refused, volts) {
  if (!refused.length) return [];
  return [{ name: "refused", colour: "ink", points: true, shape: "cross", width: 2.6, always: true, silent: true,
    size: refused.map((test) => DOT + RING * volts.indexOf(test.voltage_V) + 9), x: refused.map((test) => test.frequency_Hz), y: refused.map((test) => test.position_mm) }];
}
