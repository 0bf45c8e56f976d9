// Alarms with acknowledgement, their limits, the log of who did what, and a sound and a notification at the end of a run.
import { get } from "./api.js";
import { ask } from "./bench.js";
import { button, choice, field, h, number, section, tick } from "./dom.js";
import { say } from "./notice.js";
import { READINGS } from "./readings.js";
import { table } from "./table.js";

const SHOWN = 4; // alarms in the banner

/** The banner of alarms that nobody has acknowledged yet, and of those that last. */
export function alarmBanner() {
  const list = h("ul", {});
  const all = button("Acknowledge all", () => ask("alarms/acknowledge"), { id: "acknowledge" });
  const element = h("div", { class: "alarms", role: "alert", hidden: true }, list, all);
  let drawn = "";
  function show(alarms, mine) {
    const open = alarms.filter((alarm) => alarm.active || !alarm.acknowledged);
    const now = JSON.stringify([open, mine]);
    if (now === drawn) return;
    drawn = now;
    element.hidden = !open.length;
    all.hidden = !open.some((alarm) => !alarm.acknowledged);
    all.disabled = !mine;
    list.replaceChildren(...open.slice(0, SHOWN).map((alarm) => h("li", {}, h("strong", {}, alarm.active ? "Alarm" : "Alarm, over"), ` ${clock(alarm.time)}: ${alarm.words}`,
      alarm.acknowledged ? h("span", { class: "soft" }, ` (acknowledged by ${alarm.acknowledged})`) : null)));
    if (open.length > SHOWN) list.append(h("li", { class: "soft" }, `and ${open.length - SHOWN} more, in the list below`));
  }
  return { element, show };
}

export const clock = (time) => time.slice(11, 19);

/** Limits of the readings, every alarm, and the log of events. */
export function alarmsAndLog() {
  const which = choice(Object.entries(READINGS).map(([key, reading]) => [key, `${reading.name} [${reading.unit}]`]), { id: "alarm-reading" });
  const low = h("input", { type: "number", step: "any", id: "alarm-low" });
  const high = h("input", { type: "number", step: "any", id: "alarm-high" });
  const set = button("Set", () => {
    const { factor } = READINGS[which.value];
    const value = (input) => (input.value === "" ? null : Number(input.value) / factor);
    return ask("alarms/limit", { reading: which.value, low: value(low), high: value(high) });
  }, { id: "alarm-set" });
  const limits = h("ul", { class: "plain" });
  const alarms = h("div", {});
  const log = h("div", {});
  const element = section("Alarms and log",
    h("p", { class: "soft" }, "An alarm informs and stops nothing: what stops the rig are its three safety layers. Leave a side empty for no limit there."),
    h("div", { class: "row" }, field("Reading", which), field("below", low), field("above", high), set), limits, alarms, log);
  let drawn = "";
  let latest = "";
  async function show(state, mine) {
    set.disabled = !mine;
    const now = JSON.stringify([state.alarms, state.alarm_limits]);
    if (now !== drawn) {
      drawn = now;
      limits.replaceChildren(...state.alarm_limits.map((limit) => {
        const { name, unit, factor } = READINGS[limit.reading];
        const sides = [limit.low === null ? null : `below ${number(limit.low * factor)} ${unit}`, limit.high === null ? null : `above ${number(limit.high * factor)} ${unit}`];
        return h("li", {}, `Alarm where the ${name} is ${sides.filter(Boolean).join(" or ")} `,
          button("Remove", () => ask("alarms/limit", { reading: limit.reading, low: null, high: null }), { class: "quiet", "aria-label": `Remove the limit of ${name}` }));
      }));
      const rows = state.alarms.map((alarm) => [clock(alarm.time), alarm.words, alarm.active ? "lasts" : "over", alarm.acknowledged || "–"]);
      alarms.replaceChildren(...(rows.length ? [table({ caption: "Alarms of this session", columns: [{ name: "time" }, { name: "alarm" }, { name: "state" }, { name: "acknowledged by" }], rows })] : []));
    }
  }
  async function refresh() {
    const events = await get("bench/events");
    const now = JSON.stringify(events[0] ?? null) + events.length;
    if (now === latest) return;
    latest = now;
    const rows = events.map((entry) => [entry.time.slice(0, 19).replace("T", " "), entry.who, entry.what]);
    log.replaceChildren(table({ caption: "Who did what; all of it is in bench/bench-events.jsonl of the data folder, and what happened during a run in the folder of the run",
      columns: [{ name: "time" }, { name: "who" }, { name: "what" }], rows, empty: "Nothing was done yet." }));
  }
  return { element, show, refresh };
}

/** A tick: a sound and a notification of the browser when a run ends or an alarm comes. */
export function announcer() {
  const made = tick("sound and notification when a run ends or an alarm comes", { id: "announce", checked: stored() });
  const box = made.querySelector("input");
  let sound = null;
  box.addEventListener("change", async () => {
    store(box.checked);
    if (!box.checked) return;
    beep();
    if ("Notification" in globalThis && Notification.permission === "default") await Notification.requestPermission();
    if ("Notification" in globalThis && Notification.permission === "denied") say("this browser shows no notifications of the console; the sound remains");
  });

  function beep() {
    sound ??= new AudioContext();
    for (const [k, pitch] of [660, 880].entries()) {
      const tone = sound.createOscillator();
      const volume = sound.createGain();
      volume.gain.value = 0.1;
      tone.frequency.value = pitch;
      tone.connect(volume).connect(sound.destination);
      tone.start(sound.currentTime + 0.25 * k);
      tone.stop(sound.currentTime + 0.25 * k + 0.2);
    }
  }

  let run = null;
  let alarm = null;
  /** Look for the end of a run and for new alarms. */
  function look(state) {
    const words = [];
    const now = state.run ? `${state.run.name}: ${state.run.outcome}` : null;
    if (run !== null && run.endsWith(": running") && now !== null && !now.endsWith(": running")) words.push(now);
    run = now;
    const number = state.alarms[0]?.number ?? 0;
    if (alarm !== null && number > alarm) words.push(state.alarms[0].words);
    alarm = number;
    if (!words.length) return;
    document.documentElement.dataset.announced = words.join("; ");
    if (!box.checked) return;
    beep();
    if ("Notification" in globalThis && Notification.permission === "granted") new Notification("dampyr", { body: words.join("\n") });
  }
  return { element: made, look };
}

function stored() {
  try {
    return localStorage.getItem("announce") === "yes";
  } catch {
    return false;
  }
}

function store(on) {
  try {
    localStorage.setItem("announce", on ? "yes" : "no");
  } catch {
    // a browser without storage forgets it
  }
}
