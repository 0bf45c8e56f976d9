// The next tests, proposed from a damper or from records by what they are expected to tell; a job that continues without the page.
import { get, post } from "./api.js";
import { button, choice, field, h, section } from "./dom.js";
import { watch } from "./jobs.js";
import { attempt, say } from "./notice.js";
import { oneNumber } from "./numbers.js";
import { optionsForm } from "./options.js";
import { picker } from "./picker.js";
import { servedTable } from "./table.js";

const GOAL = ["drift", "displacement", "acceleration"];

/** proposal(rig, take): an element; `rig()` is the chosen rig, and `take(text)` is given the campaign that is proposed. */
export function proposal(rig, take) {
  const place = h("div");
  const element = h("details", { id: "propose" }, h("summary", {}, "Propose tests"), place);
  let stop = null;
  element.addEventListener("toggle", () => element.open && !place.children.length && fill());

  async function fill() {
    place.replaceChildren(h("p", { class: "soft" }, "Reading the dampers and the records …"));
    const offered = await attempt(() => get("campaigns/proposing"));
    if (!offered) return place.replaceChildren(); // and once more when it is opened again
    const damper = choice([["", "that of the rig"], ...offered.dampers.map((damper) => [damper.name, damper.title])]);
    const records = await picker([], () => {});
    const structure = choice(offered.structures);
    const voltage = h("input", { type: "text", inputmode: "decimal" });
    const of = choice(GOAL);
    const options = optionsForm(offered.options);
    const progress = h("div");
    const result = h("div");

    async function start() {
      const request = { damper: damper.value, records: records.chosen(), rig: rig(), structure: structure.value, of: of.value };
      try {
        Object.assign(request, options.values());
        const volts = oneNumber(voltage.value, "Voltage in the earthquake");
        if (volts !== null) request.voltage = volts;
      } catch (problem) {
        return say(problem.message, "bad");
      }
      result.replaceChildren();
      const job = await attempt(() => post("campaigns/proposals", request));
      if (!job) return undefined;
      stop?.();
      stop = watch(progress, job.id, (done) => done.state === "done" && shown(done.result));
      return undefined;
    }

    function shown(r) {
      result.replaceChildren(
        r.notice ? h("p", { class: "verdict bad origin" }, r.notice) : "",
        ...[...r.notes, ...r.findings].map((words) => h("p", { class: "soft" }, words)),
        section("Half widths of 95 % intervals", servedTable(r.intervals, { digits: 4 })),
        h("p", { class: "soft" }, r.command));
      take(r.text);
      say("The proposed tests are in the text; save them to run them.");
    }

    return place.replaceChildren(
      field("Damper", damper, "what is known of it, in place of records"),
      h("details", {}, h("summary", {}, "From records"), records.element),
      h("details", {}, h("summary", {}, "For the peak of a structure"), h("div", { class: "fields" }, field("Structure", structure, "in El Centro 1940, the damper in storey 1"), field("Voltage in the earthquake, V", voltage), field("Peak of", of))),
      options.element,
      h("div", { class: "row" }, button("Propose", start)), progress, result);
  }

  return { element, clear: () => stop?.() };
}
