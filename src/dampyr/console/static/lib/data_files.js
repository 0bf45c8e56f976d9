// Cards, structures and ground motions that are added to the data folder: read by the console first, then listed by the pages.
import { upload } from "./api.js";
import { choice, field, h } from "./dom.js";
import { attempt, say } from "./notice.js";

const KINDS = [["cards", "a damper's card (.toml)"], ["structures", "a structure (.toml)"], ["motions", "a ground motion"]];

/** dataFileForm(stored): the form; `stored()` is called when a file is there. */
export function dataFileForm(stored) {
  const kind = choice(KINDS);
  const file = h("input", { type: "file" });

  async function send(event) {
    event.preventDefault();
    const [chosen] = file.files;
    if (!chosen) return say("Choose a file first.", "bad");
    const taken = await attempt(() => upload(`building/files/${kind.value}/${encodeURIComponent(chosen.name)}`, chosen));
    if (!taken) return undefined;
    say(`Added ${taken.name} to the ${taken.kind}.`);
    return stored();
  }

  return h("form", { onsubmit: send }, field("What it is", kind), field("File to add", file, "It is read first; one of the same name is not replaced"),
    h("div", { class: "row" }, h("button", { type: "submit" }, "Add")));
}
