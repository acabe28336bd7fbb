// The controls: choosers of parts, and for every number a slider and a box, with what is wrong beside them.

const STEPS = 1000; // of a slider
const COMMON_WIDTHS = [0.1, 0.01, 0.001]; // of a smoothed contact

// A symbol as HTML: Greek letters, what follows as an index.
function symbolHtml(symbol) {
  const found = /^([A-Za-z]+?)(?:_(\w+)|(\d+))?$/.exec(symbol ?? "");
  if (!found) return escaped(symbol ?? "");
  const index = found[2] ?? found[3];
  return `${GREEK[found[1]] ?? escaped(found[1])}${index ? `<sub>${escaped(index)}</sub>` : ""}`;
}

// What a parameter means, with signs in place of their names.
const meaningHtml = (text) => escaped(text).replace(/\b([A-Za-z]+)(?:_(\w+))?/g, (all, word, index) => {
  const sign = GREEK[word] ?? word; // with an index, or a word of several such as back_gap
  return index && sign.length > 1 ? all.replaceAll("_", " ") : index ? `${sign}<sub>${index}</sub>` : sign;
}).replace(/\^2/g, "²");

// Units of what is shown: none, or SI by the scales of the model.
class Units {
  constructor(model) { this.model = model; }

  get si() { return this.model.state.units === "SI"; }

  by(exponents) {
    if (!this.si || !exponents) return 1;
    return exponents.reduce((product, power, i) => product * this.model.state.scales[i] ** power, 1);
  }

  factor(name) { return this.by(this.model.form.units[name]?.[1]); }

  // Factor and unit of a measure.
  measure(name) {
    const [unit, exponents] = this.model.form.measures.find((each) => each.name === name)?.si ?? ["", null];
    return [this.by(exponents), this.si ? unit : ""];
  }

  // The unit of a quantity of a motion, in SI; empty where it has none.
  unit(name) {
    const unit = this.model.form.units[name]?.[0];
    return this.si && unit && unit !== "1" ? unit : "";
  }

  label(name) { return this.unit(name) ? `${wordy(name)} [${this.unit(name)}]` : wordy(name); }

  // What a parameter is called: in SI a mass ratio, for instance, is a mass.
  name(path, beside) {
    const [section, name] = halves(path);
    if (!this.si || beside || section === "run" || section === "initial") return `${wordy(name)} `;
    return `${wordy(this.model.record(path).si[0]?.[0] ?? name)} `;
  }

  // Factor and unit of a parameter, an initial state or a setting of the run.
  ofPath(path) {
    if (path.startsWith("run.")) return [1, ""];
    if (path.startsWith("initial.")) {
      const [unit, exponents] = this.model.form.units[path.slice(8)] ?? ["", null];
      return [this.by(exponents), this.si ? unit : ""];
    }
    const { exponents, si } = this.model.record(path);
    if (!this.si || !exponents || !si.length) return [1, ""];
    const [, unit, size] = si[0];
    return [this.by(exponents) / size, unit === "1" ? "" : unit];
  }
}

class Controls {
  constructor(model, units, changed, chosen) {
    Object.assign(this, { model, units, changed, chosen, rows: new Map() });
    this.root = document.getElementById("parts");
  }

  // Build everything anew: after another part, preset or unit.
  build() {
    const { model } = this, { form } = model;
    this.rows.clear();
    this.root.replaceChildren();
    for (const section of form.sections) {
      const set = this.fieldset({ machine: "Machine", friction: "Friction law", drive: "Drive", environment: "Environment", actuator: "Actuator", controller: "Controller" }[section] ?? wordy(section));
      if (PARTS.includes(section)) set.append(this.chooser(section));
      set.append(element("p", { className: "about", innerHTML: meaningHtml(model.part(section).about) }));
      for (const { name } of model.part(section).parameters) {
        const path = `${section}.${name}`;
        if (form.parameters.includes(path)) set.append(this.row(path));
        else if (form.fixed[path] !== null) set.append(this.fixed(path, form.fixed[path]));
      }
    }
    const start = this.fieldset("Start");
    for (const name of form.states) if (form.states.indexOf(name) !== form.cyclic) start.append(this.row(`initial.${name}`));
    const run = this.fieldset("Run");
    run.append(this.row("run.periods"), this.row("run.tolerance"));
    this.beside();
    this.unitChooser();
    this.refresh();
  }

  fieldset(title) {
    const set = element("fieldset", {}), head = element("legend", { textContent: title });
    set.append(head);
    this.root.append(set);
    return set;
  }

  chooser(section) {
    const { model } = this, names = Object.keys(model.data.parts[section]), select = element("select", { id: `choose-${section}` });
    select.setAttribute("aria-label", { machine: "Kind of machine", friction: "Friction law", drive: "Waveform of the drive" }[section]);
    for (const name of names) {
      const held = model.formWith(section, name) >= 0;
      select.append(element("option", { value: name, textContent: held ? wordy(name) : `${name} (${section === "machine" && model.si ? "in SI a page for each" : "not with these parts"})`, disabled: !held, selected: name === model.form[section] }));
    }
    select.addEventListener("change", () => { if (model.choose(section, select.value)) this.chosen(); });
    return select;
  }

