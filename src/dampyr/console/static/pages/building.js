// Building: building, motion and damper on the left, the response on the right. Responses and ensembles are jobs.
import { setAddress } from "../lib/address.js";
import { get, post } from "../lib/api.js";
import { before } from "../lib/before.js";
import { charts, COLOURS } from "../lib/chart.js";
import { dataFileForm } from "../lib/data_files.js";
import { button, choice, field, h, number, section, tick } from "../lib/dom.js";
import { watch } from "../lib/jobs.js";
import { attempt, say } from "../lib/notice.js";
import { numberList, oneNumber } from "../lib/numbers.js";
import { optionsForm } from "../lib/options.js";
import { storeys } from "../lib/storeys.js";
import { servedTable, table } from "../lib/table.js";

const G = 9.80665;
const TIME = { words: "time", unit: "s" };
const KINDS = ["respond", "ensemble"];
const ENERGIES = { // not in the colours of the first cases
  input: { name: "input", colour: "ink" }, viscous: { name: "viscous damping", colour: "sky" },
  dampers: { name: "damper", colour: "purple", width: 2 }, moving: { name: "kinetic and strain", colour: "orange" },
};

export async function show(root, query) {
  const choices = await get("building/choices");
  let stop = null;
  let live = [];
  const progress = h("div");
  const sheet = h("div");
  const past = before("building", KINDS, follow);
  const form = asking(choices);
  root.append(h("div", { class: "split" },
    h("div", { class: "side" }, form.element,
      h("details", {}, h("summary", {}, "Options of a simulation"), form.settings),
      h("div", { class: "row" }, button("Simulate", () => start("building/responses", form.response), { class: "main" })),
      h("details", {}, h("summary", {}, "Add a card, a structure or a motion"), dataFileForm(() => dispatchEvent(new Event("hashchange")))),
      h("details", {}, h("summary", {}, "Many earthquakes"), form.many, h("div", { class: "row" }, button("Run the ensemble", () => start("building/ensembles", form.ensemble)))),
      past.element),
    h("div", {}, progress, sheet)));
  if (query.get("job")) follow(query.get("job"));
  else sheet.append(h("p", { class: "blank" }, "Choose a building, a motion and a damper, then simulate. The response appears here."));

  async function start(path, question) {
    let request;
    try {
      request = question();
    } catch (problem) {
      return say(problem.message, "bad");
    }
    const job = await attempt(() => post(path, request));
    if (job) {
      follow(job.id);
      past.look();
    }
  }

  function follow(id) {
    if (!root.isConnected) return; // the person has left the page; the job continues
    setAddress(root, "building", { job: id });
    stop?.();
    clear();
    sheet.replaceChildren();
    stop = watch(progress, id, async (job) => {
      past.look();
      if (job.state === "done") await (job.kind === "respond" ? response(job) : ensemble(job));
    });
  }

  function clear() {
    for (const chart of live) chart.clear();
    live = [];
  }

  const plot = (panels, settings) => {
    const made = charts([panels].flat(), settings);
    live.push(made);
    return made.element;
  };

  /** The charts of `host`, in place of those that it had. */
  const redraw = (host, panels, settings) => {
    host.drawing?.clear();
    live = live.filter((chart) => chart !== host.drawing);
    host.replaceChildren(plot(panels, settings));
    host.drawing = live.at(-1);
  };

  const page = (id) => h("a", { class: "button", href: `/api/building/jobs/${id}/page`, download: "" }, "Save the whole page");

  async function response({ id, result: r, request }) {
    const curves = await attempt(() => get(`building/responses/${id}/curves`));
    if (!curves) return;
    const names = r.cases.map((response) => response.name);
    const colourOf = (name) => (names.indexOf(name) ? COLOURS[(names.indexOf(name) - 1) % COLOURS.length] : "muted");
    const moving = storeys({ ...curves.frames, colourOf });
    live.push(moving);
    const over = (which, k, words, unit, factor) => ({
      label: `${words} over time, ${names.join(", ")}`, x: TIME, y: { words, unit }, height: 210,
      series: names.map((name) => ({ name, colour: colourOf(name), always: true, x: curves.cases[name][which][k].x, y: curves.cases[name][which][k].y.map((v) => factor * v) })) });
    const floor = choice(r.floors.map((name, k) => [k, `floor ${name}`]), { value: String(r.floors.length - 1), onchange: () => histories() });
    const lines = h("div");
    const chosen = choice(names, { value: names.at(-1), onchange: () => energies() });
    const energy = h("div");
    const damped = names.filter((name) => curves.cases[name].loops.length);
    const ruled = damped.filter((name) => new Set(curves.cases[name].inputs[0].y).size > 1);
    const input = ruled.length ? [{ label: `Input over time, ${ruled.join(", ")}`, x: TIME, y: { words: "input", unit: r.unit }, height: 150,
      series: ruled.map((name) => ({ name, always: true, width: 1, colour: colourOf(name), ...curves.cases[name].inputs[0] })) }] : [];
    const histories = () => {
      const k = Number(floor.value);
      redraw(lines, [over("displacement", k, `displacement, floor ${r.floors[k]}`, "mm", 1e3), over("acceleration", k, `acceleration, floor ${r.floors[k]}`, "m/s²", 1), over("drift", k, `drift, storey ${k + 1}`, "mm", 1e3), ...input], { linked: true });
    };
    const energies = () => redraw(energy, { label: `Energies over time, ${chosen.value}`, x: TIME, y: { words: "energy", unit: "J" }, height: 260, zero: true,
      series: Object.entries(curves.cases[chosen.value].energy).map(([name, line]) => ({ ...ENERGIES[name], ...line })) });
    sheet.replaceChildren(
      section(r.title, r.notice ? h("p", { class: "verdict bad origin" }, r.notice) : null, (r.findings ?? []).map((finding) => h("p", { class: `verdict ${finding.severity === "wrong" ? "bad" : "fair"}` }, finding.sentence)), moving.element),
      section("Peaks", peaks(r), r.note ? h("p", { class: "soft" }, r.note) : "", h("div", { class: "row" }, page(id))),
      section("Histories", field("Floor", floor), lines),
      damped.length ? section(curves.cases[damped[0]].loops.length > 1 ? "The dampers" : "The damper", plot({ label: `Damper force over stroke, ${damped.join(", ")}`, x: { words: "stroke", unit: "mm", pad: 0.04 }, y: { words: "force", unit: "N" }, height: 340,
        series: damped.flatMap((name) => curves.cases[name].loops.map((loop, k, { length }) => ({ name: length > 1 ? `${name}, storey ${request.damper.storeys[k]}` : name, always: true, colour: colourOf(name), dash: DASHES[k % DASHES.length], y: loop.y, x: loop.x.map((v) => 1e3 * v) }))) })) : "",
      section("Energy", field("Case", chosen), energy, energyTable(r)),
      section("Ground motion", plot({ label: "Ground acceleration over time", x: TIME, y: { words: "acceleration", unit: "m/s²" }, height: 180, series: [{ name: "ground", colour: "muted", ...curves.ground }] })));
    histories();
    energies();
  }

  function ensemble({ id, result: r }) {
    const notice = () => (r.notice ? h("p", { class: "verdict bad origin" }, r.notice) : null);
    const row = () => h("div", { class: "row" }, page(id));
    const all = r.fragilities ?? [{ ...r, axis: { words: "peak ground acceleration", unit: "g", factor: 1 / G } }]; // of jobs of before
    const colourAt = (name, k) => (name === "no damper" ? "muted" : COLOURS[(k - 1 + COLOURS.length) % COLOURS.length]); // as in a response
    const growing = ({ axis, sweeps }) => {
      const series = sweeps.flatMap((sweep, k) => sweep.fractiles.map((peaks, j) => ({ name: j === 1 ? sweep.name : "", of: sweep.name, always: true, colour: colourAt(sweep.name, k), width: j === 1 ? 2.2 : 1, dash: j === 1 ? undefined : "dashed",
        x: sweep.levels.map((v) => axis.factor * v), y: peaks.map((v) => (v === null ? null : 1e3 * v)) })));
      const remarks = sweeps.map(({ name, bent_back: bent, unbounded }) => `${name}: ${bent ? `${bent} of ${r.motions} motions have a smaller drift at a greater intensity somewhere` : "every drift grows with the intensity"}${unbounded ? `; ${unbounded} cases grew without bound, and lines end where they reach them` : ""}.`);
      return section("Incremental analysis", notice(), plot({ label: `Largest drift over ${axis.words}`, x: { words: axis.words, unit: axis.unit, pad: 0.03 }, y: { words: "largest drift", unit: "mm" }, height: 380, zero: true, series }),
        h("p", { class: "soft" }, "Medians over the motions, dashed the fractiles of 16 and 84 %."), remarks.map((remark) => h("p", {}, remark)));
    };
    const fragility = ({ limit, axis, curves, table: medians, remarks }) => {
      const series = curves.flatMap((curve, k) => {
        const colour = colourAt(curve.name, k);
        const line = (y, more) => (y ? [{ colour, x: curve.x.map((v) => axis.factor * v), y: y.map((v) => (v === null ? null : 100 * v)), ...more }] : []);
        return [...line(curve.y, { name: curve.name, always: true, width: 2.2, dash: curve.determined === false ? "dashed" : undefined }), ...line(curve.low, { of: curve.name, dash: "dotted", width: 1 }), ...line(curve.high, { of: curve.name, dash: "dotted", width: 1 }),
          { name: curve.y ? "" : curve.name, of: curve.name, always: true, colour, points: true, x: curve.counted.x.map((v) => axis.factor * v), y: curve.counted.y.map((v) => 100 * v) }];
      });
      return section(`Fragility: ${limit}`, notice(), plot({ label: `Probability of ${limit} over ${axis.words}`, x: { words: axis.words, unit: axis.unit, pad: 0.03 }, y: { words: "probability of exceeding", unit: "%" }, height: 380, zero: true, series }),
        h("p", { class: "soft" }, `${r.cases} cases, ${r.motions} motions; dotted: 90 % bands over the motions; points: the shares that were counted${curves.some((curve) => curve.y && curve.determined === false) ? "; dashed: a curve that these motions do not determine" : ""}.`),
        servedTable(medians, { caption: "Median and spread of each curve", digits: 4 }), remarks.map((remark) => h("p", {}, remark)), row());
    };
    sheet.replaceChildren(
      ...(all.length ? all.map(fragility) : [section("Ensemble", notice(), row())]),
      r.incremental ? growing(r.incremental) : "",
      section("Peaks", servedTable(r.peaks, { caption: "Across motions, of the worst storey and floor", digits: 4 })),
      section("Accuracy", r.trust.map((sentence) => h("p", {}, sentence))));
  }

  return () => {
    stop?.();
    past.clear();
    clear();
  };
}

