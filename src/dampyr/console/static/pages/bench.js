// The bench: a rig, its live readings, and who has control.
import { get, query as asQuery } from "../lib/api.js";
import { ask, bench, jog, listen } from "../lib/bench.js";
import { button, choice, field, h, number, section, tick } from "../lib/dom.js";
import { live } from "../lib/live.js";
import { table } from "../lib/table.js";

const PUSH = 100; // ms between two requests of a jog that is held
const WORDS = { watching: "watching", acted: "tripped", off: "not watching" };

export async function show(root, query) {
  const [rigs, files] = await Promise.all([get("bench/rigs"), get("campaigns/files")]);
  const charts = live();
  const parts = { ...head(), ...connecting(rigs), ...moving(), ...calibrating(), ...running(files, query.get("campaign")) };
  root.append(
    parts.control, parts.rings, parts.readings,
    h("div", { class: "split" },
      h("div", { class: "side" }, parts.rig, parts.campaign, parts.motion, parts.cell),
      h("div", {}, charts.element, parts.tests)),
  );
  const take = (frame) => {
    if (frame?.strips) charts.take(frame.strips);
    if (frame === null || frame.state || parts.held !== bench.holds) {
      parts.held = bench.holds;
      refresh(parts, bench.connected ? bench.state : null);
    }
  };
  charts.take(await get(`bench/strips?${asQuery({ seconds: 12 })}`));
  const end = listen(take);
  refresh(parts, bench.state);
  return () => {
    jog(0);
    end();
    charts.clear();
  };
}

function head() {
  const who = h("span", {});
  const take = button("Take control", () => ask("control"), { id: "take" });
  const note = h("p", { class: "verdict", role: "status", id: "note" });
  const rings = h("ul", { class: "rings", "aria-label": "The three safety layers" });
  return { control: h("div", {}, h("div", { class: "row" }, who, take), note), who, take, note, rings };
}

function connecting(rigs) {
  const which = choice(rigs.map((one) => [one.name, one.name ? `${one.name}: ${one.title}` : one.title]), { id: "rig" });
  const simulate = tick("simulated", { id: "simulate", checked: true });
  const box = simulate.querySelector("input");
  which.addEventListener("change", () => { box.checked = !rigs.find((one) => one.name === which.value).wired; });
  const go = button("Connect", () => ask("connect", { rig: which.value, simulate: box.checked }), { class: "main", id: "connect" });
  const leave = button("Disconnect", () => ask("disconnect"), { id: "disconnect" });
  const arm = button("Arm", () => ask("arm"), { class: "main", id: "arm" });
  const disarm = button("Disarm", () => ask("disarm"), { id: "disarm" });
  const identity = h("p", { class: "soft" });
  const form = h("div", {}, field("Rig", which), h("div", { class: "row" }, simulate, go));
  const on = h("div", {}, identity, h("div", { class: "row" }, arm, disarm, leave));
  return { rig: section("Rig", form, on), connectForm: form, connected: on, identity, go, leave, arm, disarm };
}

function moving() {
  const speed = h("input", { type: "number", min: "0.1", max: "10", step: "0.1", value: "2", id: "speed" });
  const away = held("← compress", -1, speed, "jog-in");
  const out = held("extend →", 1, speed, "jog-out");
  const home = button("Home by the index", () => ask("home"), { id: "home" });
  const here = button("Set the centre here", () => ask("home", { here: true }), { id: "here" });
  const place = section("Motion", h("div", { class: "row" }, home, here), field("Jog at mm/s", speed, "moves while a button is held"),
    h("div", { class: "row" }, away, out));
  return { motion: place, home, here, away, out, speed };
}

/** A hold-to-run button: while it is held by pointer or key, its request repeats; when it is released or hidden, the motion stops. */
function held(words, sign, speed, id) {
  let timer = 0;
  const push = () => jog((sign * Number(speed.value)) / 1000);
  const start = (event) => {
    event.preventDefault();
    if (timer || knob.disabled) return;
    knob.focus();
    push();
    timer = setInterval(() => (knob.isConnected ? push() : stop()), PUSH);
  };
  const stop = () => {
    if (!timer) return;
    clearInterval(timer);
    timer = 0;
    jog(0);
  };
  const knob = h("button", { type: "button", id, onpointerdown: start, onpointerup: stop, onpointercancel: stop, onpointerleave: stop, onblur: stop,
    onkeydown: (event) => { if ([" ", "Enter"].includes(event.key) && !event.repeat) start(event); },
    onkeyup: stop }, words);
  document.addEventListener("visibilitychange", stop);
  return knob;
}

