// Sharing: the state in the address, as TOML, as Python, as commands; a TOML file read back, strictly.

// A case as what differs from its preset, for an address.
function caseOf(model) {
  const { state, preset } = model, parts = [`preset=${preset.key}`], fresh = model.fresh(preset), put = putter(parts);
  const own = model.data.forms[fresh.form], form = model.form;
  for (const section of PARTS) if (form[section] !== own[section]) put(section, form[section]);
  const start = state.form === fresh.form ? fresh.values : model.valuesFor(state.form, fresh.values, own);
  for (const [path, value] of Object.entries(state.values)) if (!Object.is(value, start[path])) put(path, value);
  for (const [name, value] of Object.entries(state.initial)) if (value !== (fresh.initial[name] ?? 0)) put(`initial.${name}`, value);
  for (const name of ["periods", "tolerance"]) if (state[name] !== fresh[name]) put(`run.${name}`, state[name]);
  return parts.join("&");
}

const putter = (parts) => (key, value) => parts.push(`${key}=${encodeURIComponent(value)}`);

// The whole state as the fragment of an address: what differs from the preset.
function fragmentOf(model) {
  const { state } = model, fresh = model.fresh(model.preset), parts = [`v=${model.data.layout}`, caseOf(model)], put = putter(parts);
  for (const name of ["shown", "beside", "units", "view"]) if (state[name] !== fresh[name]) put(name, state[name]);
  if (state.beside === "kept") put("kept", state.kept);
  for (const [path, value] of Object.entries(state.besideValues)) put(`beside.${path}`, value);
  if (state.units === "SI" && state.scales.join() !== fresh.scales.join()) put("scales", state.scales.join(","));
  for (const [key, value] of Object.entries(state.fields)) put(key, value);
  return `#${parts.join("&")}`;
}

// Set a model as an address says; returns what is wrong with it, in words. What is wrong is left as in the preset.
function readFragment(model, fragment) {
  const given = new Map(fragment.replace(/^#/, "").split("&").filter(Boolean).map((each) => {
    const [key, ...rest] = each.split("=");
    let value = rest.join("=");
    try { value = decodeURIComponent(value); } catch { /* stays as it is */ }
    return [key, value];
  }));
  if (!given.size) return [];
  const { data } = model;
  if (given.get("v") !== String(data.layout)) {
    return [`This address is of another version of the lab (${given.get("v") ?? "none"}, this page reads ${data.layout}); the page shows its first preset.`];
  }
  const wrong = [];
  if (given.has("preset") && !model.open(given.get("preset"))) {
    return [`preset: this page has no ${given.get("preset")}; it shows its first one.`];
  }
  for (const section of PARTS) {
    if (given.has(section) && !model.choose(section, given.get(section))) wrong.push(`${section}: this page does not hold ${given.get(section)} with these parts`);
  }
  const { state } = model, others = new Map([...given].filter(([key]) => !["v", "preset", ...PARTS].includes(key)));
  const numbers = [...others].filter(([key]) => key.includes(".") && !/^(beside|map|strip)\./.test(key));
  for (const [key] of model.fill(numbers.map(([key, value]) => [key, typed(value)]))) {
    const value = given.get(key);
    wrong.push(model.paths.includes(key) ? `${key}: ${withGiven(model.complaint(key, typed(value)), value)}` : `${key}: there is no such number in this system`);
  }
  for (const [key] of numbers) others.delete(key);
  const choices = new Map([["units", ["SI", "none"]], ["view", ["motion", "map", "strip"]]]);
  for (const [key, value] of others) {
    const number = typed(value), scales = value.split(",").map(typed);
    if (key === "shown" && number > 0) state.shown = number;
    else if (key === "beside" && (["kept", "twin"].includes(value) || model.formOf({ ...partsOf(model.form), friction: value }) >= 0)) state.beside = value;
    else if (key.startsWith("beside.") && Number.isFinite(number)) state.besideValues[key.slice(7)] = number;
    else if (key === "kept") {
      const said = readFragment(new Model(data), `v=${data.layout}&${value}`);
      if (said.length) wrong.push(...said.map((each) => `kept: ${each}`)); else state.kept = value;
    } else if (choices.get(key)?.includes(value)) state[key] = value;
    else if (key === "scales" && scales.length === 3 && scales.every((each) => each > 0)) state.scales = scales;
    else if (Object.hasOwn(usualFields(model), key)) {
      const said = fieldWrong(model, key, value);
      if (said) wrong.push(`${key}: ${said}, got ${value}`); else state.fields[key] = value;
    } else wrong.push(`${key}: should be another value than ${value}, or is not known here`);
  }
  if (state.beside === "kept" && !state.kept) state.beside = "";
  return wrong;
}

