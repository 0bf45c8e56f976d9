// Records: a list to choose from, and the chosen ones overlaid.
import { acceptance, forAddress, fromAddress } from "../lib/acceptance.js";
import { setAddress } from "../lib/address.js";
import { get, put, query as asQuery, remove, upload } from "../lib/api.js";
import { chart, COLOURS } from "../lib/chart.js";
import { button, choice, field, h, number, section, short } from "../lib/dom.js";
import { attempt, say } from "../lib/notice.js";
import { table } from "../lib/table.js";

const MAX_OPEN = COLOURS.length;
const TIME = { words: "time", unit: "s" };
const FORCE = { words: "force", unit: "N" };
const DISPLACEMENT = { words: "displacement", unit: "mm" };
const VELOCITY = { words: "velocity", unit: "mm/s" };
const TABS = { time: "Time", loops: "Loops", spectra: "Spectra", cycles: "Cycles", acceptance: "Acceptance", about: "About" };

export async function show(root, query) {
  const state = { source: query.get("source"), open: query.getAll("open").slice(0, MAX_OPEN), tab: query.get("tab") ?? "time", filter: "", role: "" };
  const request = fromAddress(query);
  const cached = new Map();
  let listed = [];
  let charts = [];
  const [sources, formats] = await Promise.all([get("records/sources"), get("records/formats")]);
  state.source ??= sources.at(-1).name;

  const list = h("div");
  const sheet = h("div");
  const source = choice(sources.map((one) => [one.name, one.title]), { value: state.source, onchange: () => ((state.source = source.value), load()) });
  const filter = h("input", { type: "search", oninput: () => ((state.filter = filter.value.toLowerCase()), fill()) });
  const role = choice([["", "all"], ["fit", "fit"], ["validation", "validation"], ["notes", "with remarks"]], { onchange: () => ((state.role = role.value), fill()) });
  root.append(
    h("div", { class: "split wide" },
      h("div", { class: "side" },
        h("div", { class: "fields sources" }, field("Source", source), field("Filter", filter), field("Role", role)),
        list,
        uploads(formats.read, (key) => ((state.source = source.value = "data"), (state.open = [key]), load(true)))),
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
    const rows = shown.map((one) => {
      const m = one.about?.measured;
      const seen = one.about?.overview;
      return [tickFor(one), nameOf(one), inputOf(one.about), m?.frequency_hz ?? null, m || seen ? 1e3 * (m?.peak_to_peak_m ?? seen.stroke_m) : null,
        m || seen ? 1e3 * (m?.peak_speed ?? seen.peak_speed) : null];
    });
    list.replaceChildren(table({
      caption: `${shown.length} of ${listed.length} records; up to ${MAX_OPEN} are overlaid`,
      columns: [{ words: "Shown", plain: true }, { name: "record" }, { name: "input" }, { name: "frequency", unit: "Hz" }, { name: "stroke", unit: "mm" }, { name: "peak speed", unit: "mm/s" }],
      rows,
      empty: state.source === "data" ? "No records are here yet; upload one below, or run a campaign." : "No record matches the filter.",
    }));
  }

  function passes(one) {
    const words = `${one.key} ${inputOf(one.about)?.key ?? ""} ${one.about?.notes.join(" ") ?? one.problem} ${one.note}`.toLowerCase();
    if (!words.includes(state.filter)) return false;
    if (state.role === "notes") return Boolean(one.problem || one.about.notes.length || one.note);
    return !state.role || one.about?.role === state.role;
  }

  function tickFor(one) {
    if (one.problem) return null;
    const box = h("input", { type: "checkbox", checked: state.open.includes(one.key), "aria-label": `Show ${short(one.key)}`, onchange: () => toggle(one.key, box) });
    return { key: Number(!box.checked), show: box };
  }

  function toggle(key, box) {
    if (box.checked && state.open.length >= MAX_OPEN) {
      box.checked = false;
      say(`${MAX_OPEN} records are overlaid already; remove one first.`);
      return;
    }
    state.open = box.checked ? [...state.open, key] : state.open.filter((one) => one !== key);
    draw();
  }

  function keepAddress() {
    setAddress(root, "records", { source: state.source, open: state.open, tab: state.tab, ...forAddress(request) });
  }

  async function draw() {
    keepAddress();
    for (const one of charts) one.clear();
    charts = [];
    if (!state.open.length) {
      sheet.replaceChildren(h("p", { class: "blank" }, "Choose one or more records from the list."));
      return;
    }
    const tabs = h("div", { class: "tabs", role: "tablist", "aria-label": "Views" }, Object.entries(TABS).map(([name, words]) => tab(name, words)));
    const body = h("div", { role: "tabpanel", "aria-labelledby": `tab-${state.tab}`, tabindex: "0" });
    sheet.replaceChildren(tabs, body);
    const chosen = [...state.open];
    const parts = await attempt(() => VIEWS[state.tab](chosen));
    if (parts && chosen.join() === state.open.join()) body.replaceChildren(...parts);
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
      return cached.get(key);
    }));
  }

  function overlay(loaded, which, x, y, label, { fx = 1, fy = 1, ...more } = {}) {
    const series = loaded.map((one, k) => ({ name: one.name, x: times(one[which].x, fx), y: times(one[which].y, fy), colour: COLOURS[k], always: true }));
    const made = chart({ label: `${label} of ${loaded.map((one) => one.name).join(", ")}`, x, y, series, ...more });
    charts.push(made);
    return made.element;
  }

  const VIEWS = {
    async time(keys) {
      const loaded = await curves(keys);
      return [
        overlay(loaded, "displacement", TIME, DISPLACEMENT, "Displacement over time", { fy: 1e3, height: 220 }),
        overlay(loaded, "velocity", TIME, VELOCITY, "Velocity over time", { fy: 1e3, height: 220 }),
        overlay(loaded, "force", TIME, FORCE, "Force over time", { height: 260 }),
        hint(),
      ];
    },
    async loops(keys) {
      const loaded = await curves(keys);
      return [h("div", { class: "charts" },
        overlay(loaded, "force_displacement", DISPLACEMENT, FORCE, "Force over displacement", { fx: 1e3, height: 420 }),
        overlay(loaded, "force_velocity", VELOCITY, FORCE, "Force over velocity", { fx: 1e3, height: 420 })), hint()];
    },
    async spectra(keys) {
      const loaded = await curves(keys);
      return [overlay(loaded, "spectrum", { words: "frequency", unit: "Hz" }, { words: "amplitude of the force", unit: "N" }, "Amplitudes of the force by frequency", { height: 360, zero: true }), hint()];
    },
    async cycles(keys) {
      const loaded = await Promise.all(keys.map((key) => get(`records/cycles?${asQuery({ key })}`)));
      const names = keys.map(short);
      const pickup = chart({
        label: `Force at peak velocity of every cycle of ${names.join(", ")}`, x: { ...VELOCITY, words: "peak velocity", pad: 0.08 }, y: { words: "force minus its mean", unit: "N" }, height: 340,
        series: loaded.map((all, k) => ({ name: names[k], points: true, colour: COLOURS[k], always: true,
          x: all.flatMap((one) => [1e3 * one.speed_out, 1e3 * one.speed_in]), y: all.flatMap((one) => [one.force_out, one.force_in]) })),
      });
      charts.push(pickup);
      const rows = loaded.flatMap((all, k) => all.map((one, i) => [names[k], i + 1, one.start_s, 1 / one.period_s, 1e3 * one.stroke_m, one.least_force, one.largest_force, one.energy,
        1e3 * one.speed_out, one.force_out, 1e3 * one.speed_in, one.force_in]));
      return [section("Peak-velocity pick-up", pickup.element), section("Every whole cycle", table({
        caption: "Forces at peak velocity, minus the record's mean force", rows,
        columns: [{ name: "record" }, { name: "cycle" }, { name: "start", unit: "s" }, { name: "frequency", unit: "Hz" }, { name: "stroke", unit: "mm" }, { name: "least force", unit: "N" },
          { name: "largest force", unit: "N" }, { name: "energy", unit: "J" }, { name: "peak velocity, out", unit: "mm/s" }, { name: "force there", unit: "N" },
          { name: "peak velocity, in", unit: "mm/s" }, { name: "force there", unit: "N" }],
      }))];
    },
    acceptance: (keys) => acceptance(keys, request, keepAddress, charts),
    async about(keys) {
      const loaded = await Promise.all(keys.map((key) => get(`records/one?${asQuery({ key })}`)));
      return loaded.map((one) => about(one));
    },
  };

  function about(one) {
    const { about: a, key } = one;
    const m = a.measured;
    const q = a.quality;
    const facts = [
      ["role", a.role], ["input", inputOf(a)?.show ?? "unknown"],
      ...(a.measurement_session ? [["session", a.measurement_session]] : []), ...(a.specimen ? [["specimen", a.specimen]] : []),
      ["duration", `${number(a.duration_s)} s, ${q.samples} samples, every ${number(1e3 * q.dt)} ms`],
      ...(m ? [["whole cycles", `${m.cycles} from ${number(m.motion_start)} s on`], ["frequency", `${number(m.frequency_hz)} Hz`], ["peak to peak", `${number(1e3 * m.peak_to_peak_m)} mm`],
        ["peak speed", `${number(1e3 * m.peak_speed)} mm/s`], ["mean force", `${number(m.mean_force)} N`], ["energy per cycle", `${number(m.energy_per_cycle)} J`], ["drift", `${number(1e3 * m.drift_m_per_s, 3)} mm/s`],
        ["third harmonic", `${number(100 * m.harmonics[3], 2)} %`]] : [["overall stroke", `${number(1e3 * a.overview.stroke_m)} mm`], ["peak speed", `${number(1e3 * a.overview.peak_speed)} mm/s`]]),
      ...Object.entries(q.quantum).map(([channel, step]) => [`${channel} step`, `${number(step, 3)} ${SI[channel] ?? ""}`]),
      ...Object.entries(a.uncertainty).map(([channel, one]) => [`${channel} uncertainty`, `${number(one.standard, 2)} ${SI[channel]} (one sigma), by ${one.largest} before all`]),
      ...Object.entries(a.provenance), ...a.history.map((step) => ["processing", step]),
    ];
    const text = h("textarea", { value: one.note, maxlength: "2000" });
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
    const away = key.startsWith("data/uploads/") ? button("Delete the record", () => drop(key), { class: "quiet" }) : null;
    return section(a.name,
      h("p", {}, a.notes.length ? a.notes.map((note) => h("span", { class: "badge bad" }, note)) : h("span", { class: "badge good" }, "no remarks")),
      h("div", { class: "row" }, h("span", { class: "label" }, "Save as"), exports, away),
      h("dl", { class: "facts" }, facts.map(([name, value]) => [h("dt", {}, name), h("dd", {}, value)])),
      field("Note", text), h("div", { class: "row" }, button("Save the note", keep)));
  }

  async function drop(key) {
    if ((await attempt(() => remove(`records/uploads/${encodeURIComponent(key.split("/").at(-1))}`))) === undefined) return;
    state.open = state.open.filter((one) => one !== key);
    say("The record is deleted.");
    await load(true);
  }

  await load();
  await draw();
  return () => charts.forEach((one) => one.clear());
}