function calibrating() {
  const zero = button("Zero", () => ask("zero"), { id: "zero" });
  const begin = button("Calibrate…", () => ask("calibration"), { id: "calibrate" });
  const message = h("p", { class: "soft" });
  const load = h("input", { type: "text", value: "20 kg", id: "load", maxlength: "40" });
  const shunt = h("input", { type: "text", value: "100 kohm", id: "shunt", maxlength: "40" });
  const step = (name, from) => () => ask("calibration/step", { step: name, load: from?.value ?? "" });
  const unloaded = button("Read without load", step("unloaded"), { id: "read-unloaded" });
  const loaded = button("Read under the load", step("loaded", load), { id: "read-loaded" });
  const shunted = button("Read with the shunt", step("shunted", shunt), { id: "read-shunted" });
  const reading = h("p", { id: "calibrated" });
  const keep = button("Save", () => ask("calibration/end", { keep: true }), { class: "main", id: "keep" });
  const forget = button("Discard", () => ask("calibration/end", { keep: false }), { id: "forget" });
  const steps = h("ol", { class: "steps", id: "steps" },
    h("li", {}, "Take all load off the cell.", h("div", { class: "row" }, unloaded)),
    h("li", {}, "Load it, or switch a shunt in.", h("div", { class: "fields" }, field("Load", load), field("Shunt", shunt)), h("div", { class: "row" }, loaded, shunted)),
    h("li", {}, "Check the result.", reading, h("div", { class: "row" }, keep, forget)));
  return { cell: section("Load cell", message, h("div", { class: "row" }, zero, begin), steps), zero, begin, scale: message, steps, unloaded, loaded, shunted, reading, keep, forget };
}

function running(files, chosen) {
  const which = choice(files, { id: "campaign", value: chosen ?? files[0] ?? "" });
  const folder = h("input", { type: "text", id: "folder", maxlength: "100" });
  const name = () => { folder.value = which.value; };
  which.addEventListener("change", name);
  name();
  const start = button("Start", () => ask("start", { campaign: which.value, folder: folder.value }), { class: "main", id: "start" });
  const pause = button("Pause", () => ask("pause"), { id: "pause" });
  const resume = button("Resume", () => ask("resume"), { class: "main", id: "resume" });
  const stop = button("Stop", () => ask("stop"), { id: "stop" });
  const bar = h("progress", { max: "1", value: "0", "aria-label": "Progress of the campaign" });
  const facts = h("dl", { class: "facts", id: "run" });
  const form = h("div", {}, field("Campaign", which), field("Folder of its records", folder, "a folder with a part of this campaign is continued"),
    h("div", { class: "row" }, start));
  const none = h("p", { class: "soft" }, "No campaign is saved yet: ", h("a", { href: "#/campaigns" }, "make one"), ".");
  const place = section("Campaign", files.length ? form : none, h("div", { class: "row" }, pause, resume, stop), bar, facts);
  const tests = h("div", {});
  return { campaign: place, start, pause, resume, stop, bar, facts, runForm: form, tests, readings: h("dl", { class: "readings", id: "readings" }), done: "" };
}

function refresh(parts, state) {
  if (!state) {
    parts.who.textContent = "The console does not answer.";
    for (const one of Object.values(parts)) if (one instanceof HTMLButtonElement) one.disabled = true;
    return;
  }
  const { phase, rig, run } = state;
  const mine = bench.holds;
  parts.who.textContent = mine ? `This page holds control${others(state)}.` : state.holder ? `${state.holder} holds control; this page only watches.` : "Nobody holds control.";
  parts.take.hidden = mine;
  parts.note.textContent = state.note;
  parts.note.hidden = !state.note;
  parts.note.className = `verdict ${state.fault ? "bad" : ""}`;
  parts.rings.replaceChildren(...state.rings.map(ring));
  allow(parts, state, mine);
  parts.connectForm.hidden = Boolean(rig);
  parts.connected.hidden = !rig;
  if (rig) {
    parts.identity.textContent = `${rig.name}${rig.simulated ? ", simulated" : ""}: ${rig.identity}, ${number(rig.rate)} samples/s`;
    parts.scale.textContent = `${number(rig.scale)} N/V, no force at ${number(rig.zero)} V (${rig.calibrated})`;
    parts.speed.max = String(rig.jog_speed * 1000);
    if (Number(parts.speed.value) > rig.jog_speed * 1000) parts.speed.value = parts.speed.max;
  }
  for (const one of [parts.motion, parts.cell, parts.readings]) one.hidden = !rig;
  guided(parts, state.guided);
  readings(parts, state);
  progress(parts, run, phase);
}

