"use strict";
// One page: meshcat's viewer shows the scene and runs its animation, the bar below drives it.
(async function () {
  const by = (id) => document.getElementById(id);
  const about = JSON.parse(by("about").textContent);
  const series = {};
  for (const [name, text] of Object.entries(about.series)) series[name] = new Float32Array(bytes(text).buffer);

  function bytes(text) {
    return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  }

  function fail(text) {
    by("failure").textContent = text;
    by("failure").hidden = false;
  }

  // ---- the scene ----------------------------------------------------------------------------------------------
  let viewer;
  try {
    viewer = new MeshCat.Viewer(by("pane"));
  } catch (error) {
    fail("This browser shows no 3D graphics (WebGL): " + error.message);
    throw error;
  }
  const apply = viewer.handle_command.bind(viewer);
  // The second arm has the shapes of the first: they are in the page once.
  viewer.handle_command = (command) => {
    apply(command);
    const copied = about.ghost && (command.path || "").startsWith("/arm/") && !command.path.includes("/dial");
    if (copied && ["set_object", "set_transform"].includes(command.type)) apply(ghostly(command));
  };

  function ghostly(command) {
    const copy = { ...command, path: "/ghost" + command.path.slice("/arm".length) };
    if (command.type === "set_object") {
      const material = { ...command.object.materials[0], ...about.ghost.material };
      copy.object = { ...command.object, materials: [material] };
    }
    return copy;
  }

  async function load() {
    const packed = new Blob([bytes(by("scene").textContent)]).stream();
    const buffer = await new Response(packed.pipeThrough(new DecompressionStream("gzip"))).arrayBuffer();
    const view = new DataView(buffer);
    for (let at = 0; at < buffer.byteLength; ) {
      const length = view.getUint32(at);
      viewer.handle_command_bytearray(new Uint8Array(buffer, at + 4, length));
      at += 4 + length;
    }
  }

  function set(path, property, value) {
    viewer.set_property(path.split("/").filter((part) => part), property, value);
  }

  function furnish() {
    set("Background", "top_color", [0.97, 0.98, 1.0]);
    set("Background", "bottom_color", [0.84, 0.88, 0.93]);
    const scale = about.grid.cell / 0.5;
    set("Grid", "scale", [scale, scale, scale]);
    set("Grid", "position", [0, 0, about.grid.height]);
    const grid = viewer.scene_tree.find(["Grid", "<object>"]).object.material;
    Object.assign(grid, { transparent: true, opacity: 0.35, depthWrite: false });
    set("Axes", "scale", Array(3).fill(0.2 * about.size));
    set("Lights", "scale", Array(3).fill(about.size));
    for (const light of ["PointLightNegativeX", "PointLightPositiveX"]) {
      set(`Lights/${light}/<object>`, "distance", 0);
      set(`Lights/${light}/<object>`, "intensity", 0.32);
    }
    set("Lights/AmbientLight/<object>", "intensity", 0.45);
  }

  // ---- the camera ---------------------------------------------------------------------------------------------
  const THREE = MeshCat.THREE;
  const yUp = ([x, y, z]) => new THREE.Vector3(x, z, -y);

  // The part of the window that panel and bar leave free: left, top, right, bottom [px].
  function free() {
    const panel = by("panel").getBoundingClientRect();
    const bottom = by("bar").hidden ? innerHeight : by("bar").getBoundingClientRect().top;
    const beside = innerWidth - panel.right > 0.45 * innerWidth;
    return beside ? [panel.right, 0, innerWidth, bottom] : [0, Math.min(panel.bottom, 0.4 * innerHeight), innerWidth, bottom];
  }

  function center() {
    const [left, top, right, bottom] = free();
    const [x, y] = [(innerWidth - left - right) / 2, (innerHeight - top - bottom) / 2];
    viewer.camera.setViewOffset(innerWidth, innerHeight, x, y, innerWidth, innerHeight);
    viewer.set_dirty();
  }

  function fit() {
    const camera = viewer.camera;
    const [left, top, right, bottom] = free();
    const [low, high] = [yUp(about.box.low), yUp(about.box.high)];
    const middle = low.clone().add(high).multiplyScalar(0.5);
    const back = yUp(about.view).normalize();
    const across = new THREE.Vector3(0, 1, 0).cross(back).normalize();
    const up = back.clone().cross(across);
    camera.fov = 38;
    const tangent = Math.tan((camera.fov * Math.PI) / 360);
    const [tx, ty] = [(tangent * (right - left)) / innerHeight, (tangent * (bottom - top)) / innerHeight];
    let distance = 0;
    for (let k = 0; k < 8; k++) {
      const corner = new THREE.Vector3(k & 1 ? low.x : high.x, k & 2 ? low.y : high.y, k & 4 ? low.z : high.z).sub(middle);
      const need = Math.max(Math.abs(corner.dot(across)) / tx, Math.abs(corner.dot(up)) / ty);
      distance = Math.max(distance, need + corner.dot(back));
    }
    distance *= 1.06;
    Object.assign(camera, { near: distance / 200, far: distance * 50 });
    camera.position.copy(middle).addScaledVector(back, distance);
    viewer.controls.target.copy(middle);
    center();
    viewer.controls.update();
  }

  // ---- the panel ----------------------------------------------------------------------------------------------
  function element(kind, text, parent) {
    const made = document.createElement(kind);
    if (text !== undefined) made.textContent = text;
    parent.appendChild(made);
    return made;
  }

  function legend() {
    by("title").textContent = document.title;
    by("magnified").textContent = about.magnified;
    for (const entry of about.legend) {
      const item = element("li", undefined, by("legend"));
      const line = element(entry.paths.length ? "label" : "span", undefined, item);
      if (entry.paths.length) {
        const box = element("input", undefined, line);
        Object.assign(box, { type: "checkbox", checked: true });
        box.addEventListener("change", () => {
          for (const path of entry.paths) set(path, "visible", box.checked);
          viewer.set_dirty();
        });
      }
      element("i", undefined, line).style.background = entry.color;
      element("span", entry.text, line);
    }
    for (const head of about.heads) element("th", head, by("heads")).scope = "col";
    for (const joint of about.joints) element("td", joint, element("tr", undefined, by("rows")));
    for (const row of by("rows").children) about.heads.slice(1).forEach(() => element("td", "", row));
    for (const note of about.notes) element("li", note, by("notes"));
    if (innerWidth <= 720 || innerHeight <= 480) by("panel").open = false;
    by("panel").addEventListener("toggle", center);
  }

  // Digits without the minus that a rounded-off zero would have.
  function fixed(value, digits) {
    return (Math.round(value * 10 ** digits) / 10 ** digits || 0).toFixed(digits);
  }

  // As many as the largest of a column deserves.
  const digits = {};
  for (const [name, values] of Object.entries(series)) {
    const largest = 1e3 * values.reduce((most, value) => Math.max(most, Math.abs(value) || 0), 0);
    digits[name] = largest > 0 ? Math.min(Math.max(3 - Math.floor(Math.log10(largest)), 1), 5) : 2;
  }

  function numbers(frame) {
    const n = about.joints.length;
    about.joints.forEach((_, j) => {
      const cells = by("rows").children[j].children;
      about.columns.forEach((name, column) => {
        const value = series[name][frame * n + j];
        const text = name === "q" ? fixed(value, 3) : fixed(1e3 * value, digits[name]);
        cells[column + 1].textContent = Number.isFinite(value) ? text : "\u2013";
      });
    });
    if (series.gap) {
      by("gap").textContent = `\u0394q: translucent \u2212 arm; between the tips: ${fixed(1e3 * series.gap[frame], digits.gap)} mm`;
      by("gap").hidden = false;
    }
  }

  // ---- time ---------------------------------------------------------------------------------------------------
  const animator = viewer.animator;
  const slider = by("time");
  const end = about.duration - 1e-6;
  let drawn = -1;
  let running = false;

  function play() {
    if (animator.time >= end) seek(0);
    animator.mixer.timeScale = Number(by("speed").value);
    animator.play();
    running = true; // a slow frame may reach the end before `follow` has seen it run
  }

  function seek(time) {
    animator.time = Math.min(Math.max(time, 0), about.duration);
    animator.seek(animator.time);
  }

  function toggle() {
    if (animator.playing) animator.pause();
    else play();
  }

  // animator.time stays at the end when meshcat has played to it.
  function follow() {
    const time = animator.time;
    if (running && !animator.playing && time >= end && by("repeat").checked) play();
    running = animator.playing;
    if (time !== drawn) {
      drawn = time;
      slider.value = time;
      const text = `${(about.start + time).toFixed(3)} s`;
      by("clock").textContent = `${text} of ${(about.start + about.duration).toFixed(3)} s`;
      slider.setAttribute("aria-valuetext", text);
      numbers(Math.round(time * about.rate));
    }
    const label = animator.playing ? "Pause" : "Play";
    if (by("play").getAttribute("aria-label") !== label) {
      by("play").setAttribute("aria-label", label);
      by("play").textContent = animator.playing ? "\u275a\u275a" : "\u25b6";
    }
    requestAnimationFrame(follow);
  }

  function keys(event) {
    const typing = event.target.closest("input, select, button, summary");
    const step = event.shiftKey ? 1 / about.rate : about.duration / 100;
    const moves = { ArrowLeft: animator.time - step, ArrowRight: animator.time + step, Home: 0, End: about.duration };
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    if (event.key === "f") fit();
    else if (event.key === " " && (!typing || typing === slider)) toggle();
    else if (event.key in moves && (!typing || typing === slider) && about.duration) seek(moves[event.key]);
    else return;
    event.preventDefault();
  }

  function controls() {
    slider.max = about.duration;
    slider.addEventListener("input", () => seek(Number(slider.value)));
    by("play").addEventListener("click", toggle);
    by("speed").addEventListener("change", () => { animator.mixer.timeScale = Number(by("speed").value); });
    document.addEventListener("visibilitychange", () => { if (document.hidden && animator.playing) animator.pause(); });
    // meshcat moves nodes of actions that have begun, and of no others.
    animator.play();
    animator.pause();
    seek(0);
    requestAnimationFrame(follow);
    if (!matchMedia("(prefers-reduced-motion: reduce)").matches) play();
  }

  legend();
  await load();
  furnish();
  by("bar").hidden = !about.duration;
  by("fit").addEventListener("click", fit);
  document.addEventListener("keydown", keys);
  window.addEventListener("resize", center);
  window.flexdyn = { viewer, about, seek, fit };
  viewer.set_3d_pane_size();
  fit();
  if (about.duration) controls();
  else numbers(0);
  document.body.dataset.ready = "yes";
})();
