// The views of many motions: the map over two parameters and the strip of bifurcations along one.

const CELLS = 64, COLUMNS = 240, MARKS = 60, BATCH = 12;

class Fields {
  constructor(lab) {
    this.lab = lab;
    this.set = { map: null, strip: null };
    this.showing = "";
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
    const paths = [...this.model.form.parameters, ...this.model.form.states.map((name) => `initial.${name}`)];
    const first = (name) => (paths.includes(name) ? name : paths[0]);
    const second = paths.find((path) => path.startsWith("drive.amplitude")) ?? paths[1];
    this.bar("map", [["x", "Across", first("machine.mass_ratio")], ["y", "Up", second]], paths, () => this.choice("measure", "Measure", this.model.form.measures.map(({ name, meaning }) => [name, wordy(name), meaning]), "mean_velocity"));
    this.bar("strip", [["x", "Along", second]], paths, () => this.choice("state", "Points of", this.model.form.states.filter((_, i) => i !== this.model.form.cyclic).map((name) => [name, wordy(name), ""]), this.model.form.states[0]));
    for (const name of ["map", "strip"]) this.set[name] = null;
    if (this.showing) this.show(this.showing);
  }

  bar(name, axes, paths, choice) {
    const bar = $$(`${name}-bar`), kept = Object.fromEntries([...bar.querySelectorAll("select")].map((each) => [each.name, each.value]));
    bar.replaceChildren();
    for (const [key, words, usual] of axes) {
      const label = element("label", { textContent: `${words} ` }), select = element("select", { name: key });
      for (const path of paths) select.append(element("option", { value: path, textContent: wordy(path.replace(".", ": ")) }));
      select.value = paths.includes(kept[key]) ? kept[key] : usual;
      label.append(select);
      bar.append(label);
      const ends = ["from", "to"].map((end, i) => {
        const box = element("input", { type: "text", name: `${key}-${end}`, inputMode: "decimal" });
        box.setAttribute("aria-label", `${words}: ${end}`);
        box.addEventListener("change", () => this.start(name));
        bar.append(i ? element("span", { textContent: "to" }) : "", box);
        return box;
      });
      const fill = () => { const [low, high] = this.usual(select.value); ends[0].value = String(low); ends[1].value = String(high); };
      fill();
      select.addEventListener("change", () => { fill(); this.start(name); });
    }
    bar.append(choice());
    const again = element("button", { type: "button", textContent: "Compute" });
    again.addEventListener("click", () => this.start(name));
    bar.append(again);
    if (name === "map") {
      const twin = element("button", { type: "button", textContent: "From the mirrored start" });
      twin.title = "The same map with all starts mirrored: where motions have a mirror twin, the other one is shown";
      twin.addEventListener("click", () => { this.mirrored = !this.mirrored; twin.setAttribute("aria-pressed", String(this.mirrored)); this.start(name); });
      twin.setAttribute("aria-pressed", String(Boolean(this.mirrored)));
      bar.append(twin);
    }
  }

  choice(key, words, options, usual) {
    const label = element("label", { textContent: `${words} ` }), select = element("select", { name: key });
    for (const [value, text, title] of options) select.append(element("option", { value, textContent: text, title }));
    if (options.some(([value]) => value === usual)) select.value = usual;
    select.addEventListener("change", () => { this.start(this.showing); });
    label.append(select);
    return label;
  }

  usual(path) {
    const [low, high] = rangeOfPath(this.model, path);
    const least = path.startsWith("initial.") ? null : this.model.record(path).least;
    return [least !== null && low <= least ? Number((least + (high - least) / 50).toPrecision(3)) : low, high];
  }

  read(name, key) { return $$(`${name}-bar`).querySelector(`[name="${key}"]`); }

  // The axes as the bar says; null with a word about what is wrong.
  axes(name, keys) {
    const found = [];
    for (const key of keys) {
      const path = this.read(name, key).value, [low, high] = ["from", "to"].map((end) => typed(this.read(name, `${key}-${end}`).value));
      const wrong = Number.isFinite(low) && Number.isFinite(high) ? (low < high ? this.model.complaint(path, high) && "" : "the range should rise") : "the ends of a range should be numbers";
      if (wrong) { $$(`${name}-words`).textContent = `${path}: ${wrong}`; return null; }
      const log = !path.startsWith("initial.") && this.model.record(path).log && low > 0;
      found.push({ path, range: [low, high, log] });
    }
    if (new Set(found.map(({ path }) => path)).size < found.length) { $$(`${name}-words`).textContent = "the two axes should be different"; return null; }
    return found;
  }

  show(name) {
    this.showing = name;
    if (!this.set[name]) this.start(name); else this.draw();
  }

  async start(name) {
    if (!["map", "strip"].includes(name) || $$(`${name}-view`).hidden) return;
    const axes = this.axes(name, name === "map" ? ["x", "y"] : ["x"]);
    if (!axes) return;
    const pool = await this.pool();
    pool.restart();
    this.begun = performance.now();
    if (name === "map") this.startMap(pool, axes); else this.startStrip(pool, axes[0]);
  }

