// Lines and points over axes, drawn by BokehJS: each series has its own x, so time histories and loops are drawn alike.
import { bokeh } from "./bokeh.js";
import { button, h, number } from "./dom.js";

export const COLOURS = ["vermillion", "blue", "green", "purple", "orange", "sky"];

const DASHES = { dashed: [6, 5], dotted: [2, 4], long: [12, 5] };
const SHAPES = { circle: "circle", cross: "x", square: "square" };
const SIZE = 7; // px of a point
const REACH = 30; // px from the pointer within which a point is read
const LEFT = 72; // px beside every frame, so that charts above one another begin at the same place

const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || name;

/** One chart; see `charts`. */
export const chart = (panel, settings = {}) => charts([panel], settings);

/**
 * Charts with one legend and one set of tools, above one another, or side by side where `across`.
 *
 * charts([{ label, x: { words, unit, least, log, pad }, y: { ... }, series: [...], height, zero }], { linked, across })
 * series: { name, of, x, y, colour, width, dash, points, shape, size, fill, tips, always }
 *
 * `label` says in words what is shown, for those who cannot see it. `least` is the span of an axis, in its unit, below which it
 * does not zoom into a signal that is constant, `from` and `to` bound what of x is shown at first; `log` makes it logarithmic; `zero` has y begin at 0. With `linked` all charts have
 * one range of x: a zoom in one zooms all. A name in the legend hides its series in every chart; `of` counts a series to another
 * one's name. `dash` is one of dashed, dotted, long; `points` draws marks, of the `shape` circle, cross, square or ring, `fill` an
 * area within the line; `tips` are words for each point. null in x or y parts a line.
 *
 * Returns { element, clear() }.
 */
export function charts(panels, { linked = false, across = false } = {}) {
  const names = h("div", { class: "legend", role: "group", "aria-label": "Series" });
  const tools = h("div", { class: "tools", role: "group", "aria-label": "Tools of the chart" });
  const parts = panels.map((panel) => part(panel));
  const element = h("figure", { class: "chart" }, h("div", { class: "plot-foot" }, names, tools),
    h("div", { class: across ? "chart-panels across" : "chart-panels" }, parts.map((part) => part.box)));
  const hidden = new Set();
  let drawing = null;
  let cleared = false;

  const entries = legendOf(panels);
  if (entries.length > 1 || entries.some((entry) => entry.always)) names.append(...entries.map(entry));
  draw();

  async function draw() {
    try {
      const library = await bokeh();
      if (cleared) return;
      drawing = build(library, parts, linked);
      dress();
      rescale();
      await drawing.show();
      if (cleared) return drawing.clear();
      tools.append(...toolbar());
      for (const [k, part] of parts.entries()) part.box.addEventListener("pointermove", (event) => read(k, event));
    } catch (problem) {
      element.replaceChildren(h("p", { class: "verdict bad", role: "alert" }, problem.message));
    }
  }

  function entry(line) {
    const swatch = h("span", { class: ["swatch", line.dash, line.fill && "area", line.points && "dot", line.points && line.shape].filter(Boolean).join(" ") });
    swatch.style.color = `var(--${line.colour})`;
    const made = button([swatch, line.name], () => {
      if (!hidden.delete(line.name)) hidden.add(line.name);
      made.setAttribute("aria-pressed", String(!hidden.has(line.name)));
      drawing?.hide(hidden);
      rescale();
    }, { class: "name", "aria-pressed": "true", title: "Show or hide" });
    return made;
  }

  /** Every axis over what is shown; one that was zoomed stays as it is. */
  function rescale() {
    drawing?.rescale((series) => !hidden.has(series.of ?? series.name));
  }

  function toolbar() {
    const drag = (words, tool) => {
      const made = button(words, () => {
        drawing.drag(drawing.dragging() === tool ? null : tool);
        for (const [other, knob] of drags) knob.setAttribute("aria-pressed", String(drawing.dragging() === other));
      }, { class: "tool", "aria-pressed": String(drawing.dragging() === tool), title: `Drag to ${words.toLowerCase()}` });
      return made;
    };
    const drags = [["zoom", drag("Zoom", "zoom")], ["pan", drag("Pan", "pan")]];
    const wheel = button("Wheel", () => wheel.setAttribute("aria-pressed", String(drawing.turnWheel())), { class: "tool", "aria-pressed": "false", title: "Zoom with the wheel of the mouse" });
    const reset = () => drawing.reset();
    element.querySelector(".chart-panels").addEventListener("dblclick", reset);
    return [...drags.map(([, made]) => made), wheel, button("Show all", reset, { class: "tool" }), button("Save", save, { class: "tool", title: "Save as a picture" })];
  }

  /** The reading nearest to the pointer, with its units. */
  function read(k, event) {
    const place = parts[k].box.getBoundingClientRect();
    const [sx, sy] = [event.clientX - place.left, event.clientY - place.top];
    const at = drawing.nearest(k, sx, sy, (series) => !hidden.has(series.of ?? series.name));
    for (const [j, part] of parts.entries()) part.point(j === k ? at : null, linked && at ? at.sx : null);
  }

  function dress() {
    drawing?.dress();
  }

  async function save() {
    const picture = drawing.picture(entries.filter((entry) => !hidden.has(entry.name)), across);
    const blob = await new Promise((resolve) => picture.toBlob(resolve, "image/png"));
    const link = h("a", { href: URL.createObjectURL(blob), download: `${fileName(panels[0].label)}.png` });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }

  const themed = () => (element.isConnected ? dress() : clear());
  addEventListener("theme", themed);
  function clear() {
    cleared = true;
    removeEventListener("theme", themed);
    drawing?.clear();
    drawing = null;
  }
  return { element, clear };
}

