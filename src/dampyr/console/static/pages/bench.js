// The bench: a rig, its live readings, and who has control.
import { get, query as asQuery } from "../lib/api.js";
import { alarmBanner, alarmsAndLog, announcer } from "../lib/alarms.js";
import { age, ask, bench, jog, listen, operator } from "../lib/bench.js";
import { button, choice, field, h, number, section, tick } from "../lib/dom.js";
import { HELD, live } from "../lib/live.js";
import { readings, strokeBar } from "../lib/readings.js";
import { campaignPanel, enable } from "../lib/runs.js";

const PUSH = 100; // ms between two requests of a jog that is held
const LOOK = 250; // ms between two looks at the age of what is shown
const OLD = 1; // s after which a value is old
const WORDS = { watching: "watching", acted: "tripped", off: "not watching" };

let jogs = false;
const push = (speed) => {
  jogs = speed !== 0;
  jog(speed);
};

export async function show(root, query) {
  const [rigs, files, history] = await Promise.all([get("bench/rigs"), get("campaigns/files"), get(`bench/strips?${asQuery({ seconds: HELD })}`)]);
  const charts = live();
  const campaign = await campaignPanel(files, query.get("campaign"));
  const log = alarmsAndLog();
  const parts = { ...head(), ...connecting(rigs.filter((rig) => !rig.problem)), ...moving(), ...byHand(), ...calibrating(), campaign, log, banner: alarmBanner(), announcer: announcer(), tiles: readings(), bar: strokeBar(), charts };
  root.classList.add("bench");
  root.append(
    h("div", { class: "bench-head" }, parts.control, parts.rings), parts.origin, parts.lost, parts.banner.element,
    h("div", { class: "panel" },
      h("div", { class: "side" }, parts.rig, parts.motion, parts.manual, parts.cell, parts.announcer.element),
      h("div", { class: "middle" }, parts.hint, parts.tiles.element, parts.bar.element, charts.element, campaign.tests),
      h("div", { class: "side last" }, campaign.element)),
    log.element,
  );
  const take = (frame) => {
    if (frame?.strips) charts.take(frame.strips);
    if (frame === null || frame.state || parts.held !== bench.holds) {
      parts.held = bench.holds;
      refresh(parts);
    }
  };
  charts.take(history);
  const end = listen(take);
  const timer = setInterval(() => refreshAge(parts), LOOK);
  refresh(parts);
  log.refresh().catch(() => {});
  campaign.refresh().catch(() => {});
  return () => {
    if (jogs) push(0);
    clearInterval(timer);
    end();
    charts.clear();
  };
}

function head() {
  const who = h("span", {});
  const take = button("Take control", () => ask("control"), { id: "take" });
  const name = h("input", { type: "text", id: "who", maxlength: "200", autocomplete: "off", value: operator.name, placeholder: "your name, for the log" });
  name.addEventListener("change", () => { operator.name = name.value.trim(); });
  const named = () => { if (document.activeElement !== name) name.value = operator.name; };
  const note = h("p", { class: "verdict", role: "status", id: "note" });
  const rings = h("ul", { class: "rings", "aria-label": "The three safety layers" });
  const origin = h("p", { class: "verdict bad origin", role: "status", hidden: true });
  const lost = h("p", { class: "verdict bad lost", role: "alert", id: "lost", hidden: true });
  const hint = h("p", { class: "blank hint" }, "Connect a rig: its readings, its place in the stroke and live charts are shown here, armed or not.");
  return { hint, control: h("div", { class: "control" }, h("div", { class: "row" }, who, take), h("div", { class: "operator" }, h("label", { for: "who" }, "Operator"), name), note), named, who, take, note, rings, lost, origin };
}

function connecting(rigs) {
  const which = choice(rigs.map((rig) => [rig.name, rig.name ? `${rig.name}: ${rig.title}` : rig.title]), { id: "rig" });
  const simulate = tick("simulated", { id: "simulate", checked: true });
  const box = simulate.querySelector("input");
  which.addEventListener("change", () => { box.checked = !rigs.find((rig) => rig.name === which.value).wired; });
  const go = button("Connect", () => ask("connect", { rig: which.value, simulate: box.checked }), { class: "main", id: "connect" });
  const leave = button("Disconnect", () => ask("disconnect"), { id: "disconnect" });
  const arm = button("Arm", () => ask("arm"), { class: "energy", id: "arm" });
  const disarm = button("Disarm", () => ask("disarm"), { id: "disarm" });
  const identity = h("p", { class: "soft identity" });
  const waiting = h("div", { class: "waiting", role: "status" }, h("progress", { "aria-label": "Connecting" }), h("span", {}, "Connecting: the instruments are opened; this takes some seconds"));
  const form = h("div", {}, field("Rig", which), h("div", { class: "row" }, simulate, go));
  const on = h("div", {}, h("div", { class: "row" }, arm, disarm, leave), identity);
  return { rig: section("Rig", form, waiting, on), connectForm: form, connected: on, waiting, identity, go, leave, arm, disarm };
}

