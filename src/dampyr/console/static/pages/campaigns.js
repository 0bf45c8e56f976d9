// The editor of campaigns: a grid or its text, the rig's envelope, and the dry run next to it.
import { setAddress } from "../lib/address.js";
import { get, post, put, remove } from "../lib/api.js";
import { chart } from "../lib/chart.js";
import { confirmed, prompted } from "../lib/dialog.js";
import { button, choice, field, h, number, section, tick } from "../lib/dom.js";
import { drafts } from "../lib/drafts.js";
import { envelope } from "../lib/envelope.js";
import { attempt, say } from "../lib/notice.js";
import { numberList } from "../lib/numbers.js";
import { proposal } from "../lib/propose.js";
import { stepForm } from "../lib/steps.js";
import { table } from "../lib/table.js";

const LATER = 350; // ms after the last key until the plan is updated
const FIRST = { name: "", operator: "", note: "", amplitude: [1, 2, 4], frequency: [0.5, 1, 2], voltage: [0, 0.8712, 1.98], cycles: 20, repeats: 1, random: false, seed: 0 };
const COLUMNS = [{ name: "test" }, { name: "duration", unit: "s" }, { name: "peak speed", unit: "mm/s" }, { name: "position", unit: "mm" },
  { name: "force", unit: "N" }, { name: "coil", unit: "V" }, { name: "", words: "accepted by the rig", plain: true }];

