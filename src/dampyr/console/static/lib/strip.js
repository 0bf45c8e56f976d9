// Live charts on a canvas: a strip of the last seconds, and a loop of y over x. They are drawn many times a second.
import { h, number } from "./dom.js";

const FONT = "12px system-ui, sans-serif";
const [LEFT, RIGHT, TOP, BARE, BOTTOM] = [58, 16, 22, 8, 36]; // px about the frame; BARE is below a strip without numbers of its time
const SAID = 2000; // ms between two changes of what a screen reader is told
const SHRINK = 2.5; // a range that is this much wider than needed is made narrower: less, and it would tremble
const STEPS = [1, 2, 5, 10];
const NEAR = 0.7; // of a limit: data that come so far make the axis reach it

const colours = new Map(); // of the page, until its theme changes: they are needed a thousand times a second
addEventListener("theme", () => colours.clear());

function colour(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim() || name);
  return colours.get(name);
}

/**
 * A strip: signals over the last seconds.
 *
 * strip(host, { label, y: { words, unit, least }, series: [{ name, colour, dash }], limits: [{ value, words }], height, bare })
 *
 * It is appended to `host`, and as wide. `least` is the span of the axis, in its unit, below which it does not zoom into noise.
 * `limits` are named above it, and drawn where the data come within 30 % of them; an arrow says that they lie beyond the axis. `bare` leaves out
 * the numbers of the time: for a strip above another one.
 *
 * Returns { element, set, limits, clear }. `set({ now, span, origin, lines: [{ time, low, high }] })` shows the times from now - span
 * to now [s]; every strip that is given the same has its grid at the same moments. Times are written as seconds from now, below 0, or since
 * `origin` where it is given. A line goes from the least to the greatest of each of its bins; null parts it. `limits([...])` takes
 * others.
 */
export function strip(host, { label, y, series = [{}], limits = [], height = 130, bare = false }) {
  const chart = canvas(host, label, height, draw);
  const axis = range(y.least);
  let shown = null;
  let bounds = limits;

  function draw(context, width) {
    const frame = { left: LEFT, right: width - RIGHT, top: TOP, bottom: height - (bare ? BARE : BOTTOM) };
    const { now, span, origin = null, lines } = shown ?? { now: 0, span: 10, lines: [] };
    const ends = axis.fit(lines.flatMap((line) => [line.low, line.high]), bounds);
    const toX = scale([now - span, now], [frame.left, frame.right]);
    const toY = scale(ends, [frame.bottom, frame.top]);
    grid(context, frame, ticks([now - span, now], 7, origin ?? now), toX, bare ? null : (t) => number(Number((t - (origin ?? now)).toFixed(6))), true);
    grid(context, frame, ticks(ends, 4), toY, (value) => number(value, 6), false);
    title(context, frame, y);
    if (lines.length > 1) names(context, frame, y, series.slice(1, lines.length));
    if (!bare) words(context, origin === null ? "time from now [s]" : "time since the start [s]", (frame.left + frame.right) / 2, frame.bottom + 30, "center", "soft");
    clipped(context, frame, () => lines.forEach((line, k) => {
      context.strokeStyle = colour(series[k]?.colour ?? "blue");
      context.setLineDash(series[k]?.dash ?? []);
      trace(context, band(line, toX, toY));
    }));
    bounds.forEach((bound) => limit(context, frame, bound, ends, toY, y.unit));
  }

  function set(given) {
    shown = given;
    chart.draw();
    chart.say(() => summary(given.lines, series, y.unit));
  }

  return { element: chart.element, set, limits: (given) => ((bounds = given), chart.draw()), clear: chart.clear };
}

/**
 * A loop of y over x; its last part is drawn strongly, what came before faintly.
 *
 * loop(host, { label, x: { words, unit, least }, y: { ... }, series: [{ name, colour }], limits: [{ value, words }], height })
 *
 * Returns { element, set, limits, clear } as `strip`; `set({ lines: [{ x, y, recent }] })`, where the points from the index `recent` on
 * are the last part; limits are of y, or of x where they have `across`.
 */
