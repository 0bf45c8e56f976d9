// Running campaigns at the bench: what is asked before a run, the run under way, the queue, and earlier runs.
import { download, get, post, query as asQuery } from "./api.js";
import { ask, bench, operator as worker } from "./bench.js";
import { confirmed } from "./dialog.js";
import { button, choice, field, h, number, section } from "./dom.js";
import { drafts } from "./drafts.js";
import { attempt, say } from "./notice.js";
import { originBadge } from "./origin.js";
import { table } from "./table.js";

const remembered = drafts("run");

export async function campaignPanel(files, chosen) {
  const which = choice(files, { id: "campaign", value: chosen ?? files[0] ?? "" });
  const start = button("Start…", () => attempt(() => dialog.open(which.value)), { class: "main", id: "start" });
  const pause = button("Pause", () => ask("pause"), { id: "pause" });
  const resume = button("Resume", () => ask("resume"), { class: "main", id: "resume" });
  const stop = button("Stop", () => ask("stop"), { id: "stop" });
  const bar = h("progress", { max: "1", value: "0", "aria-label": "Progress of the campaign" });
  const facts = h("dl", { class: "facts", id: "run" });
  const report = button("Certificate", () => certificate(last), { id: "report", title: "The report of this run, as one page" });
  const cycles = h("div", { id: "cycles" });
  const queue = h("ol", { class: "plain", id: "queue" });
  const earlier = h("div", { id: "runs" });
  const form = h("div", {}, field("Campaign", which), h("div", { class: "row" }, start));
  const none = h("div", { id: "no-campaign" }, h("p", { class: "soft" }, "No campaign is saved yet. Three short tests, less than 20 s on the rig, are an example; or ", h("a", { href: "#/campaigns" }, "make one"), "."),
    h("div", { class: "row" }, button("Load the example campaign", () => attempt(example), { class: "main", id: "example" })));
  const element = section("Campaign", form, none, bar, facts, h("div", { class: "row" }, pause, resume, stop, report), cycles, queue, earlier);
  const dialog = startDialog(files);
  element.append(dialog.element);
  const tests = h("div", {});
  form.hidden = !files.length;
  none.hidden = !form.hidden;

  async function example() {
    const { name } = await post("campaigns/example");
    files.push(name);
    which.append(h("option", { value: name }, name));
    dialog.add(name);
    form.hidden = false;
    none.hidden = true;
  }

  let mayRun = false;
  let last = "";
  let next = null;
  let shown = "";
  let told = "";

  async function refresh() {
    const runs = await get("bench/runs");
    const open = runs.filter((run) => run.state === "interrupted");
    const rows = open.slice(0, 5).map((run) => h("li", {}, h("strong", {}, run.name), " ", originBadge(run.origin), ` ${run.complete} of ${run.tests} tests, ${run.time.slice(0, 10)} `,
      button("Continue…", () => attempt(() => dialog.open(files.includes(run.campaign) ? run.campaign : which.value, run)), { class: "continue", disabled: !mayRun, "aria-label": `Continue ${run.name}` }), " ",
      button("Remove…", () => attempt(() => discard(run)), { class: "quiet", disabled: !mayRun, "aria-label": `Remove ${run.name}` })));
    earlier.replaceChildren(...(rows.length ? [h("h3", {}, "Interrupted runs"), h("ul", { class: "plain" }, rows)] : []));
  }

  async function discard(run) {
    const what = run.complete ? `${run.complete} complete tests of ${run.tests} and what else was recorded` : "what was recorded of it; none of its tests is complete";
    if (!(await confirmed(`Remove the interrupted run ${run.name}? Its folder is deleted with ${what}.`, "Remove"))) return;
    if (await ask("runs/remove", { folder: run.name, complete: run.complete })) await refresh();
  }

  function show(state, mine) {
    const { run, phase } = state;
    const running = phase === "campaign";
    if (running && files.includes(run?.name)) which.value = run.name;
    start.hidden = false;
    start.textContent = running ? "Queue…" : "Start…";
    enable(start, mine && ["idle", "armed", "campaign"].includes(phase));
    mayRun = mine && ["idle", "armed"].includes(phase);
    for (const control of earlier.querySelectorAll("button")) control.disabled = !mayRun;
    dialog.running = running;
    for (const control of [pause, resume, stop]) enable(control, mine && running);
    pause.hidden = !running || run?.paused;
    resume.hidden = !running || !run?.paused;
    stop.hidden = !running;
    report.hidden = running || run?.outcome !== "complete" || run.report_state === "writing";
    bar.hidden = facts.hidden = !run;
    showQueue(state, mine);
    showCycles(state.comparison, run);
    if (!run) {
      tests.replaceChildren();
      shown = "";
      return;
    }
    last = run.folder;
    const share = run.outcome === "complete" ? 1 : (run.done + run.fraction * (run.phase === "testing")) / Math.max(run.tests, 1);
    bar.value = Math.min(1, share);
    const rows = [["campaign", run.name], ["folder", run.folder], ["state", stateWords(run)], ["tests", `${run.done} of ${run.tests} complete`]];
    if (run.operator) rows.push(["operator", run.operator]);
    if (run.specimen) rows.push(["specimen", run.specimen]);
    if (running) {
      rows.push(["test", run.test || "–"], ["cycle", `${run.cycles.toFixed(1)} of ${run.planned_cycles.toFixed(1)}`], ["stroke", `${(run.stroke * 1e3).toFixed(2)} mm`],
        ["time left", clockOf(run.time_left)]);
      if (next?.folder === run.folder) rows.push(["next", h("span", {}, next.name, h("small", { class: "under" }, next.words))]);
    }
    if (run.report_state) rows.push(["comparison", run.report_state]);
    facts.replaceChildren(...rows.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
    const now = `${run.folder} ${run.done} ${run.outcome} ${run.test} ${run.phase} ${mine}`;
    if (shown !== now) {
      shown = now;
      showTests(run, running && mine);
      if (run.outcome !== "running") refresh().catch(() => {});
    }
  }

  async function showTests(run, may) {
    let states;
    try {
      states = await get(`bench/tests?${asQuery({ folder: run.folder })}`);
    } catch {
      return; // its journal is not there yet
    }
    const left = states.filter((test) => test.state === "planned" && test.name !== run.test);
    next = { folder: run.folder, name: left[0]?.name ?? "no test is left", words: left[0]?.words ?? "" };
    const action = (test) => {
      if (!may) return "";
      if (test.state === "complete") return button("Repeat", () => ask("repeat", { test: test.name }), { "aria-label": `Repeat ${test.name}` });
      if (["planned", "running"].includes(test.state)) return button("Skip", () => ask("skip", { test: test.name }), { "aria-label": `Skip ${test.name}` });
      return "";
    };
    const named = (test) => (test.words ? { key: test.name, show: h("span", { title: test.words }, test.name) } : test.name);
    const rows = states.map((test) => [named(test), mark(test.state), test.attempt, test.reason, ...(may ? [action(test)] : [])]);
    const columns = [{ name: "test" }, { name: "state" }, { name: "try" }, { name: "marks and reasons" }, ...(may ? [{ name: "", words: "action", plain: true }] : [])];
    const focused = document.activeElement?.getAttribute("aria-label");
    tests.replaceChildren(section("Tests", table({ caption: `The tests of ${run.folder}`, columns, rows })));
    if (focused && !document.activeElement?.closest("button")) [...tests.querySelectorAll("button")].find((control) => control.getAttribute("aria-label") === focused)?.focus();
  }

  function showQueue(state, mine) {
    const now = JSON.stringify([state.queue, mine]);
    if (now === told) return;
    told = now;
    queue.replaceChildren(...state.queue.map((waiting) => h("li", {}, h("strong", {}, waiting.name), ` into ${waiting.folder} `,
      button("Remove", () => ask("queue/remove", { number: waiting.number }), { class: "quiet", disabled: !mine, "aria-label": `Remove ${waiting.folder} from the queue` }))));
  }

  let judged = "";
  function showCycles(comparison, run) {
    const now = JSON.stringify(comparison);
    if (now === judged) return;
    judged = now;
    if (!comparison || !run) return cycles.replaceChildren();
    const { passed, failed, tolerance, reason, folder } = comparison;
    const verdict = h("p", { class: `verdict ${failed ? "bad" : passed ? "good" : ""}` },
      `${passed} of ${passed + failed} cycles within ${number(100 * tolerance, 3)} % of ${folder}${reason ? `; ${reason}` : ""}`);
    const percent = (value) => ({ key: value, show: value === null ? "" : `${value < 0 ? "−" : "+"}${Math.abs(100 * value).toFixed(1)}` });
    const rows = [...comparison.cycles].reverse().slice(0, 4).map((cycle) => [cycle.number, cycle.passed ? h("span", { class: "badge good" }, "pass") : h("span", { class: "badge bad" }, "fail"),
      percent(cycle.energy), percent(cycle.extension), percent(cycle.compression)]);
    cycles.replaceChildren(verdict, ...(rows.length ? [table({ caption: "The last cycles against the reference",
      columns: [{ name: "cycle" }, { name: "" , words: "verdict", plain: true }, { name: "energy", unit: "%", align: "right" }, { name: "extension", unit: "%", align: "right" }, { name: "compression", unit: "%", align: "right" }], rows })] : []));
  }

  return { element, tests, show, refresh };
}

const mark = (state) => {
  const kind = { complete: "good", failed: "bad", stopped: "bad" }[state] ?? "";
  return h("span", { class: `badge ${kind}` }, state);
};

const stateWords = (run) => {
  if (run.outcome !== "running") return run.outcome;
  return run.paused && run.phase !== "paused" ? `${run.phase}; pauses after this test` : run.phase;
};

export const clockOf = (seconds) => {
  const whole = Math.max(0, Math.round(seconds));
  const parts = [Math.floor(whole / 60) % 60, whole % 60].map((part) => String(part).padStart(2, "0"));
  return whole >= 3600 ? `${Math.floor(whole / 3600)}:${parts.join(":")} h` : `${Number(parts[0])}:${parts[1]} min`;
};

/** Let a button act or not; one that has the focus keeps it. */
export function enable(knob, on) {
  const focused = document.activeElement === knob;
  knob.disabled = !on && !focused;
  if (!on && focused) knob.setAttribute("aria-disabled", "true");
  else knob.removeAttribute("aria-disabled");
}

/** Save the report of a run as a file; where it has none yet the console writes it now, which takes some seconds. */
export function certificate(folder) {
  say(`the certificate of ${folder} is written; it is saved in some seconds`);
  return attempt(() => download(`bench/runs/${encodeURIComponent(folder)}/report`));
}

/** What is asked before a run: who, what, where the records go, and what they are compared with. */
function startDialog(files) {
  const which = choice(files, { id: "start-campaign" });
  const folder = h("input", { type: "text", id: "folder", maxlength: "100" });
  const place = h("p", { class: "soft", role: "status", id: "folder-state" });
  const resume = h("p", { class: "verdict", hidden: true });
  const operator = h("input", { type: "text", id: "operator", maxlength: "200", autocomplete: "off" });
  const specimen = h("input", { type: "text", id: "specimen", maxlength: "200", autocomplete: "off" });
  const note = h("input", { type: "text", id: "run-note", maxlength: "2000", autocomplete: "off" });
  const reference = h("select", { id: "reference" });
  const tolerance = h("input", { type: "number", min: "1", max: "100", step: "any", value: "15", id: "tolerance" });
  const go = h("button", { type: "submit", class: "main", id: "start-now" }, "Start");
  const cancel = button("Cancel", () => element.close(), { id: "start-cancel" });
  const form = h("form", { method: "dialog" }, h("h2", {}, "Start a campaign"),
    h("div", { class: "fields" }, field("Campaign", which), field("Folder of its records", folder)), place, resume,
    h("div", { class: "fields" }, field("Operator", operator, "kept with every record"), field("Specimen", specimen, "which damper; kept with every record"), field("Note", note)),
    h("div", { class: "fields" }, field("Compare with", reference, "each cycle against an earlier run; a report is written at the end"), field("Tolerance in %", tolerance)),
    h("div", { class: "row" }, go, cancel));
  const element = h("dialog", { class: "ask", id: "start-dialog", "aria-label": "Start a campaign" }, form);
  const made = { element, open, running: false, add: (name) => which.append(h("option", { value: name }, name)) };
  element.addEventListener("keydown", (event) => event.key === "Escape" && element.close());
  element.addEventListener("close", () => opener?.focus());
  let opener = null;

  let all = [];
  /** An interrupted run of the chosen campaign can be gone on with, in place of a new one. */
  function offer() {
    const open = made.running ? undefined : all.find((run) => run.state === "interrupted" && run.campaign === which.value);
    resume.hidden = !open || folder.value === open.name;
    if (!open) return;
    resume.replaceChildren(`${open.name} was interrupted, ${open.complete} of ${open.tests} tests are complete. `, button("Continue it", () => {
      edited = true;
      folder.value = open.name;
      attempt(check).then(offer);
    }, { id: "continue-it" }));
  }

  let turn = 0;
  async function check() {
    const mine = ++turn;
    const text = folder.value.trim();
    if (!text) return;
    let words;
    let state = "";
    try {
      ({ state, words } = await get(`bench/folder?${asQuery({ campaign: which.value, folder: text })}`));
    } catch (problem) {
      words = problem.message;
      state = "refused";
    }
    if (mine !== turn) return;
    place.textContent = `Folder: ${words}.`;
    place.className = ["complete", "foreign", "running", "refused"].includes(state) ? "verdict bad" : state === "interrupted" ? "verdict" : "soft";
    go.disabled = !["new", "interrupted"].includes(state);
  }

  let timer = 0;
  let edited = false;
  folder.addEventListener("input", () => {
    clearTimeout(timer);
    edited = true;
    go.disabled = true;
    timer = setTimeout(check, 300);
  });
  which.addEventListener("change", () => {
    edited = false;
    attempt(suggest).then(offer);
  });

  async function suggest() {
    const { folder: name } = await get(`bench/suggested?${asQuery({ campaign: which.value })}`);
    if (edited) return; // what somebody has typed meanwhile stays
    folder.value = name;
    await check();
  }

  async function open(campaign, run = null) {
    which.value = campaign;
    const before = remembered.read("last") ?? {};
    operator.value = worker.name;
    specimen.value = run ? "" : (before.specimen ?? bench.state?.rig?.specimen ?? "");
    all = await get("bench/runs");
    reference.replaceChildren(h("option", { value: "" }, "nothing"), ...all.filter((run) => run.state === "complete").map((run) => h("option", { value: run.name }, `${run.name}, ${run.tests} tests`)));
    form.querySelector("h2").textContent = made.running ? "Queue a campaign" : run ? "Continue a campaign" : "Start a campaign";
    go.textContent = made.running ? "Add to the queue" : run ? "Continue" : "Start";
    go.disabled = true;
    folder.value = "";
    opener = document.activeElement;
    edited = false;
    element.show(); // and not as a modal one: abort, in the head, can be pressed meanwhile
    operator.focus();
    if (run) {
      folder.value = run.name;
      await check();
    } else await suggest();
    offer();
  }

  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const about = { operator: operator.value.trim(), specimen: specimen.value.trim(), note: note.value.trim() };
    remembered.keep("last", { specimen: about.specimen });
    worker.name = about.operator || worker.name;
    const accepted = await ask(made.running ? "queue" : "start", { campaign: which.value, folder: folder.value.trim(), ...about,
      reference: reference.value, tolerance: Number(tolerance.value) / 100 });
    if (accepted) element.close();
  });
  return made;
}
