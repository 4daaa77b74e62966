// The page: menus, time, picking, and the picture they lead to. The part of the address after # keeps the choices.
const field = (id) => document.getElementById(id);
const state = { array: null, part: -1, frame: 0, low: 0, high: 1, picked: -1, pickedFace: -1, playing: 0 };
const layers = {};
let waiting = false;

function redraw() {
  if (!waiting) requestAnimationFrame(draw);
  waiting = true;
}

function draw() {
  waiting = false;
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio);
  canvas.height = Math.round(canvas.clientHeight * ratio);
  gl.viewport(0, 0, canvas.width, canvas.height);
  gl.clearColor(1, 1, 1, 1);
  gl.enable(gl.DEPTH_TEST);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  const { array } = state;
  const isolines = array && array.location === "vertex" && !array.rgb ? Number(field("isolines").value) || 0 : 0;
  use(layers.surface, { is_rgb: Boolean(array && array.rgb), edges: field("edges").checked, isolines: isolines && isolines + 1 });
  gl.drawArrays(gl.TRIANGLES, 0, scene.faces.length);
  if (field("arrows").checked && layers.arrows.instances) {
    use(layers.arrows, {});
    gl.drawArraysInstanced(gl.TRIANGLES, 0, layers.arrows.count, layers.arrows.instances);
  }
  for (const curve of layers.curves) {
    use(curve, { paint: [0.75, 0.1, 0.1] });
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, curve.instances);
  }
  for (const points of layers.points) {
    use(points, { paint: points.paint, size: points.size * ratio });
    gl.drawArrays(gl.POINTS, 0, points.count);
  }
}

// Colors of the surface, and arrows, for the array, its part, the range and the frame.
function recolor() {
  const { array, part, frame, low, high } = state;
  const log = field("log").checked;
  if (array && array.rgb) {
    const begin = (array.frames > 1 ? frame : 0) * array.rows * 3;
    const full = array.data instanceof Uint8Array ? 1 : 255 * array.scale;
    const rows = Uint8ClampedArray.from(array.data.subarray(begin, begin + array.rows * 3), (value) => full * value);
    fill(layers.surface, "color", atCorners(rows, 3, array.location, Uint8Array), 3);
  } else if (array) {
    const t = Float32Array.from(scalars(array, part, frame, log), (value) => (value - low) / (high - low));
    fill(layers.surface, "value", atCorners(t, 1, array.location, Float32Array), 1);
  }
  placeArrows();
  placePoints();
  redraw();
}

// Arrows of a vector array at the rows that the page names; the longest has the length that the page gives.
function placeArrows() {
  const { array, frame } = state;
  layers.arrows.instances = 0;
  if (!array || !array.arrows) return;
  const { rows, places } = array.arrows;
  const begin = (array.frames > 1 ? frame : 0) * array.rows * 3;
  const along = new Float32Array(3 * rows.length);
  for (let i = 0; i < rows.length; i++)
    for (let k = 0; k < 3; k++) along[3 * i + k] = array.data[begin + 3 * rows[i] + k] * array.arrows.length;
  fill(layers.arrows, "base", Float32Array.from(places), 3, true);
  fill(layers.arrows, "along", along, 3, true);
  layers.arrows.instances = rows.length;
}

function placePoints() {
  scene.points.forEach((item, k) => {
    const count = item.data.length / 3 / item.frames;
    const begin = (item.frames > 1 ? state.frame : 0) * count * 3;
    fill(layers.points[k], "position", item.data.slice(begin, begin + count * 3), 3);
    layers.points[k].count = count;
  });
  const marker = layers.points[layers.points.length - 1];
  marker.count = state.picked < 0 ? 0 : 1;
  if (marker.count) fill(marker, "position", scene.positions.slice(3 * state.picked, 3 * state.picked + 3), 3);
}

// Choose an array by name, with "name:x" for a component.
function choose(name) {
  const [base, component] = name.split(/:(?=[^:]*$)/);
  const { array: before, part } = state;
  const array = scene.arrays.find((item) => item.name === name) || scene.arrays.find((item) => item.name === base);
  state.array = array || null;
  state.part = array && array.name !== name && component ? Number(component) : -1;
  if (!array) return;
  if (array !== before || part !== state.part) {
    [state.low, state.high] = array.rgb ? [0, 1] : rangeOf(array, state.part, field("log").checked);
    field("map").value = array.map;
    field("array").value = name;
  }
  showRange();
  recolor();
}

