
// A click on a heading sorts the table by it; a second click turns the order. Without script the tables just stand. The
// heading's own words stay outside of the button, which lies over them: browsers print no button in a repeated heading.
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  const numeric = (a, b) => Number(a) - Number(b);
  const words = (a, b) => a.localeCompare(b, "en", { numeric: true });
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "sort";
    button.setAttribute("aria-label", `Sort by ${head.textContent.replace(/\s+/g, " ").trim()}`);
    head.append(button);
    button.addEventListener("click", () => {
      const falling = head.getAttribute("aria-sort") === "ascending";
      for (const other of heads) other.removeAttribute("aria-sort");
      head.setAttribute("aria-sort", falling ? "descending" : "ascending");
      const key = (row) => row.cells[column].dataset.key;
      const rows = [...body.rows];
      const filled = rows.filter((row) => key(row) !== "" && key(row) !== "nan");
      const empty = rows.filter((row) => !filled.includes(row));
      const number = (row) => Number(key(row).replace("inf", "Infinity"));
      const order = filled.every((row) => !Number.isNaN(number(row)))
        ? (a, b) => numeric(number(a), number(b))
        : (a, b) => words(key(a), key(b));
      filled.sort((a, b) => (falling ? -1 : 1) * order(a, b));
      body.append(...filled, ...empty);
    });
  });
}

// Each figure can be saved as a file of its own, in the colours of the page in light.
function alone(svg) {
  const root = document.documentElement;
  const before = root.dataset.theme;
  root.dataset.theme = "light";
  const looks = getComputedStyle(root);
  const value = (_, name) => looks.getPropertyValue(name).trim().replaceAll('"', "'");
  const copy = svg.cloneNode(true);
  const [, , width, height] = svg.getAttribute("viewBox").split(" ");
  copy.setAttribute("width", `${width}pt`);
  copy.setAttribute("height", `${height}pt`);
  const text = new XMLSerializer().serializeToString(copy).replace(/var\((--[\w-]+)\)/g, value);
  if (before === undefined) delete root.dataset.theme;
  else root.dataset.theme = before;
  return text;
}

document.querySelectorAll("figure").forEach((figure, k) => {
  const button = document.createElement("button");
  button.type = "button";
  button.className = "save";
  button.textContent = "Save as SVG";
  button.setAttribute("aria-label", `Save as SVG: figure ${k + 1}`);
  button.addEventListener("click", () => {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([alone(figure.querySelector("svg"))], { type: "image/svg+xml" }));
    link.download = `${String(k + 1).padStart(2, "0")}-${figure.closest("section").id}.svg`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  });
  figure.append(button);
});
