// The address of what a page shows, for a reload, a bookmark or another window.
import { query } from "./api.js";

/** Write the address of a page; not once the person has left it: what comes late would name a page that is gone. */
export function setAddress(root, page, values) {
  if (root.isConnected) history.replaceState(null, "", `#/${page}?${query(values)}`);
}