function showRange() {
  const { array, low, high } = state;
  field("low").value = shown(low);
  field("high").value = shown(high);
  field("colorbar").hidden = !array || array.rgb;
  if (!array) return;
  const log = field("log").checked ? "log10 " : "";
  const part = state.part >= 0 ? `, component ${state.part}` : array.components > 1 ? ", length" : "";
  field("quantity").textContent = log + array.name + part;
  const middle = (low + high) / 2;
  field("colorbar").querySelectorAll(".ticks span").forEach((item, k) => {
    item.textContent = String(Number([low, middle, high][k].toPrecision(4)));
  });
  const colors = Uint8Array.from(atob(scene.maps[field("map").value]), (letter) => letter.charCodeAt(0));
  gl.bindTexture(gl.TEXTURE_2D, layers.colors);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 256, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, colors);
  const bar = field("colorbar").querySelector("canvas").getContext("2d");
  const pixels = bar.createImageData(256, 1);
  for (let i = 0; i < 256; i++) pixels.data.set([...colors.subarray(3 * i, 3 * i + 3), 255], 4 * i);
  bar.putImageData(pixels, 0, 0);
}

// The face under a point of the picture that is nearest to the viewer, and its corner nearest to that point.
function pick(x, y) {
  const [width, height] = halfExtent(canvas);
  const px = camera.middle[0] + width * ((2 * x) / canvas.clientWidth - 1);
  const py = camera.middle[1] + height * (1 - (2 * y) / canvas.clientHeight);
  const { positions, faces } = scene;
  const a = camera.axes;
  const n = positions.length / 3;
  const seen = new Float64Array(3 * n);
  for (let i = 0; i < n; i++)
    for (let k = 0; k < 3; k++)
      seen[3 * i + k] = a[3 * k] * positions[3 * i] + a[3 * k + 1] * positions[3 * i + 1] + a[3 * k + 2] * positions[3 * i + 2];
  let [depth, face, vertex] = [-Infinity, -1, -1];
  for (let f = 0; f < faces.length; f += 3) {
    const at = [3 * faces[f], 3 * faces[f + 1], 3 * faces[f + 2]];
    const turned = (i, j) => (seen[at[i]] - px) * (seen[at[j] + 1] - py) - (seen[at[i] + 1] - py) * (seen[at[j]] - px);
    const weights = [turned(1, 2), turned(2, 0), turned(0, 1)];
    const total = weights[0] + weights[1] + weights[2];
    if (!total || weights.some((weight) => weight / total < 0)) continue;
    const z = weights.reduce((sum, weight, k) => sum + (weight / total) * seen[at[k] + 2], 0);
    if (z <= depth) continue;
    [depth, face] = [z, f / 3];
    const apart = at.map((i) => Math.hypot(seen[i] - px, seen[i + 1] - py));
    vertex = faces[f + apart.indexOf(Math.min(...apart))];
  }
  showValues(vertex, face);
}

function showValues(vertex, face) {
  [state.picked, state.pickedFace] = [vertex, face];
  field("values").hidden = vertex < 0;
  const rows = [];
  if (vertex >= 0) {
    const place = [0, 1, 2].map((k) => scene.positions[3 * vertex + k] * scene.size + scene.center[k]);
    rows.push(["vertex", String(vertex)], ["position", place.map(shown).join("  ")]);
    const listed = (location, row) => {
      for (const array of scene.arrays)
        if (array.location === location) rows.push([array.name, rowOf(array, row, state.frame).map(shown).join("  ")]);
    };
    listed("vertex", vertex);
    if (face >= 0) {
      rows.push(["face", String(face)]);
      listed("face", face);
    }
  }
  const table = field("values").querySelector("table");
  table.replaceChildren(...rows.map((texts) => {
    const row = document.createElement("tr");
    row.append(...texts.map((text) => Object.assign(document.createElement("td"), { textContent: text })));
    return row;
  }));
  placePoints();
  redraw();
}

function showFrame(frame) {
  state.frame = Math.max(0, Math.min(scene.times.length - 1, Math.round(frame)));
  field("frame").value = state.frame;
  field("time").textContent = `t = ${shown(scene.times[state.frame])}`;
  recolor();
  if (state.picked >= 0) showValues(state.picked, state.pickedFace);
}

function play() {
  clearInterval(state.playing);
  const starts = field("play").textContent === "play";
  field("play").textContent = starts ? "stop" : "play";
  if (starts) state.playing = setInterval(() => showFrame((state.frame + 1) % scene.times.length), 100);
}

