// The readouts: what a motion is, each with one line on what that means.

// A travel as a person reads it: what is left of zero by rounding is zero.
const travel = (value, digits) => (Math.abs(value) < 1e-12 ? "0 to rounding" : said(value, digits));

function readoutsOf(model, shown, details, units, other) {
  const { data } = model, { form } = shown, status = data.statuses[shown.status] ?? { name: "unknown", text: "" };
  const unit = (name) => (units.si && form.units[name] ? ` ${form.units[name][0]}` : "");
  const found = [{ name: "Status", value: status.name, words: status.text, bad: !status.ok }];
  if (shown.drift !== null) {
    const drift = shown.drift * units.factor("position");
    found.push({ name: "Drift per period", key: "drift", value: travel(drift, 8) + unit("position"), words: "travel in the last whole period of this run" });
  }
  if (other && other.drift !== null && shown.drift !== null) {
    const less = 100 * (other.drift / shown.drift - 1);
    found.push({
      name: `Drift, ${model.names[1]}`, value: said(other.drift * units.factor("position"), 8) + unit("position"),
      words: other.drift * shown.drift < 0 ? `the other way than ${model.names[0]}` : Math.abs(shown.drift) > 1e-9 ? `${said(Math.abs(less), 3)} % ${less < 0 ? "less" : "more"} than ${model.names[0]}` : "of what is beside it",
    });
  }
  if (details) {
    const ran = data.statuses[details.status], settled = details.response > 0;
    found.push({
      name: "Settled", value: settled ? `yes, since period ${details.since}` : ran?.ok ? "not settled" : `no: ${ran?.name}`,
      words: settled ? "it repeats to 1e-6 from then on, up to its travel" : `not within ${model.budget().periods} periods: numbers of this run are of a transient`, bad: !settled,
    });
    if (settled) {
      found.push({
        name: "Response", value: `period-${details.response}${details.mirrored ? ", its own mirror image" : ""}`,
        words: details.mirrored ? "half a period later it is its mirror image, so it cannot travel" : "it differs from its mirror image, so it may travel",
      });
      if ("mean_velocity" in details.values) {
        found.push({ name: "Mean velocity", value: travel(details.values.mean_velocity * units.factor("velocity"), 6) + unit("velocity"), words: "travel per time, settled" });
      }
    }
    if (details.mode_sequence) found.push({ name: "Mode sequence of a period", value: details.mode_sequence, words: "F forward, S stuck, B back" });
  }
  form.rests.forEach((rests, i) => {
    const name = form.rests.length > 1 ? `Stuck, contact ${i + 1}` : "Stuck";
    found.push(rests
      ? { name, value: `${said(100 * (shown.stuck ? shown.stuck[i] : 0), 4)} %`, words: "share of the stretch on show at rest" }
      : { name, value: "never", words: "its law creeps instead of sticking" });
  });
  found.push({ name: "Speed at events", value: said(shown.residual, 2), words: "largest |v| where the contact is said to rest or turn" });
  if (details) found.push({ name: "Energy balance", value: said(details.energyResidual, 2), words: "energy stored less all works, over the whole run" });
  found.push({ name: "Computed in", value: `${said(shown.took, 2)} ms`, words: `${shown.pieces} steps, ${shown.events.length / 2} events` });
  return found;
}

function showReadouts(list, found) {
  list.replaceChildren(...found.map(({ name, value, words, bad, key }) => {
    const row = document.createElement("div"), term = element("dt", { textContent: name }), said = element("dd", { textContent: value });
    if (bad) said.className = "bad";
    if (key) said.id = `read-${key}`;
    said.append(element("small", { textContent: words }));
    row.append(term, said);
    return row;
  }));
}
