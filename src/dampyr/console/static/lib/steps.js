// A step of any kind from a form: the kinds and their fields come from the console, a new kind needs nothing here.
import { button, choice, field, h } from "./dom.js";
import { numberList, oneNumber } from "./numbers.js";
import { say } from "./notice.js";

/** stepForm(kinds, add): the element; `add` is called with the TOML of a step. */
export function stepForm(kinds, add) {
  const kind = choice(kinds.map((one) => [one.name, one.title]), { id: "kind", onchange: fill });
  const required = h("div", { class: "fields" });
  const others = h("div", { class: "fields" });
  const more = h("details", {}, h("summary", {}, "Options of the step"), others);
  const repeats = h("input", { type: "number", id: "step-repeats", min: "1", max: "2000", step: "1", value: "1" });
  let controls = [];

  const chosen = () => kinds.find((one) => one.name === kind.value);

  function fill() {
    controls = chosen().fields.map((one) => ({ one, control: control(one) }));
    const shown = controls.map(({ one, control: made }) => field(one.unit ? `${label(one.name)}, ${one.unit}` : label(one.name), made, one.words));
    required.replaceChildren(...shown.filter((_, k) => first(controls[k].one)), field("Repeats", repeats));
    others.replaceChildren(...shown.filter((_, k) => !first(controls[k].one)));
    more.hidden = !others.children.length;
  }

  function text() {
    const lines = controls.map(({ one, control: made }) => line(one, made)).filter(Boolean);
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
const first = (one) => one.required || ["voltage", "cycles", "duration", "motion", "scale", "speeds", "amplitude", "speed"].includes(one.name);

const label = (name) => `${name.charAt(0).toUpperCase()}${name.slice(1).replaceAll("_", " ")}`;

function control(one) {
  const id = `step-${one.name}`;
  if (one.type === "yes") return choice([["yes", "yes"], ["no", "no"]], { id, value: one.value });
  return h("input", { type: "text", id, maxlength: "1000", value: one.value, placeholder: one.type === "text" ? "" : "such as 2; 4; 8" });
}

/** A line of TOML; none where the value is the one that the step has without it. */
function line(one, made) {
  const typed = made.value.trim();
  if (!typed && one.required) throw new Error(`${label(one.name)} is empty; give a value`);
  if (!typed || (!one.required && typed === one.value)) return "";
  if (one.type === "yes") return `${one.name} = ${typed === "yes"}`;
  if (one.type === "text") return `${one.name} = ${JSON.stringify(typed)}`;
  const values = /[;\s]/.test(typed) ? numberList(typed, label(one.name)) : [oneNumber(typed, label(one.name))];
  if (one.type === "whole" && !values.every(Number.isInteger)) throw new Error(`${label(one.name)} must be a whole number`);
  const shown = values.map((value) => (one.unit ? `"${value} ${one.unit}"` : String(value)));
  return `${one.name} = ${shown.length > 1 || one.several ? `[${shown.join(", ")}]` : shown[0]}`;
}