export async function show(root, query) {
  const [files, rigs, kinds] = await Promise.all([get("campaigns/files"), get("bench/rigs"), get("campaigns/kinds")]);
  const form = gridForm();
  const source = h("textarea", { class: "source", spellcheck: "false", id: "source", maxlength: "65536" });
  const gutter = h("pre", { class: "gutter", "aria-hidden": "true" });
  const rig = choice(rigs.filter((rig) => !rig.problem).map((rig) => [rig.name, rig.title]), { id: "plan-rig" });
  const broken = rigs.filter((rig) => rig.problem).map((rig) => h("p", { class: "soft" }, `The rig ${rig.name} cannot be used: ${rig.problem}`));
  const name = h("input", { type: "text", id: "file", maxlength: "100", required: true });
  const open = choice([["", "new campaign"], ...files], { id: "open" });
  const beyond = h("p", { class: "soft", hidden: true }, "This campaign is more than a grid of sines: edit its text.");
  const plan = h("div", { id: "plan", "aria-live": "polite" });
  const drawn = pathView(() => ({ text: source.value, rig: rig.value }));
  const tools = h("div", { class: "row", id: "file-tools", hidden: true }, button("Copy", copy, { id: "copy" }), button("Rename", rename, { id: "rename" }), button("Delete", drop, { id: "delete" }));
  const run = h("a", { class: "button", href: "#/bench", hidden: true, id: "to-bench" }, "Run on the bench");
  const unsaved = drafts("campaign");
  const restored = h("div", { class: "row", id: "restored", role: "status", hidden: true }, h("span", {}, "Unsaved changes were restored."),
    button("Discard them", () => (unsaved.drop(open.value), start(load)), { id: "discard" }));
  let timer = 0;
  let later = null; // the update that waits for the last key
  let current = null; // the update in progress or done; whether it made the text anew
  let turn = 0;
  let under = null; // the plan that the console works on
  let saved = ""; // the text of the file that is open, as this page knows it

  function start(work) {
    clearTimeout(timer);
    later = null;
    current = work();
    return current;
  }

  const soon = (work) => {
    clearTimeout(timer);
    later = work;
    timer = setTimeout(() => start(work), LATER);
  };

  /** Once the text is what the entries say; false where they are wrong. */
  async function upToDate() {
    for (;;) {
      const mine = later ? start(later) : current;
      const ready = await mine;
      if (!later && mine === current) return ready;
    }
  }

  async function fromGrid() {
    const request = form.read();
    const mine = ++turn;
    if (typeof request === "string") return wrong(request);
    planning();
    try {
      const made = await post("campaigns/text", request);
      if (mine !== turn) return false;
      source.value = made.text;
      numberLines();
    } catch (problem) {
      return mine === turn && wrong(problem.message);
    }
    await dryRun();
    return true;
  }

  async function dryRun() {
    const mine = ++turn;
    planning();
    under = new AbortController();
    try {
      const result = await post("campaigns/plan", { text: source.value, rig: rig.value }, under.signal);
      if (mine !== turn) return true;
      plan.replaceChildren(...planned(result, drawn.element));
      drawn.update(result.tests.map((test) => test.name));
    } catch (problem) {
      if (mine === turn) wrong(problem.message);
    }
    return true;
  }

  /** What was said of the campaign before is said no more; a plan under way is given up. */
  function planning() {
    under?.abort();
    drawn.clear();
    plan.replaceChildren(h("p", { class: "verdict", id: "planning" }, "Planning …"));
  }

  /** The numbers of the lines beside the text. */
  function numberLines() {
    const count = source.value.split("\n").length;
    gutter.textContent = Array.from({ length: count }, (_, k) => k + 1).join("\n");
  }

  /** Store the unsaved draft. */
  function keep() {
    unsaved.keep(open.value, { text: source.value, name: name.value, rig: rig.value, grid: form.element.hidden ? null : form.texts() });
  }

  function wrong(sentence) {
    under?.abort();
    drawn.clear();
    plan.replaceChildren(h("p", { class: "verdict bad" }, sentence));
    return false;
  }

  function take(file) {
    source.value = file.text;
    numberLines();
    form.element.hidden = !file.grid;
    beyond.hidden = Boolean(file.grid);
    if (file.grid) form.write(file.grid);
  }

  async function load() {
    setAddress(root, "campaigns", { open: open.value });
    opened();
    name.value = open.value;
    const file = open.value ? await attempt(() => get(`campaigns/files/${encodeURIComponent(open.value)}`)) : { text: "", grid: FIRST };
    if (file) take(file);
    saved = file?.text ?? "";
    const before = unsaved.read(open.value);
    restored.hidden = !before;
    if (before) return again(before);
    return open.value ? dryRun() : fromGrid();
  }

  /** The link to the bench and what can be done with a file, where one is open. */
  function opened() {
    run.href = `#/bench?campaign=${encodeURIComponent(open.value)}`;
    run.hidden = tools.hidden = !open.value;
  }

  function listed(names, chosen) {
    open.replaceChildren(...["", ...names.filter(Boolean)].map((item) => h("option", { value: item }, item || "new campaign")));
    open.value = chosen;
  }

  const names = () => [...open.options].map((item) => item.value);

  async function copy() {
    const to = await prompted(`Copy ${open.value}`, "Name of the copy", `${open.value} copy`, "Copy");
    if (to === null) return;
    const written = await attempt(() => put(`campaigns/files/${encodeURIComponent(to)}`, { text: saved, rig: rig.value, replaces: "" }));
    if (!written) return;
    listed([...names(), written.name], written.name);
    say(`copied: ${written.name}`);
    await start(load);
  }

  async function rename() {
    const to = await prompted(`Rename ${open.value}`, "New name", open.value, "Rename");
    if (to === null || to === open.value) return;
    const made = await attempt(() => post("campaigns/rename", { name: open.value, to }));
    if (!made) return;
    unsaved.drop(open.value);
    listed(names().map((name) => (name === open.value ? made.name : name)), made.name);
    say(`renamed: ${made.name}`);
    await start(load);
  }

  async function drop() {
    const gone = open.value;
    if (!(await confirmed(`Delete the campaign ${gone}? Its file is removed; records that it made stay.`, "Delete"))) return;
    if ((await attempt(() => remove(`campaigns/files/${encodeURIComponent(gone)}`))) === undefined) return;
    unsaved.drop(gone);
    listed(names().filter((name) => name !== gone), "");
    say(`deleted: ${gone}`);
    await start(load);
  }

  function again(before) {
    name.value = before.name;
    if (rigs.some((rig) => rig.name === before.rig)) rig.value = before.rig;
    take({ text: before.text, grid: null });
    if (!before.grid) return dryRun();
    form.element.hidden = false;
    beyond.hidden = true;
    form.put(before.grid);
    return fromGrid();
  }

  async function save() {
    if (!name.reportValidity() || !(await upToDate())) return;
    const replaces = name.value === open.value ? saved : "";
    const written = await attempt(() => put(`campaigns/files/${encodeURIComponent(name.value)}`, { text: source.value, rig: rig.value, replaces }));
    if (!written) return;
    unsaved.drop(open.value);
    unsaved.drop(written.name);
    saved = written.text;
    restored.hidden = true;
    if (![...open.options].some((item) => item.value === written.name)) open.append(h("option", { value: written.name }, written.name));
    open.value = written.name;
    setAddress(root, "campaigns", { open: written.name });
    opened();
    take(written);
    say(`saved: ${written.name}`);
    dryRun();
  }

  form.element.addEventListener("input", () => {
    keep();
    soon(async () => {
      const ready = await fromGrid();
      keep();
      return ready;
    });
  });
  function edited() {
    form.element.hidden = true;
    beyond.hidden = false;
    keep();
    soon(dryRun);
  }

  /** A step of the chosen kind at the end of the text, once that says what the grid does. */
  async function add(text) {
    if (!(await upToDate())) return;
    const before = source.value.trimEnd();
    source.value = `${before}${before ? "\n\n" : ""}${text}`;
    numberLines();
    edited();
    source.scrollTop = source.scrollHeight;
  }

  /** A campaign that was proposed, as a new one. */
  async function proposed(text) {
    clearTimeout(timer);
    later = null;
    open.value = "";
    setAddress(root, "campaigns", { open: "" });
    opened();
    saved = "";
    source.value = text;
    numberLines();
    edited();
  }

  const next = proposal(() => rig.value, proposed);
  source.addEventListener("input", edited);
  source.addEventListener("input", numberLines);
  source.addEventListener("scroll", () => (gutter.scrollTop = source.scrollTop));
  name.addEventListener("input", keep);
  open.addEventListener("change", () => start(load));
  rig.addEventListener("change", () => (later ? start(later) : start(dryRun)));
  const rig_ = field("Rig", rig);
  rig_.classList.add("whole");
  const files_ = h("div", { class: "fields" }, field("Open", open), field("Save as", name), rig_);
  root.append(h("div", { class: "split" },
    h("div", { class: "side" }, files_, h("div", { class: "row" }, button("Save", save, { class: "main", id: "save" }), run), tools, broken, restored, form.element, beyond,
      h("details", { open: true }, h("summary", {}, "As TOML"), h("div", { class: "field" }, h("label", { for: "source" }, "Text"),
        h("div", { class: "numbered" }, gutter, source), h("small", { id: "source-hint" }, "what is planned, saved and run"))),
      h("details", {}, h("summary", {}, "Add a step"), stepForm(kinds, add)), next.element),
    plan));
  source.setAttribute("aria-describedby", "source-hint");
  const request = query.get("open");
  if (request && files.includes(request)) open.value = request;
  await start(load);
  return () => {
    clearTimeout(timer);
    under?.abort();
    drawn.clear();
    next.clear();
  };
}

