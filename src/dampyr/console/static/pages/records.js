// Records: a list to choose from, and the chosen ones overlaid.
import { acceptance, forAddress, fromAddress } from "../lib/acceptance.js";
import { setAddress } from "../lib/address.js";
import { get, post, put, query as asQuery, remove } from "../lib/api.js";
import { charts, COLOURS } from "../lib/chart.js";
import { cycleFigures } from "../lib/cycle_figures.js";
import { confirmed, prompted } from "../lib/dialog.js";
import { button, choice, field, h, number, section, short, tick } from "../lib/dom.js";
import { attempt, say } from "../lib/notice.js";
import { oneNumber } from "../lib/numbers.js";
import { optionsInAddress } from "../lib/options.js";
import { originBadge, originLine } from "../lib/origin.js";
import { usualSource } from "../lib/picker.js";
import { grouping, inputOf, isFound, isGrouping, told, whenOf } from "../lib/record_facts.js";
import { table } from "../lib/table.js";
import { uploads } from "../lib/uploads.js";

const MAX_OPEN = COLOURS.length;
const TIME = { words: "time", unit: "s" };
const CLOCKS = [["begin", "the begin of each motion"], ["rig", "the clock of each record"]];
const FORCE = { words: "force", unit: "N", least: 20 };
const DISPLACEMENT = { words: "displacement", unit: "mm", least: 1 };
const VELOCITY = { words: "velocity", unit: "mm/s", least: 5 };
const TABS = { time: "Time", loops: "Loops", spectra: "Spectra", cycles: "Cycles", acceptance: "Acceptance", about: "About" };

