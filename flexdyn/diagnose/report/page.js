// Pictures; everything else in the page is there without a script.
const text = (name) => document.getElementById(name).textContent;
const rooms = [...document.querySelectorAll("[data-picture]")];

// What the page holds is deflated and written in base64: plain, it would be three times as long.
async function unpacked(name) {
  const bytes = Uint8Array.from(atob(text(name)), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Response(stream).text();
}

// Columns are whole numbers, each as its difference to the one before; null: a gap.
function column(packed) {
  let level = 0;
  return packed.steps.map((step) => (step === null ? null : packed.unit * (level += step)));
}

function draw(room, figure) {
  const { data, layout } = picture(figure, figure.columns.map(column));
  room.style.height = `${layout.height}px`;
  return Plotly.react(room, data, layout, CONFIG);
}

// At once, which Plots.resize is not: the browser prints when its handlers have returned.
function printing(now) {
  document.body.classList.toggle("printing", now);
  for (const room of document.querySelectorAll(".js-plotly-plot")) {
    if (room.offsetWidth) Plotly.relayout(room, now ? { width: room.offsetWidth } : { width: null, autosize: true });
  }
}

async function start() {
  const figures = JSON.parse(await unpacked("figures"));
  if (!rooms.length) return;
  const element = document.createElement("script");
  element.textContent = await unpacked("library");
  document.head.append(element);
  for (const room of rooms) {
    const figure = figures[room.id];
    const show = () => (room.id === "motion" ? motion(room, figure) : draw(room, figure));
    const fold = room.closest("details");
    // A picture that is folded away has no width yet.
    if (fold && !fold.open) fold.addEventListener("toggle", show, { once: true });
    else show();
  }
  // Paper is narrower than the window, and pictures do not shrink by themselves: they are drawn for it beforehand.
  addEventListener("beforeprint", () => printing(true));
  addEventListener("afterprint", () => printing(false));
}

// Measured and simulated motion of one joint over a window of time.
function motion(room, parts) {
  const [joint, span, length, place] = ["joint", "span", "length", "place"].map((key) => document.getElementById(key));
  const shown = document.getElementById("shown");
  const part = () => parts.find((each) => each.joint === joint.value && each.span === span.value);
  let now;
  function range() {
    const [from, to] = now.reach;
    const wide = length.value === "all" ? to - from : Math.min(Number(length.value), to - from);
    const begin = from + (place.value / place.max) * (to - from - wide);
    place.disabled = wide >= to - from;
    shown.textContent = `${begin.toFixed(2)} to ${(begin + wide).toFixed(2)} s`;
    return [begin, begin + wide];
  }
  // The height follows the curves of the window, which Plotly does by itself only for all of them.
  function heights([from, to]) {
    const found = {};
    for (const trace of room.data) {
      const axis = "yaxis" + (trace.yaxis || "y").slice(1);
      for (let k = 0; k < trace.x.length; k++) {
        const [x, y] = [trace.x[k], trace.y[k]];
        if (y === null || x === null || x < from || x > to || trace.visible === "legendonly") continue;
        const held = (found[axis] = found[axis] || [y, y]);
        held[0] = Math.min(held[0], y);
        held[1] = Math.max(held[1], y);
      }
    }
    const room_ = ([low, high]) => [low - 0.06 * (high - low || 1e-12), high + 0.06 * (high - low || 1e-12)];
    return Object.fromEntries(Object.entries(found).map(([axis, ends]) => [`${axis}.range`, room_(ends)]));
  }
  async function show() {
    now = part();
    if (!now) return;
    await draw(room, now);
    move();
  }
  function move() {
    const window_ = range();
    Plotly.relayout(room, { "xaxis.range": window_, ...heights(window_) });
  }
  joint.addEventListener("change", show);
  span.addEventListener("change", show);
  length.addEventListener("change", move);
  place.addEventListener("input", move);
  return show();
}

start().catch((problem) => {
  for (const room of rooms) room.textContent = "This browser cannot draw the pictures of this page; a newer one can.";
  console.error(problem);
});
