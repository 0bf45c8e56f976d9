// Tables that sort: numbers to the right, a unit under each name, – where there is nothing.
import { button, h, number, symbols } from "./dom.js";

/**
 * table({ caption, columns: [{ name, unit, digits, align }], rows, groupOf, headOf })
 * A column with `symbols` sets names of parameters, such as k_x, as symbols.
 * A cell is a number, text, null, or an element; { key, show } sorts by key and shows an element. Rows with the same `groupOf(index)`
 * stand together below `headOf(group, indices)`; they are sorted among themselves, and the groups by their first rows.
 */
export function table({ caption = "", columns, rows, empty = "Nothing here.", groupOf = null, headOf = null }) {
  const sides = columns.map((column, k) => column.align ?? (isNumeric(rows, k) ? "right" : "left"));
  const places = columns.map((column, k) => decimals(rows.map((row) => row[k]).filter((cell) => typeof cell === "number"), column.digits ?? 4));
  const groups = new Map();
  rows.forEach((row, i) => {
    const line = h("tr", {}, row.map((cell, k) => h("td", { class: sides[k] }, shown(cell, columns[k], places[k]))));
    const name = groupOf?.(i) ?? "";
    if (!groups.has(name)) groups.set(name, { body: h("tbody"), made: [], indices: [] });
    groups.get(name).made.push({ line, keys: row.map(key) });
    groups.get(name).indices.push(i);
  });
  for (const [name, { body, made, indices }] of groups) {
    if (groups.size > 1) body.append(h("tr", { class: "group" }, h("th", { scope: "rowgroup", colspan: String(columns.length) }, headOf(name, indices))));
    body.append(...made.map(({ line }) => line));
  }
  const head = h("tr", {}, columns.map((column, k) => heading(column, sides[k], () => sort(k))));
  let turned = { column: -1, falling: false };

  function sort(k) {
    turned = { column: k, falling: turned.column === k && !turned.falling };
    [...head.cells].forEach((cell, j) => {
      if (j === k) cell.setAttribute("aria-sort", turned.falling ? "descending" : "ascending");
      else cell.removeAttribute("aria-sort");
    });
    const isFilled = ({ keys }) => keys[k] !== null && keys[k] !== "";
    const compare = (a, b) => (turned.falling ? -1 : 1) * order(a.keys[k], b.keys[k]);
    const inOrder = (some, of) => [...some.filter((one) => isFilled(of(one))).sort((a, b) => compare(of(a), of(b))), ...some.filter((one) => !isFilled(of(one)))];
    for (const group of groups.values()) {
      group.made = inOrder(group.made, (row) => row);
      group.body.append(...group.made.map(({ line }) => line));
    }
    all.append(...inOrder([...groups.values()], ({ made }) => made[0]).map(({ body }) => body));
  }

  const all = h("table", {}, caption ? h("caption", {}, caption) : null, h("thead", {}, head), [...groups.values()].map(({ body }) => body));
  if (!rows.length) all.append(h("tbody", {}, h("tr", {}, h("td", { colspan: String(columns.length), class: "blank" }, empty))));
  const box = h("div", { class: "table", tabindex: "0", role: "region", "aria-label": caption || "Table" }, all);
  box.addEventListener("scroll", () => shade(box), { passive: true });
  watched.observe(box);
  return box;
}

/** A table that the server made (page_tables.py); `digits` may be a function of the column's name. */
export function servedTable(data, { caption = data.caption, digits = data.digits, symbols = false } = {}) {
  const columns = data.columns.map((name, k) => ({ name, unit: data.units[k], digits: typeof digits === "function" ? digits(name) : digits, symbols }));
  return table({ caption, columns, rows: data.rows });
}

const watched = new ResizeObserver((entries) => entries.forEach(({ target }) => shade(target)));

/** Edges behind which a table goes on are shaded: that it scrolls is seen where there is no bar. */
function shade(box) {
  box.classList.toggle("more", box.scrollTop + box.clientHeight < box.scrollHeight - 2);
  box.classList.toggle("wider", box.scrollLeft + box.clientWidth < box.scrollWidth - 2);
}

function heading(column, side, onclick) {
  const unit = column.unit ? h("span", { class: "unit" }, column.unit) : null;
  if (column.plain) return h("th", { scope: "col", class: side }, column.name || h("span", { class: "unseen" }, column.words), unit);
  return h("th", { scope: "col", class: side }, button([column.name, unit].filter(Boolean), onclick, { class: "head" }));
}

const isNumeric = (rows, k) => {
  const keys = rows.map((row) => key(row[k])).filter((row) => row !== null && row !== "");
  return keys.length > 0 && keys.every((key) => typeof key === "number");
};

function key(cell) {
  if (cell === null || cell === undefined) return null;
  if (cell instanceof Node) return cell.textContent;
  if (cell === "inf") return Infinity;
  if (typeof cell === "object") return cell.key;
  return typeof cell === "boolean" ? Number(cell) : cell;
}

function shown(cell, column, places) {
  if (cell === null || cell === undefined) return "–";
  if (cell instanceof Node) return cell;
  if (typeof cell === "object") return cell.show;
  if (typeof cell === "boolean") return cell ? "yes" : "no";
  if (typeof cell === "number" && places !== null && Number.isFinite(cell)) return (Number(cell.toFixed(places)) === 0 ? (0).toFixed(places) : cell.toFixed(places)).replace("-", "−");
  if (typeof cell === "number" || cell === "inf") return number(cell, column.digits ?? 4);
  return column.symbols ? symbols(cell) : cell;
}

const MAX_PLACES = 6; // behind the point; columns that need more have powers of ten
const MAX_RATIO = 1e5; // of the largest to the least number of a column that is aligned

/**
 * The decimals of a column, so that its numbers align: as many as give the largest number `digits` digits and the least one two.
 * null where no number of decimals suits all.
 */
export function decimals(values, digits) {
  const sizes = values.filter((value) => Number.isFinite(value) && value !== 0).map(Math.abs);
  if (!sizes.length) return values.length ? 0 : null;
  if (values.every(Number.isInteger)) return Math.max(...sizes) < 1e6 ? 0 : null;
  const [least, largest] = [Math.min(...sizes), Math.max(...sizes)];
  const places = Math.max(0, digits - 1 - Math.floor(Math.log10(largest)), 1 - Math.floor(Math.log10(least)));
  if (places > MAX_PLACES || largest >= 1e6 || largest / least > MAX_RATIO) return null;
  const idle = Math.min(...values.map((value) => /0*$/.exec(value.toFixed(places))[0].length));
  return Math.max(0, places - idle);
}

function order(a, b) {
  if (typeof a === "number" && typeof b === "number") return a - b;
  return String(a).localeCompare(String(b), "en", { numeric: true });
}