function moving() {
  const speed = h("input", { type: "number", min: "0.1", max: "10", step: "0.1", value: "2", id: "speed" });
  const away = held("← in", -1, speed, "jog-in");
  const out = held("out →", 1, speed, "jog-out");
  const home = button("Home by the index", () => ask("home"), { id: "home" });
  const here = button("Set the centre here", () => ask("home", { here: true }), { id: "here" });
  const target = h("input", { type: "number", step: "any", value: "0", id: "target" });
  const go = button("Go", () => ask("go", { position: Number(target.value) / 1000 }), { id: "go" });
  const halt = button("Stop", () => ask("halt"), { id: "halt", "aria-label": "Stop the motion" });
  const place = section("Motion", h("div", { class: "row" }, home, here),
    h("div", { class: "row" }, field("Jog [mm/s]", speed), field("Go to [mm]", target), go), h("div", { class: "row" }, away, out, halt));
  return { motion: place, home, here, away, out, speed, target, goTo: go, halt };
}

function byHand() {
  const input = (id, value, more = {}) => h("input", { type: "number", step: "any", min: "0", value, id, ...more });
  const amplitude = input("sine-amplitude", "4");
  const frequency = input("sine-frequency", "0.5");
  const voltage = input("sine-voltage", "0");
  const cycles = input("sine-cycles", "5", { step: "1", min: "1", max: "1000" });
  const sine = button("Move", () => ask("sine", { amplitude: Number(amplitude.value) / 1000, frequency: Number(frequency.value), voltage: Number(voltage.value), cycles: Number(cycles.value) }), { id: "sine" });
  const volts = input("coil-voltage", "1");
  const seconds = input("coil-seconds", "10", { max: "120" });
  const coil = button("Energise", () => ask("coil", { voltage: Number(volts.value), seconds: Number(seconds.value) }), { id: "coil" });
  const manual = h("details", { class: "manual" }, h("summary", {}, "Sine and coil by hand"),
    h("p", { class: "soft" }, "Checked as a test of a campaign is; nothing is recorded."),
    h("div", { class: "fields" }, field("Amplitude [mm]", amplitude), field("Frequency [Hz]", frequency), field("Coil [V]", voltage), field("Cycles", cycles)),
    h("div", { class: "row" }, sine),
    h("div", { class: "fields" }, field("Coil at rest [V]", volts), field("for [s]", seconds)), h("div", { class: "row" }, coil));
  return { manual, sine, coil };
}

