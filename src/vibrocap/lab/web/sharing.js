// Buttons of sharing: copy, save, open a file, check.

function listenToSharing(lab) {
  const { model } = lab;
  $$("link").addEventListener("click", () => {
    if (location.protocol !== "file:") copied(lab, addressOf(lab), "The link");
    else if (model.lacking()) lab.notice(model.lacking(), true);
    else copied(lab, asToml(model), `This page lies on your disk, where nobody else can follow a link. Send the file ${fileName()} itself; opened with ${fragmentOf(model)} behind its name it shows this motion. The case`);
  });
  $$("copy").addEventListener("change", () => {
    const made = { toml: asToml, python: asPython, command: asCommand }[$$("copy").value];
    if (made && model.lacking()) lab.notice(model.lacking(), true);
    else if (made) copied(lab, made(model), `The case as ${$$("copy").selectedOptions[0].textContent}`);
    $$("copy").value = "";
  });
  $$("save").addEventListener("change", () => {
    const kind = $$("save").value;
    $$("save").value = "";
    const { view } = model.state;
    if (lab.shown && kind === "csv") saved(`${view}.csv`, view === "motion" ? asCsv(lab.shown) : lab.fields.csv(view), "text/csv");
    if (lab.shown && kind === "svg") saved(`${view}.svg`, pictureSvg(lab), "image/svg+xml");
    if (lab.shown && kind === "png") savePng(lab);
  });
  $$("file").addEventListener("change", async () => {
    const [file] = $$("file").files;
    if (file) opened(lab, await file.text(), file.name);
    $$("file").value = "";
  });
  addEventListener("dragover", (event) => { event.preventDefault(); document.body.classList.add("drop"); });
  addEventListener("dragleave", () => document.body.classList.remove("drop"));
  addEventListener("drop", async (event) => {
    event.preventDefault();
    document.body.classList.remove("drop");
    const [file] = event.dataTransfer.files;
    if (file) opened(lab, await file.text(), file.name);
  });
  $$("check").addEventListener("click", () => checked(lab));
}

const fileName = () => decodeURIComponent(location.pathname.split("/").pop());

// Where this motion is found: of a page on a disk the name of its file, which the reader may have elsewhere.
const addressOf = (lab) => (location.protocol === "file:" ? fileName() : location.href.split("#")[0]) + fragmentOf(lab.model);

// A text goes to the clipboard, and stands in the page where a browser does not let it.
async function copied(lab, text, what) {
  lab.copied = text;
  try {
    await navigator.clipboard.writeText(text);
    lab.notice(`${what} was copied:\n${text}`);
  } catch { lab.notice(`${what}, to copy by hand:\n${text}`); }
}

function saved(name, content, type) {
  const link = element("a", { href: URL.createObjectURL(new Blob([content], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

function opened(lab, text, name) {
  const wrong = readToml(lab.model, text);
  if (wrong.length) {
    lab.notice(`${name} cannot be run here; the last motion stays.\n${wrong.join("\n")}`, true);
    lab.controls.complain(wrong);
    return;
  }
  lab.notice(`${name} was read.`);
  lab.rebuilt();
}

// The stretch on show as a table.
function asCsv(shown) {
  const names = ["time", "side", ...shown.form.states, ...shown.form.observed], { data, width, rows } = shown.rows, lines = [names.join(",")];
  for (let i = 0; i < rows; i++) lines.push(Array.from(data.subarray(i * width, i * width + names.length)).join(","));
  return `${lines.join("\n")}\n`;
}

// All panels in one picture, two side by side, each so wide and high; or the map, or the strip.
function pictureSvg(lab, theme = themeOf(document.body), width = 620, height = 300) {
  if (lab.model.state.view !== "motion") return lab.fields.svg(lab.model.state.view, theme);
  const parts = [];
  const given = { shown: lab.shown, beside: lab.other, units: lab.units, names: lab.names };
  let x = 0, y = 0;
  for (const { panel } of lab.drawings) {
    if (panel.wanted && !lab.other) continue;
    if (panel.wide && x) { x = 0; y += height; }
    const pen = new SvgPen(panel.wide ? 2 * width : width, height);
    panel.draw(pen, theme, given);
    parts.push(`<g transform="translate(${x} ${y})">${pen.parts.join("\n").replaceAll("clip", `p${parts.length}clip`)}</g>`);
    if (panel.wide || x) { x = 0; y += height; } else x = width;
  }
  const total = y + (x ? height : 0), back = `<rect width="${2 * width}" height="${total}" fill="${theme.paper}"/>`;
  return svgOf(2 * width, total, back + parts.join("\n").replaceAll(/<(\/?)p\d+clipPath/g, "<$1clipPath").replaceAll(/ p\d+clip-path=/g, " clip-path="));
}

async function savePng(lab) {
  const image = new Image(), url = URL.createObjectURL(new Blob([pictureSvg(lab)], { type: "image/svg+xml" }));
  image.src = url;
  await image.decode();
  const canvas = element("canvas", { width: image.width * 2, height: image.height * 2 });
  canvas.getContext("2d").drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob((blob) => saved(`${lab.model.state.view}.png`, blob, "image/png"));
  URL.revokeObjectURL(url);
}

// The end of the preset's motion, as this page finds it and as the plain kernel of the package found it, to the last bit.
async function checked(lab) {
  const { preset } = lab.model, trial = new Model(data);
  trial.open(preset.key);
  const answer = await lab.asked.ask({ ask: "motion", side: 2, ...trial.request() });
  const form = trial.form, same = form.states.every((_, i) => Object.is(answer.final[i], preset.check.state[i]) || answer.final[i] === preset.check.state[i]);
  const alike = same && answer.status === preset.check.status && answer.pieces === preset.check.pieces && answer.events.length / 2 === preset.check.events;
  const lines = form.states.map((name, i) => `${wordy(name)}: this page ${answer.final[i]}, plain kernel ${preset.check.state[i]}`);
  lab.notice(`Check of “${preset.title}”, the end of ${preset.periods} periods, ${answer.pieces} steps and ${answer.events.length / 2} events: ${alike ? "the same to the last bit" : "NOT the same"}.\n${lines.join("\n")}\n`
    + "The second number was computed when this page was written. `vibrocap simulate` differs in the last digits where the processor rounds a product and a sum once.", !alike);
  document.body.dataset.check = alike ? "same" : "different";
}

const lab = new Lab();
