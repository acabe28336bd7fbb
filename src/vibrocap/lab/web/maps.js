// Maps and strips: many motions over one or two parameters, by a pool of workers, coarse to fine.

class Pool {
  constructor(make, count) {
    this.workers = Array.from({ length: count }, make);
    this.free = [...this.workers];
    this.queue = [];
    this.turn = 0;
  }

  // Forget what waits; what runs is not listened to any more.
  restart() { this.turn++; this.queue = []; }

  // Ask for all of these, in order of their list; each(answer, task) as they come, then done().
  run(tasks, each, done) {
    const turn = this.turn;
    let left = tasks.length;
    this.queue.push(...tasks.map((task) => ({
      task,
      then: (answer) => { if (turn === this.turn) { each(answer, task); if (--left === 0) done(); } },
    })));
    this.#feed();
  }

  #feed() {
    while (this.free.length && this.queue.length) {
      const worker = this.free.pop(), { task, then } = this.queue.shift();
      worker.ask(task.message).then(then, () => then(null)).finally(() => { this.free.push(worker); this.#feed(); });
    }
  }
}

// A worker with promises in place of messages.
class Asked {
  constructor(url) {
    this.worker = new Worker(url);
    this.waiting = new Map();
    this.last = 0;
    this.worker.onmessage = ({ data: { id, answer, failed } }) => {
      const { resolve, reject } = this.waiting.get(id);
      this.waiting.delete(id);
      if (failed === undefined) resolve(answer); else reject(new Error(failed));
    };
    this.worker.onerror = (event) => {
      for (const { reject } of this.waiting.values()) reject(new Error(event.message || "the worker failed"));
      this.waiting.clear();
    };
  }

  ask(message) {
    const id = ++this.last;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.worker.postMessage({ ...message, id });
    });
  }
}

// The value at a share of a range, by factors where the slider of the parameter goes by factors.
function atShare([low, high, log], share) {
  return log ? low * (high / low) ** share : low + (high - low) * share;
}

const SIZES = ["16", "32", "64", "128"];

// The settings of maps and strips as they are until another choice is made; an axis is a path, or "path,low,high".
function usualFields({ form }) {
  const axes = axesOf(form), second = axes.find((path) => path.startsWith("drive.amplitude")) ?? axes[1];
  const first = axes.includes("machine.mass_ratio") ? "machine.mass_ratio" : axes[0];
  const measures = form.measures.map(({ name }) => name);
  return {
    "map.x": first, "map.y": second, "map.measure": measures.includes("mean_velocity") ? "mean_velocity" : measures[0],
    "map.size": "64", "map.start": "own", "strip.x": second, "strip.state": form.states.find((_, i) => i !== form.cyclic),
  };
}

const axesOf = (form) => [...form.parameters, ...form.states.map((name) => `initial.${name}`).filter((path) => !isSwitched(form, path))];

// What such a setting may be, of those that are no axis.
function choicesOf({ form }, key) {
  if (key === "map.measure") return form.measures.map(({ name }) => name);
  if (key === "strip.state") return form.states.filter((name, i) => i !== form.cyclic && !form.switched.includes(name));
  return key === "map.size" ? SIZES : ["own", "mirrored"];
}

// An axis of such a setting: its path and range, low, high, by factors; the usual range where none is given.
function axisOf(model, text) {
  const [path, ...ends] = text.split(","), state = path.startsWith("initial.");
  const [low, high] = ends.length ? ends.map(typed) : usualRange(model, path);
  return { path, range: [low, high, !state && model.record(path).log && low > 0] };
}

function usualRange(model, path) {
  const [low, high] = rangeOfPath(model, path), { least, most } = path.startsWith("initial.") ? {} : model.record(path);
  const inset = (high - low) / 50, inner = (end, by) => Number((end + by).toPrecision(3));
  return [low <= least ? inner(least, inset) : low, high >= most ? inner(most, -inset) : high];
}

// What is wrong with such a setting; "" where nothing is.
function fieldWrong(model, key, text) {
  if (!/\.[xy]$/.test(key)) return choicesOf(model, key).includes(text) ? "" : `should be one of ${choicesOf(model, key).join(", ")}`;
  const [path, ...ends] = text.split(",");
  if (!axesOf(model.form).includes(path)) return "should be a number of this system";
  const [low, high] = ends.map(typed);
  if (ends.length === 0) return "";
  if (ends.length !== 2 || !Number.isFinite(low) || !Number.isFinite(high)) return "the ends of a range should be numbers";
  return low < high ? "" : "the range should rise";
}

