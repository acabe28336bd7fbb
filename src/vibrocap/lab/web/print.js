// The page on paper: the machine as it stands, what it is, its panels, and where it is found; on one page.

// In units of which the page is 800 wide and, less its margins, 1050 high: the scene, a line of text, and what panels get.
const ON_PAPER = { width: 800, height: 1050, scene: 170, line: 19, letters: 105, least: 300, most: 640 };

function putOnPaper(lab) {
  const { model, shown } = lab, root = $$("paper"), theme = themeOf(root), there = shown?.count > 0;
  const moves = there && model.state.view === "motion";
  const paragraphs = [
    ...model.form.sections.map((section) => `<b>${escaped(model.part(section).name)}</b>: ${sectionOnPaper(lab, section)}`),
    `<b>start and run</b>: ${startOnPaper(lab)}`,
    ...(moves ? [readoutsOf(model, shown, lab.details, lab.units, lab.other).map(({ name, value }) => `<span>${escaped(name)}: <b>${escaped(value)}</b></span>`).join("; ")] : []),
    `<small>${escaped(addressOf(lab))}; vibrocap ${escaped(model.data.version)}</small>`,
  ];
  root.innerHTML = `<h1>${escaped(model.preset.title)}</h1>${paragraphs.map((each) => `<p>${each}</p>`).join("")}`;
  const texts = [...root.querySelectorAll("p")], { width, height, scene, line, letters, least, most } = ON_PAPER;
  const lines = texts.reduce((sum, each) => sum + 0.4 + Math.ceil(each.textContent.length / letters), 2);
  const room = Math.min(most, Math.max(least, height - scene - line * lines)), rows = lab.other ? 5 : 4;
  if (moves) root.firstChild.insertAdjacentHTML("afterend", sceneOnPaper(lab, theme, width, scene));
  if (there) texts[texts.length - 1].insertAdjacentHTML("beforebegin", pictureSvg(lab, theme, width / 2, room / rows));
}

// The machine as it stands.
function sceneOnPaper(lab, theme, width, height) {
  const { shown } = lab, row = shown.at(lab.clock.time), pen = new SvgPen(width, height), [words, clock] = lab.words(row);
  pen.within(0, 0, width, height, () => drawScene(pen, theme, shown.form, lab.now(row)));
  pen.text(4, 14, words, { fill: theme.side(row[1]), size: 13, weight: 600 });
  pen.text(width - 4, 14, clock, { fill: theme.soft, size: 12, align: "right" });
  return pen.svg.replaceAll("clip0", "scene-clip");
}

// The numbers of a part, with their symbols and units.
function sectionOnPaper({ model, units }, section) {
  const found = [];
  for (const { name, symbol } of model.part(section).parameters) {
    const path = `${section}.${name}`, value = model.form.parameters.includes(path) ? model.get(path) : model.form.fixed[path];
    if (value === null || value === undefined) continue;
    const [factor, unit] = units.ofPath(path), number = typeof value === "number", shown = number ? said(value * factor) : value;
    found.push(`<span>${escaped(units.name(path).trim())} <i>${symbolHtml(symbol)}</i> = ${escaped(shown)}${number && unit ? ` ${escaped(unit)}` : ""}</span>`);
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
