// The state of the lab: which parts, which numbers, how it runs; what may be set, and what is wrong with what is not.

const WIDTH = "friction.smoothing_velocity"; // of a law that is smoothed
const PARTS = ["machine", "friction", "drive"];
const MOST_PERIODS = 2000;
const NEEDED = "should be given; in SI it has no default";

const wordy = (name) => name.replace(/_/g, " ");

// Part and parameter of a path: "drives.clamp" and "amplitude" of "drives.clamp.amplitude".
const halves = (path) => [path.slice(0, path.lastIndexOf(".")), path.slice(path.lastIndexOf(".") + 1)];

// A complaint with what was given, where it does not say so itself.
const withGiven = (wrong, value) => (wrong.includes(", got ") ? wrong : `${wrong}, got ${value}`);

// The range of tolerances of a form's kernel, which belong to the order of its series (`numerics/run/motion.py`).
const TOLERANCES = { 10: [1e-7, 1e-5], 12: [1e-11, 9.99e-8], 16: [1e-14, 9.99e-12] };

class Model {
  constructor(data) {
    this.data = data;
    this.open(data.presets[0].key);
  }

  // Begin with a preset.
  open(key) {
    const preset = this.data.presets.find((each) => each.key === key);
    if (!preset) return false;
    this.preset = preset;
    this.state = this.fresh(preset);
    return true;
  }

  fresh(preset) {
    return {
      form: preset.form,
      values: { ...preset.values },
      initial: { ...preset.initial },
      periods: preset.periods,
      tolerance: preset.tolerance,
      shown: 4,
      beside: "", // a law, "kept" or "twin"
      besideValues: {},
      kept: "", // a case as the address of a page has it
      view: "motion",
      fields: {}, // settings of maps and strips that are not as usual
      units: preset.units,
      scales: preset.scales ?? [1, 1, 1],
      limits: { ...this.data.limits },
    };
  }

  get form() { return this.data.forms[this.state.form]; }
  part(section, form = this.form) { return this.data.parts[section][form[section]]; }

  // The form of these parts, by number; -1 where the page does not hold it.
  formOf(parts) {
    return this.data.forms.findIndex((form) => PARTS.every((section) => form[section] === parts[section]));
  }

  // Whether the case that the page shows is in SI: there no default of another machine's stands for its own.
  get si() { return this.preset.units === "SI"; }

  // The form with another machine, law or drive; -1 where there is none. In SI a machine counts in units of its own.
  formWith(section, name) {
    if (section === "machine" && this.si && name !== this.form.machine) return -1;
    return this.formOf({ ...partsOf(this.form), [section]: name });
  }

  // Another machine, law or drive: what both have keeps its value, the rest begins with its default, or asks for one.
  choose(section, name) {
    const number = this.formWith(section, name);
    if (number < 0) return false;
    this.state.values = this.valuesFor(number, this.state.values);
    this.state.form = number;
    const initial = {};
    for (const name of this.form.states) initial[name] = this.state.initial[name] ?? 0;
    this.state.initial = initial;
    if (this.state.beside === this.form.friction) this.state.beside = "";
    return true;
  }

  // Under which path the value of a parameter of one form stands in another; undefined where it has none there.
  origin(path, form, old) {
    const [section, name] = halves(path);
    if (form[section] === old[section]) return path;
    const from = this.data.carried[section]?.[form[section]]?.[old[section]]?.[name];
    return from && `${section}.${from}`;
  }

  // Values for a form, from those of another or else from the preset's; else defaults, and NaN for what has none in SI.
  valuesFor(number, known, old = this.form) {
    const form = this.data.forms[number], own = this.data.forms[this.preset.form], found = {};
    for (const path of form.parameters) {
      const other = form[halves(path)[0]] !== old[halves(path)[0]], record = this.record(path, form);
      const first = other ? this.preset.values[this.origin(path, form, own)] : undefined;
      found[path] = known[this.origin(path, form, old)] ?? first ?? (other && this.si && record.needed ? NaN : record.default);
    }
    return found;
  }

