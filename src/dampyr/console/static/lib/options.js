// A form for the options of a job, made of what the server says of each: its kind, choices, unit, usual value and words.
import { choice, field, h, tick } from "./dom.js";
import { numberList, oneNumber } from "./numbers.js";

/** `element`, the controls; `values()`, what differs from the usual, in SI units: an Error says what is wrong. */
export function optionsForm(options) {
  const controls = options.map((option) => [option, control(option)]);
  return {
    element: h("div", { class: "fields" }, controls.map(([, one]) => one.element)),
    values() {
      const chosen = {};
      for (const [option, one] of controls) {
        const value = one.value();
        if (JSON.stringify(value) !== JSON.stringify(option.default)) chosen[option.name] = value;
      }
      return chosen;
    },
  };
}

function control(option) {
  if (option.kind === "bool") return ticked(option);
  if (option.choices && option.several) return tickedChoices(option);
  if (option.choices && option.kind !== "float") return selected(option);
  return typed(option);
}

function ticked({ label, words, default: usual }) {
  const box = tick(label, { checked: usual });
  return { element: h("div", { class: "field" }, box, h("small", {}, words)), value: () => box.firstChild.checked };
}

function tickedChoices({ label, words, choices, default: usual }) {
  const boxes = choices.map(([value, meaning]) => [value, tick(value, { checked: usual.includes(value), title: meaning })]);
  const element = h("div", { class: "field", role: "group", "aria-label": label }, h("span", { class: "label" }, label), h("div", { class: "row" }, boxes.map(([, box]) => box)), h("small", {}, words));
  return { element, value: () => boxes.filter(([, box]) => box.firstChild.checked).map(([value]) => value) };
}

function selected({ label, words, kind, choices, default: usual, optional }) {
  const made = choice([...(optional ? [["", "–"]] : []), ...choices.map(([value, meaning]) => [value, meaning === String(value) ? meaning : `${value}: ${meaning}`])], { value: usual ?? "" });
  return { element: field(label, made, words), value: () => (kind === "int" && made.value ? Number(made.value) : made.value || null) };
}

function typed(option) {
  const { label, words, unit, choices, default: usual } = option;
  const input = h("input", { type: "text", value: asText(option, usual), placeholder: choices ? [...choices.map(([value]) => value), "number"].join(", ") : option.pairs ? "NAME = VALUE; …" : option.several ? "…; …" : "" });
  return { element: field(unit ? `${label}, ${unit}` : label, input, words), value: () => read(option, input.value.trim()) };
}

function asText(option, value) {
  if (value === null || value === undefined) return "";
  if (option.several) return value.map((one) => single(option, one)).join("; ");
  if (option.pairs && typeof value === "object") return Object.entries(value).map(([name, one]) => `${name} = ${single(option, one)}`).join("; ");
  return single(option, value);
}

const single = ({ kind, factor }, value) => (kind === "str" || typeof value === "string" ? value : String(Number((factor * value).toPrecision(12))));

function read(option, text) {
  if (option.pairs) return pairs(option, text);
  if (option.several) return option.kind === "str" ? parts(text) : numberList(text, option.label).map((value) => inSi(option, value));
  if (!text) return option.optional ? null : option.default;
  if (option.choices?.some(([value]) => value === text)) return text;
  return option.kind === "str" ? text : inSi(option, oneNumber(text, option.label));
}

function pairs(option, text) {
  const entries = parts(text);
  if (!entries.length) return option.default;
  if (option.for_all && entries.length === 1 && !entries[0].includes("=")) return entries[0];
  return Object.fromEntries(entries.map((entry) => {
    const [name, value] = entry.includes("=") ? entry.split("=", 2).map((one) => one.trim()) : ["*", entry];
    if (name === "*" && !option.for_all) throw new Error(`${option.label}: ${entry} has no =; write it as in NAME = VALUE`);
    return [name, option.kind === "str" ? value : inSi(option, oneNumber(value, `${option.label}, ${name}`))];
  }));
}

const parts = (text) => text.split(";").map((one) => one.trim()).filter(Boolean);

const inSi = ({ factor }, value) => Number((value / factor).toPrecision(12));
