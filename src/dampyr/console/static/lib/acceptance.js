// Records judged by a reference damper: the request, the band with its points, and the points outside.
import { get, query as asQuery } from "./api.js";
import { cardGroups, groupedOptions } from "./cards.js";
import { chart, charts as drawCharts, COLOURS } from "./chart.js";
import { field, h, number, section, short } from "./dom.js";
import { attempt, say } from "./notice.js";
import { optionsForm, optionsInAddress } from "./options.js";
import { originLine } from "./origin.js";
import { table } from "./table.js";

const OTHERS = "others";
const WAYS = ["extension", "compression"];
const QUANTITIES = [...WAYS, "energy"];
const SHAPES = [[true, "circle", "inside"], [false, "cross", "outside"], [null, "square", "not judged"]];
const BADGES = { passed: "badge good", failed: "badge bad", "not judged": "badge" };

/** The request in an address: the reference, and the options that are not as usual, in SI units; `options` is what the server offers. */
export const fromAddress = (query, options) => ({ reference: query.get("reference") ?? "", options, values: optionsInAddress(options, query) });

/** The request for an address, without defaults. */
export const forAddress = ({ reference, values }) => ({ reference, ...values });

/** acceptance(keys of the records, request, changed): elements; `request` is changed by the form, which then calls `changed()`. */
export async function acceptance(keys, request, changed, charts) {
  const dampers = await get("records/references");
  const result = h("div");
  let last = 0;

  async function judge() {
    const mine = ++last;
    changed();
    if (!request.reference) return result.replaceChildren(h("p", { class: "blank" }, "Choose a reference: a card, a published damper, or a record of a reference damper."));
    const question = asQuery({ key: keys, reference: request.reference === OTHERS ? keys : request.reference, ...request.values });
    if (!result.children.length) result.append(h("p", { class: "soft" }, "Judging …"));
    const judgement = await attempt(() => get(`records/acceptance?${question}`));
    if (mine !== last) return undefined;
    for (const chart of charts.splice(0)) chart.clear();
    return result.replaceChildren(...(judgement ? shown(judgement, question, charts) : []));
  }

  const form = asking(keys, dampers, request, judge);
  judge();
  return [form, result];
}

function asking(keys, dampers, request, changed) {
  const reference = h("select", {}, h("option", { value: "" }, "choose …"));
  const groups = [
    ...cardGroups(dampers),
    ["Records shown", [...(keys.length > 1 ? [[OTHERS, "each by the others"]] : []), ...keys.map((key) => [key, short(key)])]],
  ];
  const offered = groups.flatMap(([, all]) => all.map(([value]) => value));
  if (request.reference && !offered.includes(request.reference)) groups[2][1].push([request.reference, short(request.reference)]);
  reference.append(...groupedOptions(groups));
  reference.value = request.reference;
  const form = optionsForm(request.options, request.values, () => {
    try {
      const values = form.values();
      if (values.quantities?.length === 0) throw new Error("No quantity is to be judged; tick one or more.");
      Object.assign(request, { reference: reference.value, values });
    } catch (problem) {
      return say(problem.message, "bad");
    }
    return changed();
  });
  form.element.prepend(field("Reference", reference));
  return form.element;
}

