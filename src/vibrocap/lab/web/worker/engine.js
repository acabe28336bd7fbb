// The engine: kernels at work. It fills their memory as `numerics/run/motion.py` and `ensemble.py` do, and reads what
// they leave; no equation stands here. Runs in a worker, and in Node for tests.

const BEGINNING = -1, RUNNING = 0, DONE = 1, TRACE_FULL = 2;
const ROUNDS = 20000; // steps between two looks at the trace
const EVENT_ROOM = 2000, PIECE_ROOM = 20000;

// The module of all kernels at work, and its memory behind the tables: what asks for room gives it back when it is done.
class Engine {
  constructor(module) {
    this.kernel = new WebAssembly.Instance(module).exports;
    this.top = 65536;
  }

  // What is done with (floats, ints, trace) of so many numbers; the first two are 0, and so is the trace but for what
  // earlier runs left where `keep` says it may.
  within({ floats, ints }, trace, work, kept = 0) {
    const { memory } = this.kernel, start = this.top;
    this.top += 8 * (floats + ints + trace);
    const missing = this.top + (1 << 20) - memory.buffer.byteLength; // room for small ones within, as a larger memory is another
    if (missing > 0) memory.grow(Math.ceil(missing / 65536));
    const arrays = [
      new Float64Array(memory.buffer, start, floats).fill(0), new BigInt64Array(memory.buffer, start + 8 * floats, ints).fill(0n),
      new Float64Array(memory.buffer, start + 8 * (floats + ints), trace),
    ];
    if (!kept) arrays[2].fill(0);
    try { return work(...arrays, ...arrays.map((array) => array.byteOffset)); } finally { this.top = start; }
  }
}

class Form {
  constructor(record, number, engine) {
    Object.assign(this, record);
    this.engine = engine;
    const names = ["advance", "begin", "write_table", "take_piece", "look_at", "advance_ensemble"];
    this.kernel = Object.fromEntries(names.map((name) => [name, engine.kernel[name + number]]));
  }

  // How many segments the drive has with these parameters, 0 without corners.
  segments(parameters) { return this.corners ? this.corners.segments * CUTS[this.number](parameters) : 0; }

  // What a run begins with: natural sizes of the states and period; of a drive with corners its table, and behind the
  // parameters its period and room for the present segment, which the kernel fills.
  beginning(parameters, initial) {
    const { at, sizes } = this.motion, n = this.states.length, { corners } = this, first = 2 * this.room.length;
    const segments = this.segments(parameters), start = first + n + 1; // of the table
    return this.engine.within(sizes, start + (corners ? segments * (corners.coefficients + 1) : 0), (floats, ints, all, ...places) => { // bounds of `room` first
      const trace = all.subarray(first);
      floats.set(initial, at.STATE);
      floats.set(parameters, at.PARAMETER);
      this.kernel.begin(...places, 0);
      this.room.forEach((name, i) => {
        const value = initial[this.states.indexOf(name)], near = 1e-12 * (1 + Math.abs(value));
        const wanted = value < all[2 * i] - near ? `at least ${all[2 * i]}` : value > all[2 * i + 1] + near ? `at most ${all[2 * i + 1]}` : "";
        if (wanted) throw new Error(`initial.${name}: should be ${wanted}, where ${name === "actuator_output" ? "the actuator has its limit" : "a stop stands"}, got ${value}`);
      });
      ints[at.SEGMENT_COUNT] = BigInt(segments);
      this.kernel.write_table(...places, trace[n], start);
      const drive = corners && { table: all.slice(start) }, present = corners ? [trace[n], ...Array(corners.coefficients + 1).fill(0)] : [];
      return { scales: trace.slice(0, n), period: trace[n], drive, parameters: [...parameters, ...present] };
    });
  }
}