/** The path of the campaign or of one of its tests over time; drawn when it is opened. */
function pathView(request) {
  const which = choice([["", "the whole campaign"]], { id: "path-of", onchange: draw });
  const place = h("div");
  const element = h("details", { id: "path" }, h("summary", {}, "Path over time"), field("Of", which), place);
  let charts = [];
  let under = null;
  element.addEventListener("toggle", () => element.open && draw());

  function clear() {
    under?.abort();
    for (const chart of charts) chart.clear();
    charts = [];
    place.replaceChildren();
  }

  async function draw() {
    clear();
    if (!element.open) return;
    under = new AbortController();
    const { signal } = under;
    place.replaceChildren(h("p", { class: "soft" }, "Drawing the path …"));
    let path;
    try {
      path = await post("campaigns/path", { ...request(), test: which.value }, signal);
    } catch (problem) {
      if (!signal.aborted) place.replaceChildren(h("p", { class: "verdict bad" }, problem.message));
      return;
    }
    if (signal.aborted) return;
    const time = { words: "time", unit: "s" };
    const made = (of, y, height) => chart({ label: `${y.words} of ${which.value || "the whole campaign"} over time`, x: time, y, height,
      series: [{ name: y.words, x: path[of][0], y: path[of][1], colour: of === "voltage" ? "vermillion" : "blue" }] });
    charts = [made("displacement", { words: "displacement", unit: "mm" }, 240), made("voltage", { words: "coil", unit: "V" }, 140)];
    place.replaceChildren(...charts.map((chart) => chart.element), h("p", { class: "soft" }, "Slow ways from one test to the next are left out."));
  }

  /** The tests of a new plan. */
  function update(tests) {
    const chosen = tests.includes(which.value) ? which.value : "";
    which.replaceChildren(h("option", { value: "" }, "the whole campaign"), ...tests.map((test) => h("option", { value: test }, test)));
    which.value = chosen;
    draw();
  }
  return { element, update, clear };
}

