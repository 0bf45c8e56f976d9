
// A click on a heading sorts the table by it; a second click turns the order. Without script the tables just stand.
for (const table of document.querySelectorAll("table")) {
  const heads = [...table.tHead.rows[0].cells];
  const body = table.tBodies[0];
  const numeric = (a, b) => Number(a) - Number(b);
  const words = (a, b) => a.localeCompare(b, "en", { numeric: true });
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
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