  startMap(pool, axes) {
    const field = (this.set.map = new FieldMap(CELLS, axes, this.read("map", "measure").value)), tasks = [];
    const { model } = this, order = coarseToFine(CELLS), form = model.state.form, signs = model.form.symmetry;
    const kept = order.filter(([column, row, size]) => {
      if (allowed(model, axes, [(column + size / 2) / CELLS, (row + size / 2) / CELLS])) return true;
      field.put([column, row, size], null);
      return false;
    });
    for (let i = 0; i < kept.length; i += BATCH) {
      const cells = kept.slice(i, i + BATCH), runs = runsOf(model, axes, cells.map(([column, row]) => [(column + 0.5) / CELLS, (row + 0.5) / CELLS]));
      if (this.mirrored) for (const run of runs) run.initial = run.initial.map((value, k) => signs[k] * value);
      tasks.push({ cells, message: { ask: "cells", form, runs, budget: { ...model.budget(100), periods: 100, threshold: 1e-5, asked: field.asked(model.form) } } });
    }
    let done = 0;
    pool.run(tasks, (answer, { cells }) => {
      cells.forEach((cell, k) => field.put(cell, answer ? answer.found[k] : null));
      done += cells.length;
      this.soon();
      $$("map-words").textContent = `${done} of ${order.length} motions`;
    }, () => {
      this.took = performance.now() - this.begun;
      document.body.dataset.map = String(Math.round(this.took));
      $$("map-words").textContent = `${order.length} motions, each run until it settled or for 100 periods, in ${said(this.took / 1000, 3)} s. Click a cell to see its motion.`;
      this.draw();
    });
  }

  startStrip(pool, axis) {
    const { model } = this, state = this.read("strip", "state").value, form = model.state.form, tasks = [];
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

  label(path) {
    const name = wordy(path.split(".")[1]);
    return path.startsWith("initial.") ? `${name} at the start` : name;
  }

  draw() {
    const theme = themeOf(document.body);
    if (this.set.map && !$$("map-view").hidden) {
      this.map = this.set.map.draw(new CanvasPen($$("map")), theme, this.set.map.axes.map(({ path }) => this.label(path)), this.cell);
    }
    if (this.set.strip && !$$("strip-view").hidden) this.drawStrip(new CanvasPen($$("strip")), theme);
  }

  drawStrip(pen, theme) {
    const { axis, state, columns } = this.set.strip, [low, high, log] = axis.range, all = [];
    for (const found of columns.values()) if (found) all.push(...found.marks);
    const ends = log ? [Math.log10(low), Math.log10(high)] : [low, high];
    const map = (this.stripMap = frame(pen, theme, { x: ends, y: rangeOf(all), xName: this.label(axis.path) + (log ? " (powers of ten)" : ""), yName: wordy(state), title: `${wordy(state)} at the period marks`, margin: { left: 64 } }));
    for (const [k, found] of columns) {
      const x = map.sx(ends[0] + ((ends[1] - ends[0]) * (k + 0.5)) / COLUMNS);
      if (!found || found.status !== 1) pen.path([x, map.box.bottom - 8, x, map.box.bottom], theme.bad, 2);
      else for (const mark of found.marks) pen.disc(x, map.sy(mark), found.response > 0 ? 1.6 : 0.9, found.response > 0 ? theme.first : theme.second);
    }
  }

  clicked(name, event) {
    const canvas = $$(name), box = canvas.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
    if (name === "map" && this.map) {
      const inner = this.map.box, n = CELLS;
      const column = Math.floor((n * (x - inner.left)) / (inner.right - inner.left)), row = Math.floor((n * (inner.bottom - y)) / (inner.bottom - inner.top));
      if (column >= 0 && column < n && row >= 0 && row < n) { this.cell = [column, row]; this.fly(); }
    } else if (name === "strip" && this.stripMap) {
      const inner = this.stripMap.box, share = (x - inner.left) / (inner.right - inner.left);
      if (share >= 0 && share <= 1) this.land([this.set.strip.axis], [share]);
    }
  }

  pressed(name, event) {
    if (name !== "map" || !this.set.map) return;
    const moves = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (moves) {
      event.preventDefault();
      this.cell ??= [CELLS / 2, CELLS / 2];
      this.cell = this.cell.map((each, i) => Math.min(CELLS - 1, Math.max(0, each + moves[i])));
      const known = this.set.map.at(...this.cell), value = known?.found?.values[this.set.map.measure];
      $$("map-words").textContent = `${this.set.map.axes.map(({ path, range }, i) => `${this.label(path)} ${said(atShare(range, (this.cell[i] + 0.5) / CELLS), 4)}`).join(", ")}: ${known ? said(value ?? NaN, 5) : "not computed yet"}${known?.found?.response === 0 ? " (unsettled)" : ""}`;
      this.draw();
    } else if (event.key === "Enter" && this.cell) this.fly();
  }

  fly() { this.land(this.set.map.axes, this.cell.map((each) => (each + 0.5) / CELLS), this.mirrored); }

  // Show the motion of a point.
  land(axes, shares, mirrored = false) {
    const { model } = this;
    for (let turn = 0; turn < 2; turn++) axes.forEach(({ path, range }, i) => model.set(path, Number(atShare(range, shares[i]).toPrecision(15))));
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
