"use strict";
// How pictures look; what they show comes from the diagnosis. Colours are those of page.css.
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const sum = (one, other) => one.map((x, k) => (x === null || other[k] === null ? null : x + other[k]));

// Of every picture; its buttons offer to send data to nobody.
const CONFIG = {
  displaylogo: false,
  responsive: true,
  modeBarButtonsToRemove: ["lasso2d", "select2d"],
  showSendToCloud: false,
  showEditInChartStudio: false,
  plotlyServerURL: "",
};

const axis = (more) => ({ gridcolor: colour("rule"), zeroline: false, automargin: true, tickfont: { size: 11 }, ...more });

// Plotly takes markup in a title.
function titled(text) {
  const marks = { "&": "&amp;", "<": "&lt;", ">": "&gt;" };
  return { text: text.replace(/[&<>]/g, (mark) => marks[mark]), standoff: 6 };
}

function page_(height, margin, more) {
  const font = { family: getComputedStyle(document.body).fontFamily, size: 12, color: colour("ink") };
  return { height, margin, paper_bgcolor: "white", plot_bgcolor: "white", font, hovermode: "closest", ...more };
}

// One curve: a line, dots, a line that can be seen among dots of its own colour, or the room that noise takes.
function drawn({ x, y, name, colour: tone, look, below }, columns) {
  const [own, axes] = [colour(tone), below ? { xaxis: below[0], yaxis: below[1] } : {}];
  const base = { type: "scatter", name, x: columns[x], y: columns[y], ...axes };
  const line = (color, width) => ({ ...base, mode: "lines", line: { color, width } });
  const told = { hovertemplate: `%{x:.5g}, %{y:.4g}<extra>${name}</extra>` };
  switch (look) {
    case "dots":
      return [{ ...base, ...told, mode: "markers", marker: { color: own, size: 3.5, opacity: 0.45 } }];
    case "bold":
      return [{ ...line("white", 5), hoverinfo: "skip" }, { ...line(own, 2.4), ...told }];
    case "band":
      return [{ ...line(own, 0), fill: "toself", fillcolor: `${own}55`, hoverinfo: "skip" }];
    default:
      return [{ ...line(own, 1.1), ...told }];
  }
}

// What was measured, the models with it, and their errors below; each is in the legend once. Not simplified by Plotly:
// it would choose points for the whole span, and a window would show straight pieces.
function moved(columns, row) {
  const [t, measured, ...errors] = columns;
  const models = [
    ["as given", { color: colour("before"), width: 1.6 }],
    ["calibrated", { color: colour("between"), width: 1.4, dash: "dot" }],
    ["corrected", { color: colour("after"), width: 1.6 }],
  ];
  const line = (name, style, y, place, showlegend) => ({
    type: "scatter", mode: "lines", x: t, y, yaxis: place ? `y${place + 1}` : "y", name, legendgroup: name, showlegend,
    line: { ...style, simplify: false }, hovertemplate: "%{x:.4f} s, %{y:.5g}",
  });
  const found = [line("measured", { color: colour("ink"), width: 3.4 }, measured, row, row === 0)];
  models.forEach(([name, style], k) => {
    found.push(line(name, style, sum(errors[k], measured), row, row === 0));
    found.push(line(name, style, errors[k], row + 1, false));
  });
  return found;
}

// Axes one below the other: of each pair the upper one is the higher one.
function stacked({ titles }) {
  const [rows, gap] = [2 * titles.length, 0.035];
  const scale = (1 - gap * (rows - 1)) / (0.43 * titles.length);
  const layout = page_(170 * rows, { l: 86, r: 10, t: 30, b: 44 }, {
    xaxis: axis({ automargin: false, anchor: `y${rows}`, title: titled("t [s]") }),
    legend: { orientation: "h", x: 0, y: 1, yanchor: "bottom" },
    dragmode: "zoom",
  });
  let top = 1;
  for (let row = 0; row < rows; row++) {
    const [label, low] = [titles[row >> 1], row % 2 === 1];
    const bottom = top - (low ? 0.15 : 0.28) * scale;
    const title = titled(low ? `error ${label.slice(label.indexOf("["))}` : label);
    const zero = { zeroline: low, zerolinecolor: colour("ink") };
    layout[row ? `yaxis${row + 1}` : "yaxis"] = axis({ automargin: false, domain: [Math.max(bottom, 0), top], title, ...zero });
    top = bottom - gap;
  }
  return layout;
}

// Axes by what a picture shows.
const LAYOUTS = {
  motion: stacked,
  residual: ({ titles: [x, y], limit }) => page_(246, { l: 58, r: 10, t: 10, b: 44 }, {
    xaxis: axis({ title: titled(x) }),
    yaxis: axis({ title: titled(y), zeroline: true, zerolinecolor: colour("ink"), ...(limit ? { range: [-limit, limit] } : {}) }),
    showlegend: false,
  }),
  plan: ({ titles: [x, y, left] }) => page_(430, { l: 62, r: 10, t: 8, b: 44 }, {
    xaxis: axis({ anchor: "y2", title: titled(x) }),
    yaxis: axis({ domain: [0.68, 1], title: titled(y) }),
    yaxis2: axis({ domain: [0, 0.6], title: titled(left) }),
    showlegend: false,
  }),
  force: ({ titles: [position, speed, force] }) => page_(330, { l: 62, r: 10, t: 8, b: 44 }, {
    xaxis: axis({ domain: [0, 0.47], title: titled(position) }),
    xaxis2: axis({ domain: [0.53, 1], anchor: "y2", title: titled(speed) }),
    yaxis: axis({ title: titled(force) }),
    yaxis2: axis({ anchor: "x2", matches: "y", showticklabels: false }),
    showlegend: false,
  }),
};

// Curves and axes of a picture, as Plotly wants them.
function picture(figure, columns) {
  const pairs = () => figure.titles.flatMap((_, k) => moved(columns.slice(5 * k, 5 * k + 5), 2 * k));
  const data = figure.kind === "motion" ? pairs() : figure.curves.flatMap((curve) => drawn(curve, columns));
  return { data, layout: LAYOUTS[figure.kind](figure) };
}
