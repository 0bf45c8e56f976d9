// Requests to the console. A failure is an Error whose message is one sentence for a person.

export class Refused extends Error {
  constructor(status, message) {
    super(message);
    this.status = status;
  }
}

async function ask(method, path, body, headers = {}, signal = undefined) {
  let answer;
  try {
    answer = await fetch(`/api/${path}`, { method, body, headers, signal, credentials: "same-origin" });
  } catch {
    throw new Refused(0, "the console does not answer; is `dampyr console` still running?");
  }
  if (answer.ok) return answer;
  let answered = {};
  try {
    answered = await answer.json();
  } catch {
    // an answer without a sentence
  }
  throw new Refused(answer.status, answered.detail ?? `the console answered ${answer.status}`);
}

const inJson = { "content-type": "application/json" };

export const get = async (path) => (await ask("GET", path)).json();
export const text = async (path) => (await ask("GET", path)).text();
export const post = async (path, data = {}, signal = undefined) => (await ask("POST", path, JSON.stringify(data), inJson, signal)).json();
export const put = async (path, data) => (await ask("PUT", path, JSON.stringify(data), inJson)).json();
export const remove = (path) => ask("DELETE", path);
export const send = async (method, path, file) => (await ask(method, path, file, { "content-type": "application/octet-stream" })).json();
export const upload = (path, file) => send("PUT", path, file);

/** Save an answer as a file, by the name that it has. */
export async function download(path) {
  const answer = await ask("GET", path);
  const name = /filename="([^"]+)"/.exec(answer.headers.get("content-disposition") ?? "");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await answer.blob());
  link.download = name ? name[1] : "";
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Query text of an object: lists repeat, what is undefined or empty is left out. */
export function query(values) {
  const parameters = new URLSearchParams();
  for (const [name, value] of Object.entries(values)) {
    for (const item of Array.isArray(value) ? value : [value]) {
      if (item !== undefined && item !== null && item !== "") parameters.append(name, item);
    }
  }
  return parameters.toString();
}

/** The address of a WebSocket of the console. */
export const socket = (path) => new WebSocket(`${location.origin.replace(/^http/, "ws")}/api/${path}`);
