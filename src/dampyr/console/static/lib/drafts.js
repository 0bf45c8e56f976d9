// Unsaved drafts in this browser's storage: a reload, another page or a closed window does not lose them.

/** drafts("campaign"): read(name), keep(name, value), drop(name); one value for each name. */
export function drafts(kind) {
  const place = (name) => `draft ${kind} ${name}`;
  return {
    read(name) {
      try {
        return JSON.parse(localStorage.getItem(place(name)));
      } catch {
        return null; // a browser without storage
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
        // nothing was stored
      }
    },
  };
}