const partsOf = (form) => Object.fromEntries(PARTS.map((section) => [section, form[section]]));
const tomlValue = (value) => (typeof value === "string" ? JSON.stringify(value) : Number.isInteger(value) && Math.abs(value) < 1e15 ? value.toFixed(1) : pythonNumber(value));

// A number as Python writes one: 1e-09 as well as 1e-9 reads back the same.
function pythonNumber(value) {
  const text = String(value);
  return /[.e]/.test(text) ? text : `${text}.0`;
}

function given(model, section) {
  const { form, state } = model, found = {};
  for (const { name } of model.part(section).parameters) {
    const path = `${section}.${name}`, value = Object.hasOwn(state.values, path) ? state.values[path] : form.fixed[path];
    if (value !== undefined && value !== null) found[name] = value;
  }
  return found;
}

function started(model) {
  return Object.fromEntries(Object.entries(model.state.initial).filter(([, value]) => value !== 0));
}

function asToml(model) {
  const lines = [];
  for (const section of model.form.sections) {
    lines.push(`[${section}]`);
    if (section in model.data.keys) lines.push(`${model.data.keys[section]} = ${JSON.stringify(model.form[section])}`);
    for (const [name, value] of Object.entries(given(model, section))) lines.push(`${name} = ${tomlValue(value)}`);
    lines.push("");
  }
  lines.push("[initial]", ...Object.entries(started(model)).map(([name, value]) => `${name} = ${tomlValue(value)}`), "");
  lines.push("[run]", `periods = ${model.state.periods}`, `tolerance = ${model.state.tolerance}`);
  const { events, steps } = model.state.limits, usual = model.data.limits;
  if (events !== usual.events) lines.push(`max_events_per_period = ${events}`);
  if (steps !== usual.steps) lines.push(`max_steps = ${steps}`);
  lines.push("", model.part("machine").described ?? "");
  return lines.join("\n").trimEnd() + "\n";
}

function asPython(model) {
  const imports = [], part = (section) => {
    const { python } = model.part(section);
    if (python.module) imports.push(`from ${python.module} import ${python.imported ?? python.name}`);
    const values = Object.entries(given(model, section)).map(([name, value]) => `${name}=${typeof value === "string" ? JSON.stringify(value) : pythonNumber(value)}`);
    return `${python.module ? "" : "vc."}${python.name}(${values.join(", ")})`;
  };
  const start = Object.entries(started(model)).map(([name, value]) => `"${name}": ${pythonNumber(value)}`).join(", ");
  const laws = [], fields = [], waves = []; // laws of further contacts stand in the list of the first one's, None where it has none
  for (const section of model.form.sections) {
    if (section.startsWith("drives.")) {
      waves.push(`"${halves(section)[1]}": ${part(section)}`);
      continue;
    }
    const contact = /^friction(?:_(\d+))?$/.exec(section);
    if (contact) laws[(contact[1] ?? 1) - 1] = section;
    if (!contact || contact[1] === undefined) fields.push(section);
  }
  const friction = laws.length > 1 ? `[${Array.from(laws, (section) => (section ? part(section) : "None")).join(", ")}]` : part("friction");
  const system = fields.map((section) => `    ${section}=${section === "friction" ? friction : part(section)},`);
  if (waves.length) system.push(`    drives={${waves.join(", ")}},`);
  return [
    "import vibrocap as vc", ...imports, "",
    "system = vc.System(", ...system, ")",
    `motion = vc.simulate(system, periods=${model.state.periods}, initial={${start}}, tolerance=${model.state.tolerance})`,
    "print(motion.state)", "",
  ].join("\n");
}

function asCommand(model) {
  const { form, state } = model, quoted = (text) => (/^[\w.=+-]+$/.test(text) ? text : `'${text}'`);
  const settings = [];
  for (const section of model.form.sections) {
    for (const [name, value] of Object.entries(given(model, section))) {
      if (value !== model.record(`${section}.${name}`).default) settings.push(`--set ${quoted(`${section}.${name}=${value}`)}`);
    }
  }
  for (const [name, value] of Object.entries(started(model))) settings.push(`--initial ${quoted(`${name}=${value}`)}`);
  const made = model.part("machine").described ? "# case.toml: this case, copied as TOML" :
    `vibrocap new ${form.machine} --law ${form.friction} --drive ${form.drive} --defaults --out case.toml`;
  return [
    made,
    ["vibrocap simulate case.toml", ...settings, `--periods ${state.periods}`, `--tolerance ${state.tolerance}`].join(" "), "",
  ].join("\n");
}