export function loop(host, { label, x, y, series = [{}], limits = [], height = 286 }) {
  const chart = canvas(host, label, height, draw);
  const across = range(x.least);
  const up = range(y.least);
  let shown = { lines: [] };
  let bounds = limits;

  function draw(context, width) {
    const frame = { left: LEFT, right: width - RIGHT, top: TOP, bottom: height - BOTTOM };
    const [upright, level] = [bounds.filter((bound) => bound.across), bounds.filter((bound) => !bound.across)];
    const [wide, high] = [across.fit(shown.lines.map((line) => line.x), upright), up.fit(shown.lines.map((line) => line.y), level)];
    const toX = scale(wide, [frame.left, frame.right]);
    const toY = scale(high, [frame.bottom, frame.top]);
    grid(context, frame, ticks(wide, 5), toX, (value) => number(value, 6), true);
    grid(context, frame, ticks(high, 6), toY, (value) => number(value, 6), false);
    title(context, frame, y);
    words(context, x.unit ? `${x.words} [${x.unit}]` : x.words, (frame.left + frame.right) / 2, frame.bottom + 30, "center", "soft");
    clipped(context, frame, () => shown.lines.forEach((line, k) => {
      context.strokeStyle = colour(series[k]?.colour ?? "blue");
      const { recent = 0 } = line;
      if (recent > 0) {
        context.globalAlpha = 0.35;
        trace(context, polyline(line, 0, recent + 1, toX, toY));
        context.globalAlpha = 1;
      }
      trace(context, polyline(line, recent, line.x.length, toX, toY));
    }));
    level.forEach((bound) => limit(context, frame, bound, high, toY, y.unit));
    upright.forEach((bound) => wall(context, frame, bound, wide, toX, x.unit));
  }

  function set(given) {
    shown = given;
    chart.draw();
    chart.say(() => summary(given.lines.map((line) => ({ low: line.y, high: line.y })), series, y.unit));
  }

  return { element: chart.element, set, limits: (given) => ((bounds = given), chart.draw()), clear: chart.clear };
}

/** A canvas as wide as its host and as sharp as the screen; it is drawn only while it can be seen. */
function canvas(host, label, height, paint) {
  const surface = h("canvas");
  const element = h("div", { class: "strip", role: "img", "aria-label": label }, surface);
  surface.style.height = `${height}px`;
  host.append(element);
  const context = surface.getContext("2d");
  let [width, ratio, waiting, seen, said] = [0, 0, false, true, -Infinity];

  function draw() {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => {
      waiting = false;
      if (seen && element.isConnected) now();
    });
  }

  function now() {
    if (element.clientWidth !== width || devicePixelRatio !== ratio) {
      [width, ratio] = [element.clientWidth, devicePixelRatio];
      surface.width = Math.round(width * ratio);
      surface.height = Math.round(height * ratio);
    }
    if (width < LEFT + RIGHT + 40) return;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = FONT;
    context.lineJoin = "bevel"; // round ones take twice the time where no graphics card draws them
    paint(context, width);
  }

  /** The text alternative: what is shown, and the latest of it. */
  function say(text) {
    const time = performance.now();
    if (time - said < SAID) return;
    said = time;
    element.setAttribute("aria-label", [label, text()].filter(Boolean).join(": "));
  }

  const resizing = new ResizeObserver(draw);
  const seeing = new IntersectionObserver(([entry]) => {
    seen = entry.isIntersecting;
    if (seen) draw();
  });
  resizing.observe(element);
  seeing.observe(element);
  addEventListener("theme", draw);
  const clear = () => {
    resizing.disconnect();
    seeing.disconnect();
    removeEventListener("theme", draw);
  };
  return { element, draw, say, clear };
}

