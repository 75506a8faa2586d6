"use strict";
// Residual pictures; everything else in the page is there without a script.
const figures = JSON.parse(document.getElementById("figures").textContent);
figures.forEach((figure, k) => {
  Plotly.newPlot(`trace-${k}`, figure.data, figure.layout, figure.config);
});
