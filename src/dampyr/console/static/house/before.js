// Work of this kind that was asked for, by this page or another; it is looked for anew every few seconds.
import { get } from "./api.js";
import { h, section } from "./dom.js";

const EVERY = 2000;
const MOST = 8;

/** before(kinds, follow): { element, look, clear }; `follow(id)` is called when one is chosen. */
export function before(page, kinds, follow) {
  const element = h("div");
  let shown = "";
  const timer = setInterval(() => document.hidden || look(), EVERY);

  async function look() {
    let jobs;
    try {
      jobs = (await get("jobs")).filter((one) => kinds.includes(one.kind)).slice(0, MOST);
    } catch {
      return; // the head of the page tells when the console is gone
    }
    const now = JSON.stringify(jobs.map(({ id, state }) => [id, state]));
    if (now === shown) return;
    shown = now;
    const focused = element.contains(document.activeElement) ? document.activeElement.getAttribute("href") : null;
    element.replaceChildren(...(jobs.length ? [section("Before", h("ul", { class: "before" }, jobs.map(line)))] : []));
    if (focused) element.querySelector(`a[href="${CSS.escape(focused)}"]`)?.focus();
  }

  function line(one) {
    const chosen = (event) => (event.preventDefault(), follow(one.id));
    const kind = { done: "good", failed: "bad" }[one.state] ?? "";
    return h("li", {}, h("a", { href: `#/${page}?job=${one.id}`, onclick: chosen }, one.title), " ", h("span", { class: `badge ${kind}` }, one.state));
  }

  look();
  return { element, look, clear: () => clearInterval(timer) };
}
