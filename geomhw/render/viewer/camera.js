// A parallel projection: rows right, up and toward the viewer; zoom; and the point in the middle, in view coordinates.
const camera = { axes: scene.axes.flat(), zoom: 1, middle: [0, 0] };

function resetCamera() {
  Object.assign(camera, { axes: scene.axes.flat(), zoom: 1, middle: [...scene.middle] });
}

// Turn about the picture's axes by angles to the right and down.
function turn(right, down) {
  const [c, s, d, e] = [Math.cos(right), Math.sin(right), Math.cos(down), Math.sin(down)];
  const turned = [c, 0, s, s * e, d, -c * e, -s * d, e, c * d];
  const old = camera.axes;
  camera.axes = turned.map((_, at) => {
    const [i, j] = [Math.floor(at / 3), at % 3];
    return turned[3 * i] * old[j] + turned[3 * i + 1] * old[3 + j] + turned[3 * i + 2] * old[6 + j];
  });
}

// Half width and half height of what is visible, in units of the scene.
function halfExtent(canvas) {
  const aspect = canvas.clientWidth / Math.max(canvas.clientHeight, 1);
  const [width, height] = scene.extent;
  const half = Math.max(height, width / aspect) * 1.12 / camera.zoom;
  return [half * aspect, half];
}

function listenToCamera(canvas, redraw, click) {
  const touches = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    touches.set(event.pointerId, [event.clientX, event.clientY]);
    moved = 0;
  });
  canvas.addEventListener("pointermove", (event) => {
    const last = touches.get(event.pointerId);
    if (!last) return;
    const [dx, dy] = [event.clientX - last[0], event.clientY - last[1]];
    const unit = (2 * halfExtent(canvas)[1]) / canvas.clientHeight;
    moved += Math.abs(dx) + Math.abs(dy);
    if (touches.size === 2) {
      const [other] = [...touches].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const apart = ([x, y]) => Math.hypot(x - other[0], y - other[1]);
      camera.zoom *= apart([event.clientX, event.clientY]) / Math.max(apart(last), 1);
      camera.middle = [camera.middle[0] - (dx * unit) / 2, camera.middle[1] + (dy * unit) / 2];
    } else if (event.shiftKey || event.buttons & 6) {
      camera.middle = [camera.middle[0] - dx * unit, camera.middle[1] + dy * unit];
    } else turn(dx / 150, dy / 150);
    touches.set(event.pointerId, [event.clientX, event.clientY]);
    redraw();
  });
  for (const name of ["pointerup", "pointercancel"])
    canvas.addEventListener(name, (event) => {
      if (touches.delete(event.pointerId) && name === "pointerup" && moved < 4) click(event.offsetX, event.offsetY);
    });
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const before = halfExtent(canvas);
    camera.zoom *= Math.exp(-event.deltaY / 500);
    const after = halfExtent(canvas);
    const [x, y] = [(2 * event.offsetX) / canvas.clientWidth - 1, 1 - (2 * event.offsetY) / canvas.clientHeight];
    camera.middle = [camera.middle[0] + x * (before[0] - after[0]), camera.middle[1] + y * (before[1] - after[1])];
    redraw();
  }, { passive: false });
  canvas.addEventListener("contextmenu", (event) => event.preventDefault());
  canvas.addEventListener("keydown", (event) => {
    const steps = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
    const zooms = { "+": 1.2, "-": 1 / 1.2 };
    if (steps[event.key]) turn(...steps[event.key]);
    else if (zooms[event.key]) camera.zoom *= zooms[event.key];
    else return;
    event.preventDefault();
    redraw();
  });
}
