// The figures of every cycle and of the device: the form of their options, and the tables.
import { get, query as asQuery } from "./api.js";
import { h } from "./dom.js";
import { attempt, say } from "./notice.js";
import { optionsForm } from "./options.js";
import { servedTable } from "./table.js";

/** cycleFigures(keys of the records, asked, changed): elements; `asked.values` is changed by the form, which then calls `changed()`. */
export function cycleFigures(keys, asked, changed) {
  const result = h("div", { "aria-live": "polite" });
  let last = 0;

  async function tell() {
    const mine = ++last;
    const question = asQuery({ key: keys, ...asked.values });
    if (!result.children.length) result.append(h("p", { class: "soft" }, "Working out the figures …"));
    const answer = await attempt(() => get(`records/cycle-figures?${question}`));
    if (mine !== last) return;
    result.replaceChildren(...(answer ? shown(answer, question) : []));
  }

  const form = optionsForm(asked.options, asked.values, () => {
    try {
      asked.values = form.values();
    } catch (problem) {
      return say(problem.message, "bad");
    }
    changed();
    return tell();
  });
  tell();
  return [form.element, result];
}

function shown(answer, question) {
  return [
    ...answer.notes.map((note) => h("p", { class: "verdict fair" }, note)),
    h("div", { class: "row" }, h("a", { class: "button", href: `/api/records/cycle-figures/page?${question}`, download: "cycles.html" }, "Save the page")),
    ...answer.tables.flatMap((each) => [
      servedTable(each, { digits: 4 }),
      ...each.notes.map((note) => h("p", { class: "soft" }, note)),
    ]),
  ];
}
