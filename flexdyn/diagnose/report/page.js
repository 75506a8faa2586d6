"use strict";
// Residuals and proposed experiments; everything else in the page is there without a script.
const figures = JSON.parse(document.getElementById("figures").textContent);
for (const [name, figure] of Object.entries(figures)) {
  const room = document.getElementById(name);
  const draw = () => Plotly.newPlot(room, figure.data, figure.layout, figure.config);
  const fold = room.closest("details");
  // A picture that is folded away has no width yet.
  if (fold && !fold.open) fold.addEventListener("toggle", draw, { once: true });
  else draw();
}
