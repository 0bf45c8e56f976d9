// What tells records apart wherever they are listed: the run (their folder), specimen, operator, session and date. Lists are grouped,
// searched and sorted by these.
import { choice, h, number } from "./dom.js";

const FACTS = ["run", "specimen", "operator", "session", "date"];

/** The groups of a list; "" for none. */
export const grouping = (value, changed) => {
  const made = choice([["", "nothing"], ...FACTS], { value, onchange: () => changed(made.value) });
  return made;
};

export const isGrouping = (name) => name === "" || FACTS.includes(name);

/** The facts of a record in a list, "" for what is not known. */
export function factsOf({ key, about }) {
  const origin = about?.origin ?? {};
  return {
    run: key.split("/").slice(1, -1).join("/"),
    specimen: about?.specimen || (origin.specimens ?? []).join(", "),
    operator: (origin.operators ?? []).join(", ") || about?.provenance.operator || "",
    session: about?.measurement_session || (origin.sessions ?? []).join(", "),
    date: (origin.dates ?? []).join(", "),
  };
}

/** When a record was made, for a column that sorts: the date, and the time of day where it is known; null where neither is. */
export function whenOf(record) {
  const { started, ended } = record.about?.provenance ?? {};
  const made = new Date(started ?? ended ?? NaN);
  if (Number.isNaN(made.getTime())) return factsOf(record).date || null;
  const two = (value) => String(value).padStart(2, "0");
  return `${made.getFullYear()}-${two(made.getMonth() + 1)}-${two(made.getDate())} ${two(made.getHours())}:${two(made.getMinutes())}`;
}

/** All that a record is found by, in lower case. */
export const wordsOf = (record) =>
  [record.key, record.about?.name, ...Object.values(factsOf(record)), whenOf(record), inputOf(record.about)?.show ?? record.about?.input_value, record.about?.role, ...(record.about?.notes ?? []), record.problem, record.note]
    .filter((word) => word !== undefined && word !== null).join(" ").toLowerCase();

/** Whether a record has every word of a search. */
export const isFound = (record, search) => {
  const words = wordsOf(record);
  return search.toLowerCase().split(/\s+/).every((word) => words.includes(word));
};

/**
 * For a table of `records`: `groupOf(index)` by the fact `by`, `headOf(name, indices)` with what all of a group share, and
 * `lineOf(record)`, a small line of what differs within the list besides.
 */
export function told(records, by) {
  const facts = records.map(factsOf);
  const shared = (name, indices) => new Set(indices.map((k) => facts[k][name])).size === 1;
  const all = [...records.keys()];
  const differing = FACTS.filter((name) => name !== by && name !== "session" && name !== "date" && !shared(name, all));
  const nameless = { run: "not in a folder", specimen: "specimen not stated", operator: "operator not stated", session: "session not stated", date: "date not stated" };
  const inGroups = by && !shared(by, all);
  return {
    groupOf: inGroups ? (k) => facts[k][by] : null,
    headOf(name, indices) {
      const others = FACTS.filter((other) => other !== by && other !== "session" && shared(other, indices) && facts[indices[0]][other]).map((other) => facts[indices[0]][other]);
      return [h("span", { class: "group-name" }, name || nameless[by]), h("small", {}, ` ${[`${indices.length} record${indices.length === 1 ? "" : "s"}`, ...others].join(" · ")}`)];
    },
    lineOf(k) {
      const group = inGroups ? all.filter((j) => facts[j][by] === facts[k][by]) : all;
      const words = differing.filter((name) => !inGroups || !shared(name, group)).map((name) => facts[k][name]).filter(Boolean);
      return words.length ? h("small", { class: "under" }, words.join(" · ")) : null;
    },
  };
}

/** The input of a record, for a cell. */
export function inputOf(about) {
  if (!about?.input_range) return null;
  const [low, high] = about.input_range;
  return { key: low, show: low === high ? `${number(low, 5)} ${about.input}` : `${number(low, 3)} to ${number(high, 3)} ${about.input}` };
}
