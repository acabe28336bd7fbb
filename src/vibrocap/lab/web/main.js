// The page at work: it asks the worker, draws what comes, and listens.

const SCENE_HEIGHT = 250; // of the scene in the page; on a full screen all of it is larger
const data = JSON.parse(document.getElementById("data").textContent);
for (const form of data.forms) form.measures = form.measures.map((number) => data.measures[number]);
const $$ = (id) => document.getElementById(id);
const workerUrl = URL.createObjectURL(new Blob([$$("worker").textContent], { type: "text/javascript" }));
const opening = { ask: "open", forms: data.forms, code: data.code, limits: { ...data.limits, pieces: 200000 } };

class Lab {
  constructor() {
    this.model = new Model(data);
    this.units = new Units(this.model);
    this.asked = new Asked(workerUrl);
    this.ready = this.asked.ask(opening);
    this.controls = new Controls(this.model, this.units, () => this.compute(), () => this.rebuilt());
    this.shown = this.other = this.details = null;
    this.clock = { time: 0, playing: !matchMedia("(prefers-reduced-motion: reduce)").matches, last: 0 };
    this.frames = [];
    this.fields = new Fields(this);
    this.listen();
    this.go(location.hash);
    requestAnimationFrame((now) => this.tick(now));
  }

  // Begin from an address.
  go(hash) {
    const wrong = readFragment(this.model, hash);
    this.notice(wrong.join("\n"), wrong.length > 0);
    this.rebuilt(false);
    this.controls.complain(wrong);
    this.mode(this.model.state.view);
  }

  // Parts, preset or units have changed: the controls are others.
  rebuilt(kept = true) {
    $$("preset").value = this.model.preset.key;
    $$("note").textContent = this.model.preset.note;
    $$("shown").value = String(this.model.state.shown);
    this.controls.build();
    this.panels();
    this.fields.build();
    this.compute(kept);
  }

  notice(text, bad = false) {
    $$("notice").textContent = text;
    $$("notice").className = bad ? "bad" : "";
  }

  // Ask for the motion as it is now; while one is on its way, only the latest wish is kept.
  async compute(kept = true) {
    if (kept) { this.remember(); this.fields.stale(); }
    this.wish = true;
    if (this.busy) return;
    this.busy = true;
    try {
      await this.ready;
      while (this.wish) {
        this.wish = false;
        const begun = performance.now();
        await this.motions();
        if (this.failed) this.notice("");
        this.failed = false;
        this.draw();
        this.frames.push(performance.now() - begun);
        if (this.frames.length === 1) this.first = performance.now();
        if (!this.wish) await this.detailed();
      }
    } catch (error) {
      this.failed = true;
      this.notice(`The motion could not be computed: ${error.message}. The last one stays.`, true);
      this.controls.complain([error.message]);
    } finally { this.busy = false; }
  }

  // The address follows, a moment later.
  remember() {
    clearTimeout(this.later);
    this.later = setTimeout(() => history.replaceState(null, "", fragmentOf(this.model)), 150);
  }

  // The motion, and what moves beside it; what cannot be beside is said, and the motion itself is shown.
  async motions() {
    const request = this.model.request(), form = this.model.form;
    const answer = await this.asked.ask({ ask: "motion", side: 0, ...request });
    let other = null, wrong = "";
    try { other = await this.motionBeside(request, answer); } catch (error) { wrong = `Beside it: ${error.message}.`; }
    if (wrong || this.alone) this.notice(wrong, true);
    this.alone = wrong !== "";
    this.shown = new Shown(form, answer);
    this.other = other;
    this.details = null;
    this.clock.time = Math.min(Math.max(this.clock.time, answer.from ?? 0), answer.end);
  }

  async motionBeside(request, { mirrored }) {
    const beside = this.model.requestBeside();
    if (!beside) return null;
    if (this.model.state.beside === "twin") { // begins half a period later, and mirrored
      if (!mirrored) throw new Error("there is no mirror-image solution, as forward and back are not alike here");
      const { final } = await this.asked.ask({ ask: "motion", side: 1, ...request, periods: 0.5 });
      beside.initial = this.model.form.symmetry.map((sign, i) => sign * final[i] + 0);
    }
    return new Shown(this.model.data.forms[beside.form], await this.asked.ask({ ask: "motion", side: 1, ...beside }));
  }

  async detailed() {
    const { form, parameters, initial } = this.model.request();
    const details = await this.asked.ask({ ask: "details", side: 0, form, parameters, initial, budget: this.model.budget() });
    if (this.wish) return;
    this.details = details;
    showReadouts($$("readouts"), readoutsOf(this.model, this.shown, this.details, this.units, this.other));
    document.body.dataset.settled = String(this.frames.length);
  }

  get names() { return this.model.names; }

