// A figure that the console drew, as SVG in the page: it follows light and dark, and is read out by its label.
import { text } from "./api.js";
import { h } from "./dom.js";

export async function figure(path, caption) {
  const parsed = new DOMParser().parseFromString(await text(path), "image/svg+xml");
  const svg = document.adoptNode(parsed.documentElement);
  for (const part of svg.querySelectorAll("style, script")) part.remove();
  for (const part of [svg, ...svg.querySelectorAll("[style]")]) {
    const looks = part.getAttribute("style");
    part.removeAttribute("style");
    if (looks) part.style.cssText = looks;
  }
  return h("figure", { class: "drawn" }, svg, h("figcaption", {}, caption));
}
