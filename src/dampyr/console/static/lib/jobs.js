// Progress of a job: a bar, its stage, a button to cancel. The job continues without the page, and is shown again after a reload.
import { get, post } from "./api.js";
import { button, h } from "./dom.js";
import { attempt } from "./notice.js";

const EVERY = 400;
const ENDED = ["done", "failed", "cancelled"];

/** Show the job `id` in `root` until it ends; `ended` is called with the whole job. Returns a function that stops watching. */
export function watch(root, id, ended) {
  let on = true;
  const bar = h("progress", { max: 1, "aria-label": "Progress" });
  const words = h("span", { class: "stage" }, "waiting");
  const cancel = button("Cancel", () => attempt(() => post(`jobs/${id}/cancel`)), { class: "quiet" });
  const shown = h("div", { class: "job", role: "group", "aria-label": "Job in progress" }, bar, words, cancel);
  root.replaceChildren(shown);
  if (shown.getBoundingClientRect().top > innerHeight) shown.scrollIntoView(); // on a phone it stands below the form

  async function look() {
    if (!on) return;
    const job = await attempt(() => get(`jobs/${id}`));
    if (!on) return;
    if (job === undefined) {
      root.replaceChildren();
      return;
    }
    if (job.state === "waiting") bar.removeAttribute("value");
    else bar.value = job.progress;
    words.textContent = job.state === "waiting" ? "waiting for other jobs" : `${job.stage} ${Math.round(100 * job.progress)} %`;
    if (ENDED.includes(job.state)) {
      on = false;
      root.replaceChildren();
      if (job.state !== "done") root.append(h("p", { class: "verdict bad", role: "alert" }, sentence(job)));
      ended(job);
    } else setTimeout(look, EVERY);
  }
  look();
  return () => {
    on = false;
  };
}

function sentence(job) {
  if (job.state === "cancelled") return "Cancelled.";
  return `It failed: ${job.reason}${/[.!?]$/.test(job.reason) ? "" : "."}`;
}
