// The editor of campaigns: a grid or its text, the rig's envelope, and the dry run next to it.
import { setAddress } from "../lib/address.js";
import { get, post, put } from "../lib/api.js";
import { button, choice, field, h, number, section, tick } from "../lib/dom.js";
import { drafts } from "../lib/drafts.js";
import { envelope } from "../lib/envelope.js";
import { attempt, say } from "../lib/notice.js";
import { table } from "../lib/table.js";

const LATER = 350; // ms after the last key until the plan is updated
const FIRST = { name: "", operator: "", note: "", amplitude: [2, 4, 8], frequency: [0.5, 1, 2], voltage: [0, 0.8712, 1.98], cycles: 20, repeats: 1, random: false, seed: 0 };
const COLUMNS = [{ name: "test" }, { name: "duration", unit: "s" }, { name: "peak speed", unit: "mm/s" }, { name: "position", unit: "mm" },
  { name: "force", unit: "N" }, { name: "coil", unit: "V" }, { name: "", words: "accepted by the rig", plain: true }];

export async function show(root, query) {
  const [files, rigs, kinds] = await Promise.all([get("campaigns/files"), get("bench/rigs"), get("campaigns/kinds")]);
  const form = gridForm();
  const source = h("textarea", { class: "source", spellcheck: "false", id: "source", maxlength: "65536" });
  const rig = choice(rigs.map((one) => [one.name, one.title]), { id: "plan-rig" });
  const name = h("input", { type: "text", id: "file", maxlength: "100", required: true });
  const open = choice([["", "new campaign"], ...files], { id: "open" });
  const kind = choice(kinds.map((one) => [one.name, one.title]), { id: "kind" });
  const beyond = h("p", { class: "soft", hidden: true }, "This campaign is more than a grid of sines: edit its text.");
  const plan = h("div", { id: "plan", "aria-live": "polite" });
  const run = h("a", { class: "button", href: "#/bench", hidden: true, id: "to-bench" }, "Run on the bench");
  const unsaved = drafts("campaign");
  const restored = h("div", { class: "row", id: "restored", role: "status", hidden: true }, h("span", {}, "Unsaved changes were restored."),
    button("Discard them", () => (unsaved.drop(open.value), start(load)), { id: "discard" }));
  let timer = 0;
  let later = null; // the update that waits for the last key
  let current = null; // the update in progress or done; whether it made the text anew
  let turn = 0;
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
    try {
      const made = await post("campaigns/text", request);
      if (mine !== turn) return false;
      source.value = made.text;
    } catch (problem) {
      return mine === turn && wrong(problem.message);
    }
    await dryRun();
    return true;
  }

  async function dryRun() {
    const mine = ++turn;
    try {
      const result = await post("campaigns/plan", { text: source.value, rig: rig.value });
      if (mine === turn) plan.replaceChildren(...planned(result));
    } catch (problem) {
      if (mine === turn) wrong(problem.message);
    }
    return true;
  }

  /** Store the unsaved draft. */
  function keep() {
    unsaved.keep(open.value, { text: source.value, name: name.value, rig: rig.value, grid: form.element.hidden ? null : form.texts() });
  }

  function wrong(sentence) {
    plan.replaceChildren(h("p", { class: "verdict bad" }, sentence));
    return false;
  }

  function take(file) {
    source.value = file.text;
    form.element.hidden = !file.grid;
    beyond.hidden = Boolean(file.grid);
    if (file.grid) form.write(file.grid);
  }

  async function load() {
    setAddress(root, "campaigns", { open: open.value });
    run.hidden = true;
    name.value = open.value;
    const file = open.value ? await attempt(() => get(`campaigns/files/${encodeURIComponent(open.value)}`)) : { text: "", grid: FIRST };
    if (file) take(file);
    saved = file?.text ?? "";
    const before = unsaved.read(open.value);
    restored.hidden = !before;
    if (before) return again(before);
    return open.value ? dryRun() : fromGrid();
  }

  function again(before) {
    name.value = before.name;
    if (rigs.some((one) => one.name === before.rig)) rig.value = before.rig;
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
    if (![...open.options].some((one) => one.value === written.name)) open.append(h("option", { value: written.name }, written.name));
    open.value = written.name;
    setAddress(root, "campaigns", { open: written.name });
    run.href = `#/bench?campaign=${encodeURIComponent(written.name)}`;
    run.hidden = false;
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
  async function add() {
    if (!(await upToDate())) return;
    const before = source.value.trimEnd();
    source.value = `${before}${before ? "\n\n" : ""}${kinds.find((one) => one.name === kind.value).text}`;
    edited();
    source.scrollTop = source.scrollHeight;
  }

  source.addEventListener("input", edited);
  name.addEventListener("input", keep);
  open.addEventListener("change", () => start(load));
  rig.addEventListener("change", () => (later ? start(later) : start(dryRun)));
  const files_ = h("div", { class: "fields" }, field("Open", open), field("Save as", name), field("Rig", rig));
  root.append(h("div", { class: "split" },
    h("div", { class: "side" }, files_, h("div", { class: "row" }, button("Save", save, { class: "main", id: "save" }), run), restored, form.element, beyond,
      h("details", { open: true }, h("summary", {}, "As TOML"), field("Text", source, "what is planned, saved and run"),
        h("div", { class: "row" }, field("Kind of step", kind), button("Add the step", add, { id: "add" })))),
    plan));
  const request = query.get("open");
  if (request && files.includes(request)) open.value = request;
  await start(load);
  return () => clearTimeout(timer);
}

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
    h("div", { class: "fields" }, field("Amplitudes, mm", parts.amplitude, "half of the stroke"), field("Frequencies, Hz", parts.frequency), field("Coil, V", parts.voltage),
      field("Cycles", parts.cycles), field("Repeats", parts.repeats), field("Seed", parts.seed), field("Name", parts.name), field("Operator", parts.operator), field("Note", parts.note)),
    h("div", { class: "row" }, random));

  /** The grid, or a sentence that says what is wrong. */
  function read() {
    const result = { random: box.checked };
    for (const key of ["name", "operator", "note"]) result[key] = parts[key].value;
    for (const key of ["amplitude", "frequency", "voltage"]) {
      result[key] = parts[key].value.split(/[\s,;]+/).filter(Boolean).map(Number);
      if (!result[key].length || result[key].some((one) => !Number.isFinite(one))) return `${key} must be numbers separated by commas, such as 2, 4, 8`;
    }
    for (const key of ["cycles", "repeats", "seed"]) {
      if (!parts[key].value || !parts[key].checkValidity()) return `${key} must be a whole number from ${parts[key].min} to ${parts[key].max}`;
      result[key] = Number(parts[key].value);
    }
    return result;
  }

  function write(grid) {
    for (const [key, part] of Object.entries(parts)) part.value = Array.isArray(grid[key]) ? grid[key].join(", ") : String(grid[key]);
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

function planned(plan) {
  const minutes = plan.duration_s >= 60 ? `${number(plan.duration_s / 60)} min` : `${number(plan.duration_s)} s`;
  const refused = plan.refusals.length;
  const verdict = refused ? `The rig refuses ${refused === 1 ? "one item" : `${refused} items`} of this campaign, so nothing would run.`
    : `The rig can run all ${plan.tests.length} tests, ${minutes}.`;
  const rows = plan.tests.map((one) => [{ key: one.name, show: h("span", {}, one.name, h("small", { class: "under" }, one.words)) }, one.duration_s, one.speed_mm_s, one.position_mm, one.force_N, one.voltage_V,
    { key: one.refusal ? 1 : 0, show: h("span", { class: `badge ${one.refusal ? "bad" : "good"}` }, one.refusal ? "refused" : "accepted") }]);
  return [
    h("p", { class: `verdict ${refused ? "bad" : "good"}`, id: "verdict" }, verdict),
    refused ? h("ul", { class: "refusals" }, plan.refusals.map((one) => h("li", {}, one))) : "",
    plan.tests.some((one) => one.frequency_Hz > 0) ? section("Limits of the rig", envelope(plan)) : "",
    section("Dry run", table({ caption: `${plan.tests.length} tests on ${plan.rig}, ${minutes}, in the order in which they run`, columns: COLUMNS, rows })),
    ...plan.notes.map((one) => h("p", { class: "soft" }, one)),
  ];
}
