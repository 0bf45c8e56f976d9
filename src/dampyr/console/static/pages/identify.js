// Identify: records and a model, or a card that is there, on the left; the result on the right. Both are jobs that continue
// without the page.
import { setAddress } from "../lib/address.js";
import { download, get, post, query as asQuery } from "../lib/api.js";
import { before } from "../lib/before.js";
import { comparison } from "../lib/comparison.js";
import { cardGroups, groupedOptions } from "../lib/cards.js";
import { charts as drawCharts } from "../lib/chart.js";
import { button, capital, choice, field, h, number, section, symbols, tick, withReach } from "../lib/dom.js";
import { watch } from "../lib/jobs.js";
import { attempt, say } from "../lib/notice.js";
import { optionsForm } from "../lib/options.js";
import { picker } from "../lib/picker.js";
import { servedTable, table } from "../lib/table.js";

const FORCE = { words: "force", unit: "N" };

export async function show(root, query) {
  let stop = null;
  let charts = [];
  const choices = await get("identify/choices");
  const records = await picker(query.getAll("record"), () => {});
  const model = choice(choices.models, { value: "dahl" });
  const ons = choices.add_ons.map((name) => [name, tick(name)]);
  const fitting = form(choices.options);
  const progress = h("div");
  const sheet = h("div");
  const card = h("select", {}, h("option", { value: "" }, "choose …"), groupedOptions(cardGroups(choices.dampers)));
  const scoring = form(choices.score_options);
  const past = before("identify", ["identify", "validate"], reopen);
  root.append(h("div", { class: "split" },
    h("div", { class: "side" },
      records.element,
      h("fieldset", {}, h("legend", {}, "Model"), field("Hysteresis", model),
        h("div", { class: "row", role: "group", "aria-label": "Added to it" }, ons.map(([, box]) => box))),
      h("details", {}, h("summary", {}, "Fit options"), fitting.element),
      h("div", { class: "row" }, button("Identify", () => start(composed()), { class: "main" }), button("Find the best model", () => start(null), { title: "Every model of the catalogue is tried" })),
      h("p", { class: "soft" }, `Find the best model tries all of the catalogue. ${choices.search_time}`),
      h("fieldset", {}, h("legend", {}, "Or a card that is there"), field("Card", card, "What it predicts of the chosen records, none of which is fitted"),
        h("div", { class: "row" }, button("Validate", validate))),
      h("details", {}, h("summary", {}, "Scoring options"), scoring.element),
      past.element),
    h("div", {}, progress, sheet)));
  const open = query.get("job");
  let beside = query.get("with") ?? "";
  if (open) reopen(open);
  else sheet.append(h("p", { class: "blank" }, "Choose records and a model, then identify; or a card, then validate. The result appears here."));

  const composed = () => [model.value, ...ons.filter(([, box]) => box.firstChild.checked).map(([name]) => name)].join(" + ");

  const start = (wanted) => submit("identify/jobs", { model: wanted }, fitting);

  function validate() {
    if (!card.value) return say("Choose a card first.", "bad");
    return submit("identify/validations", { card: card.value }, scoring);
  }

  async function submit(where, what, form) {
    const request = { records: records.chosen(), ...what };
    try {
      Object.assign(request, form.values());
    } catch (problem) {
      return say(problem.message, "bad");
    }
    if (!request.records.length) return say("Choose one record or more first.", "bad");
    const job = await attempt(() => post(where, request));
    if (job) {
      follow(job.id);
      past.look();
    }
  }

  /** A job of before, and the form as it was when it was started. */
  async function reopen(id) {
    follow(id);
    const job = await attempt(() => get(`jobs/${id}`));
    if (!job) return;
    records.choose(job.request.records);
    (job.kind === "validate" ? scoring : fitting).fill(job.request);
    if (job.kind === "validate") card.value = job.request.card;
    else if (job.request.model) {
      const [first, ...added] = job.request.model.split(" + ");
      model.value = first;
      for (const [name, box] of ons) box.firstChild.checked = added.includes(name);
    }
  }

  function follow(id) {
    if (!root.isConnected) return; // the person has left the page; the job continues
    setAddress(root, "identify", { job: id, with: beside || undefined });
    stop?.();
    clear();
    sheet.replaceChildren();
    stop = watch(progress, id, (job) => {
      past.look();
      if (job.state === "done") (job.kind === "validate" ? showValidation : showResult)(job);
    });
  }

  function clear() {
    for (const chart of charts) chart.clear();
    charts = [];
  }

  function showResult(job) {
    const { id, result: r } = job;
    const name = h("input", { type: "text", maxlength: "80", value: r.model.replaceAll(" + ", "-") });
    const keep = async () => {
      const saved = await attempt(() => post(`identify/jobs/${id}/card`, { name: name.value }));
      if (saved) say(`Saved the card ${saved.name}.`);
    };
    const verdict = r.verdict ?? { kind: r.converged ? "" : "bad", words: `The search ${r.reason}.` }; // of jobs of before
    sheet.replaceChildren(
      section(r.model,
        r.notice ? h("p", { class: "verdict bad origin" }, r.notice) : null,
        h("p", { class: `verdict ${verdict.kind}` }, symbols(verdict.words)),
        r.predictions.map((prediction) => h("p", {}, `It predicts ${prediction.records} records that it was not fitted on, by ${prediction.split}, with an L1 of ${number(100 * prediction.mean_l1, 3)} %.`)),
        r.held.map((record) => h("p", {}, record.problem || `Validation record ${record.record}: L1 ${number(100 * record.l1, 3)} %, predicted.`)),
        h("div", { class: "row" }, r.card ? [field("Name of the card", name), button("Save the card", keep, { class: "main" }), Object.entries(choices.exports).map(([kind, words]) =>
          button(`Save as ${words}`, () => attempt(() => download(`identify/jobs/${id}/export?${asQuery({ to: kind })}`))))] : h("span", {}, "There is no damper to save."),
          h("a", { class: "button", href: `/api/identify/jobs/${id}/page`, download: "" }, "Save the whole page")),
        r.warnings_of_fit.length ? h("details", {}, h("summary", {}, "Before you trust the numbers"), h("ul", {}, r.warnings_of_fit.map((warning) => h("li", {}, symbols(warning))))) : null),
      r.data.leaderboard ? board(r.data.leaderboard.entries, r.choice) : "",
      measuredAndModelled(id, r),
      section("Parameters", r.parameters.map((shown) => servedTable(shown, { digits: 4, symbols: true }))),
      section("Goodness of fit by record", servedTable(r.scores, { digits: 3, caption: `From ${number(r.settling, 3)} s after the motion starts, each record's own offset taken` })),
      section("Beside another fit", comparison(job, beside, (other) => ((beside = other), setAddress(root, "identify", { job: id, with: other || undefined })), plot)),
      section("Residuals", r.findings.map((finding) => h("p", {}, `${capital(finding)}.`))),
    );
  }

  function showValidation({ id, result: r }) {
    if (!r.tables) return sheet.replaceChildren(h("a", { class: "button", href: `/api/identify/jobs/${id}/page`, download: "" }, "Save the whole page")); // of an earlier version
    sheet.replaceChildren(
      section(`${r.card}: ${r.model}`,
        r.notice ? h("p", { class: "verdict bad origin" }, r.notice) : null,
        r.verdict.map((words) => h("p", { class: "verdict" }, words)),
        h("div", { class: "row" }, h("a", { class: "button", href: `/api/identify/jobs/${id}/page`, download: "" }, "Save the whole page")),
        r.warnings.length ? h("details", {}, h("summary", {}, "Before you trust the numbers"), h("ul", {}, r.warnings.map((warning) => h("li", {}, warning)))) : null),
      measuredAndModelled(id, r),
      section("Scores", r.tables.map((shown) => servedTable(shown, { caption: [shown.caption, ...shown.notes].join(" "), digits: (name) => (name === "input" ? 5 : 3) }))),
    );
    return undefined;
  }

  function measuredAndModelled(id, r) {
    const plots = h("div");
    const which = choice(r.records, { onchange: draw });
    draw();
    return section("Measured and modelled", field("Record", which), plots);

    async function draw() {
      const record = which.value;
      const lines = await attempt(() => get(`identify/jobs/${id}/curves?${asQuery({ record })}`));
      if (!lines) return;
      clear();
      const series = (over, factor) => [
        { name: r.notice ? r.data.origin.kind : "measured", colour: "muted", width: 2.4, ...scaled(lines[over].measured, factor) }, { name: r.model, colour: "vermillion", ...scaled(lines[over].model, factor) }];
      const pair = (over, unit, factor, height) => ({ label: `Measured and modelled force of ${record} over ${over}`, x: { words: over, unit }, y: FORCE, height, series: series(over, factor) });
      const residual = { label: `Residual force of ${record}`, x: { words: "time", unit: "s" }, y: { words: "residual", unit: "N" }, height: 150, series: [{ name: "measured minus modelled", colour: "blue", ...lines.residual }] };
      plots.replaceChildren(
        plot([pair("time", "s", 1, 260), residual], { linked: true }),
        plot([pair("displacement", "mm", 1e3, 340), pair("velocity", "mm/s", 1e3, 340)], { across: true }));
    }
  }

  function plot(panels, settings) {
    const made = drawCharts(panels, settings);
    charts.push(made);
    return made.element;
  }

  return () => {
    stop?.();
    past.clear();
    clear();
  };
}

