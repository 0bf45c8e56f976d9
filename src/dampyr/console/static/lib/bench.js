// This page's stream of the bench: one for all pages, so that abort works everywhere and control is not lost.
import { post, socket } from "./api.js";
import { drafts } from "./drafts.js";
import { say } from "./notice.js";

const AGAIN = 1000; // ms until a lost stream is reopened
const SILENT = 500; // ms after which an abort without an answer on the stream is sent over HTTP
const TAKEN = 4410; // the code of a stream that is closed since another page is open by its id
const PATIENT = 5; // times that a page which was open asks for its id again
const LONGEST = 3000; // ms that the abort over HTTP may take
const listeners = new Set();
const signs = new Map();
let link = null;
let counted = 0;
let opened = false; // whether this page has had a stream by its id

export const bench = { state: null, holds: false, connected: false };

let at = performance.now();

/** s since the console was heard last. */
export const age = () => (performance.now() - at) / 1000;

/** The id of this tab; a reload keeps it, and with it control. A tab that was duplicated has a copy, and gets one of its own. */
let client = (() => {
  try {
    return sessionStorage.getItem("client") ?? anotherId();
  } catch {
    return anotherId();
  }
})();

function anotherId() {
  const id = [...crypto.getRandomValues(new Uint8Array(12))].map((byte) => byte.toString(16).padStart(2, "0")).join("");
  try {
    sessionStorage.setItem("client", id);
  } catch {
    // a browser without storage: a reload is another page
  }
  return id;
}

const remembered = drafts("run");

/** Who works at this page: named once, remembered by this browser, and told to the bench. */
export const operator = {
  get name() {
    return remembered.read("last")?.operator ?? "";
  },
  set name(name) {
    remembered.keep("last", { ...remembered.read("last"), operator: name });
    send({ operator: name });
  },
};

/** Call listener(frame) for every frame, listener(null) when the stream is lost. Returns a function that ends it. */
export function listen(listener) {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

let refused = 0; // times in a row that this id was taken

export function open() {
  link = socket(`bench/stream?client=${client}`);
  link.addEventListener("open", () => {
    bench.connected = true;
    send({ operator: operator.name });
  });
  link.addEventListener("message", (event) => take(JSON.parse(event.data)));
  link.addEventListener("close", (event) => {
    // its own last stream may be about to end: after a reload at once, after a lost network in three seconds
    refused = event.code === TAKEN ? refused + 1 : 0;
    if (refused > (opened ? PATIENT : 1)) [client, refused, opened] = [anotherId(), 0, false];
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
  opened = true;
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
  await post("bench/abort", { who: operator.name.slice(0, 40) || "a page" }, AbortSignal.timeout(LONGEST));
  return performance.now() - begun;
}