export async function show(root, query) {
  const state = { source: query.get("source"), open: query.getAll("open").slice(0, MAX_OPEN), tab: Object.hasOwn(TABS, query.get("tab") ?? "") ? query.get("tab") : "time", filter: "", role: "", group: isGrouping(query.get("group")) ? query.get("group") : "run", clock: query.get("clock") === "rig" ? "rig" : "begin", all: query.get("all") === "true" };
  const cached = new Map();
  let listed = [];
  let drawings = [];
  const [sources, formats, reading, judging, figures] = await Promise.all(["sources", "formats", "uploads/options", "acceptance/options", "cycle-figures/options"].map((name) => get(`records/${name}`)));
  const request = fromAddress(query, judging);
  const asked = { options: figures, values: optionsInAddress(figures, query) };
  state.source ??= await usualSource(sources);

  const list = h("div");
  const sheet = h("div");
  const source = choice(sources.map((source) => [source.name, source.title]), { value: state.source, onchange: () => ((state.source = source.value), load()) });
  const filter = h("input", { type: "search", placeholder: "name, specimen, date …", oninput: () => ((state.filter = filter.value), fill()) });
  const role = choice([["", "all"], ["fit", "fit"], ["validation", "validation"], ["notes", "with remarks"]], { onchange: () => ((state.role = role.value), fill()) });
  const group = grouping(state.group, (value) => ((state.group = value), keepAddress(), fill()));
  const rest = tick("Interrupted and repeated ones too", { onchange: () => fill() });
  root.append(
    h("div", { class: "split wide" },
      h("div", { class: "side" },
        h("div", { class: "fields sources" }, field("Source", source), field("Filter", filter), field("Role", role), field("Group by", group)),
        rest,
        list,
        uploads(formats.read, reading, (keys) => ((state.source = source.value = "data"), (state.open = keys.slice(0, MAX_OPEN)), load(true)))),
      sheet),
  );

  async function load(again = false) {
    list.replaceChildren(h("p", { class: "soft" }, "Reading the records …"));
    listed = (await attempt(() => get(`records/list?${asQuery({ source: state.source })}`))) ?? [];
    fill();
    if (again) await draw();
  }

  function fill() {
    const shown = listed.filter(passes);
    const leftOut = rest.firstChild.checked ? 0 : listed.filter((record) => record.left_out && !shown.includes(record)).length;
    const { groupOf, headOf, lineOf } = told(shown, state.group);
    const dated = shown.some(whenOf);
    const rows = shown.map((record, k) => {
      const m = record.about?.measured;
      const seen = record.about?.overview;
      return [tickFor(record), nameOf(record, lineOf(k)), ...(dated ? [whenCell(record)] : []), inputOf(record.about), m?.frequency_hz ?? null, m || seen ? 1e3 * (m?.peak_to_peak_m ?? seen.stroke_m) : null,
        m || seen ? 1e3 * (m?.peak_speed ?? seen.peak_speed) : null];
    });
    list.replaceChildren(table({
      caption: `${shown.length} of ${listed.length} records; up to ${MAX_OPEN} are overlaid${leftOut ? `; ${leftOut} interrupted or repeated not shown` : ""}`,
      columns: [{ words: "Shown", plain: true }, { name: "record" }, ...(dated ? [{ name: "date" }] : []), { name: "input" }, { name: "frequency", unit: "Hz" }, { name: "stroke", unit: "mm" }, { name: "peak speed", unit: "mm/s" }],
      rows, groupOf, headOf,
      empty: state.source === "data" && !listed.length ? "No records are here yet; upload one below, or run a campaign." : "No record matches the filter.",
    }));
  }

  function passes(record) {
    if (record.left_out && !rest.firstChild.checked && !state.open.includes(record.key)) return false;
    if (!isFound(record, state.filter)) return false;
    if (state.role === "notes") return Boolean(record.problem || record.about.notes.length || record.note);
    return !state.role || record.about?.role === state.role;
  }

  function tickFor(record) {
    if (record.problem) return null;
    const box = h("input", { type: "checkbox", checked: state.open.includes(record.key), "aria-label": `Show ${short(record.key)}`, onchange: () => toggle(record.key, box) });
    return { key: Number(!box.checked), show: box };
  }

  function toggle(key, box) {
    if (box.checked && state.open.length >= MAX_OPEN) {
      box.checked = false;
      say(`${MAX_OPEN} records are overlaid already; remove one first.`);
      return;
    }
    state.open = box.checked ? [...state.open, key] : state.open.filter((other) => other !== key);
    draw();
  }

  function keepAddress() {
    setAddress(root, "records", { source: state.source, group: state.group === "run" ? undefined : state.group, open: state.open, tab: state.tab, clock: state.clock === "rig" ? "rig" : undefined, all: state.all || undefined, ...forAddress(request), ...asked.values });
  }

  async function draw() {
    keepAddress();
    for (const drawing of drawings) drawing.clear();
    drawings = [];
    if (!state.open.length) {
      sheet.replaceChildren(h("p", { class: "blank" }, "Choose one or more records from the list."));
      return;
    }
    const tabs = h("div", { class: "tabs", role: "tablist", "aria-label": "Views" }, Object.entries(TABS).map(([name, words]) => tab(name, words)));
    const body = h("div", { role: "tabpanel", "aria-labelledby": `tab-${state.tab}`, tabindex: "0" });
    sheet.replaceChildren(tabs, body);
    const chosen = [...state.open];
    const parts = await attempt(() => VIEWS[state.tab](chosen));
    const notice = originLines(listed.filter((record) => chosen.includes(record.key)));
    if (parts && chosen.join() === state.open.join()) body.replaceChildren(...notice, ...parts);
  }

  function tab(name, words) {
    const on = name === state.tab;
    const made = button(words, () => choose(name), { role: "tab", id: `tab-${name}`, "aria-selected": String(on), tabindex: on ? "0" : "-1" });
    made.addEventListener("keydown", (event) => {
      const names = Object.keys(TABS);
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (step) choose(names[(names.indexOf(name) + step + names.length) % names.length], true);
    });
    return made;
  }

  async function choose(name, focus = false) {
    state.tab = name;
    const done = draw();
    if (focus) document.getElementById(`tab-${name}`)?.focus();
    await done;
  }

  async function curves(keys) {
    return Promise.all(keys.map(async (key) => {
      if (!cached.has(key)) cached.set(key, await get(`records/curves?${asQuery({ key })}`));
      return { key, ...cached.get(key) };
    }));
  }

  /** Series of what was loaded, one for each record; a colour is a record's in every view. */
  const seriesOf = (loaded, which, fx = 1, fy = 1) => {
    const names = namesOf(loaded);
    return loaded.map((record, k) => ({ name: names[k], x: times(record[which].x, fx), y: times(record[which].y, fy), colour: COLOURS[k], always: true }));
  };

  function drawn(panels, settings = {}) {
    const made = charts(panels, settings);
    drawings.push(made);
    return made.element;
  }

  function clockChoice() {
    const clock = choice(CLOCKS, { value: state.clock, onchange: () => ((state.clock = clock.value), draw()) });
    return h("div", { class: "row" }, field("Time from", clock));
  }

  const VIEWS = {
    async time(keys) {
      const loaded = (await curves(keys)).map((record) => (state.clock === "rig" ? byClock(record) : record));
      const over = (which, words, y, fy, height) => ({ label: `${words} over time of ${named(loaded)}`, x: TIME, y, height, series: seriesOf(loaded, which, 1, fy) });
      return [clockChoice(), drawn([over("displacement", "Displacement", DISPLACEMENT, 1e3, 210), over("velocity", "Velocity", VELOCITY, 1e3, 210), over("force", "Force", FORCE, 1, 250)], { linked: true }), hint()];
    },
    async loops(keys) {
      const loaded = await curves(keys);
      const over = (which, words, x) => ({ label: `Force over ${words} of ${named(loaded)}`, x: { ...x, pad: 0.04 }, y: FORCE, height: 420, series: seriesOf(loaded, which, 1e3) });
      return [drawn([over("force_displacement", "displacement", DISPLACEMENT), over("force_velocity", "velocity", VELOCITY)], { across: true }), hint()];
    },
    async spectra(keys) {
      const loaded = await curves(keys);
      const names = namesOf(loaded);
      const marks = loaded.map(({ spectrum: { harmonics: marked } }, k) => ({ name: "", of: names[k], points: true, shape: "ring", size: 9, colour: COLOURS[k], always: true,
        x: marked.map((one) => one.frequency), y: marked.map((one) => one.amplitude), tips: marked.map((one) => (one.number === 1 ? "excitation" : `harmonic ${one.number}`)) }));
      const excited = loaded.map(({ spectrum: { excitation } }) => excitation).filter((frequency) => frequency !== null);
      const whole = tick("All frequencies", { checked: state.all, onchange: () => ((state.all = whole.firstChild.checked), draw()) });
      const range = state.all || !excited.length ? {} : { from: Math.min(...excited) / 3, to: 40 * Math.max(...excited) };
      const rows = loaded.flatMap(({ spectrum: { harmonics: marked, of } }, k) => marked.length ? [[names[k], of, marked[0].frequency, marked[0].amplitude, ...SHOWN_HARMONICS.map((wanted) => percent(marked.find((one) => one.number === wanted), marked[0]))]] : []);
      return [h("div", { class: "row" }, whole), drawn([{ label: `Amplitudes of the force by frequency of ${named(loaded)}`, height: 420, x: { words: "frequency", unit: "Hz", log: true, ...range }, y: { words: "amplitude of the force", unit: "N", log: true, pad: 0.05 },
        series: [...loaded.map((record, k) => ({ name: names[k], x: record.spectrum.x, y: record.spectrum.y, colour: COLOURS[k], always: true })), ...marks] }]), hint(),
      h("p", { class: "soft" }, `${[...new Set(loaded.map(({ spectrum: { of } }) => of))].join("; ")}. ○ the excitation and its harmonics.`),
      rows.length ? table({ caption: "Harmonics of the force, as parts of the amplitude at the excitation", rows,
        columns: [{ name: "record" }, { name: "of" }, { name: "excitation", unit: "Hz" }, { name: "amplitude", unit: "N" }, ...SHOWN_HARMONICS.map((wanted) => ({ name: `${wanted}`, unit: "%", digits: 3 }))] }) : ""];
    },
    async cycles(keys) {
      const loaded = await Promise.all(keys.map((key) => get(`records/cycles?${asQuery({ key })}`)));
      const names = keys.map(short);
      const ways = [["out", "circle", "extension"], ["in", "ring", "compression"]];
      const pickup = drawn([{
        label: `Size of the force at peak velocity of every cycle of ${names.join(", ")}`, height: 340,
        x: { words: "peak velocity", unit: "mm/s", pad: 0.08, least: 5 }, y: { words: "force minus its mean", unit: "N", least: 20 },
        series: loaded.flatMap((all, k) => ways.map(([way, shape, words]) => ({ name: shape === "ring" ? "" : names[k], of: names[k], points: true, shape, colour: COLOURS[k], always: true,
          x: all.map((cycle) => 1e3 * Math.abs(cycle[`speed_${way}`])), y: all.map((cycle) => Math.abs(cycle[`force_${way}`])), tips: all.map((_, i) => `cycle ${i + 1}, ${words}`) }))),
      }]);
      const rows = loaded.flatMap((all, k) => all.map((cycle) => [names[k], cycle.number, cycle.level || "run-in or run-out", cycle.start_s, 1 / cycle.period_s, 1e3 * cycle.stroke_m, cycle.least_force, cycle.largest_force, cycle.energy,
        1e3 * cycle.speed_out, cycle.force_out, 1e3 * cycle.speed_in, cycle.force_in]));
      return [section("Peak-velocity pick-up", pickup, h("p", { class: "soft" }, "● extension, ○ compression, both without their signs.")), section("Every whole cycle", table({
        caption: "Mean forces above 95 % of the peak velocity, minus the record's mean force", rows,
        columns: [{ name: "record" }, { name: "cycle" }, { name: "level", align: "right" }, { name: "start", unit: "s" }, { name: "frequency", unit: "Hz" }, { name: "stroke", unit: "mm" }, { name: "least force", unit: "N" },
          { name: "largest force", unit: "N" }, { name: "energy", unit: "J" }, { name: "peak velocity, out", unit: "mm/s" }, { name: "force there", unit: "N" },
          { name: "peak velocity, in", unit: "mm/s" }, { name: "force there", unit: "N" }],
      })), section("Figures of cycles and of the device", ...cycleFigures(keys, asked, keepAddress))];
    },
    acceptance: (keys) => acceptance(keys, request, keepAddress, drawings),
    async about(keys) {
      const loaded = await Promise.all(keys.map((key) => get(`records/one?${asQuery({ key })}`)));
      return loaded.map((record) => about(record));
    },
  };

  function about(record) {
    const { about: a, key } = record;
    const m = a.measured;
    const q = a.quality;
    const facts = [
      ["origin", a.origin.kind], ["role", a.role], ["input", inputOf(a)?.show ?? "unknown"],
      ...(a.measurement_session ? [["session", a.measurement_session]] : []), ...(a.specimen ? [["specimen", a.specimen]] : []),
      ["duration", `${number(a.duration_s)} s, ${q.samples} samples, every ${number(1e3 * q.dt)} ms`],
      ...(m ? [["whole cycles", `${m.cycles} from ${number(m.motion_start)} s on`], ["frequency", `${number(m.frequency_hz)} Hz`], ["peak to peak", `${number(1e3 * m.peak_to_peak_m)} mm`],
        ["peak speed", `${number(1e3 * m.peak_speed)} mm/s`], ["mean force", `${number(m.mean_force)} N`], ["energy per cycle", `${number(m.energy_per_cycle)} J`], ["drift", `${number(1e3 * m.drift_m_per_s, 3)} mm/s`],
        ["third harmonic", `${number(100 * m.harmonics[3], 2)} %`]] : [["overall stroke", `${number(1e3 * a.overview.stroke_m)} mm`], ["peak speed", `${number(1e3 * a.overview.peak_speed)} mm/s`]]),
      ...Object.entries(q.quantum).map(([channel, step]) => [`${channel} step`, inUnit(channel, step, 3)]),
      ...Object.entries(a.uncertainty).map(([channel, uncertainty]) => [`${channel} uncertainty`, `${inUnit(channel, uncertainty.standard, 2)} (one sigma), by ${uncertainty.largest} before all`]),
      ...Object.entries(a.provenance), ...a.history.map((step) => ["processing", step]),
    ];
    const text = h("textarea", { value: record.note, maxlength: "2000" });
    const keep = async () => {
      if (await attempt(() => put("records/notes", { key, text: text.value }))) {
        say("The note is saved.");
        const there = listed.find((other) => other.key === key);
        if (there) there.note = text.value.trim();
        fill();
      }
    };
    const exports = formats.written.map((format) =>
      h("a", { class: "button", href: `/api/records/export?${asQuery({ key, format: format.name })}`, download: "" }, format.title));
    const own = key.startsWith("data/uploads/");
    return section(a.name,
      h("p", {}, a.notes.length ? a.notes.map((note) => h("span", { class: "badge bad" }, note)) : h("span", { class: "badge good" }, "no remarks")),
      h("div", { class: "row" }, h("span", { class: "label" }, "Save as"), exports),
      h("dl", { class: "facts" }, facts.map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])),
      field("Note", text), h("div", { class: "row" }, button("Save the note", keep)),
      own ? changes(key, a) : null);
  }

  /** What can be changed of a record that was uploaded. */
  function changes(key, a) {
    const entries = { specimen: a.specimen, operator: a.provenance.operator, measurement_session: a.measurement_session };
    const inputs = Object.fromEntries(Object.entries(entries).map(([name, value]) => [name, h("input", { type: "text", maxlength: "100", value: value ?? "" })]));
    const numbers = { voltage: a.input === "V" ? a.input_value : null, current: a.input === "A" ? a.input_value : null, temperature: null };
    inputs.role = choice(["fit", "validation"], { value: a.role });
    for (const [name, value] of Object.entries(numbers)) inputs[name] = h("input", { type: "text", inputmode: "decimal", value: value ?? "" });
    const typed = (name) => (name in numbers ? oneNumber(inputs[name].value, WORDS[name]) : inputs[name].value.trim());
    const before = Object.fromEntries(Object.keys(inputs).map((name) => [name, typed(name)]));
    const save = async () => {
      let given;
      try {
        given = Object.fromEntries(Object.keys(inputs).map((name) => [name, typed(name)]).filter(([name, value]) => value !== before[name] && value !== null && value !== ""));
      } catch (problem) {
        return say(problem.message, "bad");
      }
      if (!Object.keys(given).length) return say("Nothing is changed; enter what is known of the record.", "bad");
      if (!(await attempt(() => post("records/edit", { key, ...given })))) return;
      cached.delete(key);
      await load(true);
      say("The record is written anew; the file as it came is stored with it.");
    };
    const rename = async () => {
      const name = await prompted(`Rename ${short(key)}`, "New name", short(key), "Rename");
      if (name === null || name === short(key)) return;
      const made = await attempt(() => post("records/rename", { key, name }));
      if (!made) return;
      state.open = state.open.map((open) => (open === key ? made.key : open));
      await load(true);
      say(`Renamed ${short(made.key)}.`);
    };
    return h("details", {}, h("summary", {}, "Change what is said of it"),
      h("div", { class: "fields" }, Object.keys(inputs).map((name) => field(WORDS[name], inputs[name]))),
      h("div", { class: "row" }, button("Save the changes", save), button("Rename", rename)),
      h("div", { class: "row" }, button("Delete the record", () => drop(key), { class: "danger" })));
  }

  async function drop(key) {
    if (!(await confirmed(`Delete the record ${short(key)} and its note? The console cannot bring it back.`, "Delete"))) return;
    if ((await attempt(() => remove(`records/uploads/${encodeURIComponent(key.split("/").at(-1))}`))) === undefined) return;
    state.open = state.open.filter((other) => other !== key);
    await load(true);
    say("The record is deleted.");
  }

  await load();
  await draw();
  return () => drawings.forEach((drawing) => drawing.clear());
}

