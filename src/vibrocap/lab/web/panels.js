// The panels: a motion over time, in its phase plane, round its friction loop, and its energy by channel.

// A motion as the worker has sent it, with columns by name.
class Shown {
  constructor(form, answer) {
    Object.assign(this, answer);
    this.form = form;
    this.names = ["time", ...form.rests.map((_, i) => (i ? `side_${i + 1}` : "side")), ...form.states, ...form.observed];
    this.columns = {};
  }

  get count() { return this.rows ? this.rows.rows : 0; }

  // A column of the stretch on show.
  column(name) {
    if (!(name in this.columns)) {
      const { data, width, rows } = this.rows, place = this.names.indexOf(name), found = new Float64Array(rows);
      for (let i = 0; i < rows; i++) found[i] = data[i * width + place];
      this.columns[name] = found;
    }
    return this.columns[name];
  }

  // Whether there is such a column.
  has(name) { return this.count > 0 && this.names.includes(name); }

  // Time in periods of the drive.
  get periods() { return (this.columns.periods ??= this.column("time").map((time) => time / this.period)); }

  // A column of the whole motion: at the start of every piece.
  whole(state) {
    const width = this.form.states.length + 1, found = [[], []];
    for (let i = 0; i < this.overview.length; i += width) {
      found[0].push(this.overview[i] / this.period);
      found[1].push(this.overview[i + 1 + state]);
    }
    return found;
  }

  // The row at a time, between two of them; its side is that of the earlier one.
  at(time) {
    const times = this.column("time"), { data, width } = this.rows;
    let low = 0, high = times.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (times[middle] <= time) low = middle; else high = middle - 1;
    }
    const next = Math.min(low + 1, times.length - 1), span = times[next] - times[low];
    const share = span > 0 ? Math.min(1, (time - times[low]) / span) : 0, row = new Float64Array(width);
    for (let j = 0; j < width; j++) row[j] = data[low * width + j] + share * (data[next * width + j] - data[low * width + j]);
    const whole = (share > 0 && span > 0 ? next : low) * width;
    row.set(data.subarray(whole + 1, whole + 1 + this.form.rests.length), 1);
    return row;
  }

  // The sides of all contacts in such a row.
  sides(row) { return [...row.subarray(1, 1 + this.form.rests.length)]; }

  // The value of a name in such a row.
  of(row, name) { return row[this.names.indexOf(name)]; }

  // Coordinates of the shapes of the scene in such a row.
  shapes(row) {
    let place = this.names.length;
    return this.form.scene.map(({ points }) => { place += 2 * points; return row.slice(place - 2 * points, place); });
  }

  // Travel in the last whole period; null where there is none.
  get drift() {
    const n = this.form.states.length, done = this.sections.length / n, { cyclic } = this.form;
    if (cyclic < 0 || done < 2) return null;
    return this.sections[(done - 1) * n + cyclic] - this.sections[(done - 2) * n + cyclic];
  }
}

