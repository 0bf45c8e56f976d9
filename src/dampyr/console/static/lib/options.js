// A form for the options of a job, made of what the server says of each: its kind, choices, unit, usual value and words.
import { choice, field, h, tick } from "./dom.js";
import { numberList, oneNumber } from "./numbers.js";

/**
 * `element`, the controls; `values()`, what differs from the usual, in SI units: an Error says what is wrong.
 *
 * The controls begin with `chosen`, such values; `changed` is called when a person has changed one.
 */
export function optionsForm(options, chosen = {}, changed = () => {}) {
  const controls = options.map((option) => [option, control(option, Object.hasOwn(chosen, option.name) ? chosen[option.name] : option.default)]);
  const groups = [...new Set(options.map((option) => option.group))];
  const of = (group) => h("div", { class: "fields" }, controls.filter(([option]) => option.group === group).map(([, control]) => control.element));
  return {
    element: h("div", { onchange: changed }, groups.map((group) => (group ? h("details", {}, h("summary", {}, group), of(group)) : of(group)))),
    values() {
      const values = {};
      for (const [option, control] of controls) {
        const value = control.value();
        if (JSON.stringify(value) !== JSON.stringify(option.default)) values[option.name] = value;
      }
      return values;
    },
  };
}

/** The values of options in an address, in SI units; a text that is no number stays one, and the server says so. */
export function optionsInAddress(options, query) {
  const read = ({ kind }, text) => (kind === "bool" ? text === "true" : kind === "str" || text === "" || Number.isNaN(Number(text)) ? text : Number(text));
  return Object.fromEntries(options.filter(({ name }) => query.has(name)).map((option) => {
    const values = query.getAll(option.name).map((text) => read(option, text));
    return [option.name, option.several ? values : values[0]];
  }));
}

function control(option, value) {
  if (option.kind === "bool") return ticked(option, value);
  if (option.choices && option.several) return tickedChoices(option, value);
  if (option.choices && option.kind !== "float") return selected(option, value);
  return typed(option, value);
}

function ticked({ label, words }, value) {
  const box = tick(label, { checked: value });
  return { element: h("div", { class: "field" }, box, h("small", {}, words)), value: () => box.firstChild.checked };
}

function tickedChoices({ label, words, choices }, value) {
  const boxes = choices.map(([name, meaning]) => [name, tick(name, { checked: value.includes(name), title: meaning })]);
  const element = h("div", { class: "field", role: "group", "aria-label": label }, h("span", { class: "label" }, label), h("div", { class: "row" }, boxes.map(([, box]) => box)), h("small", {}, words));
  return { element, value: () => boxes.filter(([, box]) => box.firstChild.checked).map(([name]) => name) };
}

function selected({ label, words, kind, choices, optional }, value) {
  const made = choice([...(optional ? [["", "–"]] : []), ...choices.map(([name]) => name)], { value: value ?? "" });
  return { element: field(label, made, words), value: () => (kind === "int" && made.value ? Number(made.value) : made.value || null) };
}

function typed(option, value) {
  const { label, words, unit, choices } = option;
  const input = h("input", { type: "text", value: asText(option, value), placeholder: choices ? [...choices.map(([name]) => name), "number"].join(", ") : option.placeholder });
  return { element: field(unit ? `${label}, ${unit}` : label, input, words), value: () => read(option, input.value.trim()) };
}

function asText(option, value) {
  if (value === null || value === undefined) return "";
  if (option.several) return value.map((item) => single(option, item)).join("; ");
  if (option.pairs && typeof value === "object") return Object.entries(value).map(([name, item]) => `${name} = ${single(option, item)}`).join("; ");
  return single(option, value);
}

const single = ({ kind, factor }, value) => (kind === "str" || typeof value === "string" ? value : String(Number((factor * value).toPrecision(12))));

function read(option, text) {
  if (option.pairs) return pairs(option, text);
  if (option.several) return option.kind === "str" ? parts(text) : numberList(text, option.label).map((value) => inSi(option, value));
  if (!text) return option.optional ? null : option.default;
  if (option.choices?.some(([name]) => name === text)) return text;
  return option.kind === "str" ? text : quantity(option, text, option.label);
}

function pairs(option, text) {
  const entries = parts(text);
  if (!entries.length) return option.default;
  if (option.for_all && entries.length === 1 && !entries[0].includes("=")) return entries[0];
  return Object.fromEntries(entries.map((entry) => {
    const [name, value] = entry.includes("=") ? entry.split("=", 2).map((text) => text.trim()) : ["*", entry];
    if (name === "*" && !option.for_all) throw new Error(`${option.label}: ${entry} has no =; write it as in NAME = VALUE`);
    return [name, option.kind === "str" ? value : quantity(option, value, `${option.label}, ${name}`)];
  }));
}

const parts = (text) => text.split(";").map((text) => text.trim()).filter(Boolean);

const WITH_UNIT = /^[+-]?[\d.,]+(e[+-]?\d+)?\s*[a-zµ%].*$/i;

/** A number in SI; one with a unit behind it is sent as it is typed, with a point as its decimal mark. */
const quantity = (option, text, name) => (option.unit && WITH_UNIT.test(text) ? text.replace(",", ".") : inSi(option, oneNumber(text, name)));

const inSi = ({ factor }, value) => Number((value / factor).toPrecision(12));
