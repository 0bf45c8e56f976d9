// This page's stream of the bench: one for all pages, so that abort is at hand everywhere and control is kept.
import { post, socket } from "./api.js";
import { say } from "./notice.js";

const AGAIN = 1000; // ms until a lost stream is opened anew
const SILENT = 500; // ms after which an abort that the stream did not answer goes another way
const LONGEST = 3000; // ms that it may take there
const listeners = new Set();
const signs = new Map();
let link = null;
let counted = 0;

export const bench = { state: null, holds: false, connected: false, strips: null };

/** The id of this tab; a reload keeps it, and with it control. */
export const client = (() => {
  const made = () => [...crypto.getRandomValues(new Uint8Array(12))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  try {
    const kept = sessionStorage.getItem("client") ?? made();
    sessionStorage.setItem("client", kept);
    return kept;
  } catch {
    return made();
  }
})();

/** Hear of every frame: told(frame), or told(null) when the stream is lost. Returns a function that ends it. */
export function listen(told) {
  listeners.add(told);
  return () => listeners.delete(told);
}

export function open() {
  link = socket(`bench/stream?client=${client}`);
  link.addEventListener("open", () => { bench.connected = true; });
  link.addEventListener("message", (event) => take(JSON.parse(event.data)));
  link.addEventListener("close", () => {
    bench.connected = false;
    bench.holds = false;
    for (const told of listeners) told(null);
    setTimeout(open, AGAIN);
  });
}

function take(told) {
  if ("aborted" in told) {
    signs.get(told.aborted)?.(performance.now());
    signs.delete(told.aborted);
    return;
  }
  if ("refused" in told) {
    say(told.refused, "bad");
    return;
  }
  bench.state = told.state ?? bench.state;
  bench.holds = told.holds;
  for (const heard of listeners) heard(told);
  send({ heard: told.frame });
}

function send(told) {
  if (link?.readyState === WebSocket.OPEN) link.send(JSON.stringify(told));
}

/** Do something on the bench; what it refuses is said. */
export async function ask(what, more = {}) {
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