  row(path, beside = false) {
    const { model } = this, id = `n-${beside ? "beside-" : ""}${path.replaceAll(".", "-")}`;
    const record = path.startsWith("run.") || path.startsWith("initial.") ? null : model.record(path, beside ? this.besideForm : model.form);
    const name = halves(path)[1], row = element("div", { className: "row" });
    const words = { "run.periods": "how long the motion is", "run.tolerance": "error per step" }[path] ?? (this.units.si && !beside ? record?.inSi : undefined) ?? record?.meaning ?? "at the start";
    const label = element("label", { htmlFor: id, innerHTML: `${escaped(wordy(name))} ${record ? `<i>${symbolHtml(record.symbol)}</i>` : ""} <small>${meaningHtml(words)}</small><small class="unit"></small>` });
    const slider = element("input", { type: "range", min: "0", max: String(STEPS), step: "1" });
    slider.setAttribute("aria-label", wordy(name));
    const box = element("input", { type: "text", id, inputMode: "decimal", spellcheck: false });
    const wrong = element("output", { id: `${id}-wrong` });
    wrong.setAttribute("for", id);
    box.setAttribute("aria-describedby", wrong.id);
    row.append(label, slider, box, wrong);
    const entry = { path, slider, box, wrong, label, beside };
    this.rows.set((beside ? "beside." : "") + path, entry);
    slider.addEventListener("input", () => this.take(entry, this.fromSlider(entry), false));
    box.addEventListener("input", () => this.take(entry, typed(box.value) / this.factor(entry), true));
    box.addEventListener("change", () => { if (!wrong.textContent) this.show(entry); });
    return row;
  }

  fixed(path, value) {
    const row = element("div", { className: "row" });
    row.append(element("span", { className: "fixed", textContent: `${wordy(halves(path)[1])}: ${value} (the same in the whole page)` }));
    return row;
  }

  get besideForm() { return this.model.data.forms[this.model.formOf({ ...partsOf(this.model.form), friction: this.model.state.beside })]; }

  range(entry) {
    if (!entry.beside) return rangeOfPath(this.model, entry.path);
    const { low, high, log } = this.model.record(entry.path, this.besideForm);
    return [low, high, log];
  }

  value(entry) {
    if (!entry.beside) return this.model.get(entry.path);
    return this.model.valuesBeside(this.model.data.forms.indexOf(this.besideForm))[entry.path];
  }

  factor(entry) { return entry.beside ? 1 : this.units.ofPath(entry.path)[0]; }

  // What a slider says: rounded to what its steps can tell, so that it reads well.
  fromSlider(entry) {
    const [low, high, log] = this.range(entry), value = atShare([low, high, log], entry.slider.valueAsNumber / STEPS);
    if (entry.path === "run.periods" || isSwitched(this.model.form, entry.path)) return Math.round(value) + 0;
    const digits = log ? 3 : Math.max(1, Math.ceil(Math.log10(Math.max(Math.abs(value), 1e-300) / ((high - low) / STEPS))) + 0);
    const rounded = Number(value.toPrecision(Math.min(12, Math.max(1, digits))));
    return Math.min(high, Math.max(low, rounded));
  }

  // A number is given; what is wrong with it is said beside it, and the last good motion stays.
  take(entry, value, byHand) {
    const { model } = this;
    let wrong = "";
    if (entry.beside) {
      wrong = model.complaint(entry.path, value, this.besideForm, model.valuesBeside(model.data.forms.indexOf(this.besideForm)));
      if (!wrong) model.state.besideValues[entry.path] = value;
    } else wrong = model.set(entry.path, value);
    if (wrong && byHand) wrong = withGiven(wrong, entry.box.value.trim() || "nothing");
    entry.wrong.textContent = wrong;
    entry.box.setAttribute("aria-invalid", String(Boolean(wrong)));
    if (wrong) return;
    this.show(entry, byHand);
    this.changed();
  }