// Every panel: title; wanted(model): whether it is shown; draw(pen, theme, {shown, beside, units}); marks where time is.
const PANELS = [
  {
    key: "travel", title: "Travel", wide: true,
    draw(pen, theme, { shown, beside, units, names }) {
      const state = shown.form.cyclic >= 0 ? shown.form.cyclic : 0, name = shown.form.states[state];
      const [xs, raw] = shown.whole(state), factor = units.factor(name), ys = raw.map((y) => y * factor);
      const other = beside?.has(name) ? beside.whole(beside.form.states.indexOf(name)).map((each, i) => (i ? each.map((y) => y * factor) : each)) : null;
      const map = frame(pen, theme, {
        title: `${wordy(name)} over the whole run`, x: [0, xs[xs.length - 1] || 1],
        y: rangeOf(other ? [...ys, ...other[1]] : ys), xName: "drive periods", yName: units.label(name),
        note: other ? `solid: ${names[0]}; dashed: ${names[1]}` : "",
      });
      map.inside(() => {
        const from = map.sx(shown.from / shown.period);
        pen.box(from, map.box.top, map.box.right - from, map.box.bottom - map.box.top, theme.grid);
        if (other) trace(pen, map, other[0], other[1], theme.second, 2, [6, 4]);
        trace(pen, map, xs, ys, theme.first, 2);
      });
      return { map, mark: (row) => [shown.of(row, "time") / shown.period, shown.of(row, name) * factor] };
    },
  },
  timeHistory("contact_velocity", "velocity of the contact", true),
  timeHistory(0, "", false),
  {
    key: "loop", title: "Friction loop",
    draw(pen, theme, { shown, beside, units }) {
      return plane(pen, theme, shown, beside, units, "contact_velocity", "friction", "friction force over velocity");
    },
  },
  {
    key: "phase", title: "Phase plane",
    draw(pen, theme, { shown, beside, units }) {
      const [one, two] = shown.form.states;
      return plane(pen, theme, shown, beside, units, one, two, "phase plane");
    },
  },
  {
    key: "energy", title: "Energy by channel", wide: true,
    draw(pen, theme, { shown, units }) {
      const { data, width, rows } = shown.works, factor = units.factor("energy"), xs = [], lines = [];
      for (let i = 0; i < rows; i++) xs.push(data[i * width] / shown.period);
      const names = [...shown.form.channels, "stored"];
      names.forEach((name, j) => {
        const ys = [];
        for (let i = 0; i < rows; i++) ys.push(data[i * width + 1 + j] * factor);
        if (ys.some((y) => y !== 0)) lines.push({ name, ys });
      });
      const map = frame(pen, theme, {
        title: "works by channel, and what is stored", x: [xs[0], xs[rows - 1]], y: rangeOf(lines.flatMap(({ ys }) => ys)),
        xName: "drive periods", yName: units.label("energy"), margin: { right: 104 },
      });
      const inks = [theme.first, theme.second, theme.third, theme.fourth, theme.soft], dashes = [[], [7, 3], [2, 3], [9, 3, 2, 3], []];
      const ends = lines.map(({ name, ys }, j) => ({ name, y: map.sy(ys[rows - 1]), ink: name === "stored" ? theme.ink : inks[j % 5], dash: dashes[j % 5] }));
      map.inside(() => lines.forEach(({ ys }, j) => trace(pen, map, xs, ys, ends[j].ink, 1.8, ends[j].dash)));
      let last = -Infinity;
      for (const end of [...ends].sort((a, b) => a.y - b.y)) {
        last = Math.max(end.y, last + 13);
        pen.text(map.box.right + 6, last, end.name.replace("contact_", "").replace("_", " "), { fill: end.ink, size: 11, base: "middle" });
      }
      return { map, mark: null, time: (row) => shown.of(row, "time") / shown.period };
    },
  },
  {
    key: "difference", title: "Difference", wide: true, wanted: (beside) => beside !== null,
    draw(pen, theme, { shown, beside, units, names }) {
      const state = shown.form.cyclic >= 0 ? shown.form.cyclic : 0, name = shown.form.states[state], factor = units.factor(name);
      const n = shown.form.states.length, m = beside.form.states.length, other = beside.form.states.indexOf(name);
      const marks = other < 0 ? 0 : Math.min(shown.sections.length / n, beside.sections.length / m), xs = [], ys = [];
      for (let k = 0; k < marks; k++) {
        xs.push(k);
        ys.push((beside.sections[k * m + other] - shown.sections[k * n + state]) * factor);
      }
      const map = frame(pen, theme, {
        title: `${wordy(name)}: ${names[1]} less ${names[0]}`, x: [0, Math.max(1, marks - 1)], y: rangeOf(ys),
        xName: "period marks", yName: units.label(name),
      });
      map.inside(() => trace(pen, map, xs, ys, theme.fourth, 2));
      return { map, mark: null };
    },
  },
];

// A history of a name, or of a state by number, over the stretch on show.
function timeHistory(which, words, sided) {
  return {
    key: sided ? "velocity" : "inner", title: sided ? "Velocity" : "Inner motion",
    draw(pen, theme, { shown, beside, units }) {
      const name = typeof which === "number" ? shown.form.states[which] : which, factor = units.factor(name);
      const scaled = (each) => each.column(name).map((y) => y * factor), ys = scaled(shown), xs = shown.periods;
      const other = beside?.has(name) ? scaled(beside) : null;
      const map = frame(pen, theme, {
        title: words || wordy(name), x: [xs[0], xs[xs.length - 1]], y: rangeOf(other ? [...ys, ...other] : ys),
        xName: "drive periods", yName: units.label(name),
      });
      map.inside(() => {
        if (other) trace(pen, map, beside.periods, other, theme.soft, 1.5, [5, 4]);
        if (sided) sidedTrace(pen, map, xs, ys, shown.column("side"), theme, 2.2);
        else trace(pen, map, xs, ys, theme.first, 2);
      });
      return { map, mark: (row) => [shown.of(row, "time") / shown.period, shown.of(row, name) * factor] };
    },
  };
}

// One name over another, round the stretch on show.
function plane(pen, theme, shown, beside, units, one, two, title) {
  const scaled = (each, name) => each.column(name).map((y) => y * units.factor(name));
  const xs = scaled(shown, one), ys = scaled(shown, two);
  const others = beside?.has(one) && beside.has(two) ? [scaled(beside, one), scaled(beside, two)] : null;
  const map = frame(pen, theme, {
    title, x: rangeOf(others ? [...xs, ...others[0]] : xs), y: rangeOf(others ? [...ys, ...others[1]] : ys),
    xName: units.label(one), yName: units.label(two),
  });
  map.inside(() => {
    if (others) trace(pen, map, others[0], others[1], theme.soft, 1.5, [5, 4]);
    sidedTrace(pen, map, xs, ys, shown.column("side"), theme, 2);
  });
  return { map, mark: (row) => [shown.of(row, one) * units.factor(one), shown.of(row, two) * units.factor(two)] };
}

// Where time is, drawn over a panel.
function drawMark(pen, theme, drawing, row) {
  const { map } = drawing;
  if (drawing.time) {
    const x = map.sx(drawing.time(row));
    pen.path([x, map.box.top, x, map.box.bottom], theme.soft, 1, [3, 3]);
  } else if (drawing.mark) {
    const [x, y] = drawing.mark(row);
    pen.disc(map.sx(x), map.sy(y), 4.5, theme.paper, theme.ink, 2);
  }
}
