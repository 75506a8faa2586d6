"use strict";
// Residuals and proposed experiments; everything else in the page is there without a script.
const figures = JSON.parse(document.getElementById("figures").textContent);
for (const [room, figure] of Object.entries(figures)) {
  Plotly.newPlot(room, figure.data, figure.layout, figure.config);
}