  // Put what the model says into a row.
  show(entry, keepBox = false) {
    const [low, high, log] = this.range(entry), value = this.value(entry), factor = this.factor(entry);
    const share = log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low || 1);
    entry.slider.value = String(Math.round(STEPS * Math.min(1, Math.max(0, share))));
    const given = !Number.isNaN(value);
    const text = given ? String(Number((value * factor).toPrecision(8))) : ""; // to read; the number itself keeps all its digits
    if (!keepBox) entry.box.value = text;
    const unit = entry.beside ? "" : this.units.ofPath(entry.path)[1];
    entry.slider.setAttribute("aria-valuetext", unit ? `${text} ${unit}` : text);
    entry.label.querySelector(".unit").textContent = unit ? ` [${unit}]` : "";
    entry.label.firstChild.textContent = this.units.name(entry.path, entry.beside);
    entry.wrong.textContent = given ? "" : NEEDED;
    entry.box.setAttribute("aria-invalid", String(!given));
  }

  refresh() { for (const entry of this.rows.values()) this.show(entry); }

  // Complaints of a file or an address, beside their fields where they have one.
  complain(complaints) {
    for (const each of complaints) {
      const [path] = each.split(":"), entry = this.rows.get(path);
      if (!entry) continue;
      entry.wrong.textContent = each.slice(path.length + 2);
      entry.box.setAttribute("aria-invalid", "true");
    }
  }

  // What moves beside: another law, another case, this one as it is now, its mirror-image solution.
  beside() {
    const { model } = this, { state } = model, set = this.fieldset("Beside it"), select = element("select", { id: "beside" });
    const offer = (value, textContent, to = select) => to.append(element("option", { value, textContent, selected: value === state.beside }));
    const group = (label) => { const found = element("optgroup", { label }); select.append(found); return found; };
    select.setAttribute("aria-label", "What moves beside this motion");
    offer("", "nothing");
    offer("=", "this motion, kept as it is now");
    if (state.kept) offer("kept", "the kept case");
    if (model.form.mirrored !== "false") offer("twin", "its mirror-image solution");
    const laws = group("another law"), presets = group("another case");
    for (const name of Object.keys(model.data.parts.friction)) {
      if (name === model.form.friction || model.formOf({ ...partsOf(model.form), friction: name }) < 0) continue;
      offer(name, name === model.data.smoothed + model.form.friction ? "what smoothing would say (tanh)" : `the ${wordy(name)} law`, laws);
    }
    for (const { key, title } of model.data.presets) offer(`=preset=${key}`, title, presets);
    select.addEventListener("change", () => {
      const keeps = select.value.startsWith("=");
      if (keeps) state.kept = select.value.slice(1) || caseOf(model);
      Object.assign(state, { beside: keeps ? "kept" : select.value, besideValues: {} });
      this.chosen();
    });
    set.append(select);
    const say = (textContent) => set.append(element("p", { className: "line", textContent }));
    if (state.beside === "kept") {
      const { preset, form } = model.keptCase, changed = state.kept !== `preset=${preset.key}`;
      say(`Dashed: ${preset.title}${changed ? `, changed (${wordy(form.friction)})` : ""}; as long as this one.`);
      const swap = element("button", { type: "button", textContent: "Swap the two" });
      swap.addEventListener("click", () => { model.swap(); this.chosen(); });
      set.append(swap);
    } else if (state.beside === "twin") say("Dashed: the mirror image of this motion, half a period later, run from its own start.");
    else if (!this.besideForm) state.beside = "";
    else {
      say("Dashed. What both laws have is the same number for both.");
      for (const path of this.besideForm.parameters) if (path.startsWith("friction.") && !model.origin(path, this.besideForm, model.form)) set.append(this.row(path, true));
      if (this.rows.has(`beside.${WIDTH}`)) set.append(this.widths());
    }
  }

  // Widths of smoothing that are in use, to be taken at a click.
  widths() {
    const line = element("p", { className: "line", textContent: "Often taken: " });
    for (const width of COMMON_WIDTHS) {
      const take = element("button", { type: "button", textContent: String(width) });
      take.addEventListener("click", () => this.take(this.rows.get(`beside.${WIDTH}`), width, false));
      line.append(take);
    }
    return line;
  }

  unitChooser() {
    const { model } = this, set = this.fieldset("Units"), select = element("select", { id: "units" });
    select.setAttribute("aria-label", "Units");
    for (const [value, words] of [["none", "dimensionless"], ["SI", "SI"]]) select.append(element("option", { value, textContent: words, selected: value === model.state.units }));
    select.addEventListener("change", () => { model.state.units = select.value; this.chosen(); });
    set.append(select);
    if (model.state.units !== "SI") return;
    ["mass [kg]", "length [m]", "time [s]"].forEach((words, i) => {
      const row = element("div", { className: "row" }), id = `scale-${i}`;
      const box = element("input", { type: "text", id, value: String(model.state.scales[i]), inputMode: "decimal" });
      const wrong = element("output", {});
      row.append(element("label", { htmlFor: id, textContent: `one unit of ${words}` }), element("span", {}), box, wrong);
      box.addEventListener("change", () => {
        const value = typed(box.value);
        wrong.textContent = value > 0 ? "" : `should be a number greater than 0, got ${box.value || "nothing"}`;
        if (!(value > 0)) return;
        model.state.scales = model.state.scales.map((each, k) => (k === i ? value : each));
        this.refresh();
        this.changed();
      });
      set.append(row);
    });
  }
}

function element(tag, properties) { return Object.assign(document.createElement(tag), properties); }
