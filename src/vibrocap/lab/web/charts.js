// Charts: pens that draw on a canvas or write SVG, and frames with axes.

class CanvasPen {
  // zoom: how many times larger everything is drawn, letters and lines too.
  constructor(canvas, zoom = 1) {
    const ratio = (window.devicePixelRatio || 1) * zoom, box = canvas.getBoundingClientRect();
    this.width = Math.max(1, box.width / zoom);
    this.height = Math.max(1, box.height / zoom);
    const [w, h] = [Math.round(this.width * ratio), Math.round(this.height * ratio)];
    if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
    this.context = canvas.getContext("2d");
    this.context.setTransform(ratio, 0, 0, ratio, 0, 0);
    this.context.clearRect(0, 0, this.width, this.height);
    this.context.lineJoin = this.context.lineCap = "round";
  }

  path(points, stroke, width = 1.5, dash = []) {
    const { context } = this;
    context.beginPath();
    for (let i = 0; i < points.length; i += 2) context.lineTo(points[i], points[i + 1]);
    context.strokeStyle = stroke;
    context.lineWidth = width;
    context.setLineDash(dash);
    context.stroke();
  }

  shape(points, fill, stroke = "", width = 1.5) {
    const { context } = this;
    context.beginPath();
    for (let i = 0; i < points.length; i += 2) context.lineTo(points[i], points[i + 1]);
    context.closePath();
    this.#ink(fill, stroke, width);
  }

  box(x, y, w, h, fill, stroke = "", radius = 0) {
    this.context.beginPath();
    this.context.roundRect(x, y, w, h, radius);
    this.#ink(fill, stroke, 1.5);
  }

  disc(x, y, r, fill, stroke = "", width = 1.5) {
    this.context.beginPath();
    this.context.arc(x, y, r, 0, 2 * Math.PI);
    this.#ink(fill, stroke, width);
  }

  text(x, y, words, { fill, size = 12, align = "left", weight = 400, turned = false, base = "alphabetic" }) {
    const { context } = this;
    context.save();
    context.translate(x, y);
    if (turned) context.rotate(-Math.PI / 2);
    context.font = `${weight} ${size}px system-ui, sans-serif`;
    context.textAlign = align;
    context.textBaseline = base;
    context.fillStyle = fill;
    context.fillText(words, 0, 0);
    context.restore();
  }

  // What is drawn is turned about a point, with the clock.
  turned(x, y, angle, draw) {
    this.context.save();
    this.context.translate(x, y);
    this.context.rotate(angle);
    this.context.translate(-x, -y);
    draw();
    this.context.restore();
  }

  within(x, y, w, h, draw) {
    this.context.save();
    this.context.beginPath();
    this.context.rect(x, y, w, h);
    this.context.clip();
    draw();
    this.context.restore();
  }

  #ink(fill, stroke, width) {
    const { context } = this;
    context.setLineDash([]);
    if (fill) { context.fillStyle = fill; context.fill(); }
    if (stroke) { context.strokeStyle = stroke; context.lineWidth = width; context.stroke(); }
  }
}

// The same, as SVG text.
class SvgPen {
  constructor(width, height) {
    Object.assign(this, { width, height, parts: [], clips: 0 });
  }

  #points(points) {
    const all = [];
    for (let i = 0; i < points.length; i += 2) all.push(`${points[i].toFixed(2)},${points[i + 1].toFixed(2)}`);
    return all.join(" ");
  }

  path(points, stroke, width = 1.5, dash = []) {
    const dashed = dash.length ? ` stroke-dasharray="${dash.join(" ")}"` : "";
    this.parts.push(`<polyline points="${this.#points(points)}" fill="none" stroke="${stroke}" stroke-width="${width}"${dashed}/>`);
  }

  shape(points, fill, stroke = "", width = 1.5) {
    this.parts.push(`<polygon points="${this.#points(points)}" fill="${fill || "none"}" stroke="${stroke || "none"}" stroke-width="${width}"/>`);
  }

  box(x, y, w, h, fill, stroke = "", radius = 0) {
    this.parts.push(`<rect x="${x}" y="${y}" width="${w}" height="${h}" rx="${radius}" fill="${fill || "none"}" stroke="${stroke || "none"}"/>`);
  }

  disc(x, y, r, fill, stroke = "", width = 1.5) {
    this.parts.push(`<circle cx="${x}" cy="${y}" r="${r}" fill="${fill || "none"}" stroke="${stroke || "none"}" stroke-width="${width}"/>`);
  }

  text(x, y, words, { fill, size = 12, align = "left", weight = 400, turned = false, base = "alphabetic" }) {
    const anchor = { left: "start", center: "middle", right: "end" }[align];
    const dy = { middle: 0.35, top: 0.8, alphabetic: 0 }[base] * size;
    const turn = turned ? ` transform="rotate(-90 ${x} ${y})"` : "";
    this.parts.push(`<text x="${x}" y="${y + dy}" fill="${fill}" font-size="${size}" font-weight="${weight}" text-anchor="${anchor}"${turn}>${escaped(words)}</text>`);
  }

  turned(x, y, angle, draw) {
    this.parts.push(`<g transform="rotate(${(angle * 180) / Math.PI} ${x} ${y})">`);
    draw();
    this.parts.push("</g>");
  }

  within(x, y, w, h, draw) {
    const name = `clip${this.clips++}`;
    this.parts.push(`<clipPath id="${name}"><rect x="${x}" y="${y}" width="${w}" height="${h}"/></clipPath><g clip-path="url(#${name})">`);
    draw();
    this.parts.push("</g>");
  }

  get svg() {
    return svgOf(this.width, this.height, this.parts.join("\n"));
  }
}