  panels() {
    const wanted = PANELS.filter((panel) => !panel.wanted || (panel.wanted(this.model.state.beside || null) && this.model.state.beside));
    $$("panels").replaceChildren(...wanted.map((panel) => {
      const box = element("figure", { className: panel.wide ? "panel wide" : "panel" });
      const [below, above] = [element("canvas", {}), element("canvas", {})];
      below.setAttribute("role", "img");
      below.setAttribute("aria-label", panel.title);
      above.setAttribute("aria-hidden", "true");
      box.append(below, above);
      return box;
    }));
    this.drawings = wanted.map((panel, i) => ({ panel, below: $$("panels").children[i].children[0], above: $$("panels").children[i].children[1] }));
  }

  draw() {
    if (!this.shown || !this.shown.count || $$("motion-view").hidden) return;
    const theme = (this.theme = themeOf(document.body));
    const given = { shown: this.shown, beside: this.other, units: this.units, names: this.names };
    for (const each of this.drawings) {
      const pen = new CanvasPen(each.below); // which is empty again
      each.drawing = each.panel.wanted && !this.other ? null : each.panel.draw(pen, theme, given);
    }
    showReadouts($$("readouts"), readoutsOf(this.model, this.shown, this.details, this.units, this.other));
    this.moment();
  }

  // What happens at an event, by the number that the worker gives it (`Dense.events`).
  eventWords(number) {
    const contact = Math.floor(number / 1000);
    return wordy(this.shown.form.events[number % 1000]) + (contact ? ` of contact ${contact}` : "");
  }

  // Everything that moves with time.
  moment() {
    const { shown, theme } = this;
    if (!shown || !shown.count) return;
    const { time } = this.clock, row = shown.at(time), [words, clock] = this.words(row);
    const zoom = document.fullscreenElement ? Math.max(1, innerHeight / SCENE_HEIGHT) : 1;
    drawScene(new CanvasPen($$("scene"), zoom), theme, shown.form, this.now(row));
    if ($$("contact").textContent !== words) $$("contact").textContent = words;
    $$("contact").style.color = theme.side(row[1]);
    $$("clock").textContent = clock;
    for (const { above, drawing } of this.drawings) if (drawing) drawMark(new CanvasPen(above), theme, drawing, row);
    const share = Math.round((1000 * (time - shown.from)) / (shown.end - shown.from));
    if (document.activeElement !== $$("time") || this.clock.playing) $$("time").value = String(share);
    $$("time").setAttribute("aria-valuetext", `period ${(time / shown.period).toFixed(2)}, contact ${words}`);
  }

  // What the contacts do in a row, and the time, in words.
  words(row) {
    const { shown, units } = this, force = said(shown.of(row, "friction") * units.factor("friction"), 3);
    const friction = `${force} ${units.unit("friction")}`.trim(), length = units.unit("position");
    const slope = (length ? `   ground in ${length}` : "") + (this.slope ? `   ground inclined by ${said((this.slope * 180) / Math.PI, 3)}°` : "");
    return [
      shown.sides(row).map((side, i) => (i ? `contact ${i + 1} ` : "") + contactWords(shown.form, i, side)).join(", "),
      `period ${(row[0] / shown.period).toFixed(2)}   friction ${friction}${slope}`,
    ];
  }

  // The slope of the ground in rad, uphill forward.
  get slope() { return this.model.get("environment.inclination") ?? this.model.form.fixed["environment.inclination"] ?? 0; }

  // What the scene shows of a row.
  now(row) {
    const { shown } = this, { cyclic, states, length } = shown.form;
    return {
      sides: shown.sides(row), friction: shown.of(row, "friction"), load: shown.of(row, "load"),
      perForce: ARROW / (this.largest("friction") || 1), perLoad: LOAD_ARROW / (this.largest("load") || 1), shapes: shown.shapes(row), walls: this.walls,
      camera: this.camera(row), reach: this.reach, origin: (this.model.state.initial[states[cyclic]] ?? 0) / length,
      unit: this.units.factor("position") * length, slope: this.slope,
    };
  }

  // The middle of the contacts in a row, of a machine that travels or that a table takes along.
  middle(row) {
    const { shown } = this, { cyclic, drifts, length, scene, states } = shown.form;
    if (cyclic < 0 && !drifts.length) return 0;
    const places = shown.shapes(row).filter((_, i) => scene[i].kind === "contact");
    return places.length ? places.reduce((sum, [x]) => sum + x, 0) / places.length : shown.of(row, states[Math.max(cyclic, 0)]) / length;
  }

  // The camera moves as the machine would if it travelled evenly, and a little with it.
  camera(row) {
    const { shown } = this, { data, width, rows } = shown.rows, share = (row[0] - shown.from) / (shown.end - shown.from || 1);
    const [first, last] = (shown._ends ??= [0, rows - 1].map((i) => this.middle(data.subarray(i * width, (i + 1) * width))));
    const straight = first + (last - first) * share;
    return straight + 0.1 * (this.middle(row) - straight);
  }

