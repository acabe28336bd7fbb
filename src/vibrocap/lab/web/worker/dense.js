// A recorded motion at the instants that are drawn: states and observables on its pieces, and integrals of powers.

// Gauss-Legendre nodes and weights on [0, 1]: eight for Taylor steps, exact to order 15; four, exact to order 7, for
// implicit steps, which are short and of order 5.
const onUnit = (half) => half.flatMap(([x, w]) => [[0.5 - x / 2, w / 2], [0.5 + x / 2, w / 2]]);
const GAUSS = onUnit([[0.1834346424956498, 0.362683783378362], [0.525532409916329, 0.3137066458778873],
  [0.7966664774136267, 0.2223810344533745], [0.9602898564975363, 0.1012285362903763]]);
const GAUSS_OF_STIFF = onUnit([[0.3399810435848563, 0.6521451548625461], [0.8611363115940526, 0.3478548451374538]]);

const CONTACT = 1000; // times the number of a further contact, added to the number of what happens there

class Dense {
  constructor(motion) {
    const { form } = motion, { sizes } = form.motion;
    this.motion = motion;
    this.form = form;
    this.size = sizes.piece;
    this.count = motion.pieces.length / sizes.piece;
    this.states = form.states.length;
    this.contacts = form.rests.length;
    this.coordinates = form.scene.reduce((sum, shape) => sum + 2 * shape.points, 0);
    this.seen = this.states + form.observed.length + this.coordinates;
  }

  // What is done while the kernel is ready to look at this motion.
  looking(work) {
    const { motion, form } = this, { sizes, at } = form.motion, table = motion.drive ? motion.drive.table : [];
    const first = sizes.piece + this.seen - this.coordinates, start = sizes.piece + this.seen + form.drifts.length;
    return form.engine.within(sizes, start + table.length, (floats, ints, trace, ...places) => {
      trace.set(table, start);
      ints[at.TABLE_START] = BigInt(start);
      ints[at.SEGMENT_COUNT] = BigInt(form.segments(motion.parameters));
      floats.set(motion.parameters, at.PARAMETER);
      floats.set(motion.scales, at.SCALE);
      floats[at.PERIOD] = motion.period;
      const [a, b, c] = places, { take_piece, look_at } = form.kernel;
      const seen = trace.subarray(this.size, this.size + this.seen), drawn = trace.subarray(first, start);
      let before = 0; // whole periods
      this.take = (i) => {
        before = motion.pieces[i * this.size];
        trace.set(motion.pieces.subarray(i * this.size, (i + 1) * this.size));
        take_piece(a, b, c, 0);
      };
      // States, observables and coordinates of the scene at a share of the way through the piece that was taken.
      this.look = (share) => {
        look_at(a, b, c, share, this.size);
        form.drifts.forEach((place, k) => { drawn[place] += before * drawn[this.coordinates + k]; });
        return seen;
      };
      return work(seen);
    });
  }

  start(i) {
    const { pieces, period } = this.motion;
    return pieces[i * this.size] * period + pieces[i * this.size + 1];
  }

  length(i) { return this.motion.pieces[i * this.size + 2]; }
  sides(i) { return this.motion.pieces.subarray((i + 1) * this.size - this.contacts, (i + 1) * this.size); }

  get end() { return this.count ? this.start(this.count - 1) + this.length(this.count - 1) : 0; }

