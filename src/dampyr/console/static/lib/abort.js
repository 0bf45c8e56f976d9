// Abort, on every page: a button in the head and the Escape key. A notice reports what it did.
import { abort, bench, listen, open } from "./bench.js";
import { button, h } from "./dom.js";
import { say } from "./notice.js";

export function begin(place) {
  const badge = h("span", { class: "badge", id: "bench-state" }, "bench");
  const knob = button([h("span", {}, "Abort"), h("kbd", {}, "Esc")], now, { class: "abort", "aria-keyshortcuts": "Escape" });
  place.append(badge, knob);
  addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || event.repeat) return;
    if (document.querySelector("dialog[open]") && bench.connected && bench.state && !bench.state.armed) return; // it closes the dialog
    event.preventDefault();
    now();
  }, { capture: true });
  listen(() => {
    const words = !bench.connected ? "no connection" : bench.state?.phase ?? "bench";
    if (badge.textContent !== words) badge.textContent = words;
    const hot = bench.connected && bench.state?.armed;
    badge.classList.toggle("bad", Boolean(hot) || !bench.connected);
  });
  open();
}

async function now() {
  try {
    const took = await abort();
    document.documentElement.dataset.aborted = took.toFixed(0);
    const rig = bench.state && !bench.state.rig ? "no rig is connected, so there was nothing to stop" : "the table is braked and the coil is off";
    say(`aborted: ${rig}, after ${took.toFixed(0)} ms`, "bad");
  } catch (problem) {
    say(`${problem.message} — use the switch on the rig`, "bad");
  }
}
