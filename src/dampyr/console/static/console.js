// The shell: navigation, one page at a time, light and dark.
import { get } from "./lib/api.js";
import { h } from "./lib/dom.js";
import { say } from "./lib/notice.js";

const main = document.getElementById("main");
let leave = null;
let showing = 0;
let pages = [];

/** #/records?open=... as { name, query }. */
function place() {
  const [name, rest] = location.hash.replace(/^#\/?/, "").split("?");
  return { name, query: new URLSearchParams(rest ?? "") };
}

async function show(first = false) {
  const { name, query } = place();
  if (location.hash && !location.hash.startsWith("#/")) return;
  const page = pages.find((one) => one.name === name);
  const turn = ++showing;
  leave?.();
  leave = null;
  for (const link of document.querySelectorAll("#pages a")) {
    if (link.dataset.name === name) link.setAttribute("aria-current", "page");
    else link.removeAttribute("aria-current");
  }
  document.title = page ? `${page.title} · dampyr` : "dampyr console";
  const root = h("div", { class: "page" });
  main.replaceChildren(root);
  if (!page) return welcome(root);
  root.append(h("h1", {}, page.title));
  try {
    const module = await import(`./pages/${name}.js`);
    const left = await module.show(root, query);
    if (turn === showing) leave = left ?? null;
    else left?.();
  } catch (problem) {
    if (turn === showing) say(problem.message, "bad");
  }
  if (!first) main.focus({ preventScroll: true });
  scrollTo(0, 0);
}

function welcome(root) {
  root.append(h("h1", {}, "dampyr"));
  if (!pages.length) root.append(h("p", {}, "This console has no pages."));
  root.append(h("ul", { class: "doors" }, pages.map((one) => h("li", {}, h("a", { href: `#/${one.name}` }, one.title)))));
}

const THEMES = ["system", "light", "dark"];
const MARKS = { system: "◐", light: "☀", dark: "☾" };

function themes() {
  const knob = document.getElementById("theme");
  const root = document.documentElement;
  const tell = () => {
    const now = root.dataset.theme ?? "system";
    knob.textContent = MARKS[now];
    knob.setAttribute("aria-label", now === "system" ? "Colours: as the system" : `Colours: ${now}`);
    dispatchEvent(new Event("theme"));
  };
  knob.addEventListener("click", () => {
    const next = THEMES[(THEMES.indexOf(root.dataset.theme ?? "system") + 1) % THEMES.length];
    if (next === "system") delete root.dataset.theme;
    else root.dataset.theme = next;
    try {
      localStorage.setItem("theme", next);
    } catch {
      // a browser without storage forgets it
    }
    tell();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", tell);
  tell();
}

async function start() {
  themes();
  try {
    const about = await get("console");
    pages = about.pages;
    document.getElementById("pages").append(
      ...pages.map((one) => h("a", { href: `#/${one.name}`, "data-name": one.name }, one.title)),
    );
    if (pages.some((one) => one.name === "bench")) (await import("./lib/abort.js")).begin(document.getElementById("aside"));
    document.querySelector(".brand").title = `dampyr ${about.version}`;
  } catch (problem) {
    say(problem.message, "bad");
    if (problem.status === 401) askForToken();
    return;
  }
  addEventListener("hashchange", () => show());
  await show(true);
}

function askForToken() {
  const given = h("input", { type: "password", id: "token", autocomplete: "off" });
  const form = h("form", { class: "page" }, h("h1", {}, "Token"), h("label", { for: "token" }, "The token that the console printed"), given,
    h("button", { type: "submit" }, "Enter"));
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    location.assign(`/?token=${encodeURIComponent(given.value)}`);
  });
  main.replaceChildren(form);
  given.focus();
}

start();