const fileName = (label) => label.toLowerCase().replace(/[^a-z0-9.]+/g, "-").replace(/^-|-$/g, "").slice(0, 80) || "chart";

/** What the legend names: each name once, looking as its first series does. */
function legendOf(panels) {
  const named = new Map();
  for (const panel of panels) {
    panel.series.forEach((line, k) => {
      const mine = { ...line, colour: line.colour ?? COLOURS[k % COLOURS.length] };
      if (line.name && !named.has(line.name)) named.set(line.name, mine);
    });
  }
  return [...named.values()];
}

/** The element of one chart, with the words of a reading. */
function part(panel) {
  const host = h("div", { class: "plot", role: "img", "aria-label": panel.label });
  host.style.minHeight = `${panel.height ?? 260}px`;
  const dot = h("div", { class: "reading-dot" });
  const hair = h("div", { class: "hair" });
  const tip = h("div", { class: "tip" });
  const over = h("div", { class: "over", "aria-hidden": "true" }, hair, dot, tip);
  const box = h("div", { class: "chart-panel" }, host, over);
  box.addEventListener("pointerleave", () => point(null, null));

  function point(at, sx) {
    dot.hidden = tip.hidden = !at;
    hair.hidden = sx === null;
    if (sx !== null) hair.style.left = `${sx}px`;
    if (!at) return;
    dot.style.left = `${at.sx}px`;
    dot.style.top = `${at.sy}px`;
    dot.style.color = `var(--${at.colour})`;
    tip.replaceChildren(...at.words.map((line) => h("div", {}, line)));
    const right = at.sx > box.clientWidth / 2;
    tip.style.left = right ? "" : `${at.sx + 12}px`;
    tip.style.right = right ? `${box.clientWidth - at.sx + 12}px` : "";
    tip.style.top = `${Math.max(0, Math.min(at.sy - 14, box.clientHeight - 64))}px`;
  }
  point(null, null);
  return { panel, host, box, point };
}

