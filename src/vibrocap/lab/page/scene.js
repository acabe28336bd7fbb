// The scene: the machine as its own description says, on ground with ticks, its contact in the colour of what it does.

const ARROW = 1.1; // height of the friction arrow's longest, in lengths of the equations

// now: { position, side, friction, shapes: coordinates by shape, camera, start }
function drawScene(pen, theme, form, now) {
  const low = -0.42, high = 1.95, scale = pen.height / (high - low), middle = pen.width / 2;
  const px = (x) => middle + (x - now.camera) * scale, py = (y) => pen.height - (y - low) * scale;
  const half = pen.width / 2 / scale;
  pen.path([0, py(0), pen.width, py(0)], theme.axis, 1.5);
  const step = half > 6 ? 1 : 0.25, unit = now.unit;
  for (let k = Math.floor((now.camera - half) / step); k <= (now.camera + half) / step + 1; k++) {
    const x = k * step, whole = Math.abs(x - Math.round(x)) < 1e-9;
    pen.path([px(x), py(0), px(x), py(whole ? -0.1 : -0.05)], theme.axis, 1);
    if (whole) pen.text(px(x), py(-0.13), said(x * unit, 4), { fill: theme.soft, size: 11, align: "center", base: "top" });
  }
  flag(pen, px(now.origin), py(0), theme);
  form.scene.forEach((shape, number) => drawn(pen, theme, shape, now.shapes[number], px, py, scale, now.side));
  const contact = form.scene.findIndex((shape) => shape.kind === "contact");
  if (contact >= 0) arrow(pen, theme, px(now.shapes[contact][0]), py(-0.24), -now.friction * now.perForce * scale);
}

// Where the motion began.
function flag(pen, x, y, theme) {
  pen.path([x, y, x, y - 26], theme.second, 2);
  pen.shape([x, y - 26, x + 12, y - 21, x, y - 16], theme.second);
}

function drawn(pen, theme, shape, points, px, py, scale, side) {
  const [x, y] = [px(points[0]), py(points[1])], [w, h] = shape.size.map((each) => each * scale);
  if (shape.kind === "box") pen.box(x - w / 2, y - h / 2, w, h, theme.body, theme.ink, 0.12 * scale);
  else if (shape.kind === "disc") pen.disc(x, y, w / 2, theme.first, theme.ink);
  else if (shape.kind === "hinge") pen.disc(x, y, 4, theme.paper, theme.ink);
  else if (shape.kind === "rod") pen.path([x, y, px(points[2]), py(points[3])], theme.ink, 3);
  else if (shape.kind === "spring") pen.path(coil(x, y, px(points[2]), py(points[3])), theme.ink, 1.5);
  else if (shape.kind === "contact") pen.path([x - w / 2, y, x + w / 2, y], theme.side(side), 7);
}

function coil(x0, y0, x1, y1) {
  const points = [x0, y0], turns = 9, length = Math.hypot(x1 - x0, y1 - y0) || 1;
  const [ux, uy] = [(x1 - x0) / length, (y1 - y0) / length];
  for (let k = 0; k < 2 * turns; k++) {
    const along = length * (0.1 + (0.8 * (k + 0.5)) / (2 * turns)), out = k % 2 ? 7 : -7;
    points.push(x0 + ux * along - uy * out, y0 + uy * along + ux * out);
  }
  return [...points, x1, y1];
}

// The force of the ground on the machine.
function arrow(pen, theme, x, y, length) {
  if (Math.abs(length) < 3) { pen.disc(x, y, 2.5, theme.ink); return; }
  const way = Math.sign(length), tip = x + length, head = Math.min(9, Math.abs(length));
  pen.path([x, y, tip - way * head * 0.8, y], theme.ink, 2.5);
  pen.shape([tip, y, tip - way * head, y - 5, tip - way * head, y + 5], theme.ink);
}

// What the contact does, in words.
function contactWords(form, side) {
  if (side === 0) return "sticks";
  const verb = form.sticks ? "slips" : "slides";
  return `${verb} ${side > 0 ? "forward" : "back"}`;
}
