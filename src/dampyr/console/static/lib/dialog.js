// A question before something that cannot be taken back, and a question for a name. Escape says no; the focus goes back to where it was.
import { button, field, h } from "./dom.js";

/** Whether the person agrees: await confirmed("Delete it?", "Delete"). */
export function confirmed(question, yes) {
  return show(question, [], yes, () => true);
}

/** The text that the person enters, null where they leave it. */
export function prompted(question, label, value, yes) {
  const input = h("input", { type: "text", maxlength: "100", value, required: true });
  return show(question, [field(label, input)], yes, () => input.value.trim() || null);
}

function show(question, parts, yes, answer) {
  return new Promise((resolve) => {
    const before = document.activeElement;
    let result = null;
    const form = h("form", { method: "dialog" }, h("p", {}, question), parts,
      h("div", { class: "row" }, button("Cancel", () => made.close(), { autofocus: !parts.length }), h("button", { type: "submit", class: "main" }, yes)));
    const made = h("dialog", { class: "ask", "aria-label": question }, form);
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      result = answer();
      if (result !== null) made.close();
    });
    made.addEventListener("keydown", (event) => event.key === "Escape" && made.close());
    made.addEventListener("close", () => {
      made.remove();
      before?.focus?.();
      resolve(result);
    });
    document.body.append(made);
    made.show(); // and not as a modal one: abort, in the head, can be pressed meanwhile
    (parts[0]?.querySelector("input") ?? form.querySelector("button")).focus();
    parts[0]?.querySelector("input").select();
  });
}