/** The models of Bokeh for charts in one document. */
function build(library, parts, linked) {
  const coarse = matchMedia("(pointer: coarse)").matches; // a finger scrolls the page until it is told to zoom
  const shared = linked ? new library.Range1d({ start: 0, end: 1 }) : null;
  const made = parts.map(({ panel }, k) => plotOf(library, panel, shared, linked && k < parts.length - 1));
  const document = new library.Document();
  for (const plot of made) document.add_root(plot.plot);
  const frames = []; // of the ranges as they are without a zoom
  let views = null;
  let held = coarse ? null : "zoom";

  async function show() {
    views = await library.embed.add_document_standalone(document, parts[0].host, parts.map((part) => part.host));
    for (const plot of made) {
      plot.view = views.get(plot.plot);
      plot.view.canvas_view.events_el.removeAttribute("tabindex"); // an image holds nothing to focus
    }
    drag(held);
  }

  function dress() {
    for (const plot of made) plot.dress();
  }

  function hide(names) {
    for (const plot of made) for (const { series, renderer } of plot.drawn) renderer.visible = !names.has(series.of ?? series.name);
  }

  function rescale(isShown) {
    const spans = made.map(({ panel }) => panel.series.filter(isShown));
    made.forEach((plot, k) => {
      const across = linked ? spans.flat() : spans[k];
      fit(plot.plot.x_range, extent(across.map((line) => line.x), plot.panel.x), linked ? 0 : 2 * k);
      const { from = -Infinity, to = Infinity } = plot.panel.x;
      const seen = (line) => (from === -Infinity && to === Infinity ? line.y : line.y.filter((_, i) => line.x[i] >= from && line.x[i] <= to));
      fit(plot.plot.y_range, extent(spans[k].map(seen), { pad: 0.06, zero: plot.panel.zero, ...plot.panel.y }), 2 * k + 1);
    });
  }

  function fit(range, [start, end], k) {
    const was = frames[k];
    frames[k] = { range, start, end };
    if (!was || (range.start === was.start && range.end === was.end)) range.setv({ start, end });
  }

  function reset() {
    for (const frame of frames) frame?.range.setv({ start: frame.start, end: frame.end });
  }

  function drag(tool) {
    held = tool;
    for (const plot of made) {
      plot.zoom.active = tool === "zoom";
      plot.pan.active = tool === "pan";
    }
  }

  function turnWheel() {
    for (const plot of made) plot.wheel.active = !plot.wheel.active;
    return made[0].wheel.active;
  }

  function nearest(k, sx, sy, isShown) {
    const { view, panel, drawn } = made[k];
    const { x_scale: toX, y_scale: toY, bbox } = view.frame;
    if (!bbox.contains(sx, sy)) return null;
    let best = null;
    let least = linked ? Infinity : REACH ** 2;
    for (const { series, colour: name } of drawn) {
      if (!isShown(series) || series.silent) continue;
      let near = null;
      let away = Infinity;
      for (let i = 0; i < series.x.length; i++) {
        if (series.x[i] === null || series.y[i] === null) continue;
        const [px, py] = [toX.compute(series.x[i]), toY.compute(series.y[i])];
        const far = linked ? Math.abs(px - sx) : (px - sx) ** 2 + (py - sy) ** 2; // histories are read at the pointer's time
        if (far >= away || !bbox.contains(px, py)) continue;
        away = far;
        near = { series, i, sx: px, sy: py, colour: name };
      }
      const far = near && linked ? Math.abs(near.sy - sy) : away;
      if (near && far < least) [best, least] = [near, far];
    }
    if (!best) return null;
    const { series, i } = best;
    const reading = (axis, value) => `${axis.words} ${number(value)}${axis.unit ? ` ${axis.unit}` : ""}`;
    const title = [series.name || series.of, series.tips?.[i] ?? []].flat().filter(Boolean);
    return { ...best, words: [...title, reading(panel.x, series.x[i]), reading(panel.y, series.y[i])] };
  }

  /** The charts and their legend on one canvas. */
  function picture(entries, across) {
    const layers = made.map((plot) => plot.view.export("png").canvas);
    const ratio = layers[0].width / parts[0].host.clientWidth;
    const columns = across && parts.length > 1 && parts[0].box.offsetTop === parts[1].box.offsetTop;
    const total = (side) => layers.reduce((sum, layer) => sum + layer[side], 0);
    const widest = (side) => Math.max(...layers.map((layer) => layer[side]));
    const head = Math.round(26 * ratio);
    const canvas = h("canvas", { width: columns ? total("width") : widest("width"), height: head + (columns ? widest("height") : total("height")) });
    const context = canvas.getContext("2d");
    context.fillStyle = colour("paper");
    context.fillRect(0, 0, canvas.width, canvas.height);
    context.font = `${13 * ratio}px system-ui, sans-serif`;
    context.textBaseline = "middle";
    let at = 10 * ratio;
    for (const entry of entries) {
      context.fillStyle = colour(entry.colour);
      context.fillRect(at, head / 2 - ratio, 18 * ratio, 3 * ratio);
      context.fillStyle = colour("ink");
      context.fillText(entry.name, at + 24 * ratio, head / 2);
      at += 42 * ratio + context.measureText(entry.name).width;
    }
    let [left, top] = [0, head];
    for (const layer of layers) {
      context.drawImage(layer, left, top);
      if (columns) left += layer.width;
      else top += layer.height;
    }
    return canvas;
  }

  return { show, dress, hide, rescale, reset, drag, dragging: () => held, turnWheel, nearest, picture, clear: () => document.clear() };
}