const others = (state) => (state.clients > 1 ? `; ${state.clients - 1} more watch` : "");

function ring(one) {
  const kind = one.state === "acted" ? "bad" : one.state === "watching" ? "good" : "";
  return h("li", { class: kind }, h("strong", {}, one.name), h("span", { class: `badge ${kind}` }, WORDS[one.state]), h("span", { class: "soft" }, one.words));
}

function allow(parts, { phase, run }, mine) {
  const at = (...phases) => !(mine && phases.includes(phase));
  parts.go.disabled = at("disconnected");
  parts.leave.disabled = at("idle", "armed");
  parts.arm.disabled = at("idle");
  parts.disarm.disabled = at("armed", "homing", "measuring");
  for (const one of [parts.home, parts.here, parts.away, parts.out, parts.zero]) one.disabled = at("armed");
  for (const one of [parts.begin, parts.unloaded, parts.loaded, parts.shunted, parts.keep, parts.forget]) one.disabled = at("idle");
  parts.start.disabled = at("idle", "armed");
  for (const one of [parts.pause, parts.resume, parts.stop]) one.disabled = at("campaign");
  parts.pause.hidden = phase !== "campaign" || run?.paused;
  parts.resume.hidden = phase !== "campaign" || !run?.paused;
  parts.stop.hidden = phase !== "campaign";
  parts.runForm.hidden = phase === "campaign";
}

function guided(parts, reading) {
  parts.steps.hidden = !reading;
  parts.begin.hidden = Boolean(reading);
  if (!reading) return;
  parts.loaded.disabled ||= !reading.zeroed;
  parts.shunted.disabled ||= !reading.zeroed;
  parts.keep.disabled ||= !reading.zeroed;
  const zero = reading.zeroed ? `No force at ${number(reading.zero)} V, noise ${number(reading.noise, 2)} N rms. ` : "No reading yet.";
  parts.reading.textContent = zero + (reading.scaled ? `Scale ${number(reading.scale, 5)} N/V. ${reading.doubt}` : "");
}

function readings(parts, state) {
  const { live, homed } = state;
  const rows = live === null ? [] : [["position", homed ? (live.position * 1e3).toFixed(2).replace("-", "−") : "not homed", homed ? "mm" : ""], ["force", live.force.toFixed(0).replace("-", "−"), "N"],
    ["coil", number(live.voltage, 3), "V"], ["damper", live.temperature.toFixed(1), "°C"]];
  parts.readings.replaceChildren(...rows.map(([name, value, unit]) => h("div", {}, h("dt", {}, name), h("dd", {}, value, h("small", {}, ` ${unit}`)))));
}

function progress(parts, run, phase) {
  parts.bar.hidden = !run;
  parts.facts.hidden = !run;
  if (!run) return;
  const share = run.outcome === "complete" ? 1 : (run.done + run.fraction * (run.phase === "testing")) / Math.max(run.tests, 1);
  parts.bar.value = Math.min(1, share);
  const rows = [["campaign", run.name], ["state", run.outcome === "running" ? run.phase : run.outcome], ["tests", `${run.done} of ${run.tests} complete`]];
  if (phase === "campaign") {
    rows.push(["test", run.test || "–"], ["cycle", `${number(run.cycles)} of ${number(run.planned_cycles)}`], ["stroke", `${number(run.stroke * 1e3, 3)} mm`],
      ["time left", clock(run.time_left)]);
  }
  parts.facts.replaceChildren(...rows.flatMap(([name, value]) => [h("dt", {}, name), h("dd", {}, value)]));
  const now = `${run.folder} ${run.done} ${run.outcome} ${run.test} ${run.phase}`;
  if (parts.done !== now) {
    parts.done = now;
    tests(parts, run.folder);
  }
}

const clock = (seconds) => `${Math.floor(seconds / 60)}:${String(Math.floor(seconds % 60)).padStart(2, "0")} min`;

async function tests(parts, folder) {
  let states;
  try {
    states = await get(`bench/tests?${asQuery({ folder })}`);
  } catch {
    return; // its journal is not there yet
  }
  const rows = states.map((one) => [one.name, one.state, one.attempt, one.reason]);
  parts.tests.replaceChildren(section("Tests", table({ caption: `The tests of ${folder}`, columns: [{ name: "test" }, { name: "state" }, { name: "try" }, { name: "reason" }], rows })));
}
