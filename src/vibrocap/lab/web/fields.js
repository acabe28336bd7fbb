// The views of many motions: the map over two parameters and the strip of bifurcations along one.

const COLUMNS = 240, MARKS = 60, BATCH = 12;

class Fields {
  constructor(lab) {
    this.lab = lab;
    this.set = { map: null, strip: null };
    this.begunFor = {}; // what is shown, or on its way there
    this.finished = {};
    for (const name of ["map", "strip"]) {
      const canvas = $$(name);
      canvas.addEventListener("click", (event) => this.clicked(name, event));
      canvas.addEventListener("keydown", (event) => this.pressed(name, event));
    }
  }

  get model() { return this.lab.model; }

  async pool() {
    if (!this._pool) {
      const count = Math.max(1, (navigator.hardwareConcurrency || 2) - 1);
      this._pool = new Pool(() => new Asked(workerUrl), count);
      await Promise.all(this._pool.workers.map((worker) => worker.ask(opening)));
    }
    return this._pool;
  }

  // The bars of both views, for the parameters of this form.
  build() {
    this.bar("map", [["map.x", "Across"], ["map.y", "Up"]], [["map.measure", "Measure"], ["map.size", "Cells"], ["map.start", "Start"]]);
    this.bar("strip", [["strip.x", "Along"]], [["strip.state", "Points of"]]);
    this.stale();
  }

  // By what a number of an axis is multiplied to be shown, and its unit.
  scale(path) { return this.lab.units.ofPath(path); }

  // A setting as it stands, and another one: kept, and in the address, where it is not as usual.
  setting(key) { return this.model.state.fields[key] ?? usualFields(this.model)[key]; }

  put(key, value) {
    const { fields } = this.model.state;
    if (value === usualFields(this.model)[key]) delete fields[key]; else fields[key] = value;
    this.lab.remember();
    this.start(key.split(".")[0]);
  }

  bar(name, axes, choices) {
    const bar = $$(`${name}-bar`), paths = axesOf(this.model.form);
    bar.replaceChildren();
    const chooser = (key, words, options, to = bar) => {
      const label = element("label", { textContent: `${words} ` }), select = element("select", { name: key });
      for (const [value, textContent, title] of options) select.append(element("option", { value, textContent, title: title ?? "" }));
      label.append(select);
      to.append(label);
      return select;
    };
    for (const [key, words] of axes) {
      const group = element("div", { className: "axis" }), wrong = element("output", {});
      const select = chooser(key, words, paths.map((path) => [path, `${halves(path)[0]}: ${this.name(path)}`]), group);
      const ends = ["from", "to"].map((end, i) => {
        const box = element("input", { type: "text", name: `${key}-${end}`, inputMode: "decimal" });
        box.setAttribute("aria-label", `${words}: ${end}`);
        group.append(i ? element("span", { textContent: "to" }) : "", box);
        return box;
      });
      const unit = element("span", { className: "unit" });
      group.append(unit, wrong);
      bar.append(group);
      const show = () => {
        const { path, range } = axisOf(this.model, this.setting(key));
        const [factor, words] = this.scale(path);
        select.value = path;
        unit.textContent = words;
        ends.forEach((box, i) => { box.value = String(factor === 1 ? range[i] : Number((range[i] * factor).toPrecision(6))); });
        wrong.textContent = "";
      };
      for (const box of ends) {
        box.addEventListener("change", () => {
          const text = [select.value, ...ends.map(({ value }) => typed(value) / this.scale(select.value)[0])].join();
          wrong.textContent = fieldWrong(this.model, key, text);
          box.setAttribute("aria-invalid", String(Boolean(wrong.textContent)));
          if (!wrong.textContent) this.put(key, text === [select.value, ...usualRange(this.model, select.value)].join() ? select.value : text);
        });
      }
      select.addEventListener("change", () => { this.put(key, select.value); show(); });
      show();
    }
    for (const [key, words] of choices) {
      const told = { "map.measure": Object.fromEntries(this.model.form.measures.map(({ name, meaning }) => [name, meaning])) }[key] ?? {};
      const select = chooser(key, words, choicesOf(this.model, key).map((value) => [value, key === "map.size" ? `${value} × ${value}` : wordy(value), told[value]]));
      select.value = this.setting(key);
      if (key === "map.start") select.title = "Mirrored: where two mirror-image solutions exist, mostly the other one is found";
      select.addEventListener("change", () => this.put(key, select.value));
    }
  }

