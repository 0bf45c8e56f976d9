// BokehJS out of the installed `bokeh` package, loaded when the first chart is drawn.
import { get } from "./api.js";
import { capital } from "./dom.js";

const FILES = ["/bokeh/bokeh.min.js", "/bokeh/bokeh-api.min.js"];
let loading = null;

/** The library; rejects with a sentence where it is not installed. */
export function bokeh() {
  loading ??= load().catch((problem) => {
    loading = null; // the next chart tries again
    throw problem;
  });
  return loading;
}

async function load() {
  const { charts } = await get("console");
  if (charts) throw new Error(`${capital(charts)}.`);
  adoptStyles();
  for (const file of FILES) await script(file);
  window.Bokeh.set_log_level("warn");
  return window.Bokeh;
}

function script(address) {
  return new Promise((resolve, reject) => {
    const element = document.createElement("script");
    element.src = address;
    element.onload = () => resolve();
    element.onerror = () => {
      element.remove();
      reject(new Error("The charts could not be loaded; reload the page."));
    };
    document.head.append(element);
  });
}

/**
 * Bokeh writes the style of its parts into `style` elements of their shadow roots, which the content policy of the console does
 * not allow (style-src 'self'). A style sheet that a script constructs is allowed: an element that does as `style` does, with such
 * a sheet, is made in its place. Nothing else of the console makes `style` elements.
 */
function adoptStyles() {
  if (customElements.get("shadow-style")) return;
  customElements.define("shadow-style", ShadowStyle);
  const create = document.createElement;
  document.createElement = function (tag, options) {
    return tag === "style" ? new ShadowStyle() : create.call(document, tag, options);
  };
}

class ShadowStyle extends HTMLElement {
  #sheet = new CSSStyleSheet();
  #text = "";
  #root = null;

  get textContent() {
    return this.#text;
  }

  set textContent(css) {
    this.#text = css;
    this.#sheet.replaceSync(css);
  }

  connectedCallback() {
    this.style.display = "none";
    this.#root = this.getRootNode();
    this.#root.adoptedStyleSheets = [...this.#root.adoptedStyleSheets, this.#sheet];
  }

  disconnectedCallback() {
    this.#root.adoptedStyleSheets = this.#root.adoptedStyleSheets.filter((sheet) => sheet !== this.#sheet);
  }
}
