// The scene: the machine as its own description says, on ground with ticks, its contact in the colour of what it does.

const BARE = 22; // on either side of an arrow, where no number of the ground stands
const ARROW = 1.1, LOAD_ARROW = 0.3; // the longest arrows of friction and load, in lengths of the equations

// now: { sides: of the contacts, friction, load, perForce, perLoad, shapes: coordinates by shape, camera, reach: how far the contact gets from it, origin, unit, slope: of the ground, uphill forward }
function drawScene(pen, theme, form, now) {
  const [rise, level] = [Math.abs(Math.sin(now.slope)), Math.cos(now.slope)];
  const low = -0.42 * level - rise, high = 1.95 * level + rise, scale = pen.height / (high - low), middle = pen.width / 2;
  pen.turned(middle, pen.height + low * scale, -now.slope, () => drawGround(pen, theme, form, now, scale, middle, low));
}

// The ground and what is on it, as on level ground.
function drawGround(pen, theme, form, now, scale, middle, low) {
  const along = Math.min(scale, (pen.width / 2 - scale) / now.reach); // a machine that goes far is seen from afar
  const px = (x) => middle + (x - now.camera) * along, py = (y) => pen.height - (y - low) * scale;
  const seen = Math.hypot(pen.width / 2, pen.height), half = seen / along;
  pen.path([middle - seen, py(0), middle + seen, py(0)], theme.axis, 1.5);
  const contact = form.scene.findIndex((shape) => shape.kind === "contact"), edge = contact < 0 ? 0 : (form.scene[contact].size[0] * scale) / 2;
  const x = contact < 0 ? NaN : px(now.shapes[contact][0]), load = x + 0.8 * edge, letterAt = x - Math.sign(-now.friction || 1) * 11;
  const covered = (place) => Math.abs(place - load - 6) < BARE || Math.abs(place - letterAt) < BARE; // by the arrows of the forces
  const unit = now.unit, each = ticks(0, (pen.width / along) * unit, 11)[1] / unit, step = each / 5;
  for (let k = Math.floor((now.camera - half) / step); k <= (now.camera + half) / step + 1; k++) {
    const mark = k * step, whole = Math.abs(mark / each - Math.round(mark / each)) < 1e-9;
    pen.path([px(mark), py(0), px(mark), py(whole ? -0.1 : -0.05)], theme.axis, 1);
    const text = said(mark * unit, 4), cut = Math.abs(px(mark) - middle) + 4 * text.length > pen.width / 2;
    if (whole && !cut && !covered(px(mark))) pen.text(px(mark), py(-0.13), text, { fill: theme.soft, size: 11, align: "center", base: "top" });
  }
  flag(pen, px(now.origin), py(0), theme);
  let contacts = 0;
  form.scene.forEach((shape, number) => drawn(pen, theme, shape, now.shapes[number], px, py, scale, shape.kind === "contact" ? now.sides[contacts++] : 0, now.walls[shape.box || shape.name] ?? 0));
  if (contact < 0) return;
  arrow(pen, theme, x, py(-0.3), -now.friction * now.perForce * scale, 0);
  letter(pen, theme, letterAt, py(-0.3), "R");
  arrow(pen, theme, load, py(-0.02), 0, Math.max(0, now.load) * now.perLoad * scale);
  letter(pen, theme, load + 12, py(-0.2), "N");
}

// Beside an arrow.
function letter(pen, theme, x, y, text) {
  pen.text(x, y, text, { fill: theme.ink, size: 12, align: "center", base: "middle" });
}

// Where the motion began.
function flag(pen, x, y, theme) {
  pen.path([x, y, x, y - 26], theme.second, 2);
  pen.shape([x, y - 26, x + 12, y - 21, x, y - 16], theme.second);
}

function drawn(pen, theme, shape, points, px, py, scale, side, wall) {
  const [x, y] = [px(points[0] - (shape.kind === "spring" ? wall : 0)), py(points[1])], far = 2 * (px(wall) - px(0));
  const w = shape.size[0] * scale + (shape.kind === "disc" ? 0 : far), h = shape.size[1] * scale;
  if (shape.kind === "box") pen.box(x - w / 2, y - h / 2, w, h, theme.body, theme.ink, 0.12 * scale);
  else if (shape.kind === "disc") pen.disc(x, y, w / 2, theme.first, theme.ink);
  else if (shape.kind === "hinge") pen.disc(x, y, 4, theme.paper, theme.ink);
  else if (shape.kind === "rod") pen.path([x, y, px(points[2]), py(points[3])], theme.ink, 3);
  else if (shape.kind === "spring") pen.path(coil(x, y, px(points[2]), py(points[3])), theme.ink, 1.5);
  else if (shape.kind === "contact") pen.path([x - w / 2, y, x + w / 2, y], side === undefined ? theme.soft : theme.side(side), 7);
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

// A force of the ground on the machine: along it from (x, y), or up to there.
function arrow(pen, theme, x, y, along, up) {
  const length = Math.abs(along) + up, head = Math.min(9, length);
  if (length < 3) { pen.disc(x, y, 2.5, theme.ink); return; }
  if (up) {
    pen.path([x, y + up, x, y + head * 0.8], theme.ink, 2.5);
    pen.shape([x, y, x - 5, y + head, x + 5, y + head], theme.ink);
    return;
  }
  const way = Math.sign(along), tip = x + along;
  pen.path([x, y, tip - way * head * 0.8, y], theme.ink, 2.5);
  pen.shape([tip, y, tip - way * head, y - 5, tip - way * head, y + 5], theme.ink);
}

// What a contact does, in words.
function contactWords(form, contact, side) {
  if (side === 0) return "sticks";
  const verb = form.rests[contact] ? "slips" : "slides";
  return `${verb} ${side > 0 ? "forward" : "back"}`;
}
