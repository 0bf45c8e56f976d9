// The first page: the rig, the last runs, the last jobs, and the room on the disk.
import { get } from "./api.js";
import { bench, listen } from "./bench.js";
import { button, h, number, section } from "./dom.js";
import { originBadge } from "./origin.js";
import { certificate, clockOf } from "./runs.js";
import { table } from "./table.js";

const RUNS = 8;
const JOBS = 6;

export async function dashboard(root, pages) {
  const rig = h("div", { class: "card" });
  const disk = h("div", { class: "card" });
  const runs = h("div", {});
  const jobs = h("div", {});
  root.append(h("h1", {}, "dampyr"), h("div", { class: "cards" }, rig, disk), runs, jobs,
    section("Pages", h("ul", { class: "doors" }, pages.map((page) => h("li", {}, h("a", { href: `#/${page.name}` }, page.title))))));
  const end = pages.some((page) => page.name === "bench") ? listen(() => rigCard(rig)) : () => {};
  rigCard(rig);
  const [listed, all, room] = await Promise.all([get("bench/runs"), get("jobs"), get("bench/disk")]);
  const share = 1 - room.free / room.total;
  disk.replaceChildren(h("h2", {}, "Disk"), h("p", {}, `${size(room.free)} of ${size(room.total)} free`),
    h("meter", { min: "0", max: "1", high: "0.9", value: String(share), "aria-label": "Used part of the disk" }), h("p", { class: "soft" }, `data folder: ${room.folder}`));
  runs.replaceChildren(section("Last runs", table({ caption: "The latest first", empty: h("span", {}, "No campaign was run into this data folder yet: ", h("a", { href: "#/bench" }, "begin on the bench"), "."),
    columns: [{ name: "folder" }, { name: "campaign" }, { name: "state" }, { name: "tests" }, { name: "operator" }, { name: "last event, UTC" }, { name: "", words: "certificate", plain: true }],
    rows: listed.slice(0, RUNS).map((run) => [h("span", { class: "named" }, h("a", { href: run.state === "complete" ? "#/records" : "#/bench" }, run.name), originBadge(run.origin)), run.campaign, badge(run.state), `${run.complete} of ${run.tests}`,
      run.operator || "–", run.time.slice(0, 16).replace("T", " "), run.state === "complete" ? button("Certificate", () => certificate(run.name), { "aria-label": `Certificate of ${run.name}` }) : ""]) })));
  jobs.replaceChildren(section("Last jobs", table({ caption: "Fits and simulations", empty: "No job was started yet.",
    columns: [{ name: "job" }, { name: "state" }, { name: "started" }, { name: "took", unit: "s" }],
    rows: all.slice(0, JOBS).map((job) => [job.title, badge(job.state), { key: job.made, show: local(job.made) },
      job.ended ? { key: job.ended - job.made, show: (job.ended - job.made).toFixed(1) } : null]) })));
  return end;
}

function rigCard(place) {
  const state = bench.connected ? bench.state : null;
  const rows = [];
  if (!state) rows.push(h("p", { class: "soft" }, "The bench does not answer yet."));
  else if (!state.rig) rows.push(h("p", {}, "No rig is connected."));
  else {
    rows.push(h("p", {}, `${state.rig.name}${state.rig.simulated ? ", simulated" : ""}: `, h("span", { class: `badge ${state.armed ? "bad" : ""}` }, state.phase)));
    if (state.live && (state.live_age ?? 0) < 2) rows.push(h("p", { class: "soft" }, `${state.live.force.toFixed(0).replace("-", "−")} N, damper ${state.live.temperature.toFixed(1)} °C`));
    if (state.run?.outcome === "running") rows.push(h("p", {}, `${state.run.name}: ${state.run.done} of ${state.run.tests} tests, ${clockOf(state.run.time_left)} left`));
    else if (state.run) rows.push(h("p", {}, `${state.run.name}: ${state.run.outcome}`));
  }
  const alarms = state?.alarms.filter((alarm) => alarm.active || !alarm.acknowledged).length ?? 0;
  if (alarms) rows.push(h("p", { class: "verdict bad" }, `${number(alarms)} alarm${alarms > 1 ? "s" : ""} to be acknowledged`));
  place.replaceChildren(h("h2", {}, "Rig"), ...rows, h("p", {}, h("a", { href: "#/bench" }, "to the bench")));
}

const KIND = { complete: "good", done: "good", failed: "bad", interrupted: "bad", unreadable: "bad", cancelled: "" };
const badge = (state) => h("span", { class: `badge ${KIND[state] ?? ""}` }, state);
const size = (bytes) => (bytes >= 1e12 ? `${(bytes / 1e12).toFixed(2)} TB` : bytes >= 1e9 ? `${(bytes / 1e9).toFixed(1)} GB` : `${(bytes / 1e6).toFixed(0)} MB`);
const local = (seconds) => new Date(seconds * 1000).toLocaleString("sv").slice(0, 16);
