// A building that moves: floors and columns of each case side by side, magnified to fill the picture.
import { button, h, number } from "./dom.js";

const SVG = "http://www.w3.org/2000/svg";
const WIDTH = 220;
const REACH = 62;

const s = (tag, attributes) => {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
};

/** storeys({ time, cases: { name: [[floor 1 over time], ...] }, colourOf: (name) => ... }): { element, clear }. */
export function storeys({ time, cases, colourOf }) {
  const most = Math.max(...Object.values(cases).flat(2).map(Math.abs)) || 1;
  const scale = REACH / most;
  const drawn = Object.entries(cases).map(([name, floors]) => frame(name, floors, colourOf(name)));
  const slide = h("input", { type: "range", min: "0", max: String(time.length - 1), value: "0", "aria-label": "Time", oninput: () => (stop(), at(Number(slide.value))) });
  const clock = h("span", { class: "stage" });
  const play = button("Play", () => (running ? stop() : start()));
  const element = h("div", { class: "moving" },
    h("div", { class: "frames" }, drawn.map((drawing) => h("figure", {}, drawing.svg, h("figcaption", {}, drawing.name)))),
    h("div", { class: "row" }, play, h("div", { class: "slide" }, slide), clock),
    h("p", { class: "soft" }, `Displacements relative to the ground, magnified; the largest is ${number(1e3 * most, 3)} mm.`));
  let running = 0;
  let begun = 0;

  function at(k) {
    slide.value = String(k);
    clock.textContent = `${number(time[k], 3)} s`;
    slide.setAttribute("aria-valuetext", clock.textContent);
    for (const drawing of drawn) drawing.move(k, scale);
  }

  function start() {
    play.textContent = "Stop";
    const from = Number(slide.value) >= time.length - 1 ? 0 : Number(slide.value);
    begun = performance.now() - 1000 * time[from];
    const step = (now) => {
      const k = time.findIndex((t) => t >= (now - begun) / 1000);
      if (k < 0 || !element.isConnected) {
        at(time.length - 1);
        return stop();
      }
      at(k);
      running = requestAnimationFrame(step);
    };
    running = requestAnimationFrame(step);
  }

  function stop() {
    cancelAnimationFrame(running);
    running = 0;
    play.textContent = "Play";
  }

  at(peak(cases));
  return { element, clear: stop };
}

/** The frame at which the first case reaches furthest. */
function peak(cases) {
  const top = Object.values(cases)[0].at(-1);
  return top.reduce((best, value, k) => (Math.abs(value) > Math.abs(top[best]) ? k : best), 0);
}

function frame(name, floors, colour) {
  const storey = Math.max(14, Math.min(80, 190 / floors.length));
  const height = storey * floors.length + 24;
  const svg = s("svg", { viewBox: `0 0 ${WIDTH} ${height}`, role: "img", "aria-label": `${name}: the building, ${floors.length} floors, moving` });
  const ground = height - 10;
  svg.append(s("line", { x1: 10, x2: WIDTH - 10, y1: ground, y2: ground, class: "ground" }));
  const columns = floors.map(() => [s("path", { class: "column" }), s("path", { class: "column" })]);
  const slabs = floors.map(() => s("rect", { class: "slab", width: 76, height: 7, rx: 1.5 }));
  for (const slab of slabs) slab.style.fill = `var(--${colour})`;
  svg.append(...columns.flat(), ...slabs);
  return {
    name,
    svg,
    move(k, scale) {
      let below = 0;
      floors.forEach((floor, i) => {
        const x = scale * floor[k];
        const [foot, head] = [ground - i * storey, ground - (i + 1) * storey];
        slabs[i].setAttribute("x", WIDTH / 2 - 38 + x);
        slabs[i].setAttribute("y", head - 3.5);
        columns[i].forEach((column, side) => {
          const base = WIDTH / 2 + (side ? 33 : -33);
          const middle = (foot + head) / 2;
          column.setAttribute("d", `M${base + below} ${foot}C${base + below} ${middle} ${base + x} ${middle} ${base + x} ${head}`);
        });
        below = x;
      });
    },
  };
}