  // What is shown is of numbers that have changed, but for those of its axes: begin anew, after a pause.
  stale() {
    clearTimeout(this.later);
    this.later = setTimeout(() => { if (this.showing) this.show(this.showing); }, 250);
  }

  // All that a map or a strip depends on.
  of(name) {
    const { form, values, initial } = this.model.state, known = { ...values };
    for (const [key, value] of Object.entries(initial)) known[`initial.${key}`] = value;
    const keys = Object.keys(usualFields(this.model)).filter((key) => key.startsWith(name)), settings = keys.map((key) => this.setting(key));
    for (const each of settings) delete known[each.split(",")[0]];
    return JSON.stringify([form, known, settings]);
  }

  get showing() { return this.model.state.view === "motion" ? "" : this.model.state.view; }

  // The axes as the bar says; null with a word about what is wrong.
  axes(name, keys) {
    const found = keys.map((key) => axisOf(this.model, this.setting(key)));
    if (new Set(found.map(({ path }) => path)).size === found.length) return found;
    $$(`${name}-words`).textContent = "the two axes should be different";
    return null;
  }

  show(name) {
    if (this.begunFor[name] === this.of(name)) this.draw(); else this.start(name);
  }

  async start(name) {
    if (!["map", "strip"].includes(name) || $$(`${name}-view`).hidden) return;
    const axes = this.axes(name, name === "map" ? ["map.x", "map.y"] : ["strip.x"]);
    if (!axes) return;
    this.begunFor = { ...this.finished, [name]: this.of(name) };
    const pool = await this.pool();
    pool.restart();
    this.begun = performance.now();
    if (name === "map") this.startMap(pool, axes); else this.startStrip(pool, axes[0]);
  }

  startMap(pool, axes) {
    const n = Number(this.setting("map.size")), mirrored = this.setting("map.start") === "mirrored";
    const field = (this.set.map = new FieldMap(n, axes, this.setting("map.measure"))), tasks = [];
    this.cell = null;
    const { model } = this, order = coarseToFine(n), form = model.state.form, signs = model.form.symmetry;
    const kept = order.filter(([column, row, size]) => {
      if (allowed(model, axes, [(column + 0.5) / n, (row + 0.5) / n])) return true;
      field.put([column, row, size], null);
      return false;
    });
    for (let i = 0; i < kept.length; i += BATCH) {
      const cells = kept.slice(i, i + BATCH), runs = runsOf(model, axes, cells.map(([column, row]) => [(column + 0.5) / n, (row + 0.5) / n]));
      if (mirrored) for (const run of runs) run.initial = run.initial.map((value, k) => signs[k] * value);
      tasks.push({ cells, message: { ask: "cells", form, runs, budget: { ...model.budget(100), periods: 100, threshold: 1e-5, asked: field.asked(model.form) } } });
    }
    let done = 0;
    pool.run(tasks, (answer, { cells }) => {
      cells.forEach((cell, k) => field.put(cell, answer ? answer.found[k] : null));
      done += cells.length;
      this.soon();
      $$("map-words").textContent = `${done} of ${order.length} motions`;
    }, () => {
      this.finished.map = this.begunFor.map;
      this.took = performance.now() - this.begun;
      document.body.dataset.map = String(Math.round(this.took));
      $$("map-words").textContent = `${order.length} motions, each run until it settled or for 100 periods, in ${said(this.took / 1000, 3)} s. Click a cell to see its motion${model.form.mirrored === "false" ? "" : ", and its mirror-image solution under “Beside it”"}.`;
      this.draw();
    });
  }

