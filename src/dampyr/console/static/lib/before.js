// Recent jobs of this kind, of this page or another; the list is refreshed every few seconds.
import { get } from "./api.js";
import { h, section } from "./dom.js";

const EVERY = 2000;
const MAX_SHOWN = 8;

/** before(kinds, follow): { element, look, clear }; `follow(id)` is called when one is chosen. */
export function before(page, kinds, follow) {
  const element = h("div");
  let shown = "";
  const timer = setInterval(() => document.hidden || look(), EVERY);

  async function look() {
    let jobs;
    try {
      jobs = (await get("jobs")).filter((job) => kinds.includes(job.kind)).slice(0, MAX_SHOWN);
    } catch {
      return; // the head of the page shows when the console does not answer
    }
    const now = JSON.stringify(jobs.map(({ id, state }) => [id, state]));
    if (now === shown) return;
    shown = now;
    const focused = element.contains(document.activeElement) ? document.activeElement.getAttribute("href") : null;
    element.replaceChildren(...(jobs.length ? [section("Recent jobs", h("ul", { class: "before" }, jobs.map(line)))] : []));
    if (focused) element.querySelector(`a[href="${CSS.escape(focused)}"]`)?.focus();
  }

  function line(job) {
    const chosen = (event) => (event.preventDefault(), follow(job.id));
    const kind = { done: "good", failed: "bad" }[job.state] ?? "";
    return h("li", {}, h("a", { href: `#/${page}?job=${job.id}`, onclick: chosen }, job.title), h("small", {}, when(job.made)), " ", h("span", { class: `badge ${kind}` }, job.state));
  }

  /** The time of today, or the day and the time. */
  function when(made) {
    const date = new Date(1e3 * made);
    const today = date.toDateString() === new Date().toDateString();
    return date.toLocaleString([], today ? { timeStyle: "short" } : { dateStyle: "short", timeStyle: "short" });
  }

  look();
  return { element, look, clear: () => clearInterval(timer) };
}