function shown(judgement, question, charts) {
  const names = judgement.records.map((record) => record.name);
  const colourOf = new Map(judgement.records.map((record, k) => [record, COLOURS[k]]));
  const inputs = [...new Map(judgement.records.map((record) => [inputOf(record), record])).keys()];
  const forces = drawCharts(inputs.flatMap((input) => {
    const some = judgement.records.filter((record) => inputOf(record) === input);
    return WAYS.filter((way) => some.some((record) => record.points.some((p) => p.quantity === way && p.cycle.length))).map((way) => ({
      label: `Forces at peak velocity in ${way} of ${some.map((record) => record.name).join(", ")} in the band about the reference`, height: 270,
      x: { words: `peak velocity${input ? ` at ${input}` : ""}, ${way}`, unit: "mm/s", pad: 0.06, least: 5 }, y: { words: "force", unit: "N", least: 20 },
      series: [...judgement.bands.filter((band) => inputOf(band) === input && band.quantity === way).flatMap(asBand),
        ...some.flatMap((record) => asPoints(record, colourOf.get(record), record.points.filter((p) => p.quantity === way), (p, i) => [1e3 * p.speed[i], p.measured[i]]))],
    }));
  }), { across: true });
  const cycles = Math.max(1, ...judgement.records.flatMap((record) => record.points.flatMap((p) => p.cycle)));
  const used = chart({
    label: `Deviation within the band, every cycle of ${names.join(", ")} uses`, height: 260,
    x: { words: "cycle", pad: 0.04 }, y: { words: "off by", unit: "half-widths" },
    series: [{ name: "edges of the band", x: [0, cycles + 1, null, 0, cycles + 1], y: [1, 1, null, -1, -1], colour: "ink", dash: "dashed", width: 1, always: true, silent: true },
      ...judgement.records.flatMap((record) => asPoints(record, colourOf.get(record), record.points, (p, i) => (p.used[i] === null ? null : [p.cycle[i], p.used[i]])))],
  });
  charts.push(forces, used);
  const judged = judgement.records.some((record) => record.judged);
  const any = judgement.records.some((record) => record.points.some((p) => WAYS.includes(p.quantity) && p.cycle.length));
  return [
    originLine(judgement.data.origin, "This judgement"),
    h("p", { class: "verdict", role: "status" }, inShort(judgement.records)),
    ...judgement.notes.map((note) => h("p", { class: "verdict fair" }, note)),
    summary(judgement.records),
    h("p", { class: "soft" }, "Cycles count from the start of the motion. Wrong rejection: the chance, at the record's scatter, that a damper like the reference fails; wrong acceptance: that one passes of which one quantity at one level lies a third of the half-width beyond the band."),
    h("div", { class: "row" }, h("a", { class: "button", href: `/api/records/acceptance/page?${question}`, download: "acceptance.html" }, "Save the page")),
    any ? section("Forces at peak velocity", forces.element, h("p", { class: "soft" }, "● inside, ✕ outside, □ not judged; one chart for each input and direction. The band is drawn through the means of points of equal speed.")) : null,
    judged ? section("Deviation within the band", used.element, h("p", { class: "soft" }, "Deviation in half-widths of the band: 0 is the reference, 1 and −1 are the edges; above 0 the damper is stronger, in either direction.")) : null,
    relevelled(judgement.relevelled),
    levels(judgement.records),
    outside(judgement.records),
    open(judgement.records),
  ].filter(Boolean);
}

function inShort(records) {
  const counts = Object.keys(BADGES).map((verdict) => [verdict, records.filter((record) => record.verdict === verdict).length]).filter(([, count]) => count);
  return `${counts.map(([verdict, count]) => `${count} ${verdict}`).join(", ")}.`;
}

function summary(records) {
  return table({
    caption: "One point outside fails a record, and so does the mean of a level. Where less than half of a level's cycles could be judged, it has neither passed nor failed.",
    columns: [{ name: "record" }, { name: "verdict", align: "left" }, { name: "run", align: "right" }, { name: "whole" }, { name: "judged", align: "right" }, { name: "stroke", unit: "mm" }, { name: "judged to", unit: "mm" }, { name: "outside" },
      { name: "worst", align: "left" }, { name: "cycle" }, { name: "off by", unit: "%", digits: 3 }, { name: "wrong rejection", unit: "%", align: "right" }, { name: "wrong acceptance", unit: "%", align: "right" }],
    rows: records.map((record) => [record.name, badge(record.verdict),
      { key: record.run, show: record.run.toFixed(1) }, record.cut, { key: record.judged_cycles, show: `${record.judged_cycles} of ${record.cut}` }, 1e3 * record.stroke_m, record.judged ? 1e3 * record.judged_stroke_m : null, record.outside_count,
      record.worst?.quantity ?? null, record.worst?.cycle ?? null, percent(record.worst?.deviation), chance(record.wrong_rejection), chance(record.wrong_acceptance)]),
  });
}

function relevelled(records) {
  return records.length ? section("Relevelled", table({
    caption: "Judged again with the level of the first cycles, measured over expected, taken out of the later ones",
    columns: [{ name: "record" }, { name: "level", digits: 4 }, { name: "verdict", align: "left" }, { name: "judged" }, { name: "outside" }, { name: "worst", align: "left" }, { name: "off by", unit: "%", digits: 3 }],
    rows: records.map((record) => [record.name, record.level, badge(record.verdict), record.judged_cycles, record.outside_count, record.worst?.quantity ?? null, percent(record.worst?.deviation)]),
  })) : null;
}