  startStrip(pool, axis) {
    const { model } = this, state = this.setting("strip.state"), form = model.state.form, tasks = [];
    const strip = (this.set.strip = { axis, state, columns: new Map() });
    const kept = spread(COLUMNS).filter((k) => allowed(model, [axis], [(k + 0.5) / COLUMNS]));
    for (let i = 0; i < kept.length; i += 4) {
      const columns = kept.slice(i, i + 4), runs = runsOf(model, [axis], columns.map((k) => [(k + 0.5) / COLUMNS]));
      tasks.push({ columns, message: { ask: "strip", form, runs, state: model.form.states.indexOf(state), marks: MARKS, budget: { ...model.budget(240), periods: 240, threshold: 1e-5 } } });
    }
    pool.run(tasks, (answer, { columns }) => {
      columns.forEach((k, i) => strip.columns.set(k, answer ? answer.found[i] : null));
      this.soon();
      $$("strip-words").textContent = `${strip.columns.size} of ${kept.length} values`;
    }, () => {
      this.finished.strip = this.begunFor.strip;
      $$("strip-words").textContent = `${kept.length} values: one point per period of each settled response, else the last ${MARKS} marks of 240 periods. All begin with the start of the controls.`;
      this.draw();
    });
  }

  // Draw at the next frame, however many ask for it.
  soon() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => { this.waits = false; this.draw(); });
  }

  name(path) { return this.lab.units.name(path).trim(); }

  label(path) {
    const name = this.name(path), unit = this.scale(path)[1], words = path.startsWith("initial.") ? `${name} at the start` : name;
    return unit ? `${words} [${unit}]` : words;
  }

  // What a map is drawn with: labels and scales of its axes, scale and unit of its measure.
  shownAs({ axes, measure }) {
    const paths = axes.map(({ path }) => path);
    return { labels: paths.map((path) => this.label(path)), scales: paths.map((path) => this.scale(path)[0]), measure: this.lab.units.measure(measure) };
  }

  draw() {
    const theme = themeOf(document.body);
    if (this.set.map && !$$("map-view").hidden) {
      this.map = this.set.map.draw(new CanvasPen($$("map")), theme, this.shownAs(this.set.map), this.cell);
    }
    if (this.set.strip && !$$("strip-view").hidden) this.drawStrip(new CanvasPen($$("strip")), theme);
  }

  // What is shown as a picture, and as a table.
  svg(name, theme) {
    const pen = new SvgPen(900, 620), field = this.set[name];
    pen.box(0, 0, 900, 620, theme.paper);
    if (field && name === "map") field.draw(pen, theme, this.shownAs(field));
    if (field && name === "strip") this.drawStrip(pen, theme);
    return pen.svg;
  }

  // The title of a column of values along an axis.
  columnTitle(path) {
    const unit = this.scale(path)[1];
    return unit ? `${halves(path)[0]}.${this.name(path)} [${unit}]` : path;
  }

  csv(name) {
    const field = this.set[name], lines = [];
    if (name === "strip") {
      const [along, up] = [this.scale(field.axis.path)[0], this.lab.units.factor(field.state)];
      lines.push([this.columnTitle(field.axis.path), this.lab.units.label(field.state), "response_period"]);
      for (const k of [...field.columns.keys()].sort((a, b) => a - b)) {
        const found = field.columns.get(k), value = atShare(field.axis.range, (k + 0.5) / COLUMNS);
        for (const mark of found?.marks ?? []) lines.push([value * along, mark * up, found.response]);
      }
    } else {
      const { scales, measure: [size, unit] } = this.shownAs(field);
      lines.push([...field.axes.map(({ path }) => this.columnTitle(path)), unit ? `${field.measure} [${unit}]` : field.measure, "response_period", "status"]);
      for (let i = 0; i < field.n ** 2; i++) {
        const cell = [i % field.n, Math.floor(i / field.n)], found = field.cells.get(i)?.found;
        const point = field.axes.map(({ range }, k) => atShare(range, (cell[k] + 0.5) / field.n) * scales[k]);
        const value = found?.values[field.measure];
        lines.push([...point, value === undefined || value === null ? "" : value * size, found?.response ?? "", found?.status ?? ""]);
      }
    }
    return `${lines.map((each) => each.join(",")).join("\n")}\n`;
  }

  drawStrip(pen, theme) {
    const { axis, state, columns } = this.set.strip, [low, high, log] = axis.range.map((end, i) => (i < 2 ? end * this.scale(axis.path)[0] : end)), all = [];
    const size = this.lab.units.factor(state), name = this.lab.units.label(state);
    for (const found of columns.values()) if (found) all.push(...found.marks.map((mark) => mark * size));
    const ends = log ? [Math.log10(low), Math.log10(high)] : [low, high];
    const map = (this.stripMap = frame(pen, theme, { x: ends, y: rangeOf(all), xName: this.label(axis.path) + (log ? " (powers of ten)" : ""), yName: name, title: `${wordy(state)} at the period marks`, margin: { left: 64 } }));
    const at = (k) => map.sx(ends[0] + ((ends[1] - ends[0]) * (k + 0.5)) / COLUMNS);
    if (this.column !== undefined) pen.path([at(this.column), map.box.top, at(this.column), map.box.bottom], theme.soft, 1, [3, 3]);
    for (const [k, found] of columns) {
      const x = at(k);
      if (!found || found.status !== 1) pen.path([x, map.box.bottom - 8, x, map.box.bottom], theme.bad, 2);
      else for (const mark of found.marks) pen.disc(x, map.sy(mark * size), found.response > 0 ? 1.6 : 0.9, found.response > 0 ? theme.first : theme.second);
    }
  }

  clicked(name, event) {
    const canvas = $$(name), box = canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    if (name === "map" && this.map) {
      const inner = this.map.box, { n } = this.set.map;
      const column = Math.floor((n * (x - inner.left)) / (inner.right - inner.left)), row = Math.floor((n * (inner.bottom - y)) / (inner.bottom - inner.top));
      if (column >= 0 && column < n && row >= 0 && row < n) { this.cell = [column, row]; this.fly(); }
    } else if (name === "strip" && this.stripMap) {
      const inner = this.stripMap.box, share = (x - inner.left) / (inner.right - inner.left);
      if (share >= 0 && share <= 1) this.land([this.set.strip.axis], [share]);
    }
  }

  pressed(name, event) {
    if (name === "strip") { this.along(event); return; }
    if (!this.set.map) return;
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (moves) {
      event.preventDefault();
      const { n } = this.set.map;
      this.cell = (this.cell ?? [n / 2, n / 2]).map((each, i) => Math.min(n - 1, Math.max(0, each + moves[i])));
      const known = this.set.map.at(...this.cell), value = known?.found?.values[this.set.map.measure];
      const { scales, measure: [size, unit] } = this.shownAs(this.set.map), at = (i, range) => said(atShare(range, (this.cell[i] + 0.5) / n) * scales[i], 4);
      const places = this.set.map.axes.map(({ path, range }, i) => `${this.name(path)} ${at(i, range)} ${this.scale(path)[1]}`.trim()).join(", ");
      $$("map-words").textContent = `${places}: ${known ? `${said((value ?? NaN) * size, 5)} ${unit}`.trim() : "not computed yet"}${known?.found?.response === 0 ? " (unsettled)" : ""}`;
      this.draw();
    } else if (event.key === "Enter" && this.cell) this.fly();
  }

  // By keys along the strip.
  along(event) {
    const strip = this.set.strip, step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (strip && step) {
      event.preventDefault();
      this.column = Math.min(COLUMNS - 1, Math.max(0, (this.column ?? COLUMNS / 2) + step));
      const found = strip.columns.get(this.column), marks = [...new Set((found?.marks ?? []).map((mark) => said(mark * this.lab.units.factor(strip.state), 4)))];
      const what = marks.length > 4 ? `${marks.length} points, not settled` : marks.join(", ");
      $$("strip-words").textContent = `${this.label(strip.axis.path)} ${said(atShare(strip.axis.range, (this.column + 0.5) / COLUMNS) * this.scale(strip.axis.path)[0], 4)}: ${what || "not computed yet"}`;
      this.draw();
    } else if (strip && event.key === "Enter" && this.column !== undefined) this.land([strip.axis], [(this.column + 0.5) / COLUMNS]);
  }

  fly() { this.land(this.set.map.axes, this.cell.map((each) => (each + 0.5) / this.set.map.n), this.setting("map.start") === "mirrored"); }

  // Show the motion of a point.
  land(axes, shares, mirrored = false) {
    const { model } = this;
    model.fill(axes.map(({ path, range }, i) => [path, Number(atShare(range, shares[i]).toPrecision(15))]));
    if (mirrored) mirror(model);
    this.lab.mode("motion");
    this.lab.controls.refresh();
    this.lab.compute();
  }
}

// The mirrored start.
function mirror(model) {
  model.form.states.forEach((name, k) => { model.state.initial[name] = model.form.symmetry[k] * (model.state.initial[name] ?? 0) + 0; });
}