const LABELS = { amplitude: "Amplitudes", frequency: "Frequencies", voltage: "Coil" };

function gridForm() {
  const text = (id, attributes = {}) => h("input", { type: "text", id, maxlength: "1000", ...attributes });
  const whole = (id, max) => h("input", { type: "number", id, min: "1", max, step: "1" });
  const parts = {
    name: text("g-name"), operator: text("g-operator"), note: text("g-note"), amplitude: text("g-amplitude"), frequency: text("g-frequency"),
    voltage: text("g-voltage"), cycles: whole("g-cycles", "100000"), repeats: whole("g-repeats", "1000"),
    seed: h("input", { type: "number", id: "g-seed", min: "0", max: "2147483648", step: "1" }),
  };
  const random = tick("in random order", { id: "g-random" });
  const box = random.querySelector("input");
  const element = h("fieldset", {}, h("legend", {}, "A grid of sines"),
    h("div", { class: "fields" }, field("Amplitudes, mm", parts.amplitude, "half of the stroke; values parted by ;"), field("Frequencies, Hz", parts.frequency), field("Coil, V", parts.voltage),
      field("Cycles", parts.cycles), field("Repeats", parts.repeats), field("Seed", parts.seed), field("Name", parts.name), field("Operator", parts.operator), field("Note", parts.note)),
    h("div", { class: "row" }, random));

  /** The grid, or a sentence that says what is wrong. */
  function read() {
    const result = { random: box.checked };
    for (const key of ["name", "operator", "note"]) result[key] = parts[key].value;
    for (const key of ["amplitude", "frequency", "voltage"]) {
      try {
        result[key] = numberList(parts[key].value, LABELS[key]);
      } catch (problem) {
        return problem.message;
      }
      if (!result[key].length) return `${LABELS[key]} is empty; give at least one value, such as 2; 4; 8`;
    }
    for (const key of ["cycles", "repeats", "seed"]) {
      if (!parts[key].value || !parts[key].checkValidity()) return `${key} must be a whole number from ${parts[key].min} to ${parts[key].max}`;
      result[key] = Number(parts[key].value);
    }
    return result;
  }

  function write(grid) {
    for (const [key, part] of Object.entries(parts)) part.value = Array.isArray(grid[key]) ? grid[key].join("; ") : String(grid[key]);
    box.checked = grid.random;
  }

  /** The entries as they are typed, valid or not. */
  const texts = () => ({ ...Object.fromEntries(Object.entries(parts).map(([key, part]) => [key, part.value])), random: box.checked });

  function put(texts) {
    for (const [key, part] of Object.entries(parts)) part.value = texts[key] ?? "";
    box.checked = Boolean(texts.random);
  }
  return { element, read, write, texts, put };
}

function planned(plan, path) {
  const minutes = plan.duration_s >= 60 ? `${number(plan.duration_s / 60)} min` : `${number(plan.duration_s)} s`;
  const refused = plan.refusals.length;
  const verdict = refused ? `The rig refuses ${refused === 1 ? "one item" : `${refused} items`} of this campaign, so nothing would run.`
    : `The rig can run all ${plan.tests.length} tests, ${minutes}.`;
  const rows = plan.tests.map((test) => [{ key: test.name, show: h("span", {}, test.name, h("small", { class: "under" }, test.words)) }, test.duration_s, test.speed_mm_s, test.position_mm, test.force_N, test.voltage_V,
    { key: test.refusal ? 1 : 0, show: h("span", { class: `badge ${test.refusal ? "bad" : "good"}` }, test.refusal ? "refused" : "accepted") }]);
  return [
    h("p", { class: `verdict ${refused ? "bad" : "good"}`, id: "verdict" }, verdict),
    refused ? h("ul", { class: "refusals" }, plan.refusals.map((refusal) => h("li", {}, refusal))) : "",
    plan.tests.some((test) => test.frequency_Hz > 0) ? section("Limits of the rig", envelope(plan)) : "",
    path,
    section("Dry run", table({ caption: `${plan.tests.length} tests on ${plan.rig}, ${minutes}, in the order in which they run`, columns: COLUMNS, rows })),
    ...plan.notes.map((note) => h("p", { class: "soft" }, note)),
  ];
}
