"use strict";
// Draws the charts in the colours of the page, labels lines at their ends, and hides and shows entries in all of them.
const report = { data: JSON.parse(document.getElementById("data").textContent), hidden: new Set(), charts: new Map() };

(() => {
  const NARROW_PX = 560;
  const LABEL_PX = 14;
  const LEAST_MARGIN_PX = 12;
  const TOOLBAR_PX = 34; // above the data, so that the toolbar covers none
  const root = document.documentElement;
  const colour = (name) => getComputedStyle(root).getPropertyValue(name).trim();
  const dark = matchMedia("(prefers-color-scheme: dark)");
  const rest = report.data.entries.flatMap((entry, i) => (entry.first ? [] : [i]));
  // The signs that plotly draws, in the middle of a chip's line.
  const marks = {
    circle: "M11 5a4 4 0 1 0 8 0a4 4 0 1 0-8 0",
    square: "M11.4 1.4h7.2v7.2h-7.2z",
    "triangle-up": "M15 0l5 9h-10z",
    cross: "M13.3 0h3.4v3.3h3.3v3.4h-3.3v3.3h-3.4v-3.3h-3.3v-3.4h3.3z",
    star: "M15 0l1.3 3.5h3.7l-2.9 2.3 1.1 3.7-3.2-2.2-3.2 2.2 1.1-3.7-2.9-2.3h3.7z",
    hexagon: "M15 0l4.4 2.5v5l-4.4 2.5-4.4-2.5v-5z",
  };
  const dashes = { solid: "", dash: "7 4", dot: "2 3", dashdot: "7 3 2 3", longdash: "12 4", longdashdot: "12 3 2 3" };

  // The words in lines of at most so many characters.
  const wrapped = (words, length) => words.split(" ").reduce((said, word) => (said.length - said.lastIndexOf(">") + word.length > length ? `${said}<br>${word}` : `${said} ${word}`));

  function axis(given, length) {
    const title = { text: wrapped(given.title ?? "", length), standoff: 6, font: { size: 12 } };
    const grid = colour("--grid");
    return { ...given, title, automargin: true, gridcolor: grid, zerolinecolor: colour("--muted"), linecolor: grid, zeroline: given.zeroline ?? false };
  }

  function layoutOf(chart, width) {
    const given = chart.row_px ? closedUp(chart.layout, chart.row_px) : chart.layout;
    const narrow = width < NARROW_PX;
    const top = given.heading || !narrow ? TOOLBAR_PX : LEAST_MARGIN_PX;
    const room = !chart.labels ? 12 : narrow ? 26 : 175;
    return {
      ...given,
      height: given.height + top - LEAST_MARGIN_PX,
      ...Object.fromEntries(Object.entries(given).filter(([name]) => /^[xy]axis/.test(name)).map(([name, each]) => [name, axis(each, name[0] === "x" ? width / 9 : 60)])),
      title: { text: given.heading ?? "", font: { size: 12.5 }, x: 0, xref: "paper", y: 0.97, yanchor: "top" },
      margin: { l: 8, r: room, t: top, b: 8 },
      paper_bgcolor: "rgba(0,0,0,0)",
      plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: colour("--font"), size: 12, color: colour("--text") },
      hoverlabel: { bgcolor: colour("--panel"), bordercolor: colour("--muted"), font: { color: colour("--text"), size: 12.5 } },
      showlegend: false,
      dragmode: narrow ? false : "zoom",
      width,
      shapes: (given.shapes ?? []).map((shape) => (shape.type === "line" ? { ...shape, line: { ...shape.line, color: colour("--muted"), width: 1.5 } } : shape)),
    };
  }

  // Where entries stand one below the other: the rows of those that are shown, without gaps for the others.
  const shownRows = () => report.data.entries.map((_, i) => i).filter((i) => !report.hidden.has(i));

  function closedUp(layout, rowPx) {
    const rows = shownRows();
    const { ticktext } = layout.yaxis;
    const yaxis = { ...layout.yaxis, tickvals: rows.map((_, k) => k), ticktext: rows.map((i) => ticktext[i]), range: [Math.max(rows.length, 1) - 0.4, -0.6] };
    const { range, ...free } = layout.xaxis; // of all entries: those that are hidden need no room
    return { ...layout, xaxis: report.hidden.size ? free : layout.xaxis, yaxis, height: layout.height - rowPx * (report.data.entries.length - rows.length) };
  }

  const traces = (chart) =>
    chart.data.map((trace) => {
      const shown = { ...trace, visible: !report.hidden.has(trace.meta) };
      if (chart.row_px && shown.visible) shown.y = trace.y.map((y) => y - trace.meta + shownRows().indexOf(trace.meta));
      if (trace.mode === "markers+text") shown.textfont = { size: 12, color: colour("--text") };
      if (trace.marker && !trace.marker.color) shown.marker = { ...trace.marker, color: colour("--muted") };
      if (chart.places) shown.marker = { ...trace.marker, line: { width: 1, color: colour("--panel") } };
      if (trace.ink) shown.line = { ...trace.line, color: colour("--text") };
      return shown;
    });

  // The name of an entry, or only its place where there is little room, beside the end of its line; none over another.
  function labelEnds(box, chart) {
    const inner = box._fullLayout;
    if (!chart.labels || !inner?._size) return;
    const narrow = box.clientWidth < NARROW_PX;
    const ends = [];
    for (const trace of box._fullData) {
      if (trace.visible !== true || trace.meta === undefined || !trace.x) continue;
      let last = trace.y.length - 1;
      while (last > 0 && trace.y[last] == null) last -= 1;
      const x = inner.xaxis.d2p(trace.x[last]);
      const y = inner.yaxis.d2p(trace.y[last]);
      if (Number.isFinite(y)) ends.push({ i: trace.meta, x, y: Math.min(Math.max(y, 0), inner._size.h) });
    }
    ends.sort((a, b) => a.y - b.y);
    const gap = Math.min(LABEL_PX, inner._size.h / Math.max(ends.length, 1));
    ends.forEach((end, k) => (end.at = k ? Math.max(end.y, ends[k - 1].at + gap) : end.y));
    for (let k = ends.length - 1; k >= 0; k -= 1) ends[k].at = Math.min(ends[k].at, inner._size.h - (ends.length - 1 - k) * gap);
    const annotations = ends.map((end) => {
      const entry = report.data.entries[end.i];
      const text = narrow ? entry.place : `${entry.place} ${entry.name.length > 24 ? `${entry.name.slice(0, 23)}…` : entry.name}`;
      const at = { xref: "paper", x: 1, xanchor: "left", xshift: 5, yref: "paper", y: 1 - end.at / inner._size.h, yanchor: "middle" };
      return { ...at, text, showarrow: false, font: { size: 11.5, color: colour("--text") }, hovertext: entry.name };
    });
    Plotly.relayout(box, { annotations });
  }

  // The places of entries beside their dots, each where it is farthest from all dots and from the other places.
  function labelDots(box, chart) {
    const inner = box._fullLayout;
    if (!chart.places || !inner?._size) return;
    const dots = box._fullData.filter((trace) => trace.visible === true).map((trace) => ({ i: trace.meta, trace, x: inner.xaxis.d2p(trace.x[0]), y: inner.yaxis.d2p(trace.y[0]) }));
    const ways = [...Array(12).keys()].map((k) => (k * Math.PI) / 6 - Math.PI / 2);
    const taken = [...dots];
    const annotations = dots.map((dot) => {
      const spots = [16, 26, 38].flatMap((far) => ways.map((way) => ({ x: dot.x + far * Math.cos(way), y: dot.y + far * Math.sin(way), far })));
      const inside = spots.filter(({ x, y }) => x > 8 && x < inner._size.w - 8 && y > 8 && y < inner._size.h - 8);
      const free = (spot) => Math.min(18, ...taken.filter((other) => other !== dot).map((other) => Math.hypot(spot.x - other.x, spot.y - other.y)));
      const best = (inside.length ? inside : spots).reduce((a, b) => (free(b) - 0.2 * b.far > free(a) - 0.2 * a.far ? b : a));
      taken.push(best);
      const at = { x: dot.trace.x[0], y: dot.trace.y[0], ax: best.x - dot.x, ay: best.y - dot.y };
      if (inner.xaxis.type === "log") at.x = Math.log10(at.x);
      const arrow = { showarrow: true, arrowhead: 0, arrowwidth: 1, arrowcolor: colour("--muted"), standoff: 6 };
      return { ...at, ...arrow, text: report.data.entries[dot.i].place, font: { size: 12, color: colour("--text") }, captureevents: false };
    });
    Plotly.relayout(box, { annotations });
  }

  function draw(id) {
    const box = document.getElementById(id);
    const chart = report.charts.get(id);
    const width = box.clientWidth;
    const config = { displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"], displayModeBar: width >= NARROW_PX ? "hover" : false };
    Plotly.react(box, traces(chart), layoutOf(chart, width), config);
    labelEnds(box, chart);
    labelDots(box, chart);
    if (!box.dataset.ready) {
      box.dataset.ready = "1";
      box.on("plotly_relayout", (change) => {
        if (!Object.keys(change).some((key) => key.includes("axis"))) return;
        labelEnds(box, report.charts.get(id));
        labelDots(box, report.charts.get(id));
      });
    }
  }

  const drawAll = () => report.charts.forEach((_, id) => draw(id));

  // A panel per parameter: all entries, or one with the middle 80 % of the patients and, where there is one, the bound.
  function panels(focus) {
    for (const [k, parameter] of report.data.parameters.entries()) {
      const one = report.data.entries.findIndex((entry) => entry.label === focus);
      const data = one < 0 ? report.data.entries.map((entry, i) => lineOf(entry, i, parameter.key)) : bandOf(report.data.entries[one], parameter.key);
      const ticks = [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1];
      const y = { type: "log", tickvals: ticks, ticktext: ticks.map((tick) => `${100 * tick} %`), range: report.data.sd_range };
      report.charts.set(`parameter-${k}`, { data, layout: { xaxis: { title: "time, s" }, yaxis: y, height: 215, heading: parameter.title.replace("F_o", "F<sub>o</sub>"), hovermode: "closest" }, labels: false });
    }
  }

  function lineOf(entry, i, key) {
    const curves = report.data.curves[entry.label];
    const line = { color: entry.colour, dash: entry.dash, width: entry.width };
    return { x: curves.time, y: curves[key].centre, mode: "lines", meta: i, line, hovertemplate: `${entry.place} ${entry.name}<br>%{y:.1%} at %{x:.1f} s<extra></extra>` };
  }

  function bandOf(entry, key) {
    const { time: x, [key]: curve } = report.data.curves[entry.label];
    const plain = { x, mode: "lines", hoverinfo: "skip", line: { width: 0, color: entry.colour } };
    const found = [
      { ...plain, y: curve.low },
      { ...plain, y: curve.high, fill: "tonexty", fillcolor: `${entry.colour}38` },
      { x, y: curve.centre, mode: "lines", line: { color: entry.colour, width: 2 }, hovertemplate: "median %{y:.1%} at %{x:.1f} s<extra></extra>" },
    ];
    if (curve.bound) found.push({ x, y: curve.bound, mode: "lines", ink: true, line: { dash: "dash", width: 1.3 }, hovertemplate: "bound %{y:.1%} at %{x:.1f} s<extra></extra>" });
    return found;
  }

  function chips() {
    for (const box of document.querySelectorAll(".entries")) {
      const all = document.createElement("button");
      all.type = "button";
      all.className = "all";
      all.addEventListener("click", () => hide(report.hidden.size ? [] : rest));
      if (rest.length) box.append(all);
      report.data.entries.forEach((entry, i) => {
        const button = document.createElement("button");
        button.type = "button";
        button.dataset.entry = i;
        const line = `<line x1="1" y1="5" x2="29" y2="5" stroke="${entry.colour}" stroke-width="2.6" stroke-dasharray="${dashes[entry.dash]}"/><path d="${marks[entry.symbol]}" fill="${entry.colour}"/>`;
        button.innerHTML = `<svg viewBox="0 0 30 10" aria-hidden="true">${line}</svg><span></span>`;
        button.lastChild.textContent = `${entry.place} ${entry.name}`;
        button.addEventListener("click", () => toggle(i));
        box.append(button);
      });
    }
  }

  function toggle(i) {
    if (!report.hidden.delete(i)) report.hidden.add(i);
    press();
    drawAll();
  }

  function hide(entries) {
    report.hidden = new Set(entries);
    press();
    drawAll();
  }

  // The buttons as the charts are.
  function press() {
    for (const button of document.querySelectorAll(".entries button[data-entry]")) button.setAttribute("aria-pressed", String(!report.hidden.has(Number(button.dataset.entry))));
    for (const button of document.querySelectorAll(".entries .all")) button.textContent = report.hidden.size ? `Show all ${report.data.entries.length}` : "Show the best only";
  }

  report.draw = draw;
  for (const [id, chart] of Object.entries(report.data.charts)) report.charts.set(id, chart);
  const focus = document.getElementById("focus");
  panels("");
  focus.addEventListener("change", () => {
    panels(focus.value);
    document.getElementById("focus-note").hidden = !focus.value;
    report.data.parameters.forEach((_, k) => draw(`parameter-${k}`));
  });
  report.hidden = new Set(rest);
  chips();
  press();
  drawAll();
  dark.addEventListener("change", drawAll);
  let before = document.body.clientWidth;
  new ResizeObserver(() => {
    if (Math.abs(document.body.clientWidth - before) < 2) return;
    before = document.body.clientWidth;
    drawAll();
  }).observe(document.body);
  addEventListener("beforeprint", () => {
    root.classList.add("printing");
    document.querySelector("main").style.width = "680px";
    drawAll();
  });
  addEventListener("afterprint", () => {
    root.classList.remove("printing");
    document.querySelector("main").style.width = "";
    drawAll();
  });
})();
