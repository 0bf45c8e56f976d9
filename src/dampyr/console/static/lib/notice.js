// A sentence to the person, read out by a screen reader; it stays until it is taken away or leaves by itself.
import { button, h } from "./dom.js";

export function say(sentence, kind = "note") {
  const words = sentence.charAt(0).toUpperCase() + sentence.slice(1);
  const shown = h("div", { class: `notice ${kind}` }, h("span", {}, words));
  shown.append(button("×", () => shown.remove(), { class: "quiet", "aria-label": "Take the message away" }));
  const all = document.getElementById("notices");
  for (const other of [...all.children]) if (other.firstChild.textContent === words) other.remove();
  all.append(shown);
  if (kind === "note") setTimeout(() => shown.remove(), 6000);
}

/** Run something; what goes wrong is said. */
export async function attempt(work) {
  try {
    return await work();
  } catch (problem) {
    say(problem.message, "bad");
    if (!(problem.name === "Error" && "status" in problem)) console.warn(problem.message);
    return undefined;
  }
}
