// The page on paper: the machine as it stands, what it is, its panels, and where it is found; on one page.

const ON_PAPER = { width: 800, scene: 170, panels: 520 }; // its panels share that height

function putOnPaper(lab) {
  const { model, shown } = lab, root = $$("paper"), theme = themeOf(root), svg = [];
  if (!shown || !shown.count) return;
  const row = shown.at(lab.clock.time), pen = new SvgPen(ON_PAPER.width, ON_PAPER.scene);
  const moves = model.state.view === "motion", rows = lab.other ? 5 : 4;
  if (moves) {
    pen.within(0, 0, pen.width, pen.height, () => drawScene(pen, theme, shown.form, lab.now(row)));
    pen.text(4, 14, lab.words(row)[0], { fill: theme.side(row[1]), size: 13, weight: 600 });
    pen.text(pen.width - 4, 14, lab.words(row)[1], { fill: theme.soft, size: 12, align: "right" });
    svg.push(pen.svg.replaceAll("clip0", "scene-clip"));
  }
  svg.push(pictureSvg(lab, theme, ON_PAPER.width / 2, ON_PAPER.panels / rows));
  root.innerHTML = [
    `<h1>${escaped(model.preset.title)}</h1>`,
    moves ? svg[0] : "",
    ...model.form.sections.map((section) => `<p><b>${escaped(model.part(section).name)}</b>: ${sectionOnPaper(lab, section)}</p>`),
    `<p><b>start and run</b>: ${startOnPaper(lab)}</p>`,
    moves ? `<p>${readoutsOf(model, shown, lab.details, lab.units, lab.other).map(({ name, value }) => `<span>${escaped(name)}: <b>${escaped(value)}</b></span>`).join("; ")}</p>` : "",
    svg[svg.length - 1],
    `<p class="soft">${escaped(addressOf(lab))}<br>vibrocap ${escaped(model.data.version)}</p>`,
  ].join("");
}

// The numbers of a part, with their symbols and units.
function sectionOnPaper({ model, units }, section) {
  const found = [];
  for (const { name, symbol } of model.part(section).parameters) {
    const path = `${section}.${name}`, value = model.form.parameters.includes(path) ? model.get(path) : model.form.fixed[path];
    if (value === null || value === undefined) continue;
    const [factor, unit] = units.ofPath(path), shown = typeof value === "number" ? said(value * factor) : value;
    found.push(`<span>${escaped(units.name(path).trim())} <i>${symbolHtml(symbol)}</i> = ${escaped(shown)}${unit ? ` ${escaped(unit)}` : ""}</span>`);
  }
  return found.join(", ");
}

// Where the motion begins, how long it is, and what is beside it.
function startOnPaper({ model, units, names, other }) {
  const found = Object.entries(started(model)).map(([name, value]) => {
    const [factor, unit] = units.ofPath(`initial.${name}`);
    return `<span>${escaped(wordy(name))} = ${said(value * factor)}${unit ? ` ${escaped(unit)}` : ""}</span>`;
  });
  found.push(`<span>${said(model.state.periods)} periods</span>`, `<span>tolerance ${said(model.state.tolerance)}</span>`);
  if (other) found.push(`solid: ${escaped(names[0])}; dashed: ${escaped(names[1])}`);
  return found.join(", ");
}