// Whether the second half of a table is the first one with the other sign, to rounding: `odd` of the package's drives,
// both halves compared between all corners at more points than their degree allows to differ.
function isOdd({ coefficients, rounding }, table) {
  const width = coefficients + 1, rows = [];
  for (let i = 0, end = 0; i < table.length; i += width) {
    if (table[i] > end) rows.push({ start: end, end: table[i], shape: table.subarray(i + 1, i + width) });
    end = table[i];
  }
  const value = ({ shape }, x) => shape.reduceRight((sum, each) => sum * x + each, 0);
  const at = (x) => { const row = rows.find(({ end }) => x < end) ?? rows.at(-1); return value(row, x - row.start); };
  const bound = rounding * Math.max(...rows.flatMap((row) => [0, row.end - row.start].map((x) => Math.abs(value(row, x)))));
  const cuts = [...new Set([0, 0.5, ...rows.map(({ end }) => (end < 0.5 ? end : end - 0.5))])].sort((a, b) => a - b);
  return cuts.every((low, i) => {
    const high = cuts[i + 1];
    if (!(high - low > rounding && high <= 0.5)) return true;
    for (let j = 0; j < width; j++) {
      const x = low + (high - low) * ((j + 0.5) / width);
      if (!(Math.abs(at(x) + at(x + 0.5)) <= bound)) return false;
    }
    return true;
  });
}

// Whether a motion has a mirror-image solution: its mirror image, half a period later, is a motion. begun: what it began with
function isMirrored(form, { parameters, drive }) {
  return MIRRORED[form.number](parameters, () => isOdd(form.corners, drive.table));
}

// One motion, of which everything is kept: what `recorded_run` does.
// limits: { events, steps, pieces }; a motion of more pieces than a page can keep ends with the status 7
function recordedRun(form, parameters, initial, periods, tolerance, limits) {
  const { at, sizes } = form.motion, { rows } = sizes;
  const begun = form.beginning(parameters, initial), { period, drive } = begun;
  const wholePeriods = Math.floor(periods + 1e-12);
  const pieceRoom = Math.floor(Math.min(PIECE_ROOM, 250 * periods + 200));
  const eventStart = (wholePeriods + 1) * rows, pieceStart = eventStart + EVENT_ROOM * sizes.event;
  const tableStart = pieceStart + pieceRoom * sizes.piece;
  return form.engine.within(sizes, tableStart + (drive ? drive.table.length : 0), (floats, ints, trace, ...places) => {
    const put = (values) => Object.entries(values).forEach(([name, value]) => { ints[at[name]] = BigInt(value); });
    const got = (name) => Number(ints[at[name]]);
    floats.set(initial, at.STATE);
    floats.set(begun.parameters, at.PARAMETER);
    floats.set(begun.scales, at.SCALE);
    floats[at.PERIOD] = period;
    floats[at.TAIL] = periods - wholePeriods > 1e-12 ? Math.max(0, (periods - wholePeriods) * period) : 0;
    floats[at.TOLERANCE] = tolerance;
    put({
      STATUS: BEGINNING, WHOLE_PERIODS: wholePeriods, EVENT_LIMIT: limits.events, STEP_LIMIT: limits.steps,
      RECORDED_EVENT_START: eventStart, RECORDED_EVENT_LIMIT: EVENT_ROOM, PIECE_START: pieceStart, PIECE_LIMIT: pieceRoom,
    });
    trace.set(initial, 0);
    if (drive) {
      trace.set(drive.table, tableStart);
      put({ TABLE_START: tableStart, SEGMENT_COUNT: form.segments(parameters) });
    }
    const pieces = [], events = [];
    let status = RUNNING, kept = 0;
    while (status === RUNNING) {
      form.kernel.advance(...places, ROUNDS);
      status = got("STATUS");
      if (status !== RUNNING) {
        const pieceEnd = pieceStart + got("PIECES") * sizes.piece;
        pieces.push(trace.slice(pieceStart, pieceEnd));
        events.push(trace.slice(eventStart, eventStart + got("RECORDED_EVENTS") * sizes.event));
        kept += got("PIECES");
        put({ PIECES: 0, RECORDED_EVENTS: 0 });
      }
      if (status === TRACE_FULL) put({ STATUS: status = kept < limits.pieces ? RUNNING : 7 });
    }
    return {
      status, period, rows,
      pieces: joined(pieces), events: joined(events),
      sections: trace.slice(0, (got("PERIOD_COUNT") + 1) * rows),
      final: floats.slice(at.STATE, at.STATE + rows),
      residual: floats[at.CONTACT_RESIDUAL],
      steps: [got("TAYLOR_STEPS"), got("IMPLICIT_STEPS")],
      scales: begun.scales, parameters: Float64Array.from(begun.parameters), drive, form,
    };
  }, true);
}