  // What is still to be given, in the first place where something is; "" where nothing is.
  lacking(form = this.form, values = this.state.values) {
    const path = form.parameters.find((each) => Number.isNaN(values[each]));
    return path ? `${path}: ${NEEDED}` : "";
  }

  record(path, form = this.form) {
    const [section, name] = halves(path);
    return this.part(section, form).parameters.find((each) => each.name === name);
  }

  // What is wrong with a number at a path; "" where nothing is. Text is what a person typed.
  complaint(path, value, form = this.form, values = this.state.values) {
    if (!Number.isFinite(value)) return "should be a finite number";
    if (path === "run.periods") {
      return value >= 1e-9 && value <= MOST_PERIODS ? "" : `should be above 0 and at most ${MOST_PERIODS}`;
    }
    if (path === "run.tolerance") {
      const [low, high] = TOLERANCES[form.motion.sizes.order];
      return value >= low && value <= high ? "" : `should be from ${low} to ${high} in this page`;
    }
    if (path.startsWith("initial.")) {
      if (isSwitched(form, path) && !Number.isInteger(value)) return "should be a whole number, as it selects the branch of the equations";
      return Math.abs(value) < 1e300 ? "" : "should be smaller";
    }
    const { least, above, most, below } = this.record(path, form);
    if (value < least || (above && value === least)) return `should be ${above ? "greater than" : "at least"} ${least}`;
    if (value > most || (below && value === most)) return `should be ${below ? "less than" : "at most"} ${most}`;
    const broken = this.broken(form, { ...values, [path]: value });
    if (!broken) return "";
    return broken[0] === path ? broken[1] : `${wordy(halves(broken[0])[1])} ${broken[1]}`;
  }

  // The first rule between numbers that is broken, as the parts themselves have it: [field, what is wrong]; or null.
  broken(form, values) {
    return RULES[form.number](form.parameters.map((path) => values[path]), (value) => String(Number(value.toPrecision(9))));
  }

  get(path) {
    const [section, name] = halves(path);
    if (section === "run") return this.state[name];
    return section === "initial" ? this.state.initial[name] : this.state.values[path];
  }

  // Set a number; returns what is wrong with it, and leaves everything as it was where something is.
  set(path, value) {
    const wrong = this.complaint(path, value);
    if (wrong) return wrong;
    const [section, name] = halves(path);
    if (section === "run") this.state[name] = value;
    else if (section === "initial") this.state.initial[name] = value;
    else this.state.values[path] = value;
    return "";
  }

  // Set as many of [path, number] as can be, whatever their order; the rest.
  fill(left) {
    for (let before = -1; before !== left.length;) {
      before = left.length;
      left = left.filter(([path, value]) => !this.paths.includes(path) || this.set(path, value) !== "");
    }
    return left;
  }

  // All paths that have a number.
  get paths() {
    return [...this.form.parameters, ...this.form.states.map((name) => `initial.${name}`), "run.periods", "run.tolerance"];
  }

  // What the worker is asked for.
  request(form = this.state.form, values = this.state.values) {
    const record = this.data.forms[form], lacking = this.lacking(record, values);
    if (lacking) throw new Error(lacking);
    return {
      form,
      parameters: record.parameters.map((path) => values[path]),
      initial: record.states.map((name) => this.state.initial[name] ?? 0),
      periods: this.state.periods,
      tolerance: this.state.tolerance,
      limits: this.state.limits,
      view: { periods: Math.min(this.state.shown, this.state.periods) },
    };
  }