/** A hold-to-run button: while it is held by pointer or key, its request repeats; when it is released or hidden, the motion stops. */
function held(words, sign, speed, id) {
  let timer = 0;
  const again = () => push((sign * Number(speed.value)) / 1000);
  const start = (event) => {
    event.preventDefault();
    if (timer || knob.disabled) return;
    knob.focus();
    again();
    timer = setInterval(() => (knob.isConnected ? again() : stop()), PUSH);
  };
  const stop = () => {
    if (!timer) return;
    clearInterval(timer);
    timer = 0;
    push(0);
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
  const peaks = button("Reset peaks", () => ask("extremes"), { id: "reset-peaks" });
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
  return { cell: section("Load cell", h("div", { class: "row" }, zero, begin, peaks), message, steps), zero, begin, peaks, scale: message, steps, unloaded, loaded, shunted, reading, keep, forget };
}

const lost = () => !bench.connected || age() > OLD;

/** Grey what is old, within a quarter of a second after it is. */
function refreshAge(parts) {
  const state = bench.state;
  const gone = lost();
  const back = parts.wasLost && !gone;
  parts.wasLost = gone;
  parts.lost.hidden = !gone;
  if (gone) {
    parts.lost.textContent = `The console does not answer. ${state?.live ? `What is shown is ${Math.max(1, Math.round(age()))} s old` : "Nothing is read"}; the rig's firmware stops it by itself when its host is silent.`;
    disableAll(parts);
  } else if (back) refresh(parts);
  const seconds = state?.live ? (state.live_age ?? 0) + age() : null;
  const stale = gone || seconds === null || seconds > OLD;
  for (const element of [parts.charts.element, parts.rings]) element.classList.toggle("stale", gone || (element === parts.charts.element && stale));
  if (state) {
    parts.tiles.show(state, gone ? Math.max(age(), OLD + 0.1) : seconds);
    parts.bar.show(state, stale);
  }
}

function disableAll(parts) {
  parts.who.textContent = "The console does not answer.";
  for (const part of Object.values(parts)) if (part instanceof HTMLButtonElement) part.disabled = true;
}

function refresh(parts) {
  const state = bench.connected ? bench.state : null;
  if (!state) {
    refreshAge(parts);
    disableAll(parts);
    return;
  }
  const { phase, rig } = state;
  const mine = bench.holds;
  parts.who.textContent = mine ? `This page holds control${others(state)}.` : state.holder ? `${state.holder} holds control; this page only watches.` : "Nobody holds control.";
  parts.named();
  parts.take.hidden = mine;
  parts.take.disabled = false;
  const note = [state.note, state.trouble].filter(Boolean).join("; ");
  if (parts.note.textContent !== note) parts.note.textContent = note;
  parts.note.hidden = !note;
  parts.note.className = `verdict ${state.fault ? "bad" : ""}`;
  parts.rings.replaceChildren(...state.rings.map(ring));
  const focused = document.activeElement;
  allow(parts, state, mine);
  parts.connectForm.hidden = Boolean(rig) || phase === "connecting";
  parts.waiting.hidden = phase !== "connecting";
  parts.connected.hidden = !rig;
  parts.origin.hidden = !rig?.notice;
  if (parts.origin.textContent !== (rig?.notice ?? "")) parts.origin.textContent = rig?.notice ?? "";
  if (rig) {
    parts.identity.textContent = `${rig.name}: ${rig.identity}, ${number(rig.rate)} samples/s`;
    parts.scale.textContent = `${number(rig.scale)} N/V, no force at ${number(rig.zero)} V (${rig.calibrated})`;
    parts.speed.max = String(rig.jog_speed * 1000);
    if (Number(parts.speed.value) > rig.jog_speed * 1000) parts.speed.value = parts.speed.max;
    parts.charts.limits(rig.limits, rig.velocity_lag);
  }
  for (const control of [parts.motion, parts.manual, parts.cell, parts.tiles.element, parts.charts.element]) control.hidden = !rig;
  parts.hint.hidden = Boolean(rig);
  guided(parts, state.guided);
  parts.campaign.show(state, mine);
  parts.banner.show(state.alarms, mine);
  parts.log.show(state, mine);
  parts.announcer.look(state);
  overlay(parts, state);
  followFocus(parts, focused);
  if (parts.seen !== state.events) {
    parts.seen = state.events;
    parts.log.refresh().catch(() => {});
  }
  refreshAge(parts);
}

/** Draw the reference of the test under way behind the live loops. */
function overlay(parts, state) {
  const now = state.comparison && state.phase === "campaign" ? `${state.comparison.folder} ${state.comparison.test} ${state.comparison.reason}` : "";
  if (parts.overlaid === now) return;
  parts.overlaid = now;
  if (!now) parts.charts.overlay(null);
  else get("bench/reference").then((loop) => parts.charts.overlay(loop)).catch(() => {});
}

/** Who has pressed a button that is gone now finds the focus on the one that comes next, once that can be pressed. */
function followFocus(parts, focused) {
  const run = parts.campaign.element;
  const next = { connect: () => parts.arm, disconnect: () => parts.go, pause: () => run.querySelector("#resume"), resume: () => run.querySelector("#pause") };
  if (focused instanceof HTMLButtonElement && next[focused.id] && focused.offsetParent === null) parts.heir = next[focused.id]();
  if (!parts.heir || parts.heir.offsetParent === null || parts.heir.disabled) return;
  if (document.activeElement === document.body || document.activeElement.offsetParent === null) parts.heir.focus();
  parts.heir = null;
}

const others = (state) => (state.clients > 1 ? `; ${state.clients - 1} more watch` : "");

function ring(layer) {
  const kind = layer.state === "acted" ? "bad" : layer.state === "watching" ? "good" : "";
  return h("li", { class: kind }, h("strong", {}, layer.name), h("span", { class: `badge ${kind}` }, WORDS[layer.state]), h("span", { class: "soft" }, layer.words));
}

function allow(parts, { phase, homed }, mine) {
  const at = (knob, ...phases) => enable(knob, mine && phases.includes(phase));
  at(parts.go, "disconnected");
  at(parts.leave, "idle", "armed");
  at(parts.arm, "idle");
  at(parts.disarm, "armed", "homing", "measuring", "moving");
  for (const control of [parts.home, parts.here, parts.zero, parts.coil]) at(control, "armed");
  for (const control of [parts.away, parts.out]) control.disabled = !(mine && phase === "armed");
  for (const control of [parts.goTo, parts.sine]) enable(control, mine && phase === "armed" && homed);
  at(parts.halt, "moving", "homing");
  for (const control of [parts.begin, parts.unloaded, parts.loaded, parts.shunted, parts.keep, parts.forget]) at(control, "idle");
  enable(parts.peaks, mine);
}

function guided(parts, reading) {
  parts.steps.hidden = !reading;
  parts.begin.hidden = Boolean(reading);
  if (!reading) return;
  for (const control of [parts.loaded, parts.shunted, parts.keep]) if (!reading.zeroed) enable(control, false);
  const zero = reading.zeroed ? `No force at ${number(reading.zero)} V, noise ${number(reading.noise, 2)} N rms. ` : "No reading yet.";
  parts.reading.textContent = zero + (reading.scaled ? `Scale ${number(reading.scale, 5)} N/V. ${reading.doubt}` : "");
}