const DASHES = [undefined, "dashed", "dotted", "long"]; // of one case, by storey
const WIDE = 8; // floors that a table has columns for

function peaks(r) {
  const floors = r.floors.length > WIDE ? [`largest of ${r.floors.length} floors`] : r.floors.map((name) => `floor\u00a0${name}`);
  const moved = (response) => (r.floors.length > WIDE ? [Math.max(...response.peak_displacement)] : response.peak_displacement);
  const rows = r.cases.map((response) => [response.name, ...moved(response).map((v) => 1e3 * v), 1e3 * Math.max(...response.peak_drift), Math.max(...response.peak_acceleration), response.peak_base_shear,
    response.peak_force.length ? Math.max(...response.peak_force) : null, ...(r.unit ? [response.mean_input.length ? response.mean_input[0] : null] : []), -100 * (1 - response.peak_displacement.at(-1) / r.cases[0].peak_displacement.at(-1)) || null]);
  return table({ caption: `Peaks inside the step; displacements relative to the ground, accelerations absolute; the response ${r.end ?? "ends with the record"}`, rows,
    columns: [{ name: "case" }, ...floors.map((name) => ({ name, unit: "mm" })), { name: "largest drift", unit: "mm" }, { name: "largest acceleration", unit: "m/s²" }, { name: "base shear", unit: "N" },
      { name: "damper force", unit: "N" }, ...(r.unit ? [{ name: "mean input", unit: r.unit }] : []), { name: "top floor, change", unit: "%", digits: 3 }] });
}