// A case file: { section: { key: number or text } }. Strict: what a case has, and nothing else.
// Throws an Error with the line for what is no such file.
function parsedToml(text) {
  const found = Object.create(null);
  let section = null;
  text.replace(/^\uFEFF/, "").split(/\r?\n/).forEach((raw, number) => {
    const fail = (what) => { throw new Error(`line ${number + 1}: ${what}`); };
    const line = raw.trim();
    if (!line || line.startsWith("#")) return;
    const head = /^\[\s*([A-Za-z0-9_.-]+)\s*\]\s*(#.*)?$/.exec(line);
    if (head) {
      if (head[1] in found) fail(`the section [${head[1]}] stands twice`);
      section = found[head[1]] = Object.create(null);
      return;
    }
    const pair = /^([A-Za-z0-9_-]+)\s*=\s*("(?:[^"\\]|\\.)*"|'[^']*'|[^#"']+?)\s*(#.*)?$/.exec(line);
    if (!pair) fail(`is no "key = value" and no [section]: ${line.slice(0, 60)}`);
    const target = section ?? (found[""] ??= Object.create(null));
    if (pair[1] in target) fail(`the key ${pair[1]} stands twice`);
    if (pair[2].startsWith('"')) target[pair[1]] = JSON.parse(pair[2]);
    else if (pair[2].startsWith("'")) target[pair[1]] = pair[2].slice(1, -1);
    else {
      const value = typed(pair[2].replace(/(?<=\d)_(?=\d)/g, ""));
      if (!Number.isFinite(value)) fail(`${pair[1]} should be a number or a text in quotes, got ${pair[2]}`);
      target[pair[1]] = value;
    }
  });
  return found;
}

// Set a model by a case file; returns every complaint, with its field. Where there is one, the model stays as it was.
function readToml(model, text) {
  let sections;
  try { sections = parsedToml(text.replace(model.part("machine").described ?? "\0", "")); } catch (error) { return [error.message]; }
  const wrong = [], trial = new Model(model.data), { data } = model;
  for (const name of Object.keys(sections)) {
    if (model.form.sections.includes(name) && !PARTS.includes(name)) {
      const key = data.keys[name];
      if (key && sections[name][key] !== model.form[name]) wrong.push(`${name}.${key}: is ${model.form[name]} in this page`);
      continue;
    }
    if (name === "") wrong.push(...Object.keys(sections[""]).map((key) => `${key}: stands in no section; this page reads cases without units`));
    else if (![...PARTS, "initial", "run"].includes(name)) wrong.push(`${name}: no such section in this page`);
  }
  const parts = {};
  for (const section of PARTS) {
    const key = data.keys[section], name = sections[section]?.[key];
    if (typeof name !== "string") wrong.push(`${section}.${key}: is missing`);
    else if (!Object.hasOwn(data.parts[section], name)) wrong.push(`${section}.${key}: this page does not hold ${name}; it has ${Object.keys(data.parts[section]).join(", ")}`);
    parts[section] = name;
  }
  if (wrong.length) return wrong;
  const number = trial.formOf(parts);
  if (number < 0) return [`friction.law: this page does not hold ${parts.friction} with the drive ${parts.drive}`];
  Object.assign(trial, { preset: model.preset });
  trial.state = { ...trial.fresh(model.preset), form: number, values: {}, initial: {}, periods: data.run.periods, tolerance: data.run.tolerance };
  trial.state.values = trial.valuesFor(number, {}, trial.form);
  for (const name of trial.form.states) trial.state.initial[name] = 0;
  const left = [];
  for (const section of [...trial.form.sections, "initial", "run"]) {
    for (const [key, value] of Object.entries(sections[section] ?? {})) if (key !== data.keys[section]) left.push([`${section}.${key}`, value]);
  }
  const numbers = [];
  const odd = left.filter(([path, value]) => {
    const limit = { __proto__: null, "run.max_events_per_period": "events", "run.max_steps": "steps" }[path], { fixed } = trial.form;
    if (limit) {
      const whole = Number.isInteger(value) && value >= 1;
      if (whole) trial.state.limits[limit] = value;
      return !whole;
    }
    if (path in fixed) return value !== fixed[path];
    if (typeof value === "number") numbers.push([path, value]);
    return typeof value !== "number";
  });
  for (const [path, value] of [...odd, ...trial.fill(numbers)]) {
    if (path in trial.form.fixed) wrong.push(`${path}: is ${trial.form.fixed[path]} in this page, got ${value}; write a page of this case`);
    else if (path.startsWith("run.max_")) wrong.push(`${path}: should be a whole number from 1, got ${value}`);
    else if (!trial.paths.includes(path)) wrong.push(`${path}: no such key; a page reads cases without units`);
    else wrong.push(`${path}: ${withGiven(typeof value === "number" ? trial.complaint(path, value) : "should be a number", value)}`);
  }
  if (wrong.length) return wrong;
  const { shown, units, scales, view, beside, kept } = model.state;
  model.state = { ...trial.state, shown, units, scales, view, ...(beside === "kept" ? { beside, kept } : {}) };
  return [];
}
