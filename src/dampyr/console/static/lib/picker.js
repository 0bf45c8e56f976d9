// Records to choose from, with boxes to tick, by source.
import { get, query as asQuery } from "./api.js";
import { button, choice, field, h, number, short, tick } from "./dom.js";
import { attempt } from "./notice.js";
import { originBadge } from "./origin.js";
import { table } from "./table.js";

/** picker(chosen keys, changed): an element, `chosen()` the keys, and `choose(keys)` others. */
export async function picker(start, changed) {
  const sources = await get("records/sources");
  const taken = new Set(start);
  let listed = [];
  const first = start[0]?.split("/")[0];
  const source = choice(sources.map((source) => [source.name, source.title]), { value: first ?? sources.at(-1).name, onchange: load });
  const filter = h("input", { type: "search", oninput: fill });
  const list = h("div");
  const rest = tick("interrupted and repeated ones", { onchange: fill });
  const isLeftOut = (record) => record.left_out && !rest.firstChild.checked && !taken.has(record.key);
  const count = h("span", { class: "soft", role: "status" });
  const element = h("div", {}, h("div", { class: "fields sources" }, field("Source", source), field("Filter", filter)),
    h("div", { class: "row" }, button("All shown", () => mark(true)), button("None", () => mark(false)), rest, count), list);

  const shown = () => listed.filter((record) => !record.problem && !isLeftOut(record) && `${record.key} ${record.about.input_value} ${record.about.role}`.toLowerCase().includes(filter.value.toLowerCase()));

  const unreadable = () => listed.filter((record) => record.problem).length;

  function mark(on) {
    if (!on) taken.clear();
    else for (const record of shown()) taken.add(record.key);
    fill();
    tell();
  }

  function tell() {
    count.textContent = `${taken.size} chosen`;
    changed([...taken]);
  }

  function fill() {
    list.replaceChildren(table({
      caption: "Records; those for validation are predicted, never fitted",
      columns: [{ words: "Chosen", plain: true }, { name: "record" }, { name: "input" }, { name: "frequency", unit: "Hz" }, { name: "role" }],
      rows: shown().map(({ key, about, left_out: leftOut }) => {
        const box = h("input", { type: "checkbox", checked: taken.has(key), "aria-label": `Choose ${short(key)}`,
          onchange: () => (box.checked ? taken.add(key) : taken.delete(key), tell()) });
        const [low, high] = about.input_range ?? [null, null];
        const input = low === null ? null : { key: low, show: low === high ? `${number(low, 5)} ${about.input}` : `${number(low, 3)} to ${number(high, 3)} ${about.input}` };
        const badges = [originBadge(about.origin),
          leftOut ? h("span", { class: "badge bad", title: leftOut }, leftOut.split(":")[0]) : null].filter(Boolean);
        const name = badges.length ? { key: short(key), show: h("span", { class: "named" }, short(key), badges) } : short(key);
        return [{ key: Number(!taken.has(key)), show: box }, name, input, about.measured?.frequency_hz ?? null, about.role === "fit" ? "fit" : "validation"];
      }),
      empty: "No records are here.",
    }));
    count.textContent = `${taken.size} chosen${unreadable() ? `; ${unreadable()} cannot be read, Records says why` : ""}`;
  }

  async function load() {
    list.replaceChildren(h("p", { class: "soft" }, "Reading the records …"));
    listed = (await attempt(() => get(`records/list?${asQuery({ source: source.value })}`))) ?? [];
    fill();
  }
  async function choose(keys) {
    taken.clear();
    for (const key of keys) taken.add(key);
    const of = keys[0]?.split("/")[0];
    if (of === source.value || !sources.some(({ name }) => name === of)) return fill();
    source.value = of;
    return load();
  }

  await load();
  return { element, chosen: () => [...taken], choose };
}
