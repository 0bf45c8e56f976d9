// The colours that this browser chose last, set before the first paint.
(() => {
  try {
    const saved = localStorage.getItem("theme");
    if (saved === "light" || saved === "dark") document.documentElement.dataset.theme = saved;
  } catch {
    // without storage the browser follows the system
  }
})();

// Paper is light: charts, which are drawn in the colours of the page, are drawn anew for it, and again afterwards.
(() => {
  const root = document.documentElement;
  let before;
  addEventListener("beforeprint", () => {
    before = root.dataset.theme;
    root.dataset.theme = "light";
    dispatchEvent(new Event("theme"));
  });
  addEventListener("afterprint", () => {
    if (before === undefined) delete root.dataset.theme;
    else root.dataset.theme = before;
    dispatchEvent(new Event("theme"));
  });
})();
