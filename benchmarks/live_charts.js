// Bins of a sine of 2 Hz, 40 ms of them at a time, to charts in the page of a console: what `live_charts.py` runs in Chromium.
async (way) => {
  const main = document.getElementById("main");
  main.replaceChildren();
  const bin = (t) => {
    const [x, v] = [8 * Math.sin(4 * Math.PI * t), 100 * Math.cos(4 * Math.PI * t)];
    const force = 400 * Math.tanh(v / 20) + 2 * v;
    const near = (value) => value + 3 * Math.random();
    return { time: t, x_low: x, x_high: x + 0.1, force_low: near(force) - 4, force_high: near(force), voltage_low: 1.978, voltage_high: 1.982,
      temperature: 20 + 0.01 * Math.random(), velocity: v, x_first: x, force_first: near(force), x_second: x + 0.05, force_second: near(force) };
  };
  const take = await ({ nothing: async () => () => {}, canvas, bokeh })[way]();
  let at = 0;
  const send = (count) => {
    const rows = Array.from({ length: count }, () => bin(at++ / 100));
    take(Object.fromEntries(Object.keys(rows[0]).map((name) => [name, rows.map((row) => row[name])])));
  };
  send(1200);
  window.drawn = 0;
  setInterval(() => send(4), 40);
  const count = () => (window.drawn++, requestAnimationFrame(count));
  count();

  async function canvas() {
    const { live } = await import("/static/lib/live.js");
    const charts = live();
    main.append(charts.element);
    return charts.take;
  }

  async function bokeh() {
    const library = await (await import("/static/lib/bokeh.js")).bokeh();
    const made = [["time", 130], ["time", 130], ["time", 130], ["time", 176], ["x", 286], ["velocity", 286]].map(([across, height], k) => {
      const plot = new library.Plot({ height, sizing_mode: "stretch_width", toolbar_location: null, x_range: new library.Range1d(), y_range: new library.DataRange1d() });
      plot.add_layout(new library.LinearAxis(), "below");
      plot.add_layout(new library.LinearAxis(), "left");
      const source = new library.ColumnDataSource({ data: { x: [], y: [] } });
      plot.add_glyph(new library.Line({ x: { field: "x" }, y: { field: "y" } }), source);
      const host = document.createElement("div");
      return { plot, source, host, across, k };
    });
    const grid = document.createElement("div");
    const [strips, loops] = [document.createElement("div"), document.createElement("div")];
    grid.className = "live";
    strips.className = "strips";
    loops.className = "loops";
    grid.append(strips, loops);
    made.forEach((one) => (one.k < 4 ? strips : loops).append(one.host));
    main.append(grid);
    const page = new library.Document();
    made.forEach((one) => page.add_root(one.plot));
    await library.embed.add_document_standalone(page, document.body, made.map((one) => one.host));
    const rows = {};
    return (bins) => {
      for (const [name, values] of Object.entries(bins)) rows[name] = [...(rows[name] ?? []), ...values].slice(-1200);
      const pairs = (low, high, from = 0) => rows[low].flatMap((value, i) => (i < from ? [] : [value, rows[high][i]]));
      const names = [["x_low", "x_high"], ["force_low", "force_high"], ["voltage_low", "voltage_high"], ["temperature", "temperature"]];
      for (const { plot, source, k } of made) {
        const loop = k >= 4;
        const x = loop ? pairs(k === 4 ? "x_first" : "velocity", k === 4 ? "x_second" : "velocity", 800) : pairs("time", "time");
        source.data = { x, y: loop ? pairs("force_first", "force_second", 800) : pairs(...names[k]) };
        const reach = k === 4 ? 9 : 105;
        plot.x_range.setv(loop ? { start: -reach, end: reach } : { start: x[0], end: x.at(-1) });
      }
    };
  }
}
