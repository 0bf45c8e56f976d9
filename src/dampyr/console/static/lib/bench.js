// This page's stream of the bench: one for all pages, so that abort works everywhere and control is not lost.
import { post, socket } from "./api.js";
import { say } from "./notice.js";

const AGAIN = 1000; // ms until a lost stream is reopened
const SILENT = 500; // ms after which an abort without an answer on the stream is sent over HTTP
const LONGEST = 3000; // ms that the abort over HTTP may take
const listeners = new Set();
const signs = new Map();
let link = null;
let counted = 0;

export const bench = { state: null, holds: false, connected: false };

let at = performance.now();

/** s since the console was heard last. */
export const age = () => (performance.now() - at) / 1000;

/** The id of this tab; a reload keeps it, and with it control. */
export const client = (() => {
  const made = () => [...crypto.getRandomValues(new Uint8Array(12))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  try {
    const id = sessionStorage.getItem("client") ?? made();
    sessionStorage.setItem("client", id);
    return id;
  } catch {
    return made();
  }
})();

/** Call listener(frame) for every frame, listener(null) when the stream is lost. Returns a function that ends it. */
export function listen(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

export function open() {
  link = socket(`bench/stream?client=${client}`);
  link.addEventListener("open", () => { bench.connected = true; });
  link.addEventListener("message", (event) => take(JSON.parse(event.data)));
  link.addEventListener("close", () => {
    bench.connected = false;
    bench.holds = false;
    for (const listener of listeners) listener(null);
    setTimeout(open, AGAIN);
  });
}

function take(message) {
  if ("aborted" in message) {
    signs.get(message.aborted)?.(performance.now());
    signs.delete(message.aborted);
    return;
  }
  if ("refused" in message) {
    say(message.refused, "bad");
    return;
  }
  at = performance.now();
  bench.state = message.state ?? bench.state;
  bench.holds = message.holds;
  for (const listener of listeners) listener(message);
  send({ heard: message.frame });
}

function send(message) {
  if (link?.readyState === WebSocket.OPEN) link.send(JSON.stringify(message));
}

/** Send a command to the bench; a refusal is shown as a notice. */
export async function ask(what, more = {}) {
  if (document.activeElement?.getAttribute("aria-disabled") === "true") return false;
  try {
    await post(`bench/${what}`, { client, ...more });
    return true;
  } catch (problem) {
    say(problem.message, "bad");
    return false;
  }
}

export const jog = (speed) => send({ jog: speed });

/**
 * Brake and cut the coil. Resolves with the ms until the rig had done it; over the stream, or over HTTP where that is lost or
 * silent. Rejects where neither answers.
 */
export async function abort() {
  const begun = performance.now();
  if (link?.readyState === WebSocket.OPEN) {
    const sign = ++counted;
    const done = new Promise((resolve) => signs.set(sign, resolve));
    send({ abort: sign });
    const ended = await Promise.race([done, new Promise((resolve) => setTimeout(resolve, SILENT))]);
    if (ended) return ended - begun;
    signs.delete(sign);
  }
  await post("bench/abort", { who: "a page" }, AbortSignal.timeout(LONGEST));
  return performance.now() - begun;
}
