// The shell: navigation, one page at a time, light and dark.
import { get } from "./lib/api.js";
import { dashboard } from "./lib/dashboard.js";
import { capital, h } from "./lib/dom.js";
import { say } from "./lib/notice.js";

const main = document.getElementById("main");
let leave = null;
let showing = 0;
let pages = [];
const ENDING = 5; // s, longer than a console takes to end

/** #/records?open=... as { name, query }. */
function place() {
  const [name, rest] = location.hash.replace(/^#\/?/, "").split("?");
  return { name, query: new URLSearchParams(rest ?? "") };
}

async function show(first = false) {
  const { name, query } = place();
  if (location.hash && !location.hash.startsWith("#/")) return;
  const page = pages.find((page) => page.name === name);
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
  if (!page) return welcome(root, turn);
  root.append(h("h1", {}, page.title));
  let module = null;
  try {
    module = await import(`./pages/${name}.js`);
    const left = await module.show(root, query);
    if (turn === showing) leave = left ?? null;
    else left?.();
  } catch (problem) {
    if (turn === showing) unavailable(root, problem, Boolean(module));
  }
  if (!first) main.focus({ preventScroll: true });
  scrollTo(0, 0);
}

/**
 * A page that could not be opened says why, and opens itself as soon as the console answers again. Where its module could not be
 * fetched the document is loaded anew, since a browser may remember the failure; not before the console has answered for longer
 * than one takes to end, or nothing of it might be fetched.
 */
function unavailable(root, problem, fetched = true) {
  const refused = "status" in problem && problem.status > 0;
  const words = refused ? problem.message : "the console does not answer; this page opens as soon as it does";
  root.append(h("p", { class: "verdict bad", role: "alert" }, capital(words)));
  if (refused) return;
  const turn = showing;
  answering(fetched ? 1 : ENDING, () => turn === showing).then((still) => {
    if (!still) return;
    if (fetched) show();
    else location.reload();
  });
}

/** Resolves once the console has answered `times` in a row, a second apart; with false where `wanted()` is not any more. */
async function answering(times, wanted = () => true) {
  for (let k = 0; k < times; ) {
    await new Promise((resolve) => setTimeout(resolve, 1000));
    if (!wanted()) return false;
    k = await get("console").then(() => k + 1, (problem) => (problem.status > 0 ? k + 1 : 0));
  }
  return wanted();
}

async function welcome(root, turn) {
  if (!pages.length) {
    root.append(h("h1", {}, "dampyr"), h("p", {}, "This console has no pages."));
    return;
  }
  try {
    const left = await dashboard(root, pages);
    if (turn === showing) leave = left;
    else left();
  } catch (problem) {
    if (turn === showing) unavailable(root, problem);
  }
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
      ...pages.map((page) => h("a", { href: `#/${page.name}`, "data-name": page.name }, page.title)),
    );
    if (pages.some((page) => page.name === "bench")) (await import("./lib/abort.js")).begin(document.getElementById("aside"));
    document.querySelector(".brand").title = `dampyr ${about.version}`;
  } catch (problem) {
    say(problem.message, "bad");
    if (problem.status === 401 || problem.status === 429) askForToken();
    else if (!(problem.status > 0)) answering(ENDING).then(() => location.reload());
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
