// Two fits side by side: verdicts, parameters, the misfit of each record, and the loops over one another.
import { get, query as asQuery } from "./api.js";
import { choice, field, h, symbols } from "./dom.js";
import { attempt } from "./notice.js";
import { table } from "./table.js";

const FORCE = { words: "force", unit: "N" };

/** comparison(job, id of the other or "", chosen(id), plot(panels, settings)): an element to choose the other fit in. */
export function comparison(job, start, chosen, plot) {
  const body = h("div");
  const other = choice([["", "choose …"]], { onchange: () => (chosen(other.value), show()) });
  let last = 0;
  offer();

  async function offer() {
    const jobs = (await attempt(() => get("jobs"))) ?? [];
    const fits = jobs.filter(({ id, kind, state }) => kind === "identify" && state === "done" && id !== job.id);
    other.append(...fits.map(({ id, title, made }) => h("option", { value: id }, `${title}, ${new Date(1e3 * made).toLocaleString([], { dateStyle: "short", timeStyle: "short" })}`)));
    if (fits.some(({ id }) => id === start)) other.value = start;
    await show();
  }

  async function show() {
    const mine = ++last;
    const second = other.value ? await attempt(() => get(`jobs/${other.value}`)) : null;
    if (mine !== last) return;
    body.replaceChildren(...(second ? shown([job, second], plot) : []));
  }

  return h("div", {}, field("Other fit", other, "Of those that this data folder keeps"), body);
}

function shown(jobs, plot) {
  const [first, second] = jobs.map(({ result }) => result);
  const names = first.model === second.model ? [`${first.model}, this`, `${second.model}, other`] : [first.model, second.model];
  const common = first.records.filter((name) => second.records.includes(name));
  const parts = [
    table({ caption: "What each says of itself", columns: [{ name: "fit" }, { name: "verdict" }], rows: [first, second].map((result, k) => [names[k], h("span", {}, symbols(result.verdict?.words ?? result.reason))]) }),
    table({ caption: "Value ± half of the 95 % interval", columns: [{ name: "parameter", symbols: true }, { name: "at" }, { name: "unit" }, ...names.map((name) => ({ name, align: "right" }))], rows: both(jobs.map(values), 3) }),
    table({ caption: "Misfit of each record, L1", columns: [{ name: "record" }, ...names.map((name) => ({ name, unit: "%", digits: 3 }))], rows: both(jobs.map(misfits), 1) }),
  ];
  if (!common.length) return [...parts, h("p", { class: "soft" }, "The two fits have no record in common, so that no loops are laid over one another.")];
  const loops = h("div");
  const record = choice(common, { onchange: () => draw() });
  draw();
  return [...parts, field("Loops of", record), loops];

  async function draw() {
    const lines = await attempt(() => Promise.all(jobs.map(({ id }) => get(`identify/jobs/${id}/curves?${asQuery({ record: record.value })}`))));
    if (!lines) return;
    const scaled = ({ x, y }) => ({ x: x.map((value) => 1e3 * value), y });
    const panel = (over, unit) => ({ label: `Force of ${record.value} over ${over}, measured and by both fits`, x: { words: over, unit, pad: 0.04 }, y: FORCE, height: 320,
      series: [{ name: first.notice ? first.data.origin.kind : "measured", colour: "muted", width: 2.4, ...scaled(lines[0][over].measured) },
        { name: names[0], colour: "vermillion", ...scaled(lines[0][over].model) }, { name: names[1], colour: "blue", dash: "dashed", ...scaled(lines[1][over].model) }] });
    loops.replaceChildren(plot([panel("displacement", "mm"), panel("velocity", "mm/s")], { across: true }));
  }
}

/** Rows of two maps with the keys of both: the parts of the key, then the two values. */
function both([first, second], parts) {
  return [...new Set([...first.keys(), ...second.keys()])].map((key) => [...key.split("\t").slice(0, parts), first.get(key) ?? null, second.get(key) ?? null]);
}

/** The parameters of a fit: "parameter, input, unit" to the value with its interval. */
function values({ result }) {
  const [{ columns, rows }] = result.parameters;
  const cells = rows.flatMap(([name, unit, ...texts]) => texts.map((text, k) => [[name, columns[k + 2], unit].join("\t"), text]));
  return new Map(cells.filter(([, text]) => text !== "" && text !== null));
}

/** The L1 of each record, %, of those that were predicted too. */
function misfits({ result }) {
  const at = result.scores.columns.indexOf("L1");
  const fitted = result.scores.rows.map((row) => [row[0], row[at]]);
  return new Map([...fitted, ...result.held.filter(({ l1 }) => typeof l1 === "number").map(({ record, l1 }) => [`${record} (predicted)`, 100 * l1])]);
}
