// The colours that this browser chose last, set before the first paint.
(() => {
  try {
    const saved = localStorage.getItem("theme");
    if (saved === "light" || saved === "dark") document.documentElement.dataset.theme = saved;
  } catch {
    // without storage the browser follows the system
  }
})();
