// The engine: kernels at work. It fills their memory as `numerics/run/motion.py` and `ensemble.py` do, and reads what
// they leave; no equation stands here. Runs in a worker, and in Node for tests.

const RUNNING = 0, TAPE_FULL = 2, DONE = 1;
const ROUNDS = 20000; // steps between two looks at the tape
const EVENT_ROOM = 2000, PIECE_ROOM = 20000;

// Functions by name of a kernel: its statements, joined.
function linked(pool, numbers, names) {
  const text = numbers.map((i) => pool[i]).join("\n");
  return new Function(`"use strict";\n${text}\nreturn { ${names.join(", ")} };`)();
}

class Form {
  constructor(record, pool) {
    Object.assign(this, record);
    this.pool = pool;
  }

  get kernel() {
    this._kernel ??= linked(this.pool, this.motion_code, ["advance", "begin", "take_piece", "look_at"]);
    return this._kernel;
  }

  get ensembleKernel() {
    this._ensemble ??= linked(this.pool, this.ensemble_code, ["advance_ensemble"]);
    return this._ensemble;
  }

  // What a run begins with: natural sizes of the states, period, contact velocity, holding rate.
  beginning(parameters, initial) {
    const { at, sizes } = this.motion, n = this.states.length;
    this._real ??= new Float64Array(sizes.real);
    this._real.set(initial, at.STATE);
    this._real.set(parameters, at.PARAMETER);
    const tape = new Float64Array(n + 3);
    this.kernel.begin(this._real, new Float64Array(sizes.whole), tape, 0);
    return { scales: tape.slice(0, n), period: tape[n], velocity: tape[n + 1], holdRate: tape[n + 2] };
  }
}