/** One plot: its axes, grids, renderers and tools, and `dress`, which gives all of them the colours of the page. */
function plotOf(library, panel, shared, bare) {
  const { Plot, Range1d, LinearScale, LogScale, Grid, PanTool, BoxZoomTool, WheelZoomTool } = library;
  const { height = 260 } = panel;
  const scale = (axis) => (axis.log ? new LogScale() : new LinearScale());
  const plot = new Plot({
    x_range: shared ?? new Range1d({ start: 1, end: 2 }), y_range: new Range1d({ start: 1, end: 2 }), x_scale: scale(panel.x), y_scale: scale(panel.y),
    height, sizing_mode: "stretch_width", min_width: 200, toolbar_location: null, min_border_left: LEFT, min_border_right: 14, min_border_top: 8,
    background_fill_alpha: 0, border_fill_alpha: 0, outline_line_alpha: 0, match_aspect: false,
  });
  const x = axisOf(library, panel.x, 0);
  if (bare) x.axis_label = null; // it stands below the last of linked charts
  const y = axisOf(library, panel.y, height);
  plot.add_layout(x, "below");
  plot.add_layout(y, "left");
  const grids = [new Grid({ dimension: 0, axis: x }), new Grid({ dimension: 1, axis: y })];
  for (const grid of grids) plot.add_layout(grid, "center");
  const drawn = panel.series.map((series, k) => rendererOf(library, plot, series, series.colour ?? COLOURS[k % COLOURS.length]));
  const [zoom, pan, wheel] = [new BoxZoomTool({ dimensions: "auto" }), new PanTool(), new WheelZoomTool()];
  plot.add_tools(zoom, pan, wheel);
  plot.toolbar.active_scroll = null;

  function dress() {
    const [ink, soft, muted, grid, blue] = ["ink", "soft", "muted", "grid", "blue"].map(colour);
    for (const axis of [x, y]) {
      axis.setv({ axis_line_color: muted, major_tick_line_color: muted, minor_tick_line_color: (axis === x ? panel.x : panel.y).log ? muted : null, major_label_text_color: soft, axis_label_text_color: ink });
    }
    for (const gridLine of grids) gridLine.setv({ grid_line_color: grid });
    zoom.overlay.setv({ fill_color: blue, fill_alpha: 0.15, line_color: blue });
    for (const drawing of drawn) drawing.dress();
  }
  return { panel, plot, drawn, zoom, pan, wheel, dress };
}