function fillMenus() {
  for (const array of scene.arrays) {
    const names = [array.name];
    if (!array.rgb && array.components > 1) for (let k = 0; k < array.components; k++) names.push(`${array.name}:${k}`);
    field("array").append(...names.map((name) => new Option(name, name)));
  }
  document.body.classList.toggle("bare", !scene.arrays.length);
  field("colorbar").hidden = true;
  field("map").append(...Object.keys(scene.maps).map((name) => new Option(name, name)));
  field("arrows").parentElement.hidden = !scene.arrays.some((array) => array.arrows);
  field("arrows").checked = true;
  field("timeline").hidden = scene.times.length < 2;
  field("frame").max = scene.times.length - 1;
}

function listen() {
  field("controls").addEventListener("submit", (event) => event.preventDefault());
  field("array").addEventListener("change", () => choose(field("array").value));
  field("map").addEventListener("change", () => { showRange(); redraw(); });
  field("log").addEventListener("change", () => {
    const name = field("array").value;
    [state.array, state.part] = [null, -1];
    choose(name);
  });
  for (const id of ["low", "high"])
    field(id).addEventListener("change", () => {
      const value = Number(field(id).value);
      if (Number.isFinite(value) && (id === "low" ? value < state.high : value > state.low)) state[id] = value;
      showRange();
      recolor();
    });
  for (const id of ["isolines", "edges", "arrows"]) field(id).addEventListener("input", redraw);
  field("home").addEventListener("click", () => { resetCamera(); redraw(); });
  field("picture").addEventListener("click", () => canvas.toBlob((blob) => {
    Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: "view.png" }).click();
  }));
  field("frame").addEventListener("input", () => showFrame(Number(field("frame").value)));
  field("play").addEventListener("click", play);
  window.addEventListener("resize", redraw);
  window.addEventListener("keydown", (event) => { if (event.key === "Escape") showValues(-1, -1); });
  listenToCamera(canvas, redraw, pick);
}

// Choices in the address: #array=distance&frame=3&vertex=7&isolines=12&turn=0.5,0.2
function followAddress() {
  const asked = new URLSearchParams(location.hash.slice(1));
  choose(asked.get("array") || (scene.arrays.length ? scene.active : ""));
  if (asked.has("isolines")) field("isolines").value = asked.get("isolines");
  if (asked.has("edges")) field("edges").checked = true;
  if (asked.has("turn")) turn(...asked.get("turn").split(",").map(Number));
  if (asked.has("frame")) showFrame(Number(asked.get("frame")));
  if (asked.has("vertex")) showValues(Number(asked.get("vertex")), -1);
  if (asked.has("click")) pick(...asked.get("click").split(",").map((share, k) => share * [canvas.clientWidth, canvas.clientHeight][k]));
}

async function start() {
  if (!gl) throw Error("this browser has no WebGL 2");
  if (typeof DecompressionStream === "undefined") throw Error("this browser is too old to unpack the data");
  await loadScene();
  resetCamera();
  layers.surface = program(SURFACE);
  fill(layers.surface, "position", atCorners(scene.positions, 3, "vertex", Float32Array), 3);
  fill(layers.surface, "normal", atCorners(scene.normals, 3, "vertex", Int8Array), 3);
  layers.colors = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, layers.colors);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB8, 1, 1, 0, gl.RGB, gl.UNSIGNED_BYTE, new Uint8Array([204, 204, 204]));
  layers.arrows = program(ARROWS);
  const [parts, normals] = arrowShape();
  fill(layers.arrows, "part", parts, 3);
  fill(layers.arrows, "part_normal", normals, 3);
  layers.arrows.count = parts.length / 3;
  layers.curves = scene.curves.map((item) => {
    const layer = program(CURVES);
    const segments = item.data;
    fill(layer, "side", Float32Array.from([0, -1, 0, 1, 1, -1, 1, 1]), 2);
    const pairs = segments.length / 6;
    const [starts, ends] = [new Float32Array(3 * pairs), new Float32Array(3 * pairs)];
    for (let i = 0; i < pairs; i++) {
      starts.set(segments.subarray(6 * i, 6 * i + 3), 3 * i);
      ends.set(segments.subarray(6 * i + 3, 6 * i + 6), 3 * i);
    }
    fill(layer, "start", starts, 3, true);
    fill(layer, "end", ends, 3, true);
    layer.instances = pairs;
    return layer;
  });
  layers.points = scene.points.map((item) => Object.assign(program(POINTS), { paint: [0.75, 0.1, 0.1], size: item.size }));
  layers.points.push(Object.assign(program(POINTS), { paint: [0.1, 0.1, 0.1], size: 12 }));
  fillMenus();
  listen();
  showFrame(0);
  followAddress();
  draw();
  document.body.dataset.state = gl.getError() ? "failed" : "ready";
}

start().catch((error) => {
  field("problem").hidden = false;
  field("problem").textContent = `Nothing can be drawn: ${error.message}.`;
  document.body.dataset.state = "failed";
});
