// Uploads: several files at once, their columns shown before, and what the files do not state themselves.
import { get, query as asQuery, send, upload } from "./api.js";
import { charts } from "./chart.js";
import { choice, field, h, number, short } from "./dom.js";
import { say } from "./notice.js";
import { optionsForm } from "./options.js";

const ENOUGH = 2 ** 20; // bytes of a file that show its columns: half a minute at 1 kHz
const LOOK = 1000; // ms between two looks at the place in the queue
const UNITS = { time: "s", displacement: "mm", force: "N", velocity: "mm/s", voltage: "V", current: "A", temperature: "degC" };

/** uploads(formats, options, taken): the form; `options` is what can be said of a file besides its columns, `taken` is called with the keys of the records that came in. */
export function uploads(formats, options, taken) {
  const plainText = ["csv", "txt", "dat"];
  const file = h("input", { type: "file", multiple: true, accept: formats.map((format) => `.${format.name}`).join() });
  const about = optionsForm(options, {}, () => said().header !== header && preview());
  const which = choice([], { "aria-label": "File whose columns are shown" });
  const shown = h("div", { id: "columns", "aria-live": "polite" });
  const drawing = h("div", { id: "drawn-columns" });
  let plots = null;
  const states = h("ul", { class: "before", id: "uploads" });
  const go = h("button", { type: "submit", class: "main" }, "Upload");
  let columns = [];
  let turn = 0;
  let header; // of the columns that are shown
  let extent = { rows: 0, every: 1, isPart: false };

  async function preview() {
    const chosen = file.files[Number(which.value)] ?? file.files[0];
    const mine = ++turn;
    header = said().header;
    columns = [];
    shown.replaceChildren();
    draw();
    if (!chosen || !plainText.includes(chosen.name.split(".").at(-1).toLowerCase())) return;
    const question = asQuery({ header, part: chosen.size > ENOUGH });
    let result;
    try {
      result = await send("PUT", `records/preview/${encodeURIComponent(chosen.name)}?${question}`, chosen.slice(0, ENOUGH));
    } catch (problem) {
      result = { columns: [], problem: problem.message };
    }
    if (mine !== turn) return;
    columns = result.columns.map((shownColumn, k) => column(shownColumn, k, result.channels));
    extent = { rows: result.rows, every: result.every, isPart: chosen.size > ENOUGH };
    shown.replaceChildren(...(result.problem ? [h("p", { class: "verdict bad" }, result.problem)] : [tableOf(result)]), ...(result.notices ?? []).map((notice) => h("p", { class: "soft" }, `${notice}.`)));
    draw();
  }

  /** The chosen columns over the time, and the force over the displacement, as the file has them: what is chosen wrongly is seen. */
  function draw() {
    plots?.clear();
    plots = null;
    const of = Object.fromEntries(columns.filter((one) => one.channel.value).map((one) => [one.channel.value, one]));
    const across = of.time ?? (columns.length ? { name: "row", drawn: columns[0].drawn.map((_, k) => k * extent.every), unit: { value: "" } } : null);
    const measured = Object.entries(of).filter(([channel, one]) => channel !== "time" && one.kind === "number");
    if (!across || !measured.length) return drawing.replaceChildren();
    const axis = (one) => ({ words: one.name, unit: one.factor?.value.trim() ? "" : one.unit.value.trim(), pad: 0.03 });
    const panel = (x, y, channel, height) => ({ label: `${y.name} over ${x.name} in the file, before it is uploaded`, x: axis(x), y: axis(y), height, series: [{ name: channel, x: x.drawn, y: y.drawn, colour: "blue", width: 1 }] });
    const panels = measured.map(([channel, one]) => panel(across, one, channel, 120));
    if (of.displacement && of.force) panels.push(panel(of.displacement, of.force, "force", 220));
    plots = charts(panels, { across: true });
    const every = extent.every > 1 ? `every ${extent.every}th row` : "every row";
    drawing.replaceChildren(plots.element, h("p", { class: "soft" }, `As the file has them: ${every} of ${extent.isPart ? "its first " : ""}${extent.rows}.`));
  }

  function column(description, k, channels) {
    const name = description.name || `column ${k}`;
    const unit = h("input", { type: "text", maxlength: "20", value: description.unit || (description.kind === "number" ? UNITS[description.channel] ?? "" : ""), disabled: Boolean(description.unit) || description.kind !== "number", "aria-label": `Unit of ${name}` });
    const channel = choice([["", "not read"], ...Object.keys(channels)], { value: description.channel, "aria-label": `Channel of ${name}`, onchange: () => ((unit.value ||= unit.disabled ? "" : UNITS[channel.value] ?? ""), draw()) });
    unit.addEventListener("change", draw);
    const typed = (words, placeholder) => h("input", { type: "text", maxlength: "40", placeholder, disabled: description.kind !== "number", "aria-label": `${words} of ${name}` });
    return { ...description, name, k, unit, factor: typed("Factor", "0.005 mm"), offset: typed("Offset", "-12 N"), channel, stated: description.unit, guessed: description.channel };
  }

  function tableOf(result) {
    const row = (label, cells) => h("tr", {}, h("th", { scope: "row" }, label), cells.map((cell) => h("td", {}, cell)));
    const rows = result.columns[0]?.values.length ?? 0;
    return h("div", { class: "table", tabindex: "0", role: "region", "aria-label": "Columns of the file" }, h("table", {}, h("caption", {}, "Columns of the file; what is chosen here holds for all files; a factor takes the place of a unit, as for counts"),
      h("tbody", {}, row("Column", columns.map((shownColumn) => shownColumn.name)), row("Channel", columns.map((shownColumn) => shownColumn.channel)), row("Unit", columns.map((shownColumn) => shownColumn.unit)),
        row("Factor", columns.map((shownColumn) => shownColumn.factor)), row("Offset", columns.map((shownColumn) => shownColumn.offset)),
        Array.from({ length: rows }, (_, i) => h("tr", {}, i ? null : h("th", { scope: "row", rowspan: String(rows) }, "First rows"), result.columns.map((shownColumn) => h("td", { class: "right" }, number(shownColumn.values[i], 6))))))));
  }

  /** What the columns say besides the files: only what differs from what the files say themselves. */
  function mapping() {
    const chosen = columns.filter((shownColumn) => shownColumn.channel.value);
    const twice = chosen.find((choice, k) => chosen.findIndex((other) => other.channel.value === choice.channel.value) !== k);
    if (twice) throw new Error(`two columns are the ${twice.channel.value}; choose one of them`);
    const unit = chosen.filter((choice) => !choice.stated && choice.unit.value.trim()).map((choice) => `${choice.channel.value}=${choice.unit.value.trim()}`);
    const typed = (which) => chosen.filter((choice) => choice[which].value.trim()).map((choice) => `${choice.channel.value}=${choice[which].value.trim()}`);
    const scaled = { unit, factor: typed("factor"), offset: typed("offset") };
    if (columns.every((shownColumn) => shownColumn.channel.value === shownColumn.guessed)) return scaled;
    const dropped = columns.filter((shownColumn) => shownColumn.guessed && !chosen.some((other) => other.channel.value === shownColumn.guessed));
    return { ...scaled, column: [...chosen.map((choice) => `${choice.channel.value}=${choice.k}`), ...dropped.map((column) => `${column.guessed}=-`)] };
  }

  /** What the form says, and nothing while it says what is wrong: the upload tells. */
  function said() {
    try {
      return about.values();
    } catch {
      return {};
    }
  }

  async function uploadFile(chosen, request) {
    const state = h("span", { class: "badge" }, "sending");
    const words = h("small");
    states.append(h("li", {}, h("span", {}, chosen.name, " ", words), state));
    const ticket = Math.random().toString(36).slice(2); // crypto.randomUUID needs https
    const timer = setInterval(async () => {
      const { position } = await get(`records/queue?${asQuery({ ticket })}`).catch(() => ({}));
      if (position !== undefined && position !== null) state.textContent = position ? `waiting: ${position} before it` : "being read";
    }, LOOK);
    try {
      const made = await upload(`records/uploads/${encodeURIComponent(chosen.name)}?${asQuery({ ...request, ticket })}`, chosen);
      state.textContent = "uploaded";
      state.classList.add("good");
      words.textContent = made.notices.join("; ");
      for (const notice of made.notices) say(`${short(made.key)}: ${notice}`);
      return made.key;
    } catch (problem) {
      state.textContent = "refused";
      state.classList.add("bad");
      words.textContent = problem.message;
      say(`${chosen.name}: ${problem.message}`, "bad");
      return null;
    } finally {
      clearInterval(timer);
    }
  }

  file.addEventListener("change", () => {
    which.replaceChildren(...[...file.files].map((reading, k) => h("option", { value: String(k) }, reading.name)));
    which.hidden = file.files.length < 2;
    preview();
  });
  which.addEventListener("change", preview);
  which.hidden = true;
  const form = h("form", {}, field("File", file, `${[...new Set(formats.map((format) => format.title))].join(", ")}; several at once, at most 64 MiB each`), which, shown, drawing,
    about.element,
    h("div", { class: "row" }, go), states);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const chosen = [...file.files];
    if (!chosen.length) return say("Choose a file first.", "bad");
    let request;
    try {
      request = { ...mapping(), ...about.values() };
    } catch (problem) {
      return say(problem.message, "bad");
    }
    go.disabled = true;
    states.replaceChildren();
    const keys = [];
    for (const item of chosen) keys.push(await uploadFile(item, request)); // one after the other: the console reads them so
    go.disabled = false;
    const came = keys.filter(Boolean);
    if (!came.length) return;
    say(came.length === 1 ? `Uploaded ${short(came[0])}.` : `Uploaded ${came.length} records.`);
    file.value = "";
    columns = [];
    shown.replaceChildren();
    draw();
    which.hidden = true;
    taken(came);
  });
  return h("details", {}, h("summary", {}, "Upload records"), form);
}
