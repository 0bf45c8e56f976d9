// A step of any kind from a form: the kinds and their fields come from the console, a new kind needs nothing here.
import { button, choice, field, h } from "./dom.js";
import { numberList, oneNumber } from "./numbers.js";
import { say } from "./notice.js";

/** stepForm(kinds, add): the element; `add` is called with the TOML of a step. */
export function stepForm(kinds, add) {
  const kind = choice(kinds.map((member) => [member.name, member.title]), { id: "kind", onchange: fill });
  const required = h("div", { class: "fields" });
  const others = h("div", { class: "fields" });
  const more = h("details", {}, h("summary", {}, "Options of the step"), others);
  const repeats = h("input", { type: "number", id: "step-repeats", min: "1", max: "2000", step: "1", value: "1" });
  let controls = [];

  const chosen = () => kinds.find((member) => member.name === kind.value);

  function fill() {
    controls = chosen().fields.map((field) => ({ option: field, control: control(field) }));
    const shown = controls.map(({ option, control: made }) => field(option.unit ? `${label(option.name)}, ${option.unit}` : label(option.name), made, option.words));
    required.replaceChildren(...shown.filter((_, k) => first(controls[k].option)), field("Repeats", repeats));
    others.replaceChildren(...shown.filter((_, k) => !first(controls[k].option)));
    more.hidden = !others.children.length;
  }

  function text() {
    const lines = controls.map(({ option, control: made }) => line(option, made)).filter(Boolean);
    if (!repeats.checkValidity()) throw new Error("Repeats must be a whole number from 1 to 2000");
    if (Number(repeats.value) > 1) lines.push(`repeats = ${Number(repeats.value)}`);
    return `[[step]]\nkind = "${kind.value}"\n${lines.join("\n")}${lines.length ? "\n" : ""}`;
  }

  function put() {
    try {
      add(text());
    } catch (problem) {
      say(problem.message, "bad");
    }
  }

  fill();
  return h("div", { id: "step-form" }, field("Kind of step", kind), required, more, h("div", { class: "row" }, button("Add the step", put, { id: "add" })));
}

/** What a person enters first; the rest has a good value. */
const first = (field) => field.required || ["voltage", "cycles", "duration", "motion", "scale", "speeds", "amplitude", "speed"].includes(field.name);

const label = (name) => `${name.charAt(0).toUpperCase()}${name.slice(1).replaceAll("_", " ")}`;

function control(field) {
  const id = `step-${field.name}`;
  if (field.type === "yes") return choice([["yes", "yes"], ["no", "no"]], { id, value: field.value });
  return h("input", { type: "text", id, maxlength: "1000", value: field.value, placeholder: field.type === "text" ? "" : "such as 2; 4; 8" });
}

/** A line of TOML; none where the value is the one that the step has without it. */
function line(field, made) {
  const typed = made.value.trim();
  if (!typed && field.required) throw new Error(`${label(field.name)} is empty; give a value`);
  if (!typed || (!field.required && typed === field.value)) return "";
  if (field.type === "yes") return `${field.name} = ${typed === "yes"}`;
  if (field.type === "text") return `${field.name} = ${JSON.stringify(typed)}`;
  const values = /[;\s]/.test(typed) ? numberList(typed, label(field.name)) : [oneNumber(typed, label(field.name))];
  if (field.type === "whole" && !values.every(Number.isInteger)) throw new Error(`${label(field.name)} must be a whole number`);
  const shown = values.map((value) => (field.unit ? `"${value} ${field.unit}"` : String(value)));
  return `${field.name} = ${shown.length > 1 || field.several ? `[${shown.join(", ")}]` : shown[0]}`;
}
