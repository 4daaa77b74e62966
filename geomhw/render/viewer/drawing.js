// WebGL 2: the surface with its colors, arrows, curves and points. Each vertex of each face is drawn by itself, so that
// colors per face and per vertex, and edges, take one way.
const canvas = document.getElementById("surface");
const gl = canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });

const PROJECTION = `#version 300 es
  precision highp float;
  uniform mat3 axes; uniform vec2 middle, half_extent, pixel;
  vec4 project(vec3 p, float nearer) {
    vec3 q = p * axes;
    return vec4((q.xy - middle) / half_extent, -0.4 * q.z - nearer, 1.0);
  }
  vec3 lit(vec3 color, vec3 normal) {
    vec3 n = normalize(normal * axes);
    n = n.z < 0.0 ? -n : n;
    return color * (0.42 + 0.58 * dot(n, normalize(vec3(-0.25, 0.35, 1.0))));
  }`;
const SURFACE = [`
  in vec3 position, normal, color; in float value;
  out vec3 n, rgb, corner; out float t;
  void main() {
    int k = gl_VertexID % 3;
    corner = vec3(k == 0, k == 1, k == 2);
    n = normal; rgb = color; t = value;
    gl_Position = project(position, 0.0);
  }`, `
  in vec3 n, rgb, corner; in float t;
  uniform sampler2D colors; uniform bool is_rgb, edges; uniform float isolines;
  out vec4 result;
  float line(float distance, float width) { return 1.0 - smoothstep(width - 0.5, width + 0.5, distance); }
  void main() {
    vec3 color = vec3(0.8);
    if (is_rgb) color = rgb;
    else if (!isnan(t) && !isinf(t)) {
      color = texture(colors, vec2(0.5 / 256.0 + clamp(t, 0.0, 1.0) * 255.0 / 256.0, 0.5)).rgb;
      float level = t * isolines;
      if (isolines > 0.0 && t > 0.0 && t < 1.0 && level > 0.5 && level < isolines - 0.5)
        color *= 1.0 - 0.75 * line(abs(fract(level - 0.5) - 0.5) / max(fwidth(level), 1e-9), 0.7);
    }
    color = lit(color, n);
    if (edges) {
      vec3 d = corner / fwidth(corner);
      color *= 1.0 - 0.6 * line(min(d.x, min(d.y, d.z)), 0.5);
    }
    result = vec4(color, 1.0);
  }`];
const ARROWS = [`
  in vec3 part, base, along; in vec3 part_normal;
  out vec3 n;
  void main() {
    float size = max(length(along), 1e-30);
    vec3 z = along / size;
    vec3 x = normalize(cross(z, abs(z.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0)));
    mat3 frame = mat3(x, cross(z, x), z);
    n = frame * part_normal;
    gl_Position = project(base + size * (frame * part), 0.004);
  }`, `
  in vec3 n; out vec4 result;
  void main() { result = vec4(lit(vec3(0.13, 0.13, 0.2), n), 1.0); }`];
const CURVES = [`
  in vec2 side; in vec3 start, end;
  void main() {
    vec4 a = project(start, 0.003), b = project(end, 0.003);
    vec2 d = (b.xy - a.xy) / pixel;
    d = length(d) > 0.0 ? normalize(d) : vec2(1, 0);
    vec4 p = side.x < 0.5 ? a : b;
    p.xy += (side.y * vec2(-d.y, d.x) + (2.0 * side.x - 1.0) * d) * pixel * 2.0;
    gl_Position = p;
  }`, `
  uniform vec3 paint; out vec4 result;
  void main() { result = vec4(paint, 1.0); }`];
const POINTS = [`
  in vec3 position; uniform float size;
  void main() { gl_Position = project(position, 0.004); gl_PointSize = size; }`, `
  uniform vec3 paint; uniform float size; out vec4 result;
  void main() {
    float r = length(gl_PointCoord - 0.5) * size;
    if (r > 0.5 * size) discard;
    result = vec4(size > 8.0 && r > 0.5 * size - 1.5 ? vec3(1.0) : paint, 1.0);
  }`];

function program([vertex, fragment]) {
  const made = gl.createProgram();
  const sources = [[gl.VERTEX_SHADER, PROJECTION + vertex], [gl.FRAGMENT_SHADER, PROJECTION + fragment]];
  for (const [kind, source] of sources) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw Error(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  }
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw Error(gl.getProgramInfoLog(made));
  return { made, array: gl.createVertexArray(), buffers: {}, count: 0, instances: 0 };
}

// Fill an attribute of a layer; perInstance: one value for each instance.
function fill(layer, name, data, size, perInstance = false) {
  gl.bindVertexArray(layer.array);
  layer.buffers[name] ??= gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, layer.buffers[name]);
  gl.bufferData(gl.ARRAY_BUFFER, data, gl.DYNAMIC_DRAW);
  const at = gl.getAttribLocation(layer.made, name);
  if (at < 0) return;
  const type = data instanceof Uint8Array ? gl.UNSIGNED_BYTE : data instanceof Int8Array ? gl.BYTE : gl.FLOAT;
  gl.enableVertexAttribArray(at);
  gl.vertexAttribPointer(at, size, type, type !== gl.FLOAT, 0, 0);
  gl.vertexAttribDivisor(at, perInstance ? 1 : 0);
}

// Use a layer, with uniforms by name: numbers, booleans or arrays.
function use(layer, uniforms) {
  gl.useProgram(layer.made);
  gl.bindVertexArray(layer.array);
  const extent = halfExtent(canvas);
  const pixel = [2 / canvas.clientWidth, 2 / canvas.clientHeight];
  gl.uniformMatrix3fv(gl.getUniformLocation(layer.made, "axes"), false, camera.axes);
  for (const [name, value] of Object.entries({ middle: camera.middle, half_extent: extent, pixel, ...uniforms })) {
    const at = gl.getUniformLocation(layer.made, name);
    if (typeof value === "boolean") gl.uniform1i(at, value);
    else if (typeof value === "number") gl.uniform1f(at, value);
    else gl[`uniform${value.length}fv`](at, value);
  }
}

// Values of rows for each corner of each face.
function atCorners(values, size, location, kind) {
  const faces = scene.faces;
  const found = new kind(faces.length * size);
  for (let c = 0; c < faces.length; c++) {
    const row = location === "face" ? Math.floor(c / 3) : faces[c];
    for (let k = 0; k < size; k++) found[c * size + k] = values[row * size + k];
  }
  return found;
}

// An arrow of length 1 along z: shaft and head with eight sides.
function arrowShape() {
  const parts = [], normals = [];
  const ring = (r, z, k) => [r * Math.cos((k * Math.PI) / 4), r * Math.sin((k * Math.PI) / 4), z];
  for (const [r0, z0, r1, z1] of [[0.04, 0, 0.04, 0.7], [0.04, 0.7, 0.12, 0.7], [0.12, 0.7, 0, 1]])
    for (let k = 0; k < 8; k++) {
      const [a, b, c, d] = [ring(r0, z0, k), ring(r0, z0, k + 1), ring(r1, z1, k + 1), ring(r1, z1, k)];
      parts.push(...a, ...b, ...c, ...a, ...c, ...d);
      for (const j of [k, k + 1, k + 1, k, k + 1, k]) normals.push(...ring(z1 - z0, r0 - r1, j));
    }
  return [new Float32Array(parts), new Float32Array(normals)];
}