function joined(parts) {
  if (parts.length === 1) return parts[0];
  const all = new Float64Array(parts.reduce((sum, part) => sum + part.length, 0));
  let place = 0;
  for (const part of parts) { all.set(part, place); place += part.length; }
  return all;
}

// Many motions of one form, one by one, of which only measures are kept: what `ensemble_run` does.
// runs: [{ parameters, initial }]; budget: { periods, window, threshold, tolerance, events, steps, asked }
// each: called with the number of every run, its result (a view that changes; null for a start that is none), what it
// began with, and the kernel's memory
function ensembleRun(form, runs, budget, each) {
  const { at, sizes } = form.ensemble, n = form.states.length, { corners } = form, tableStart = sizes.run + sizes.result;
  const numbers = corners ? Math.max(...runs.map((run) => form.segments(run.parameters))) * (corners.coefficients + 1) : 0;
  form.engine.within(sizes, tableStart + numbers, (floats, ints, trace, ...places) => {
    runs.forEach((run, number) => {
      let begun;
      try { begun = form.beginning(run.parameters, run.initial); } catch { each(number, null); return; }
      trace.set(run.initial, 0);
      trace.set(begun.parameters, n);
      trace.set(begun.scales, n + begun.parameters.length);
      if (begun.drive) trace.set(begun.drive.table, tableStart);
      trace.set([0, begun.period, 0], sizes.run - 3); // time: it begins with the drive; no delay
      const wholes = {
        TABLE_START: tableStart, TABLE_STRIDE: 0, SEGMENT_COUNT: form.segments(run.parameters), STATUS: DONE, RUN: -1,
        EVENT_LIMIT: budget.events, STEP_LIMIT: budget.steps, WINDOW: budget.window, PERIOD_BUDGET: budget.periods,
        ASKED: budget.asked ?? form.ensemble.asked, RESULT_START: sizes.run, NEXT_RUN: 0, LAST_RUN: 1, MORE: 0,
      };
      Object.entries(wholes).forEach(([name, value]) => { ints[at[name]] = BigInt(value); });
      floats[at.TOLERANCE] = budget.tolerance;
      floats[at.THRESHOLD] = budget.threshold;
      while (form.kernel.advance_ensemble(...places, 500)) { /* goes on */ }
      each(number, trace.subarray(sizes.run), begun, floats);
    });
  });
}

// What a result says: status, response, and the measures by name.
function measured(form, result, begun, threshold) {
  const { head, letters, letter_places: [room, perPlace], asymmetry, mirrored } = form.ensemble;
  const sequences = letters.map((at) => (at ? modeSequenceOf(result.slice(at[0], at[0] + room), result[at[1]], perPlace) : ""));
  const periods = result[head.periods] - result[head.window_start], alike = isMirrored(form, begun);
  return {
    status: result[head.status],
    response: result[head.response_period],
    since: result[head.since],
    windowStart: result[head.window_start],
    windowPeriods: periods,
    mode_sequence: sequences.some(Boolean) ? sequences.join("|") : "",
    mirrored: alike && result[head.response_period] > 0 && result[asymmetry] <= mirrored * threshold,
    values: READERS[form.number](result, begun.period, threshold, alike),
  };
}

const LETTERS = ["", "F", "S", "B"];

// The mode sequence in the places of packed letters, two bits each.
function modeSequenceOf(places, count, perPlace) {
  const letters = [];
  places.forEach((packed, place) => {
    const size = Math.min(Math.max(count - place * perPlace, 0), perPlace);
    for (let i = 0; i < size; i++) letters.push(LETTERS[Math.floor(packed / 4 ** (size - 1 - i)) % 4]);
  });
  if (count > perPlace * places.length) return letters.join("") + "...";
  while (letters.length > 1 && letters[letters.length - 1] === letters[0]) letters.pop();
  return letters.join("");
}

// Stroboscopic states of the run that the ensemble has just ended, the last `count` marks (of one state). They are kept
// until the run has settled, not over the window in which it is measured then.
function lastMarks(form, floats, result, begun, state, count) {
  const { at, sizes, head } = form.ensemble, n = form.states.length;
  const done = result[head.response_period] > 0 ? result[head.window_start] : result[head.periods], found = [];
  for (let k = Math.max(0, done - count + 1); k <= done; k++) {
    found.push(floats[at.MARKS + (k % sizes.marks) * n + state] * begun.scales[state]);
  }
  return found;
}
