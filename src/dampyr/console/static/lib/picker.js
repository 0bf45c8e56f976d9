// Records to choose from, with boxes to tick, by source.
import { get, query as asQuery } from "./api.js";
import { button, choice, field, h, short, tick } from "./dom.js";
import { attempt } from "./notice.js";
import { originBadge } from "./origin.js";
import { grouping, inputOf, isFound, told } from "./record_facts.js";
import { table } from "./table.js";

/** picker(chosen keys, changed): an element, `chosen()` the keys, and `choose(keys)` others. */
export async function picker(start, changed) {
  const sources = await get("records/sources");
  const taken = new Set(start);
  let listed = [];
  const first = start[0]?.split("/")[0] ?? (await usualSource(sources));
  const source = choice(sources.map((source) => [source.name, source.title]), { value: first, onchange: load });
  const filter = h("input", { type: "search", oninput: fill });
  const group = grouping("run", fill);
  const list = h("div");
  const rest = tick("interrupted and repeated ones", { onchange: fill });
  const isLeftOut = (record) => record.left_out && !rest.firstChild.checked && !taken.has(record.key);
  const count = h("span", { class: "soft", role: "status" });
  const element = h("div", {}, h("div", { class: "fields sources" }, field("Source", source), field("Filter", filter), field("Group by", group)),
    h("div", { class: "row" }, button("All shown", () => mark(true)), button("None", () => mark(false)), rest, count), list);

  const shown = () => listed.filter((record) => !record.problem && !isLeftOut(record) && isFound(record, filter.value));

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
    const here = shown();
    const { groupOf, headOf, lineOf } = told(here, group.value);
    const rowOf = (record, k) => {
      const { key, about, left_out: leftOut } = record;
      const box = h("input", { type: "checkbox", checked: taken.has(key), "aria-label": `Choose ${short(key)}`,
        onchange: () => (box.checked ? taken.add(key) : taken.delete(key), whole.forEach((look) => look()), tell()) });
      boxes.push(box);
      const badges = [originBadge(about.origin), leftOut ? h("span", { class: "badge bad", title: leftOut }, leftOut.split(":")[0]) : null, lineOf(k)].filter(Boolean);
      const name = badges.length ? { key: short(key), show: h("span", { class: "named" }, short(key), badges) } : short(key);
      return [{ key: Number(!taken.has(key)), show: box }, name, inputOf(about), about.measured?.frequency_hz ?? null, about.role === "fit" ? "fit" : "validation"];
    };
    const boxes = [];
    const whole = []; // of each group: its box follows those of its records
    const headWithBox = (name, indices) => {
      const box = h("input", { type: "checkbox", "aria-label": `Choose all of ${name || "this group"}`, onchange: () => {
        for (const k of indices) {
          boxes[k].checked = box.checked;
          if (box.checked) taken.add(here[k].key);
          else taken.delete(here[k].key);
        }
        tell();
      } });
      const look = () => {
        const count = indices.filter((k) => taken.has(here[k].key)).length;
        box.checked = count === indices.length;
        box.indeterminate = count > 0 && count < indices.length;
      };
      whole.push(look);
      look();
      return [box, " ", headOf(name, indices)];
    };
    list.replaceChildren(table({
      caption: "Records; those for validation are predicted, never fitted",
      columns: [{ words: "Chosen", plain: true }, { name: "record" }, { name: "input" }, { name: "frequency", unit: "Hz" }, { name: "role" }],
      rows: here.map(rowOf), groupOf, headOf: headWithBox,
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

/** The source that a page begins with: one's own records, where there are any. */
export async function usualSource(sources) {
  const own = await get(`records/list?${asQuery({ source: "data" })}`);
  return own.length ? "data" : sources.at(-1).name;
}