/** A form of options that can be filled in anew: `element`, `values()`, `fill(values)`. */
function form(options) {
  const element = h("div");
  let shown;
  const fill = (chosen) => element.replaceChildren((shown = optionsForm(options, chosen)).element);
  fill({});
  return { element, fill, values: () => shown.values() };
}

const scaled = ({ x, y }, factor) => ({ x: x.map((value) => factor * value), y });

function board(entries, words) {
  const percent = (value) => (typeof value === "number" ? 100 * value : value);
  return section("Which model predicts best", words.map((sentence) => h("p", {}, `${capital(sentence)}.`)), table({
    caption: "Every score is of a prediction: 3/4 of the error over records left out, 1/4 over inputs left out",
    columns: [{ name: "model" }, { name: "error ±", unit: "%" }, { name: "L1", unit: "%", digits: 3 }, { name: "relevelled", unit: "%", digits: 3 }, { name: "unseen input", unit: "%", digits: 3 }, { name: "NRMSE", unit: "%", digits: 3 },
      { name: "energy", unit: "%", digits: 3 }, { name: "parameters" }, { name: "building" }],
    rows: entries.map((e) => [e.model, typeof e.error === "number" ? { key: e.error, show: withReach(100 * e.error, percent(e.standard_error)) } : null, percent(e.l1), percent(e.relevelled), percent(e.unseen_input), percent(e.nrmse), percent(e.energy), e.parameters, e.not_for_buildings ? "no" : "yes"]),
  }));
}
