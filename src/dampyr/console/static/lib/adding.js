// Cards, structures and ground motions that are added to the data folder: read by the console first, then listed by the pages.
import { upload } from "./api.js";
import { choice, field, h } from "./dom.js";
import { attempt, say } from "./notice.js";

const KINDS = [["cards", "a damper's card (.toml)"], ["structures", "a structure (.toml)"], ["motions", "a ground motion"]];

/** adding(added): the form; `added(kind, name)` is called when a file is there. */
export function adding(added) {
  const kind = choice(KINDS);
  const file = h("input", { type: "file" });

  async function send(event) {
    event.preventDefault();
    const [chosen] = file.files;
    if (!chosen) return say("Choose a file first.", "bad");
    const taken = await attempt(() => upload(`building/files/${kind.value}/${encodeURIComponent(chosen.name)}`, chosen));
    if (!taken) return undefined;
    say(`Added ${taken.name} to the ${taken.kind}.`);
    return added(taken.kind, taken.name);
  }

  return h("form", { onsubmit: send }, field("What it is", kind), field("File to add", file, "It is read first; one of the same name is not replaced"),
    h("div", { class: "row" }, h("button", { type: "submit" }, "Add")));
}
