// Lines over an axis, with uPlot: each series has its own x, so time histories and loops are drawn alike.
import uPlot from "../vendor/uplot/uPlot.esm.js";
import { h, number } from "./dom.js";

export const COLOURS = ["vermillion", "blue", "green", "purple", "orange", "sky"];

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || name;

/**
 * A chart in a figure element.
 *
 * chart({ label, x: { words, unit, time }, y: { words, unit }, series: [{ name, x, y, colour, width, dash, points, shape, fill }],
 *         height, equal, onmove })
 *
 * `points` draws marks, of the `shape` circle, cross or square; `fill` an area within its line.
 * `x.bare` leaves out the numbers and words of the axis: for a strip above another one with the same time.
 *
 * `label` says in words what is shown, for those who cannot see it. Returns { element, set(series), clear() }; `set` gives new
 * series and is quick enough to be called thirty times a second. Drag zooms, a double click shows all again.
 */
export function chart({ label, x, y, series = [], height = 260, zero = false }) {
  const box = h("div", { class: "plot", role: "img", "aria-label": label });
  const names = h("div", { class: "legend" });
  const cursor = h("span", { class: "cursor", "aria-hidden": "true" });
  const foot = h("div", { class: "plot-foot" }, names, cursor);
  const element = h("figure", { class: "chart" }, foot, box);
  let plot = null;
  let drawn = [];
  let fixed = "";

  function build() {
    plot?.destroy();
    const width = Math.max(240, box.clientWidth);
    plot = new uPlot(options(width), [null, ...drawn.map((one) => [one.x, one.y])], box);
  }

  function options(width) {
    const ink = colour("soft");
    const line = { stroke: colour("grid"), width: 1 };
    const axis = (one, size, space) => ({
      stroke: ink, grid: line, ticks: line, label: one.unit ? `${one.words} [${one.unit}]` : one.words, labelSize: 22, size, space,
      font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif", values: (_, ticks) => ticks.map((t) => number(t, 6)),
    });
    return {
      width, height, mode: 2, legend: { show: false }, padding: [8, 12, 0, 0],
      cursor: { drag: { x: true, y: true, uni: 20 }, points: { show: false }, dataIdx: () => null },
      scales: { x: { time: false, range: padded(x.pad ?? 0) }, y: { range: padded(0.06, zero) } },
      axes: [x.bare ? { ...axis(x, 6, 50), label: undefined, values: () => [] } : axis(x, 32, 50), { ...axis(y, 58, height < 200 ? 18 : 30), scale: "y" }],
      series: [null, ...drawn.map((one) => ({
        label: one.name, stroke: one.stroke, width: one.width ?? 1.5, dash: one.dash, paths: path(one),
        facets: [{ scale: "x", auto: true }, { scale: "y", auto: true }],
      }))],
      hooks: { setCursor: [tell] },
    };
  }

  function tell(u) {
    const { left, top } = u.cursor;
    const inside = left >= 0 && top >= 0;
    cursor.textContent = inside ? `${number(u.posToVal(left, "x"))} ${x.unit ?? ""}, ${number(u.posToVal(top, "y"))} ${y.unit ?? ""}` : "";
  }

  /** New series; the chart is built anew only when their names or looks change. */
  function set(given) {
    drawn = given.map((one, k) => ({ ...one, stroke: colour(one.colour ?? COLOURS[k % COLOURS.length]) }));
    const looks = JSON.stringify(drawn.map(({ name, stroke, width, dash }) => [name, stroke, width, dash]));
    if (!box.isConnected || (plot === null && !drawn.length)) return;
    if (plot === null || looks !== fixed) {
      fixed = looks;
      write();
      build();
    } else plot.setData([null, ...drawn.map((one) => [one.x, one.y])]);
  }

  function write() {
    const named = drawn.filter((one) => one.name);
    names.replaceChildren(...(named.length > 1 || named.some((one) => one.always) ? named.map(mark) : []));
  }

  const watch = new ResizeObserver(() => {
    if (!box.isConnected || !box.clientWidth) return;
    if (plot === null) set(drawn);
    else if (Math.abs(plot.width - box.clientWidth) > 1) plot.setSize({ width: box.clientWidth, height });
  });
  watch.observe(box);
  const recolour = () => set(drawn);
  addEventListener("theme", recolour);
  drawn = series;
  if (series.length) queueMicrotask(() => set(series));

  function clear() {
    watch.disconnect();
    removeEventListener("theme", recolour);
    plot?.destroy();
    plot = null;
  }
  return { element, set, clear };
}

function mark(one) {
  const swatch = h("span", { class: ["swatch", one.dash && "dashed", one.fill && "area", one.shape && "dot"].filter(Boolean).join(" ") });
  swatch.style.color = one.stroke;
  return h("span", { class: "name" }, swatch, one.name);
}

const padded = (share, zero) => (_, low, high) => {
  if (low === null || high === null || low === undefined) return [0, 1];
  const from = zero ? Math.min(0, low) : low;
  const to = zero ? Math.max(0, high) : high;
  const margin = (to - from) * share || (to === from ? Math.abs(to) * 0.1 || 1 : 0);
  return [from - (zero && from === 0 ? 0 : margin), to + margin];
};

const SHAPES = {
  circle(line, x, y, size) {
    line.moveTo(x + size, y);
    line.arc(x, y, size, 0, 2 * Math.PI);
  },
  cross(line, x, y, size) {
    for (const sign of [1, -1]) {
      line.moveTo(x - 1.4 * size, y - 1.4 * sign * size);
      line.lineTo(x + 1.4 * size, y + 1.4 * sign * size);
    }
  },
  square: (line, x, y, size) => line.rect(x - size, y - size, 2 * size, 2 * size),
};

/** A polyline in the order of its points; null parts it. */
const path = (one) => (u, k) => {
  uPlot.orient(u, k, (series, _xs, _ys, scaleX, scaleY, toX, toY, left, top, width, height) => {
    const [xs, ys] = u.data[k];
    const line = new Path2D();
    let open = false;
    for (let i = 0; i < xs.length; i++) {
      if (ys[i] === null || xs[i] === null) {
        open = false;
        continue;
      }
      const px = toX(xs[i], scaleX, width, left);
      const py = toY(ys[i], scaleY, height, top);
      if (one.points) SHAPES[one.shape ?? "circle"](line, px, py, 3 * devicePixelRatio);
      else if (open) line.lineTo(px, py);
      else line.moveTo(px, py);
      open = true;
    }
    const { ctx } = u;
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, top, width, height);
    ctx.clip();
    ctx.strokeStyle = one.stroke;
    ctx.fillStyle = one.stroke;
    ctx.lineJoin = "round";
    ctx.lineWidth = (one.width ?? 1.5) * devicePixelRatio;
    ctx.setLineDash((one.dash ?? []).map((part) => part * devicePixelRatio));
    if (one.fill) ctx.globalAlpha = 0.22;
    if (one.fill || (one.points && (one.shape ?? "circle") === "circle")) ctx.fill(line);
    else ctx.stroke(line);
    ctx.restore();
  });
  return null;
};