const WORDS = { role: "Role", specimen: "Specimen", operator: "Operator", measurement_session: "Session", voltage: "Voltage at the coil, V", current: "Current, A", temperature: "Temperature, °C" };
const UNITS = { time: ["s", 1], displacement: ["mm", 1e3], force: ["N", 1], velocity: ["mm/s", 1e3], voltage: ["V", 1], current: ["A", 1], temperature: ["°C", 1] };
const inUnit = (channel, value, digits) => `${number((UNITS[channel]?.[1] ?? 1) * value, digits)} ${UNITS[channel]?.[0] ?? ""}`;
const times = (values, factor) => (factor === 1 ? values : values.map((value) => factor * value));
const SHOWN_HARMONICS = [2, 3, 5, 7, 9];
const percent = (harmonic, first) => (harmonic ? (100 * harmonic.amplitude) / first.amplitude : null);
const TIMES = ["displacement", "velocity", "force"];
const byClock = (record) => ({ ...record, ...Object.fromEntries(TIMES.map((name) => [name, { ...record[name], x: record[name].x.map((time) => time + record.begin) }])) });
const named = (loaded) => namesOf(loaded).join(", ");
const hint = () => h("p", { class: "soft" }, "Drag over a chart to zoom in (on a touch screen press Zoom first); double-click to show all. A name in the legend hides its line.");

