// The worker: it keeps the kernels and the motions on show, and answers the page. One message in, one out.

const show = { forms: [], motions: {}, limits: {} };
const MOST_ROWS = 2400, MOST_OVERVIEW = 2000;

// The module of the page's kernels, from what the page holds of it.
async function unpacked(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return WebAssembly.compile(await new Response(stream).arrayBuffer());
}

const answers = {
  async open({ forms, code, limits }) {
    const engine = new Engine(await unpacked(code));
    show.forms = forms.map((record, i) => new Form(record, i, engine));
    show.limits = limits;
    return {};
  },

  motion({ side, form, parameters, initial, periods, tolerance, limits, view }) {
    const begun = performance.now();
    const motion = recordedRun(show.forms[form], parameters, initial, periods, tolerance, { ...show.limits, ...limits });
    const took = performance.now() - begun, dense = new Dense(motion);
    show.motions[side] = dense;
    const { events, overview } = { events: dense.events(), overview: dense.overview(MOST_OVERVIEW) };
    return {
      status: motion.status, period: motion.period, end: dense.end, pieces: dense.count, steps: motion.steps,
      residual: motion.residual, final: motion.final, sections: motion.sections, took, events, overview,
      mirrored: isMirrored(motion.form, motion),
      ...viewed(dense, view),
    };
  },

  view({ side, view }) { return viewed(show.motions[side], view); },

  // What takes a second run: whether the motion settles, its measures, and the balance of energy over all of it.
  details({ side, form, parameters, initial, budget }) {
    const dense = show.motions[side], record = show.forms[form];
    let found = null;
    ensembleRun(record, [{ parameters, initial }], budget, (_, result, begun) => {
      found = measured(record, result, begun, budget.threshold);
    });
    const whole = dense.count ? dense.works(0, dense.end) : null;
    return { ...found, energyResidual: whole ? whole.residual : 0 };
  },

  cells({ form, runs, budget }) {
    const record = show.forms[form], found = [];
    const keep = (_, result, begun) => found.push(result && measured(record, result, begun, budget.threshold));
    ensembleRun(record, runs, budget, keep);
    return { found };
  },

  strip({ form, runs, budget, state, marks }) {
    const record = show.forms[form], found = [];
    ensembleRun(record, runs, { ...budget, asked: 0 }, (_, result, begun, floats) => {
      if (!result) { found.push(null); return; }
      const response = result[record.ensemble.head.response_period];
      found.push({
        status: result[record.ensemble.head.status], response,
        marks: lastMarks(record, floats, result, begun, state, response > 0 ? response : marks),
      });
    });
    return { found };
  },
};

// Rows of the stretch on show, from and to in periods of the drive, counted from the end where negative.
function viewed(dense, { periods }) {
  if (!dense || !dense.count) return { rows: null, works: null };
  const end = dense.end, period = dense.motion.period;
  const from = Math.max(0, end - periods * period);
  return { from, rows: dense.rows(from, end, MOST_ROWS), works: dense.works(from, end), stuck: dense.sticking(from, end) };
}

if (typeof self !== "undefined" && typeof importScripts === "function") {
  self.onmessage = async ({ data }) => {
    const { id, ask, ...request } = data;
    try {
      const answer = await answers[ask](request);
      const given = [answer.rows?.data, answer.works?.data, answer.overview]; // moved, not copied
      self.postMessage({ id, answer }, given.flatMap((data) => (data ? [data.buffer] : [])));
    } catch (error) {
      self.postMessage({ id, failed: String(error && error.message ? error.message : error) });
    }
  };
}