// The cells of a map of n by n: every level halves the size, each cell once; [column, row, size] in cells.
function coarseToFine(n) {
  const found = [], seen = new Set();
  for (let size = n / 8; size >= 1; size /= 2) {
    for (let row = 0; row < n; row += size) {
      for (let column = 0; column < n; column += size) {
        const key = row * n + column;
        if (!seen.has(key)) { seen.add(key); found.push([column, row, size]); }
      }
    }
  }
  return found;
}

// The runs of some cells: the numbers of the model with those of the axes in their places.
function runsOf(model, axes, shares) {
  const { parameters, initial } = model.request();
  return shares.map((point) => {
    const run = { parameters: [...parameters], initial: [...initial] };
    axes.forEach(({ path, range }, i) => {
      const value = atShare(range, point[i]), place = model.form.parameters.indexOf(path);
      if (place >= 0) run.parameters[place] = value;
      else run.initial[model.form.states.indexOf(path.replace("initial.", ""))] = value;
    });
    return run;
  });
}

// Whether a cell is what the model would take; a cell of levels in the wrong order is none.
function allowed(model, axes, point) {
  const values = { ...model.state.values };
  axes.forEach(({ path, range }, i) => { if (path in values) values[path] = atShare(range, point[i]); });
  return axes.every(({ path }, i) => model.complaint(path, atShare(axes[i].range, point[i]), model.form, values) === "");
}

const SIGNED = ["mean_velocity", "drift", "displacement"], BOTH = 1e-6; // of the largest value: what is less is rounding
const BLUE_TO_ORANGE = [[0, 68, 136], [102, 166, 206], [240, 240, 236], [240, 164, 98], [166, 68, 0]];
const DARK_TO_LIGHT = [[48, 18, 90], [60, 82, 140], [36, 140, 140], [110, 196, 100], [250, 230, 60]];

// The colour at a share of a scale.
function inkOf(along, signed) {
  const list = signed ? BLUE_TO_ORANGE : DARK_TO_LIGHT, share = Math.min(1, Math.max(0, along)) * (list.length - 1);
  const k = Math.min(list.length - 2, Math.floor(share)), part = share - k;
  return `rgb(${list[k].map((each, i) => Math.round(each + part * (list[k + 1][i] - each))).join(",")})`;
}

// Ticks of an axis, [place, value]; by factors, low and high are powers of ten, which stand alone where there are enough.
function logTicks(low, high, log) {
  if (!log) return ticks(low, high, 6).map((each) => [each, each]);
  const powers = ticks(low, high, 4).map((each) => [each, 10 ** each]);
  return high - low > 1.5 ? powers : ticks(10 ** low, 10 ** high, 6).map((each) => [Math.log10(each), each]);
}

// A map: its cells as they are known, drawn with its axes and legend.
class FieldMap {
  constructor(n, axes, measure) {
    Object.assign(this, { n, axes, measure, cells: new Map(), signed: false });
  }

  // Groups of measures that have to be gathered.
  asked(form) { return form.measures.find(({ name }) => name === this.measure).asked; }

  put([column, row, size], found) { this.cells.set(row * this.n + column, { column, row, size, found }); }

  get range() {
    const values = [];
    for (const { found } of this.cells.values()) if (found && found.status === 1) values.push(found.values[this.measure]);
    const finite = values.filter(Number.isFinite).sort((a, b) => a - b), n = finite.length;
    if (!n) return [0, 1];
    const low = finite[0], top = finite[n - 1], most = Math.max(Math.abs(low), Math.abs(top)) || 1;
    this.signed = SIGNED.includes(this.measure) || Math.min(-low, top) > BOTH * most; // then 0 is seen, where a load lifts off
    this.log = !this.signed && low > 0 && top > 1e4 * low; // then by factors, up to a bound: what grows without one would hide all else
    if (this.log) return [low, 1e4 * low];
    return this.signed ? [-most, most] : [low, top === low ? low + 1 : top];
  }

  // The finest known cell at a point of the map, in cells.
  at(column, row) {
    for (let size = 1; size <= this.n; size *= 2) {
      const cell = this.cells.get(Math.floor(row / size) * size * this.n + Math.floor(column / size) * size);
      if (cell && cell.size >= size) return cell;
    }
    return null;
  }

