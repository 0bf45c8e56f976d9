// Work that is not saved yet, kept by this browser: a reload, another page or a closed window does not lose it.

/** drafts("campaign"): found(name), keep(name, value), drop(name). What is kept is one value for each name. */
export function drafts(kind) {
  const place = (name) => `draft ${kind} ${name}`;
  return {
    found(name) {
      try {
        return JSON.parse(localStorage.getItem(place(name)));
      } catch {
        return null; // a browser that keeps nothing
      }
    },
    keep(name, value) {
      try {
        localStorage.setItem(place(name), JSON.stringify(value));
        return true;
      } catch {
        return false;
      }
    },
    drop(name) {
      try {
        localStorage.removeItem(place(name));
      } catch {
        // nothing was kept
      }
    },
  };
}
