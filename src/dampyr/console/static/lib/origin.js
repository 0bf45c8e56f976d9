// What a list or a page says of records and cards that are not measured.
import { h } from "./dom.js";

const isUnreal = (origin) => ["simulated", "virtual"].includes(origin?.kind);

/** A badge for an origin that is not measured, or null. */
export const originBadge = (origin) => (isUnreal(origin) ? h("span", { class: "badge bad origin" }, origin.kind) : null);

/** A line to stand above `words` that are of such an origin, or null. */
export const originLine = (origin, words = "") => (isUnreal(origin) ? h("p", { class: "verdict bad origin" }, `${words}${words ? ": " : ""}${origin.kind}, not measured`) : null);