/** The names of records; of two runs with the same names each with its folder. */
const namesOf = (loaded) => loaded.map((record) => (loaded.some((other) => other !== record && other.name === record.name) ? `${record.name} (${record.key.split("/").at(-2)})` : record.name));

const nameOf = (record, line) => ({ key: record.key, show: h("span", { class: "named", title: record.key }, short(record.key), flags(record), line) });

/** Date above time: both whole where the column is narrow. */
function whenCell(record) {
  const when = whenOf(record);
  return when && { key: when, show: h("span", {}, when.split(" ").flatMap((part) => [h("span", { class: "when" }, part), " "])) };
}

/** What is said of all records shown that are not measured: a line for each kind. */
function originLines(records) {
  const kinds = [...new Set(records.map((record) => record.about?.origin.kind))];
  return kinds.map((kind) => {
    const some = records.filter((record) => record.about?.origin.kind === kind);
    return originLine(some[0].about?.origin, some.length === records.length && some.length > 1 ? "All records shown" : some.map((record) => short(record.key)).join(", "));
  }).filter(Boolean);
}

function flags(record) {
  const marks = [];
  const origin = originBadge(record.about?.origin);
  if (origin) marks.push(origin);
  if (record.left_out) marks.push(h("span", { class: "badge bad", title: record.left_out }, record.left_out.split(":")[0]));
  if (record.problem) marks.push(h("span", { class: "badge bad", title: record.problem }, "cannot be read"), h("small", { class: "under" }, record.problem));
  else if (record.about.notes.length) marks.push(h("span", { class: "badge bad", title: record.about.notes.join("; ") }, `remarks: ${record.about.notes.length}`));
  if (record.about?.role === "validation") marks.push(h("span", { class: "badge" }, "validation"));
  if (record.note) marks.push(h("span", { class: "badge", title: record.note }, "note"));
  return marks;
}