  // What stands beside it, of the same length: a case that was kept, or the same with another law, where what it shares
  // with the first has the same value; null for nothing. Throws an Error where there is no such motion.
  requestBeside() {
    const { beside, periods, tolerance, shown, limits } = this.state;
    if (beside === "kept") {
      const model = this.keptCase;
      Object.assign(model.state, { periods, tolerance, shown, limits });
      return model.request();
    }
    if (beside === "twin") return this.request();
    const number = beside ? this.formOf({ ...partsOf(this.form), friction: beside }) : -1;
    if (number < 0) return null;
    const values = this.valuesBeside(number), broken = this.broken(this.data.forms[number], values);
    if (broken) throw new Error(`of the law beside, ${halves(broken[0])[1]} ${broken[1]}`);
    return this.request(number, values);
  }

  get keptCase() {
    if (this._kept?.text !== this.state.kept) {
      const model = new Model(this.data);
      readFragment(model, `v=${this.data.layout}&${this.state.kept}`);
      this._kept = { text: this.state.kept, model };
    }
    return this._kept.model;
  }

  // What the two motions are called.
  get names() {
    const { beside } = this.state;
    if (beside === "twin") return ["this motion", "its mirror-image solution"];
    if (beside === "kept") return ["this motion", "the kept one"];
    const number = beside ? this.formOf({ ...partsOf(this.form), friction: beside }) : -1;
    const named = (law, values) => wordy(law) + (values && WIDTH in values ? ` (width ${said(values[WIDTH])})` : "");
    return [named(this.form.friction, this.state.values), named(beside, number >= 0 && this.valuesBeside(number))];
  }

  // The present case is kept beside, and what was kept is the present one.
  swap() {
    const { shown, units, scales, view, fields, kept } = this.state, text = caseOf(this);
    readFragment(this, `v=${this.data.layout}&${kept}`);
    Object.assign(this.state, { shown, units, scales, view, fields, beside: "kept", kept: text });
  }

  valuesBeside(number) {
    const values = this.valuesFor(number, this.state.values);
    for (const [path, value] of Object.entries(this.state.besideValues)) {
      if (Object.hasOwn(values, path) && !this.origin(path, this.data.forms[number], this.form)) values[path] = value;
    }
    return values;
  }

  budget(periods = 200) {
    return {
      periods: Math.max(periods, Math.ceil(this.state.periods)), window: Math.min(10, periods), threshold: 1e-6,
      tolerance: this.form.tolerance, events: this.data.limits.events, steps: 2000000,
    };
  }
}

// Whether a state at the start is a whole number that says which branch of the equations holds.
const isSwitched = (form, path) => path.startsWith("initial.") && form.switched.includes(path.slice(8));

// The range of a slider: (low, high, by factors), without units; beyond the value of the case, and as wide as the one that stands.
function rangeOfPath(model, path) {
  if (path === "run.periods") return [1, 200, false];
  if (path === "run.tolerance") return [...TOLERANCES[model.form.motion.sizes.order], true];
  if (path.startsWith("initial.")) return isSwitched(model.form, path) ? [-1, 1, false] : [-3.2, 3.2, false];
  const { low, high, log, least = -Infinity, most = Infinity } = model.record(path), first = model.preset.values[path] ?? low;
  const below = first < low ? Math.max(least, log ? first / 10 : first - (high - first) / 2) : low;
  const above = first < high ? high : Math.min(most, log ? 10 * first : first + (first - low) / 2);
  const value = model.state.values[path] ?? low;
  return Number.isNaN(value) ? [below, above, log] : [Math.min(below, value), Math.max(above, value), log];
}

// A number as a person reads it: at most so many digits, no noise.
function said(value, digits = 6) {
  if (!Number.isFinite(value)) return "none";
  if (value === 0) return "0";
  const text = Math.abs(value) >= 1e-4 && Math.abs(value) < 1e6 ? String(Number(value.toPrecision(digits))) : value.toExponential(digits - 1);
  return text.replace(/\.?0+e/, "e").replace("e+", "e").replace(/^-/, "−");
}

// A number that a person typed; NaN for what is none. A comma is not taken for a point: it is asked about.
function typed(text) {
  const plain = text.trim().replace("−", "-");
  return /^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(plain) ? Number(plain) : NaN;
}