  // labels and scales of both axes, [scale, unit] of the measure
  draw(pen, theme, { labels, scales, measure }, chosen) {
    const [low, high] = this.range, along = (value) => (this.log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low || 1));
    const axis = ({ range: [a, b, log] }, i) => [a, b].map((end) => (log ? Math.log10(end * scales[i]) : end * scales[i]));
    const [x, y] = [[0, this.n], [0, this.n]];
    const map = frame(pen, theme, { x, y, margin: { left: 64, right: 92, bottom: 44, top: 10 }, xTicks: [], title: "" });
    pen.box(0, 0, map.box.left - 1, pen.height, theme.paper);
    pen.box(map.box.left, map.box.top, map.box.right - map.box.left, map.box.bottom - map.box.top, theme.grid);
    const order = [...this.cells.values()].sort((a, b) => b.size - a.size);
    for (const { column, row, size, found } of order) {
      const [left, right] = [map.sx(column), map.sx(column + size)], [top, bottom] = [map.sy(row + size), map.sy(row)];
      const known = found?.status === 1, value = known ? found.values[this.measure] : NaN;
      pen.box(left, top, right - left + 0.5, bottom - top + 0.5, Number.isFinite(value) ? inkOf(along(value), this.signed) : theme.paper);
      if (!known) {
        pen.path([left, top, right, bottom], theme.bad, 1);
        pen.path([left, bottom, right, top], theme.bad, 1);
      } else if (found.response === 0) {
        for (let k = 0; k < 2; k++) pen.path([left + ((right - left) * k) / 2, bottom, left + ((right - left) * (k + 1)) / 2, top], Number.isFinite(value) ? "#222" : theme.soft, 0.8);
      }
    }
    this.axes.forEach((each, i) => this.ticks(pen, theme, map, i, axis(each, i), each.range[2], labels[i]));
    this.legend(pen, theme, map, low, high, measure);
    if (chosen) pen.box(map.sx(chosen[0]), map.sy(chosen[1] + 1), map.sx(1) - map.sx(0), map.sy(0) - map.sy(1), "", theme.ink);
    return map;
  }

  ticks(pen, theme, map, i, [low, high], log, label) {
    const place = (value) => ((value - low) / (high - low)) * this.n;
    const values = logTicks(low, high, log);
    for (const [where, value] of values) {
      if (i === 0) pen.text(map.sx(place(where)), map.box.bottom + 15, said(value, 3), { fill: theme.soft, size: 11, align: "center" });
      else pen.text(map.box.left - 6, map.sy(place(where)), said(value, 3), { fill: theme.soft, size: 11, align: "right", base: "middle" });
    }
    const centre = { fill: theme.ink, size: 12, align: "center" };
    if (i === 0) pen.text((map.box.left + map.box.right) / 2, pen.height - 6, label, centre);
    else pen.text(13, (map.box.top + map.box.bottom) / 2, label, { ...centre, turned: true });
  }

  legend(pen, theme, map, low, high, [size, unit]) {
    const left = map.box.right + 14, height = Math.min(200, map.box.bottom - map.box.top - 100), top = map.box.top + 4;
    for (let k = 0; k < 40; k++) pen.box(left, top + (height * (39 - k)) / 40, 14, height / 40 + 1, inkOf(k / 39, this.signed));
    pen.text(left + 18, top + 5, `${this.log ? "≥ " : ""}${said(high * size, 3)} ${unit}`.trimEnd(), { fill: theme.soft, size: 11, base: "middle" });
    pen.text(left + 18, top + height - 2, said(low * size, 3), { fill: theme.soft, size: 11, base: "middle" });
    if (this.signed || this.log) pen.text(left + 18, top + height / 2, this.log ? said(100 * low * size, 3) : "0", { fill: theme.soft, size: 11, base: "middle" });
    pen.box(left, top + height + 16, 14, 14, theme.grid);
    pen.path([left, top + height + 30, left + 14, top + height + 16], theme.ink, 1);
    pen.text(left + 18, top + height + 24, "unsettled", { fill: theme.soft, size: 11, base: "middle" });
    pen.path([left, top + height + 38, left + 14, top + height + 52], theme.bad, 1.2);
    pen.path([left, top + height + 52, left + 14, top + height + 38], theme.bad, 1.2);
    pen.text(left + 18, top + height + 46, "failed", { fill: theme.soft, size: 11, base: "middle" });
    pen.box(left, top + height + 60, 14, 14, theme.paper, theme.axis);
    pen.text(left + 18, top + height + 68, "no value", { fill: theme.soft, size: 11, base: "middle" });
  }
}

// Order in which the columns of a strip are computed, so that it fills evenly.
function spread(n) {
  const found = [], seen = new Set();
  for (let step = 2 ** Math.floor(Math.log2(n)); step >= 1; step /= 2) {
    for (let k = 0; k < n; k += step) if (!seen.has(k)) { seen.add(k); found.push(k); }
  }
  return found;
}