const badge = (verdict) => ({ key: verdict, show: h("span", { class: BADGES[verdict] }, { passed: "✓ ", failed: "✗ ", "not judged": "? " }[verdict], verdict) });

function levels(records) {
  const rows = records.filter((record) => record.levels.length > 1).flatMap((record) => record.levels.map((level) => [record.name, level.number, { key: level.judged, show: `${level.judged} of ${level.cycles}` }, 1e3 * level.stroke_m, level.frequency_hz,
    ...QUANTITIES.map((quantity) => percent(level.deviation[quantity])), level.outside ? h("span", { class: "badge bad" }, "✗ outside") : ""]));
  return rows.length ? section("Means of each level", table({
    caption: "Mean of measured over expected less 1",
    columns: [{ name: "record" }, { name: "level" }, { name: "judged", align: "right" }, { name: "stroke", unit: "mm" }, { name: "frequency", unit: "Hz" }, ...QUANTITIES.map((name) => ({ name, unit: "%", digits: 3 })), { name: "", words: "verdict", plain: true }],
    rows,
  })) : null;
}

function outside(records) {
  const rows = records.flatMap((record) => record.outside.map((p) => [record.name, p.cycle, p.quantity, percent(p.deviation), 1e3 * p.speed, p.measured, p.low, p.high, p.quantity === "energy" ? "J" : "N"]));
  if (!rows.length) return null;
  const all = records.reduce((sum, record) => sum + record.outside_count, 0);
  return section("Points outside", table({
    caption: rows.length < all ? `The worst ${rows.length} of ${all}` : "The worst of each record first; above 0 % is stronger than the reference",
    columns: [{ name: "record" }, { name: "cycle" }, { name: "quantity", align: "left" }, { name: "off by", unit: "%", digits: 3 }, { name: "at", unit: "mm/s" }, { name: "measured" }, { name: "band from" }, { name: "to" },
      { name: "unit", align: "left" }],
    rows,
  }));
}

function open(records) {
  const rows = records.flatMap((record) => Object.entries(record.reasons).map(([why, count]) => [record.name, count, why]));
  return rows.length ? section("Not judged", table({ caption: "Nothing is extrapolated from a reference", columns: [{ name: "record" }, { name: "points" }, { name: "why", align: "left" }], rows })) : null;
}

const chance = (value) => (value === null ? null : { key: value, show: value < 1e-4 ? "below 0.01" : number(100 * value, 2) });

const percent = (value) => (value === null || value === undefined ? null : 100 * value);

const inputOf = (record) => (record.input_value === null ? "" : `${number(record.input_value, 5)} ${record.input}`);

function asBand(band) {
  const speeds = band.speed.map((value) => 1e3 * value);
  const reach = 0.02 * Math.max(...speeds.map(Math.abs));
  const x = [speeds[0] - reach, ...speeds, speeds.at(-1) + reach];
  const ends = (values) => [values[0], ...values, values.at(-1)];
  const round = { name: "band", x: [...x, ...[...x].reverse()], y: [...ends(band.high), ...ends(band.low).reverse()], colour: "sky", fill: true, always: true, silent: true };
  return [round, { name: "reference", x, y: ends(band.expected), colour: "ink", dash: "dashed", width: 1.2, always: true }];
}

function asPoints(record, colour, columns, place) {
  return SHAPES.map(([state, shape, words]) => {
    const at = columns.flatMap((p) => p.inside.flatMap((inside, i) => (inside === state ? [[place(p, i), `cycle ${p.cycle[i]}, ${p.quantity}, ${words}`]] : []))).filter(([point]) => point);
    return { name: state === true ? record.name : "", of: record.name, points: true, shape, colour, always: true, ...(state === false ? { size: 11, width: 2.6 } : {}), x: at.map(([[x]]) => x), y: at.map(([[, y]]) => y), tips: at.map(([, tip]) => tip) };
  }).filter((shape) => shape.x.length || shape.name);
}