  // How much farther out the walls of each box are than at its size, so that what slides in it stays inside, by name.
  get walls() {
    const { shown } = this, { data, width, rows } = shown.rows;
    if (!shown._walls) {
      let place = shown.names.length;
      const shapes = shown.form.scene.map((shape) => ({ ...shape, at: (place += 2 * shape.points) - 2 * shape.points }));
      shown._walls = {};
      for (const disc of shapes) {
        const box = disc.kind === "disc" && shapes.find(({ kind, name }) => kind === "box" && name === disc.box);
        if (!box) continue;
        let far = (shown._walls[box.name] ?? 0) + box.size[0] / 2;
        for (let i = 0; i < rows * width; i += width) far = Math.max(far, Math.abs(data[i + disc.at] - data[i + box.at]) + disc.size[0]);
        shown._walls[box.name] = far - box.size[0] / 2;
      }
    }
    return shown._walls;
  }

  // How far a contact or a wall gets from the camera, at least one length.
  get reach() {
    const { shown } = this, { data, width, rows } = shown.rows;
    if (!shown._reach) {
      let far = 1;
      for (let i = 0; i < rows * width; i += width) {
        const row = data.subarray(i, i + width), camera = this.camera(row);
        shown.shapes(row).forEach(([x], k) => { if (shown.form.scene[k].kind === "contact") far = Math.max(far, Math.abs(x - camera)); });
      }
      shown._reach = far + Math.max(0, ...Object.values(this.walls));
    }
    return shown._reach;
  }

  // The largest value of a force over the stretch on show.
  largest(name) {
    const known = (this.shown._largest ??= {});
    return (known[name] ??= this.shown.column(name).reduce((most, value) => Math.max(most, Math.abs(value)), 0));
  }

  tick(now) {
    const { clock, shown } = this, passed = Math.min(100, now - clock.last) / 1000;
    clock.last = now;
    if (clock.playing && shown && shown.count && !$$("motion-view").hidden) {
      clock.time += passed * Number($$("speed").value) * shown.period;
      if (clock.time > shown.end) clock.time = shown.from + ((clock.time - shown.from) % (shown.end - shown.from));
      this.moment();
    }
    requestAnimationFrame((later) => this.tick(later));
  }

  play(playing) {
    this.clock.playing = playing;
    $$("play").textContent = playing ? "Pause" : "Play";
  }

  // To the next event, or the one before.
  step(way) {
    const { shown, clock } = this;
    if (!shown) return;
    this.play(false);
    const times = [];
    for (let i = 0; i < shown.events.length; i += 2) if (shown.events[i] >= shown.from) times.push(shown.events[i]);
    const near = 1e-9 * shown.end, next = way > 0 ? times.find((time) => time > clock.time + near) : times.filter((time) => time < clock.time - near).pop();
    clock.time = next ?? (way > 0 ? shown.end : shown.from);
    this.moment();
    const at = shown.events.indexOf(next);
    this.notice(at >= 0 ? `Event at period ${(next / shown.period).toFixed(4)}: ${this.eventWords(shown.events[at + 1])}` : "No further event on show.");
  }

  mode(name) {
    for (const button of document.querySelectorAll("nav button")) button.setAttribute("aria-pressed", String(button.dataset.mode === name));
    for (const each of ["motion", "map", "strip"]) $$(`${each}-view`).hidden = each !== name;
    if (this.model.state.view !== name) { this.model.state.view = name; this.remember(); }
    if (name === "motion") { this.panels(); this.draw(); } else this.fields.show(name);
  }

  listen() {
    for (const { key, title } of data.presets) $$("preset").append(element("option", { value: key, textContent: title }));
    $$("preset").addEventListener("change", () => {
      const { view } = this.model.state;
      this.model.open($$("preset").value);
      this.model.state.view = view;
      this.notice("");
      this.rebuilt();
    });
    for (const button of document.querySelectorAll("nav button")) button.addEventListener("click", () => this.mode(button.dataset.mode));
    $$("play").addEventListener("click", () => this.play(!this.clock.playing));
    this.play(this.clock.playing);
    $$("full").hidden = !document.fullscreenEnabled;
    $$("full").addEventListener("click", () => document.querySelector(".scene").requestFullscreen());
    $$("scene").addEventListener("click", () => { if (document.fullscreenElement) this.play(!this.clock.playing); });
    $$("before").addEventListener("click", () => this.step(-1));
    $$("after").addEventListener("click", () => this.step(1));
    $$("time").addEventListener("input", () => {
      this.play(false);
      if (this.shown) { this.clock.time = this.shown.from + ((this.shown.end - this.shown.from) * $$("time").valueAsNumber) / 1000; this.moment(); }
    });
    $$("shown").addEventListener("change", () => { this.model.state.shown = Number($$("shown").value); this.compute(); });
    $$("controls").addEventListener("submit", (event) => event.preventDefault());
    addEventListener("hashchange", () => { this.model.open(data.presets[0].key); this.go(location.hash); });
    addEventListener("resize", () => { this.draw(); this.fields.draw(); });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.draw(); this.fields.draw(); });
    listenToSharing(this);
    addEventListener("beforeprint", () => putOnPaper(this));
  }
}