  // The piece that holds a time, the later one at a border.
  pieceAt(time) {
    let low = 0, high = this.count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.start(middle) <= time) low = middle; else high = middle - 1;
    }
    return low;
  }

  // Rows (time, sides, states, observables, coordinates) over a stretch of time; both ends of every piece, so that what jumps at an event jumps in
  // the rows.
  rows(from, to, most) {
    if (!this.count) return { width: 1 + this.contacts + this.seen, rows: 0, data: new Float64Array(0) };
    return this.looking(() => this.rowsSeen(from, to, most));
  }

  rowsSeen(from, to, most) {
    const first = this.pieceAt(from), last = this.pieceAt(to), pieces = last - first + 1;
    const points = Math.max(2, Math.min(9, Math.floor(most / pieces))), width = 1 + this.contacts + this.seen;
    const data = new Float64Array(pieces * points * width);
    let place = 0;
    for (let i = first; i <= last; i++) {
      this.take(i);
      const begin = this.start(i), h = this.length(i);
      const low = Math.max(0, (from - begin) / h), high = Math.min(1, (to - begin) / h);
      if (!(high >= low)) continue;
      for (let k = 0; k < points; k++) {
        const share = low + (high - low) * (k / (points - 1));
        data[place] = begin + share * h;
        data.set(this.sides(i), place + 1);
        data.set(this.look(share), place + 1 + this.contacts);
        place += width;
      }
    }
    return { width, rows: place / width, data: place < data.length ? data.slice(0, place) : data };
  }

  // The states at the start of every piece, and at the end: (time, states), for a look at the whole motion.
  overview(most) {
    const n = this.states, step = Math.max(1, Math.ceil(this.count / most)), order = this.form.motion.sizes.order;
    const data = [];
    for (let i = 0; i < this.count; i += step) {
      data.push(this.start(i));
      const head = i * this.size + 4;
      for (let j = 0; j < n; j++) data.push(this.motion.pieces[head + j]);
    }
    data.push(this.end, ...this.motion.final);
    return Float64Array.from(data);
  }

  // Works by channel over a stretch of time, at the end of each of its pieces: rows (time, works, energy gained).
  works(from, to) { return this.looking((seen) => this.worksSeen(from, to, seen)); }

  worksSeen(from, to, seen) {
    const { form } = this, first = this.pieceAt(from), last = this.pieceAt(to);
    const at = (name) => this.states + form.observed.indexOf(name);
    const powers = form.channels.map((channel) => at(`${channel}_power`));
    const [energy, ofContact] = [at("energy"), at("contact_energy")], stored = () => seen[energy] + seen[ofContact];
    const works = new Float64Array(powers.length), width = powers.length + 2, impact = form.channels.indexOf("impact");
    const data = new Float64Array((impact < 0 ? 1 : 2) * (last - first + 2) * width);
    let place = width, initial = 0, residual = 0, before = 0;
    const row = (time) => {
      const gained = stored() - initial;
      data[place] = time;
      data.set(works, place + 1);
      data[place + width - 1] = gained;
      place += width;
      return gained;
    };
    for (let i = first; i <= last; i++) {
      this.take(i);
      const h = this.length(i), begin = this.start(i);
      const low = Math.max(0, (from - begin) / h), high = Math.min(1, (to - begin) / h);
      if (i === first || impact >= 0) this.look(low);
      if (i === first) { initial = stored(); data[0] = begin + low * h; }
      else if (impact >= 0 && seen[energy] !== before) { // what an impact takes, at one instant: `piece_jumps`
        works[impact] += seen[energy] - before;
        row(begin);
      }
      const stiff = this.motion.pieces[i * this.size + 3] !== 0;
      for (const [node, weight] of stiff ? GAUSS_OF_STIFF : GAUSS) {
        this.look(low + (high - low) * node);
        for (let j = 0; j < powers.length; j++) works[j] += weight * (high - low) * h * seen[powers[j]];
      }
      this.look(high);
      before = seen[energy];
      const gained = row(begin + high * h);
      residual = Math.max(residual, Math.abs(gained - works.reduce((sum, work) => sum + work, 0)));
    }
    return { width, rows: place / width, data: data.slice(0, place), residual };
  }

  // Events: rows (time, kind).
  events() {
    const { events, period } = this.motion, size = this.form.motion.sizes.event, found = [];
    for (let i = 0; i < events.length; i += size) {
      const contact = events[i + size - 1];
      found.push(events[i] * period + events[i + 1], events[i + 2] + (contact > 1 ? CONTACT * contact : 0));
    }
    return Float64Array.from(found);
  }

  // The share of time at rest of each contact, over a stretch.
  sticking(from, to) {
    const stuck = new Array(this.contacts).fill(0);
    for (let i = this.pieceAt(from); i < this.count && this.start(i) < to; i++) {
      const share = (Math.min(to, this.start(i) + this.length(i)) - Math.max(from, this.start(i))) / (to - from);
      this.sides(i).forEach((side, contact) => { if (side === 0) stuck[contact] += share; });
    }
    return stuck;
  }
}
