// Commands: each command of the terminal as a form on the left, what it tells on the right. A command is a job that
// continues without the page.
import { setAddress } from "../lib/address.js";
import { get, post, put, query as asQuery, upload } from "../lib/api.js";
import { before } from "../lib/before.js";
import { button, choice, field, h, section } from "../lib/dom.js";
import { watch } from "../lib/jobs.js";
import { attempt, say } from "../lib/notice.js";
import { optionsForm } from "../lib/options.js";
import { picker } from "../lib/picker.js";
import { servedTable } from "../lib/table.js";

const PLACES = { bench: "Bench", campaigns: "Campaigns", records: "Records", identify: "Identify", building: "Building" };
const KEPT = [["cards", "damper's card"], ["campaigns", "campaign"], ["structures", "structure"], ["motions", "ground motion"]];
const MAX_FIGURES = 12;

export async function show(root, query) {
  const choices = await get("commands/choices");
  const which = h("select", { id: "command", onchange: () => open(which.value) }, Object.entries(choices.groups).map(([title, names]) =>
    h("optgroup", { label: title }, names.map((name) => h("option", { value: name }, `${name}: ${plain(choices.forms[name].title)}`)))));
  const about = h("div");
  const place = h("div");
  const progress = h("div");
  const sheet = h("div");
  const past = before("commands", ["command"], reopen);
  let form = null;
  let stop = null;
  root.append(h("div", { class: "split" },
    h("div", { class: "side" }, field("Command", which), about, place, past.element, elsewhere(choices.places)),
    h("div", {}, progress, sheet)));
  sheet.append(h("p", { class: "blank" }, "Choose a command and fill in its form. Files come from the data folder; what the command tells and writes appears here."));
  const job = query.get("job");
  const first = query.get("command");
  if (job) await reopen(job);
  else await open(first && choices.forms[first] ? first : choices.groups.Records[0]);

  async function open(name, values = {}) {
    which.value = name;
    const described = choices.forms[name];
    about.replaceChildren(h("p", {}, described.title), ...described.words.map((words) => h("p", { class: "soft" }, words)),
      described.page ? h("p", {}, h("a", { href: `#/${described.page}` }, `${PLACES[described.page]} has a shorter form for this.`)) : "");
    place.replaceChildren(h("p", { class: "soft" }, "Reading what can be chosen …"));
    const filled = await attempt(() => commandForm(described, choices.files, values));
    if (!filled || which.value !== name) return;
    form = filled;
    place.replaceChildren(h("form", { onsubmit: (event) => { event.preventDefault(); start(name); } },
      form.element, h("div", { class: "row" }, h("button", { type: "submit", class: "main", id: "perform", "data-command": name }, "Run"))));
  }

  async function start(name) {
    let values;
    try {
      values = form.values();
    } catch (problem) {
      return say(problem.message, "bad");
    }
    const submitted = await attempt(() => post("commands/jobs", { command: name, values }));
    if (!submitted) return undefined;
    follow(submitted.id);
    return past.look();
  }

  /** A job of before, and the form as it was when it was started. */
  async function reopen(id) {
    follow(id);
    const job = await attempt(() => get(`jobs/${id}`));
    if (job) await open(job.request.command, job.request.values);
  }

  function follow(id) {
    if (!root.isConnected) return; // the person has left the page; the job continues
    setAddress(root, "commands", { job: id });
    stop?.();
    sheet.replaceChildren();
    stop = watch(progress, id, (job) => {
      past.look();
      if (job.state === "done") sheet.replaceChildren(...told(job));
    });
  }

  return () => {
    stop?.();
    past.clear();
  };
}

/** The sentence of a command without the full stop. */
const plain = (sentence) => sentence.replace(/\.$/, "");

/** The form of one command: files by choice, all else as the terminal reads it. `values()` holds what is not as usual. */
async function commandForm(form, files, values) {
  const chosen = [];
  const elements = [];
  for (const parameter of form.parameters.filter(({ files }) => files)) {
    const made = await fileControl(parameter, files, values[parameter.name]);
    chosen.push([parameter, made]);
    elements.push(made.element);
  }
  const options = form.parameters.filter(({ files }) => !files).map((option) => (option.required ? { ...option, label: `${option.label} (needed)` } : option));
  const first = options.filter(({ group }) => !group);
  const needed = optionsForm(options.filter(({ required }) => required), values);
  const others = optionsForm(first.filter(({ required }) => !required), values);
  const grouped = optionsForm(options.filter(({ group }) => group), values);
  const element = h("div", {}, elements, needed.element,
    first.some(({ required }) => !required) ? h("details", { open: first.length <= 8 }, h("summary", {}, "Options"), others.element) : "", grouped.element);
  return {
    element,
    values() {
      const all = { ...needed.values(), ...others.values(), ...grouped.values() };
      for (const [name, value] of Object.entries(all)) if (value === null) delete all[name];
      for (const [parameter, control] of chosen) {
        const value = control.value();
        if (value.length > 1 && !parameter.several) throw new Error(`${parameter.label} takes one, and ${value.length} are chosen.`);
        if (value.length) all[parameter.name] = parameter.several ? value : value[0];
      }
      return all;
    },
  };
}