// One motion, of which everything is kept: what `recorded_run` does.
// limits: { events, steps, pieces }; a motion of more pieces than a page can keep ends with the status 7
function recordedRun(form, parameters, initial, periods, tolerance, limits) {
  const { at, sizes } = form.motion, rows = sizes.rows, kernel = form.kernel;
  const real = new Float64Array(sizes.real), whole = new Float64Array(sizes.whole);
  const begun = form.beginning(parameters, initial), period = begun.period;
  real.set(initial, at.STATE);
  real.set(parameters, at.PARAMETER);
  real.set(begun.scales, at.SCALE);
  const wholePeriods = Math.floor(periods + 1e-12);
  real[at.UNSAFE_SPEED] = real[at.FAR_SPEED] = Infinity;
  real[at.PERIOD] = period;
  real[at.HOLD_RATE] = begun.holdRate;
  real[at.TAIL] = periods - wholePeriods > 1e-12 ? Math.max(0, (periods - wholePeriods) * period) : 0;
  real[at.TOLERANCE] = tolerance;
  whole[at.WHOLE_PERIODS] = wholePeriods;
  whole[at.EVENT_LIMIT] = limits.events;
  whole[at.STEP_LIMIT] = limits.steps;
  if (begun.velocity !== 0) real[at.SIDE] = begun.velocity > 0 ? 1 : -1;
  else if (form.sticks) whole[at.ARRIVING] = 1;
  else { real[at.SIDE] = 1; whole[at.ZEROS] = 1; }
  const pieceRoom = Math.floor(Math.min(PIECE_ROOM, 250 * periods + 200));
  const eventStart = (wholePeriods + 1) * rows, pieceStart = eventStart + EVENT_ROOM * sizes.event;
  const tape = new Float64Array(pieceStart + pieceRoom * sizes.piece);
  tape.set(initial, 0);
  whole[at.RECORDED_EVENT_START] = eventStart;
  whole[at.RECORDED_EVENT_LIMIT] = EVENT_ROOM;
  whole[at.PIECE_START] = pieceStart;
  whole[at.PIECE_LIMIT] = pieceRoom;
  const pieces = [], events = [];
  let status = RUNNING, kept = 0;
  while (status === RUNNING) {
    kernel.advance(real, whole, tape, ROUNDS);
    status = whole[at.STATUS];
    if (status !== RUNNING) {
      pieces.push(tape.slice(pieceStart, pieceStart + whole[at.PIECES] * sizes.piece));
      events.push(tape.slice(eventStart, eventStart + whole[at.RECORDED_EVENTS] * sizes.event));
      kept += whole[at.PIECES];
      whole[at.PIECES] = whole[at.RECORDED_EVENTS] = 0;
    }
    if (status === TAPE_FULL) whole[at.STATUS] = status = kept < limits.pieces ? RUNNING : 7;
  }
  const completed = whole[at.PERIOD_COUNT];
  return {
    status, period, rows,
    pieces: joined(pieces), events: joined(events),
    sections: tape.slice(0, (completed + 1) * rows),
    final: real.slice(at.STATE, at.STATE + rows),
    residual: real[at.CONTACT_RESIDUAL],
    steps: [whole[at.TAYLOR_STEPS], whole[at.IMPLICIT_STEPS]],
    scales: begun.scales, parameters: Float64Array.from(parameters), form,
  };
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
// each: called with the result of every run (a view that changes) and its stroboscopic states
function ensembleRun(form, runs, budget, each) {
  const { at, sizes } = form.ensemble, n = form.states.length;
  const real = new Float64Array(sizes.real), whole = new Float64Array(sizes.whole);
  const tape = new Float64Array(sizes.run + sizes.result);
  const entry = form.ensembleKernel.advance_ensemble;
  runs.forEach((run, number) => {
    const begun = form.beginning(run.parameters, run.initial);
    tape.set(run.initial, 0);
    tape.set(run.parameters, n);
    tape.set(begun.scales, n + run.parameters.length);
    tape[sizes.run - 3] = begun.period;
    tape[sizes.run - 2] = Math.sign(begun.velocity);
    tape[sizes.run - 1] = 0; // begins with the drive
    whole[at.STATUS] = DONE;
    whole[at.RUN] = -1;
    whole[at.EVENT_LIMIT] = budget.events;
    whole[at.STEP_LIMIT] = budget.steps;
    whole[at.WINDOW] = budget.window;
    whole[at.PERIOD_BUDGET] = budget.periods;
    whole[at.ASKED] = budget.asked ?? form.ensemble.asked;
    whole[at.RESULT_START] = sizes.run;
    whole[at.NEXT_RUN] = 0;
    whole[at.LAST_RUN] = 1;
    whole[at.MORE] = 0;
    real[at.TOLERANCE] = budget.tolerance;
    real[at.THRESHOLD] = budget.threshold;
    while (entry(real, whole, tape, 500)) { /* goes on */ }
    each(number, tape.subarray(sizes.run), begun, real);
  });
}

// What a result says: status, response, and the measures by name.
function measured(form, result, begun, threshold) {
  const { head, letters, letter_count, asymmetry, mirrored } = form.ensemble;
  const periods = result[head.periods] - result[head.window_start], time = periods * begun.period;
  const found = {
    status: result[head.status],
    response: result[head.response_period],
    since: result[head.since],
    windowStart: result[head.window_start],
    windowPeriods: periods,
    word: form.kind === "smooth" ? "" : wordOf(result.slice(letters[0], letters[1]), result[letter_count], letters[2]),
    mirrored: result[head.response_period] > 0 && result[asymmetry] <= mirrored * threshold,
    values: {},
  };
  for (const { name, take, over } of form.measures) {
    const sum = take.reduce((total, [place, sign]) => total + sign * result[place], 0);
    found.values[name] = over === "time" ? sum / time : over === "periods" ? sum / periods : sum;
  }
  return found;
}

const LETTERS = ["", "F", "S", "B"];

// The word in the places of packed letters, two bits each.
function wordOf(places, count, perPlace) {
  const word = [];
  places.forEach((packed, place) => {
    const size = Math.min(Math.max(count - place * perPlace, 0), perPlace);
    for (let i = 0; i < size; i++) word.push(LETTERS[Math.floor(packed / 4 ** (size - 1 - i)) % 4]);
  });
  if (count > perPlace * places.length) return word.join("") + "...";
  while (word.length > 1 && word[word.length - 1] === word[0]) word.pop();
  return word.join("");
}

// Stroboscopic states of the run that the ensemble has just ended, the last `count` marks (of one state). They are kept
// until the run has settled, not over the window in which it is measured then.
function lastMarks(form, real, result, begun, state, count) {
  const { at, sizes, head } = form.ensemble, n = form.states.length;
  const done = result[head.response_period] > 0 ? result[head.window_start] : result[head.periods], found = [];
  for (let k = Math.max(0, done - count + 1); k <= done; k++) {
    found.push(real[at.MARKS + (k % sizes.marks) * n + state] * begun.scales[state]);
  }
  return found;
}
