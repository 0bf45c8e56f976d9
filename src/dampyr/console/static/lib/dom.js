// Elements and numbers.

/** An element: h("p", { class: "note", onclick: f }, "text", other). Text is text, never HTML. */
export function h(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name in made && !["list", "form", "type"].includes(name) && typeof value !== "string") made[name] = value;
    else if (name === "value") made.value = value;
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

let counted = 0;

/** A labelled control: field("Voltage", input, "V at the coil"). */
export function field(label, control, hint = "") {
  control.id ||= `c${++counted}`;
  const parts = [h("label", { for: control.id }, label), control];
  if (hint) {
    const note = h("small", { id: `${control.id}-hint` }, hint);
    control.setAttribute("aria-describedby", note.id);
    parts.push(note);
  }
  return h("div", { class: "field" }, parts);
}

/** A box to tick with its words behind it. */
export function tick(label, attributes = {}) {
  return h("label", { class: "tick" }, h("input", { type: "checkbox", ...attributes }), label);
}

/** A choice among [value, words] pairs or plain words. */
export function choice(options, attributes = {}) {
  const made = h("select", attributes);
  for (const option of options) {
    const [value, words] = Array.isArray(option) ? option : [option, option];
    made.append(h("option", { value }, words));
  }
  if (attributes.value !== undefined) made.value = attributes.value;
  return made;
}

export function button(words, onclick, attributes = {}) {
  return h("button", { type: "button", onclick, ...attributes }, words);
}

export function section(title, ...children) {
  return h("section", {}, h("h2", {}, title), children);
}

/** A text as a sentence begins, unless its first word is a name: of a file, an option, a record. */
export const capital = (text) => (/^\S*[._=\d/]/.test(text) ? text : text.charAt(0).toUpperCase() + text.slice(1));

/** The name of a file without its folders and its suffix. */
export const short = (key) => key.split("/").at(-1).replace(/\.[^.]+$/, "");

const SUPERSCRIPT = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };

/** A number for a person: significant digits, a true minus, powers of ten written out; – where there is none. */
export function number(value, digits = 4) {
  if (value === "inf") return "∞";
  if (value === "-inf") return "−∞";
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (Number.isInteger(value) && Math.abs(value) < 1e6) return String(value).replace("-", "−");
  const [mantissa, exponent] = general(value, digits).split("e");
  const power = exponent ? `·10${[...String(Number(exponent))].map((c) => SUPERSCRIPT[c]).join("")}` : "";
  return mantissa.replace("-", "−") + power;
}

/** A value and half of its interval, of which two digits are said, and of the value no more: as `dampyr.phrases.with_reach`. */
export function withReach(value, half) {
  if (!Number.isFinite(value) || !(half > 0) || !Number.isFinite(half)) return `${number(value)} ± ${number(half, 2)}`;
  const last = Math.floor(Math.log10(Number(half.toPrecision(2)))) - 1;
  if (last > 4 || Math.max(Math.abs(value), half) < 1e-3) return `${number(value, Math.max(Math.floor(Math.log10(Math.max(Math.abs(value), half))) - last + 1, 1))} ± ${number(half, 2)}`;
  const rounded = (one) => (Math.round(one / 10 ** last) * 10 ** last).toFixed(Math.max(-last, 0)).replace("-", "−");
  return `${rounded(value)} ± ${rounded(half)}`;
}

/** As C's %g. */
function general(value, digits) {
  if (value === 0) return "0";
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  if (Number(exponent) < -4 || Number(exponent) >= digits + 1) return `${tidy(mantissa)}e${Number(exponent)}`;
  return tidy(value.toFixed(Math.max(0, digits - 1 - Number(exponent))));
}

const tidy = (text) => (text.includes(".") ? text.replace(/\.?0+$/, "") : text);

/** A text whose parameters, such as k_x, are set as symbols. */
export function symbols(text) {
  return text.split(/((?<![\p{L}\p{N}_.])\p{L}_[\p{L}\p{N}](?![\p{L}\p{N}_]))/u).map((part, k) => (k % 2 ? h("var", {}, part[0], h("sub", {}, part.slice(2))) : part));
}