function energyTable(r) {
  return table({ caption: "Energies at the end; the residual is the error of the energy balance", rows: r.cases.map(({ name, energy: e }) => [name, e.input, e.viscous, e.dampers, e.moving, e.residual]),
    columns: [{ name: "case" }, ...["input", "viscous", "damper", "kinetic and strain", "residual"].map((name) => ({ name, unit: "J" }))] });
}

/** The form, and the requests that it makes. */
function asking(choices) {
  const text = (value, more = {}) => h("input", { type: "text", inputmode: "decimal", value, ...more });
  const building = choice([["two_storey", "two storeys (chapter 5)"], ["shear", "a shear building"], ...choices.structures.map((name) => [`named:${name}`, name])], { onchange: () => (own.hidden = building.value !== "shear") });
  const masses = text("1000 1000 1000");
  const stiffnesses = text("1e6 1e6 1e6");
  const damping = text("3");
  const own = h("div", { class: "fields", hidden: true }, field("Masses, kg", masses, "from the ground up"), field("Stiffnesses, N/m", stiffnesses), field("Damping, %", damping));
  const motion = choice([["el_centro", "El Centro 1940, NS"], ["kanai_tajimi", "synthetic, by seed"], ...choices.motions.map((file) => [`file:${file}`, file])], { onchange: () => shift() });
  const pga = text("", { placeholder: "unscaled" });
  const seed = text("1");
  const unit = choice([["", "from the file"], ["g", "g"], ["m/s^2", "m/s²"], ["cm/s^2", "cm/s²"]]);
  const seeded = field("Seed of the motion", seed);
  const united = field("Unit of the file", unit);
  const shift = () => ((seeded.hidden = motion.value !== "kanai_tajimi"), (united.hidden = !motion.value.startsWith("file:")));
  shift();
  const damper = choice(choices.dampers.map((damper) => [damper.name, damper.title]), { onchange: () => describeRange() });
  const storey = text("1");
  const inputs = text("0 1.98");
  const cases = field("Inputs", inputs, "one case each");
  const controls = h("div", { class: "row", role: "group", "aria-label": "Control laws" });
  const passive = () => choices.dampers.find(({ name }) => name === damper.value)?.unit === ""; // no input, so one case and no law
  const range = h("p", { class: "soft" });
  const laws = Object.entries(choices.laws).map(([name, words]) => [name, tick(words)]);
  controls.append(...laws.map(([, box]) => box));
  const shared = optionsForm(choices.shared_options);
  const settings = optionsForm(choices.response_options);
  const manySettings = optionsForm(choices.ensemble_options);
  const describeRange = () => {
    const chosen = choices.dampers.find(({ name }) => name === damper.value);
    cases.hidden = controls.hidden = passive();
    range.textContent = !chosen ? "" : passive() ? "It has no input." : `Calibrated from ${number(chosen.low)} to ${number(chosen.high)} ${chosen.unit}.`;
    if (chosen) inputs.value = [chosen.low, number((chosen.low + chosen.high) / 2, 3), number(chosen.high)].join(" ");
  };
  describeRange();
  const count = text("30");
  const scales = text("0.1 0.2 0.3 0.4 0.5 0.7 1 1.3 1.6 2 2.5 3");
  const element = h("div", {},
    h("fieldset", {}, h("legend", {}, "Building"), field("Structure", building), own),
    h("fieldset", {}, h("legend", {}, "Ground motion"), field("Motion", motion), h("div", { class: "fields" }, field("Peak, g", pga), seeded, united)),
    h("fieldset", {}, h("legend", {}, "Damper"), field("Card or published damper", damper), range, h("div", { class: "fields" }, field("Storeys", storey, "a damper in each"), cases),
      controls,
      h("details", {}, h("summary", {}, "Options of all cases"), shared.element)));
  const many = h("div", {}, h("div", { class: "fields" }, field("Synthetic motions", count), field("Scales", scales)), manySettings.element);

  const common = () => {
    const file = motion.value.startsWith("file:") ? motion.value.slice(5) : "";
    const chosen = { kind: file ? "file" : motion.value, file, unit: file ? unit.value : "", seed: single("Seed of the motion", seed) };
    if (pga.value.trim()) chosen.pga = G * single("Peak", pga);
    return {
      building: building.value.startsWith("named:") ? named(building.value.slice(6)) : building.value === "shear" ? { kind: "shear", masses: several("Masses", masses), stiffnesses: several("Stiffnesses", stiffnesses), damping: single("Damping", damping) / 100 } : {},
      motion: chosen,
      ...shared.values(),
      damper: { name: damper.value, storeys: several("Storeys", storey), inputs: passive() ? [] : several("Inputs", inputs), laws: passive() ? [] : laws.filter(([, box]) => box.firstChild.checked).map(([name]) => name) },
    };
  };
  const ensemble = () => {
    const request = common();
    if (request.motion.kind === "el_centro") request.motion.kind = "kanai_tajimi";
    return { ...request, ...manySettings.values(), motions: single("Synthetic motions", count), scales: several("Scales", scales) };
  };
  const response = () => ({ ...common(), ...settings.values() });
  return { element, many, settings: settings.element, response, ensemble };
}

/** A structure by its name: a file of the folder structures, or a published one. */
function named(name) {
  const file = name.startsWith("structures/");
  return { kind: file ? "file" : "published", name: file ? name.slice("structures/".length) : name };
}

function several(words, control) {
  return numberList(control.value, words);
}

function single(words, control) {
  const value = oneNumber(control.value, words);
  if (value === null) throw new Error(`${words} is empty; give a number.`);
  return value;
}
