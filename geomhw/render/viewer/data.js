// The scene: a description in JSON, and compressed arrays beside it. Stored values are relative to a scale.
const scene = JSON.parse(document.getElementById("scene").textContent);
const TYPES = { f4: Float32Array, i4: Int32Array, u1: Uint8Array };

async function loadBuffer({ id, type }) {
  const text = document.getElementById(id).textContent;
  const packed = await fetch("data:application/octet-stream;base64," + text);
  const stream = packed.body.pipeThrough(new DecompressionStream("deflate"));
  return new TYPES[type](await new Response(stream).arrayBuffer());
}

async function loadScene() {
  scene.positions = await loadBuffer(scene.positions);
  scene.normals = new Int8Array((await loadBuffer(scene.normals)).buffer);
  scene.faces = await loadBuffer(scene.faces);
  for (const item of [...scene.arrays, ...scene.curves, ...scene.points]) item.data = await loadBuffer(item.data);
  for (const item of scene.arrays) item.rows = item.location === "face" ? scene.n_faces : scene.n_vertices;
}

// The components of an array at a vertex or face in a frame.
function rowOf(array, row, frame) {
  const begin = ((array.frames > 1 ? frame : 0) * array.rows + row) * array.components;
  return Array.from(array.data.subarray(begin, begin + array.components), (value) => value * array.scale);
}

// One number a row, in the unit of the data: a component, or the length of a vector.
function scalars(array, part, frame, log) {
  const { rows, components: d, scale, data } = array;
  const begin = (array.frames > 1 ? frame : 0) * rows * d;
  const values = new Float64Array(rows);
  for (let i = 0; i < rows; i++) {
    const at = begin + i * d;
    let value = data[at + Math.max(part, 0)] * scale;
    if (part < 0 && d > 1) {
      let sum = 0;
      for (let k = 0; k < d; k++) sum += data[at + k] * data[at + k];
      value = Math.sqrt(sum) * scale;
    }
    values[i] = log ? (value > 0 ? Math.log10(value) : NaN) : value;
  }
  return values;
}

// Smallest and largest finite value over all frames.
function rangeOf(array, part, log) {
  let low = Infinity, high = -Infinity;
  for (let frame = 0; frame < array.frames; frame++)
    for (const value of scalars(array, part, frame, log))
      if (Number.isFinite(value)) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
  if (low > high) return [0, 1];
  if (array.kind === "diverging" && part < 0 && !log) high = -(low = -Math.max(-low, high));
  if (high - low > 1e-6 * Math.max(-low, high)) return [low, high]; // more than the rounding of stored values
  return [low - Math.abs(low || 1) / 2, high + Math.abs(high || 1) / 2];
}

// Seven digits: what the stored values have.
function shown(value) {
  if (!Number.isFinite(value)) return String(value).replace("Infinity", "inf");
  return String(Number(value.toPrecision(7)));
}
