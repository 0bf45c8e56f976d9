// A sentence to the person, read out by a screen reader; it leaves by itself, later where it is bad, and not while it is pointed at.
import { button, capital, h } from "./dom.js";

const STAYS = { note: 6000, bad: 20000 }; // ms
const ALL = 3;

export function say(sentence, kind = "note") {
  const words = capital(sentence);
  const shown = h("div", { class: `notice ${kind}` }, h("span", {}, words));
  shown.append(button("×", () => shown.remove(), { class: "quiet", "aria-label": "Close the message" }));
  const all = document.getElementById("notices");
  for (const other of [...all.children]) if (other.firstChild.textContent === words) other.remove();
  all.append(shown);
  while (all.children.length > ALL) all.firstChild.remove();
  const leave = () => (shown.matches(":hover, :focus-within") ? setTimeout(leave, 1000) : shown.remove());
  setTimeout(leave, STAYS[kind] ?? STAYS.bad);
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