/** The upload form: a file, and what the file does not state itself. */
function uploads(formats, taken) {
  const file = h("input", { type: "file", accept: formats.map((one) => `.${one.name}`).join() });
  const voltage = h("input", { type: "text", inputmode: "decimal" });
  const units = h("input", { type: "text", placeholder: "displacement=mm force=N" });
  const columns = h("input", { type: "text", placeholder: "force=Load cell; time=Clock" });
  const dt = h("input", { type: "text", placeholder: "2 ms" });
  const variable = h("input", { type: "text" });
  const header = h("input", { type: "text", inputmode: "numeric" });
  const sign = choice([["", "as it is"], ["-1", "turned"]]);
  const session = h("input", { type: "text", placeholder: "2026-03-01" });
  const specimen = h("input", { type: "text" });
  const go = h("button", { type: "submit", class: "main" }, "Upload");
  const form = h("form", {}, field("File", file, `${formats.map((one) => one.title).join(", ")}; at most 64 MiB`),
    h("div", { class: "fields" }, field("Voltage at the coil, V", voltage, "where the file does not state it"), field("Units", units, "where the header does not state them"), field("Columns", columns, "where the names are not recognised; by number from 0"),
      field("Sampling interval", dt, "of a file without a time"), field("Line of the names", header, "from 1; 0 for none"), field("Variable", variable, "the matrix of a MATLAB file"),
      field("Sign of the force", sign), field("Session", session, "one day's records on one mounting"), field("Specimen", specimen, "which damper it is")),
    h("div", { class: "row" }, go));
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    if (!file.files.length) return say("Choose a file first.", "bad");
    go.disabled = true;
    const said = asQuery({ voltage: voltage.value.trim().replace(",", "."), unit: units.value.split(/[\s;]+/).filter(Boolean), column: columns.value.split(";").map((one) => one.trim()).filter(Boolean),
      dt: dt.value.trim(), header: header.value.trim(), variable: variable.value.trim(), force_sign: sign.value, measurement_session: session.value.trim(), specimen: specimen.value.trim() });
    const loaded = await attempt(() => upload(`records/uploads/${encodeURIComponent(file.files[0].name)}?${said}`, file.files[0]));
    go.disabled = false;
    if (loaded) {
      say(`Uploaded ${short(loaded.key)}.`);
      form.reset();
      taken(loaded.key);
    }
  });
  return h("details", {}, h("summary", {}, "Upload a record"), form);
}

const SI = { time: "s", displacement: "m", force: "N", velocity: "m/s", voltage: "V", current: "A", temperature: "°C" };
const times = (values, factor) => (factor === 1 ? values : values.map((value) => factor * value));
const hint = () => h("p", { class: "soft" }, "Drag over a chart to zoom in; double-click to show all.");

const nameOf = (one) => ({ key: one.key, show: h("span", { class: "named", title: one.key }, short(one.key), flags(one)) });

export function inputOf(about) {
  if (!about?.input) return null;
  const [low, high] = about.input_range;
  return { key: low, show: low === high ? `${number(low, 5)} ${about.input}` : `${number(low, 3)} to ${number(high, 3)} ${about.input}` };
}

function flags(one) {
  const marks = [];
  if (one.problem) marks.push(h("span", { class: "badge bad", title: one.problem }, "cannot be read"));
  else if (one.about.notes.length) marks.push(h("span", { class: "badge bad", title: one.about.notes.join("; ") }, `remarks: ${one.about.notes.length}`));
  if (one.about?.role === "validation") marks.push(h("span", { class: "badge" }, "validation"));
  if (one.note) marks.push(h("span", { class: "badge", title: one.note }, "note"));
  return marks;
}