async function fileControl(parameter, files, value) {
  const { words, several, required, files: kind } = parameter;
  const label = required ? `${parameter.label} (needed)` : parameter.label;
  const start = value === undefined ? [] : [value].flat();
  if (kind === "records") {
    const records = await picker(start, () => {});
    return { element: h("fieldset", {}, h("legend", {}, label), records.element), value: () => records.chosen() };
  }
  if (kind === "written") {
    const input = h("input", { type: "text", value: start[0] ?? "", maxlength: "100", placeholder: required ? "a name" : "a name; empty: nothing is written" });
    return { element: field(label, input, words), value: () => [input.value.trim()].filter(Boolean) };
  }
  const listed = files[kind].map(({ value, words }) => [value, words]);
  const made = choice([...(several ? [] : [["", required ? "choose …" : "–"]]), ...listed], several ? { multiple: true, size: Math.min(6, Math.max(2, listed.length)) } : {});
  for (const option of made.options) option.selected = start.length ? start.includes(option.value) : option.value === "";
  const hint = [words, several ? "Ctrl chooses several" : "", listed.length ? "" : `The data folder has no ${kind}`].filter(Boolean).join(". ");
  return { element: field(label, made, hint), value: () => [...made.selectedOptions].map(({ value }) => value).filter(Boolean) };
}

/** What a command told: its line, its tables, its figures and its files. */
function told({ id, result: r }) {
  const at = (what, name) => `/api/commands/jobs/${id}/${what}?${asQuery({ name })}`;
  return [
    section("Result", h("p", { class: "soft" }, h("code", {}, r.command)),
      h("div", { class: "row" },
        r.page ? h("a", { class: "button main", href: `/api/commands/jobs/${id}/page`, download: "" }, "Save the whole page") : "",
        r.figures.length ? h("a", { class: "button", href: `/api/commands/jobs/${id}/figures`, download: "" }, "Save the figures") : ""),
      r.notice ? h("p", { class: "verdict bad origin" }, r.notice) : "",
      r.output.map(printed),
      r.warnings.length ? h("ul", {}, r.warnings.map((warning) => h("li", {}, warning))) : "",
      r.output.length || r.files.length ? "" : h("p", {}, "It printed nothing.")),
    r.files.length ? section("Written", h("ul", { class: "written" }, r.files.map((name) => h("li", {}, h("a", { href: at("file", name), download: "" }, name), " ", keeping(at("file", name), name))))) : "",
    r.figures.length ? section("Figures", r.figures.slice(0, MAX_FIGURES).map((name) => h("img", { class: "sheet", src: at("figure", name), alt: name.replace(/^\d+-|\.svg$/g, "").replaceAll("-", " ") })),
      r.figures.length > MAX_FIGURES ? h("p", { class: "soft" }, `${r.figures.length - MAX_FIGURES} more are in the page.`) : "") : "",
  ].filter(Boolean);
}

function printed({ text, table }) {
  if (!table) return h("p", { class: "line" }, text);
  return h("div", {}, servedTable(table), table.notes.length ? h("ul", { class: "notes" }, table.notes.map((note) => h("li", {}, note))) : "");
}

/** A file of TOML or of a motion can go into the data folder, where the other pages list it; it is read first. */
function keeping(address, name) {
  if (!/\.(toml|at2|csv|txt)$/i.test(name)) return "";
  const kind = choice(KEPT, { "aria-label": `What ${name} is` });
  const keep = async () => {
    const own = name.split("/").at(-1);
    const content = await (await fetch(address, { credentials: "same-origin" })).blob();
    const kept = await attempt(async () => (kind.value === "campaigns"
      ? put(`campaigns/files/${encodeURIComponent(own.replace(/\.toml$/i, ""))}`, { text: await content.text() })
      : upload(`building/files/${kind.value}/${encodeURIComponent(own)}`, content)));
    if (kept) say(`Kept ${own} among the ${kind.value} of the data folder.`);
  };
  return h("span", { class: "row" }, kind, button("Keep", keep, { "aria-label": `Keep ${name} in the data folder` }));
}

function elsewhere(places) {
  const missing = places.filter(({ why }) => why);
  return h("details", {}, h("summary", {}, "Commands that are not here"), h("ul", {}, missing.map(({ command, page, why }) =>
    h("li", {}, h("code", {}, `dampyr ${command}`), `: ${why}. `, PLACES[page] ? h("a", { href: `#/${page}` }, PLACES[page]) : ""))));
}