function svgOf(width, height, content) {
  return `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}" font-family="system-ui, sans-serif">${content}</svg>`;
}

function escaped(text) {
  return String(text).replace(/[&<>"]/g, (letter) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[letter]);
}

// Round numbers within a range, about so many.
function ticks(low, high, about = 5) {
  const span = high - low, raw = span / Math.max(1, about), power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((each) => each * power).find((each) => each >= raw * 0.999) ?? 10 * power;
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * span; k++) found.push(Number((k * step).toPrecision(12)));
  return found.length > 1 || about > 8 ? found : ticks(low, high, 2 * about); // one number is no scale
}

// The range of some numbers, with a margin; never empty.
function rangeOf(values, margin = 0.06) {
  let low = Infinity, high = -Infinity;
  for (const value of values) if (Number.isFinite(value)) { low = Math.min(low, value); high = Math.max(high, value); }
  if (!(high >= low)) return [-1, 1];
  const span = high - low > 1e-12 * Math.max(1, Math.abs(high)) ? high - low : Math.max(1e-3, 0.2 * Math.abs(high));
  const middle = (low + high) / 2, half = Math.max((high - low) / 2, span / 2) * (1 + 2 * margin);
  return [middle - half, middle + half];
}

// A frame with axes. Returns the maps from numbers to the pen's points, and its inner box.
function frame(pen, theme, { title, x, y, xName, yName, margin = {}, xTicks, note }) {
  const box = { left: margin.left ?? 52, top: margin.top ?? 26, right: pen.width - (margin.right ?? 12), bottom: pen.height - (margin.bottom ?? 36) };
  const width = box.right - box.left, height = box.bottom - box.top;
  const sx = (value) => box.left + ((value - x[0]) / (x[1] - x[0])) * width;
  const sy = (value) => box.bottom - ((value - y[0]) / (y[1] - y[0])) * height;
  for (const value of ticks(y[0], y[1], Math.max(2, Math.floor(height / 42)))) {
    pen.path([box.left, sy(value), box.right, sy(value)], value === 0 ? theme.axis : theme.grid, 1);
    pen.text(box.left - 6, sy(value), said(value, 4), { fill: theme.soft, size: 11, align: "right", base: "middle" });
  }
  for (const value of xTicks ?? ticks(x[0], x[1], Math.max(2, Math.floor(width / 70)))) {
    pen.path([sx(value), box.bottom, sx(value), box.bottom + 4], theme.axis, 1);
    pen.text(sx(value), box.bottom + 16, said(value, 4), { fill: theme.soft, size: 11, align: "center" });
  }
  pen.path([box.left, box.bottom, box.right, box.bottom], theme.axis, 1);
  const narrow = pen.width < 6.6 * ((title ?? "").length + (note ?? "").length);
  if (title) pen.text(narrow ? 8 : box.left, 15, title, { fill: theme.ink, size: narrow && title.length > 52 ? 10.5 : 12.5, weight: 600 });
  if (note) pen.text(box.right, narrow ? 30 : 15, note, { fill: theme.soft, size: 11, align: "right" });
  if (xName) pen.text((box.left + box.right) / 2, pen.height - 4, xName, { fill: theme.soft, size: 11, align: "center" });
  if (yName) pen.text(11, (box.top + box.bottom) / 2, yName, { fill: theme.soft, size: 11, align: "center", turned: true });
  return { box, sx, sy, inside: (draw) => pen.within(box.left, box.top - 1, width, height + 2, draw) };
}

// A line through points of numbers.
function trace(pen, { sx, sy }, xs, ys, stroke, width, dash) {
  const points = new Array(2 * xs.length);
  for (let i = 0; i < xs.length; i++) { points[2 * i] = sx(xs[i]); points[2 * i + 1] = sy(ys[i]); }
  pen.path(points, stroke, width, dash);
}

// A line whose colour is that of the side of the contact, piece by piece of one side.
function sidedTrace(pen, map, xs, ys, sides, theme, width) {
  let start = 0;
  for (let i = 1; i <= xs.length; i++) {
    if (i === xs.length || sides[i] !== sides[start]) {
      trace(pen, map, xs.slice(start, i), ys.slice(start, i), theme.side(sides[start]), width);
      if (i < xs.length) trace(pen, map, [xs[i - 1], xs[i]], [ys[i - 1], ys[i]], theme.side(sides[i]), width);
      start = i;
    }
  }
}

// Colours of the page, light or dark, as its styles say.
function themeOf(element) {
  const styles = getComputedStyle(element), get = (name) => styles.getPropertyValue(`--${name}`).trim();
  const theme = Object.fromEntries(["ink", "soft", "grid", "axis", "paper", "forward", "back", "stuck", "first", "second", "third", "fourth", "body", "bad"].map((name) => [name, get(name)]));
  theme.side = (side) => (side > 0 ? theme.forward : side < 0 ? theme.back : theme.stuck);
  return theme;
}