/** The ends of an axis over data that change: round, at least `least` apart, and the same as long as they fit. */
function range(least = 0) {
  let ends = null;
  function fit(columns, bounds = []) {
    let [low, high] = [Infinity, -Infinity];
    for (const values of columns) {
      for (const value of values) {
        if (value === null) continue;
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    if (low > high) return ends ?? [-(least || 1) / 2, (least || 1) / 2];
    for (const { value } of bounds) {
      if (value > 0 && high >= NEAR * value) high = Math.max(high, value);
      if (value < 0 && low <= NEAR * value) low = Math.min(low, value);
    }
    const lack = Math.max(least, 1e-3 * Math.max(Math.abs(low), Math.abs(high)), 1e-12) - (high - low);
    if (lack > 0) [low, high] = [low - lack / 2, high + lack / 2];
    const fits = ends !== null && low >= ends[0] && high <= ends[1];
    if (!fits || ends[1] - ends[0] > SHRINK * (high - low)) {
      const step = stepOf(high - low, 4) / 2;
      ends = [step * Math.floor(low / step), step * Math.ceil(high / step)];
    }
    return ends;
  }
  return { fit };
}

function stepOf(span, count) {
  const power = 10 ** Math.floor(Math.log10(span / count));
  return power * STEPS.find((step) => step * power >= span / count - 1e-9 * power);
}

/** Round values between two ends, counted from `base`. */
function ticks([low, high], count, base = 0) {
  const step = stepOf(high - low, count);
  const values = [];
  for (let k = Math.ceil((low - base) / step - 1e-6); k <= (high - base) / step + 1e-6; k++) values.push(base + k * step);
  return values.map((value) => (Math.abs(value) < 1e-9 * step ? 0 : value));
}

const scale = ([low, high], [from, to]) => (value) => from + ((value - low) / (high - low)) * (to - from);

/** Lines across the frame, and the words of each at its side; of the time or x where `upright`. */
function grid(context, frame, values, place, text, upright) {
  context.strokeStyle = colour("grid");
  const lines = new Path2D();
  for (const value of values) {
    const at = Math.round(place(value)) + 0.5;
    lines.moveTo(upright ? at : frame.left, upright ? frame.top : at);
    lines.lineTo(upright ? at : frame.right, upright ? frame.bottom : at);
  }
  context.lineWidth = 1;
  context.stroke(lines);
  if (!text) return;
  for (const value of values) {
    if (upright) words(context, text(value), place(value), frame.bottom + 15, "center", "soft");
    else words(context, text(value), frame.left - 6, place(value) + 4, "right", "soft");
  }
}

/** What the axis shows stands above it, where no number is. */
const title = (context, frame, axis) => words(context, axis.unit ? `${axis.words} [${axis.unit}]` : axis.words, 4, frame.top - 9, "left", "ink");

/** The lines besides the first, behind the title. */
function names(context, frame, axis, series) {
  let x = 16 + context.measureText(axis.unit ? `${axis.words} [${axis.unit}]` : axis.words).width;
  for (const { name, colour: hue, dash = [] } of series) {
    dashed(context, [x, frame.top - 13], [x + 16, frame.top - 13], hue, dash);
    words(context, name, x + 21, frame.top - 9, "left", "soft");
    x += 33 + context.measureText(name).width;
  }
}

function words(context, text, x, y, align, ink, halo = false) {
  context.textAlign = align;
  if (halo) {
    context.save();
    Object.assign(context, { strokeStyle: colour("paper"), lineWidth: 4 });
    context.strokeText(text, x, y);
    context.restore();
  }
  context.fillStyle = colour(ink);
  context.fillText(text, x, y);
}

function clipped(context, { left, right, top, bottom }, paint) {
  context.save();
  context.beginPath();
  context.rect(left, top, right - left, bottom - top);
  context.clip();
  paint();
  context.restore();
}

/** A limit: a dashed line, and its name above the frame; with an arrow where the axis does not reach it. */
function limit(context, frame, { value, words: name }, [low, high], place, unit) {
  if (value >= low && value <= high) {
    const at = Math.round(place(value)) + 0.5;
    dashed(context, [frame.left, at], [frame.right, at], "bad", [6, 4]);
  }
  if (!name) return; // the limit on the other side names both
  const where = value > high ? "↑ " : value < low ? "↓ " : "";
  words(context, `${where}${name}${name.endsWith("±") ? "" : " "}${number(value)}${unit ? ` ${unit}` : ""}`, frame.right, frame.top - 9, "right", "bad");
}

/** A limit of x: a dashed line with its name along it, where the axis reaches it. */
function wall(context, frame, { value, words: name }, [low, high], place, unit) {
  if (value < low || value > high) return;
  const at = Math.round(place(value)) + 0.5;
  dashed(context, [at, frame.top], [at, frame.bottom], "bad", [6, 4]);
  if (!name) return;
  context.save();
  context.translate(at - 5, frame.bottom - 6);
  context.rotate(-Math.PI / 2);
  words(context, `${name}${number(value)} ${unit}`, 0, 0, "left", "bad", true);
  context.restore();
}

function dashed(context, from, to, hue, dash) {
  context.save();
  context.setLineDash(dash);
  context.strokeStyle = colour(hue);
  context.beginPath();
  context.moveTo(...from);
  context.lineTo(...to);
  context.stroke();
  context.restore();
}

/** A line of about 1.5 px: two of 1 px where no graphics card draws, since a wider one takes several times as long there. */
function trace(context, path) {
  const sharp = devicePixelRatio > 1;
  context.lineWidth = sharp ? 1.5 : 1;
  context.stroke(path);
  if (sharp) return;
  context.translate(0.5, 0.5);
  context.stroke(path);
  context.translate(-0.5, -0.5);
}

/**
 * A line from the least to the greatest value of each column of pixels: no peak is lost, and there are no more points than pixels.
 * Where both are the same pixel it is one point.
 */
function band({ time, low, high }, toX, toY) {
  const path = new Path2D();
  let [open, at, least, greatest] = [false, null, 0, 0];
  const put = () => {
    if (at === null) return;
    const [foot, head] = [toY(least), toY(greatest)];
    const thin = foot - head < 1;
    if (open) path.lineTo(at, thin ? (foot + head) / 2 : foot);
    else path.moveTo(at, thin ? (foot + head) / 2 : foot);
    if (!thin) path.lineTo(at, head);
    open = true;
  };
  for (let k = 0; k < time.length; k++) {
    if (low[k] === null || high[k] === null) {
      put();
      [open, at] = [false, null];
      continue;
    }
    const x = Math.round(toX(time[k]));
    if (x === at) [least, greatest] = [Math.min(least, low[k]), Math.max(greatest, high[k])];
    else {
      put();
      [at, least, greatest] = [x, low[k], high[k]];
    }
  }
  put();
  return path;
}

function polyline({ x, y }, from, to, toX, toY) {
  const path = new Path2D();
  let [open, at] = [false, null];
  for (let k = from; k < Math.min(to, x.length); k++) {
    if (x[k] === null || y[k] === null) {
      open = false;
      continue;
    }
    const [px, py] = [toX(x[k]), toY(y[k])];
    if (open && Math.abs(px - at[0]) + Math.abs(py - at[1]) < 0.7 && k < to - 1) continue; // the same pixel
    if (open) path.lineTo(px, py);
    else path.moveTo(px, py);
    at = [px, py];
    open = true;
  }
  return path;
}

/** Such as "now 12.1 mm, from -4 to 15 mm", for every line. */
function summary(lines, series, unit) {
  const parts = lines.map((line, k) => {
    const values = [...line.low, ...line.high].filter((value) => value !== null);
    if (!values.length) return "";
    const last = line.high.findLast((value) => value !== null);
    const [low, high] = [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
    const name = lines.length > 1 && series[k]?.name ? `${series[k].name} ` : "";
    return `${name}now ${number(last, 3)}, from ${number(low, 3)} to ${number(high, 3)}${unit ? ` ${unit}` : ""}`;
  });
  return parts.filter(Boolean).join("; ");
}