function axisOf(library, axis, height) {
  const { LinearAxis, LogAxis, BasicTickFormatter, BasicTicker, LogTicker } = library;
  const formatter = new BasicTickFormatter();
  formatter.doFormat = (ticks) => ticks.map((tick) => number(tick, 6));
  const font = "system-ui, sans-serif";
  const ticker = axis.log ? logTicker(new LogTicker()) : new BasicTicker({ desired_num_ticks: height && height < 200 ? 4 : 6 });
  return new (axis.log ? LogAxis : LinearAxis)({
    axis_label: axis.unit ? `${axis.words} [${axis.unit}]` : axis.words, ticker, formatter, axis_label_standoff: 6, axis_label_text_font: font, axis_label_text_font_size: "12px",
    axis_label_text_font_style: "normal", major_label_text_font: font, major_label_text_font_size: "12px", major_tick_in: 0,
  });
}

/** Ticks at 1, 2 and 5 times a power of ten, where many decades are shown at the powers alone. */
function logTicker(ticker) {
  ticker.get_ticks_no_defaults = (low, high) => {
    const decades = Math.log10(high / low);
    const ticks = (steps) => {
      const values = [];
      for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) values.push(...steps.map((step) => step * 10 ** power));
      return values.filter((tick) => tick >= low && tick <= high);
    };
    if (decades > 2.5) return { major: ticks([1]), minor: ticks([2, 3, 4, 5, 6, 7, 8, 9]) };
    return { major: ticks(decades > 0.7 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 7, 8, 9]), minor: ticks([2, 3, 4, 5, 6, 7, 8, 9]) };
  };
  return ticker;
}

/** A series as Bokeh draws it; `dress` gives it its colour. */
function rendererOf(library, plot, series, name) {
  const { ColumnDataSource, GlyphRenderer, Line, Scatter, Patch } = library;
  const numbers = (values) => Float64Array.from(values, (value) => value ?? NaN);
  const source = new ColumnDataSource({ data: { x: numbers(series.x), y: numbers(series.y), size: Float64Array.from(series.x, (_, i) => series.size?.[i] ?? series.size ?? SIZE) } });
  const at = { x: { field: "x" }, y: { field: "y" } };
  const shape = series.shape ?? "circle";
  let glyph;
  if (series.fill) glyph = new Patch({ ...at, fill_alpha: 0.22, line_alpha: 0 });
  else if (series.points) glyph = new Scatter({ ...at, size: { field: "size" }, marker: { value: SHAPES[shape] ?? "circle" }, line_width: series.width ?? 1.8, fill_alpha: shape === "circle" ? 0.75 : 0 });
  else glyph = new Line({ ...at, line_width: series.width ?? 1.5, line_dash: DASHES[series.dash] ?? [], line_join: "round" });
  const renderer = new GlyphRenderer({ data_source: source, glyph });
  plot.add_renderers(renderer);
  const dress = () => {
    const value = { value: colour(name) };
    if (series.fill) glyph.setv({ fill_color: value });
    else glyph.setv(series.points ? { fill_color: value, line_color: value } : { line_color: colour(name) });
  };
  return { series, renderer, colour: name, dress };
}

/** From the least to the greatest value, with a margin; at least `least` wide, and never a signal's own rounding. */
export function extent(columns, { pad = 0, least = 0, zero = false, log = false, from = -Infinity, to = Infinity }) {
  let [low, high] = [Infinity, -Infinity];
  for (const values of columns) {
    for (const value of values) {
      if (value === null || Number.isNaN(value) || (log && value <= 0) || value < from || value > to) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return log ? [1, 10] : [0, 1];
  if (log) {
    const factor = Math.max((high / low) ** pad, high === low ? 2 : 1);
    return [low / factor, high * factor];
  }
  if (zero) [low, high] = [Math.min(0, low), Math.max(0, high)];
  const lack = Math.max(least, 1e-3 * Math.max(Math.abs(low), Math.abs(high))) - (high - low);
  if (lack > 0) [low, high] = zero && low === 0 ? [low, high + lack] : [low - lack / 2, high + lack / 2];
  if (high === low) return [low - 0.5, high + 0.5];
  const margin = (high - low) * pad;
  return [low - (zero && low === 0 ? 0.4 * margin : margin), high + margin]; // a mark at 0 is not cut
}
