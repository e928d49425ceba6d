// The table of a muscle: its co-energy over pressure and strain, whose slope is the force, and the
// shape's kinks and deflections. Nothing here knows any physics but where a curve crosses zero.
const ROUNDING = 1e-15;  // of a strain at a kink, as in the library

function decode(base64) {
  const bytes = Uint8Array.from(atob(base64), letter => letter.charCodeAt(0));
  return new Float64Array(bytes.buffer);
}

// Value and slope at x in 0 to 1 of a cubic with these values and slopes at its ends.
function hermite(a, b, slopeA, slopeB, x) {
  const c2 = 3 * (b - a) - 2 * slopeA - slopeB, c3 = 2 * (a - b) + slopeA + slopeB;
  return [((c3 * x + c2) * x + slopeA) * x + a, (3 * c3 * x + 2 * c2) * x + slopeA];
}

class MuscleTable {
  constructor({lines, columns, rootStep, low, high, length, nodes, kinks, bows}) {
    Object.assign(this, {lines, columns, rootStep, low, high, length});
    this.nodes = decode(nodes);  // line, column: co-energy [J], by strain, by pressure, by both
    this.kinks = decode(kinks);  // free strain, onset, collapse: of each line
    this.bows = decode(bows);  // of the bowed and the hinged shape, line, column
    this.step = (high - low) / columns;
  }
}

// A muscle at a pressure [Pa]: its free strain, onset and collapse strain [-].
class PressurizedMuscle {
  constructor(table, pressure) {
    const {rootStep: h, lines, columns, nodes, kinks, bows} = table;
    const root = Math.min(Math.sqrt(pressure) / h, lines), i = Math.min(Math.floor(root), lines - 1);
    const u = root - i, first = i === 0;
    const at = first ? pressure / h ** 2 : u;  // the first cell is one of pressure itself
    const ends = first ? [h ** 2, h ** 2] : [2 * i * h ** 2, 2 * (i + 1) * h ** 2];
    const energy = new Float64Array(columns + 1), slope = new Float64Array(columns + 1);
    this.bows = [0, 1].map(() => new Float64Array(columns + 1));
    for (let j = 0; j <= columns; j++) {
      const [a, b] = [i, i + 1].map(line => 4 * (line * (columns + 1) + j));
      [energy[j]] = hermite(nodes[a], nodes[b], nodes[a + 2] * ends[0], nodes[b + 2] * ends[1], at);
      [slope[j]] = hermite(nodes[a + 1], nodes[b + 1], nodes[a + 3] * ends[0],
                           nodes[b + 3] * ends[1], at);
      for (const kind of [0, 1]) {
        const [c, d] = [i, i + 1].map(line => (kind * (lines + 1) + line) * (columns + 1) + j);
        this.bows[kind][j] = (1 - u) * bows[c] + u * bows[d];
      }
    }
    Object.assign(this, {table, energy, slope});
    const kink = kind => {
      const [a, b] = [i, i + 1].map(line => kinks[kind * (lines + 1) + line]);
      if (Number.isFinite(a) && Number.isFinite(b)) return a + u * (b - a);
      return u < 1 ? a : b;
    };
    [this.free, this.onset, this.collapse] = [0, 1, 2].map(kink);
    this.unfolded = this.free;  // from which a hinge's deflection counts
    // where the table's own force vanishes: kinks are linear between the lines
    const [a, b] = [this.free - table.step, this.free + table.step];
    const [fa, fb] = [this.force(a), this.force(b)];
    if (fa > 0 && fb <= 0) this.free = findRoot(strain => this.force(strain), a, b, fa, fb);
  }

  place(strain) {
    const {low, high, step, columns} = this.table;
    const w = (Math.min(Math.max(strain, low), high) - low) / step;
    const j = Math.min(Math.floor(w), columns - 1);
    return [j, w - j];
  }

  force(strain) {
    const [j, w] = this.place(strain), {energy, slope, table} = this;
    const [, by] = hermite(energy[j], energy[j + 1], slope[j], slope[j + 1], w);
    return by / (table.step * table.length);
  }

  deflection(strain) {
    const hinged = strain > this.collapse, past = strain - (hinged ? this.unfolded : this.onset);
    if (!(past > 0)) return 0;
    const [j, w] = this.place(strain), bows = this.bows[hinged ? 1 : 0];
    return Math.sqrt(((1 - w) * bows[j] + w * bows[j + 1]) * past);
  }

  region(strain) {
    if (strain <= this.free + ROUNDING) return "in tension";
    if (strain > this.collapse + ROUNDING) return "collapsed";
    return strain > this.onset ? "buckled" : "compressed straight";
  }
}

// Root of f between a, where it is above zero, and b, where it is not: the Illinois method.
function findRoot(f, a, b, fa, fb) {
  for (let i = 0; i < 80 && fb !== 0 && Math.abs(b - a) > 1e-15; i++) {
    let x = b - fb * (b - a) / (fb - fa);
    if (!(x > Math.min(a, b) && x < Math.max(a, b))) x = (a + b) / 2;
    const fx = f(x);
    if (fx * fb < 0) { a = b; fa = fb; } else fa /= 2;
    b = x; fb = fx;
    if (i > 40) {  // a jump, which no chord finds
      const middle = (a + b) / 2, f_middle = f(middle);
      if (f_middle * fb < 0) { a = middle; fa = f_middle; } else { b = middle; fb = f_middle; }
    }
  }
  return b;
}

// Motor units between two plates; one muscle is one unit of one. Pressures [Pa], one each.
class PressurizedBundle {
  constructor(units, pressures, ratios, find) {
    this.units = units.map((unit, i) => find(unit.muscle, pressures[i]));
    this.counts = units.map(unit => unit.count);
    this.ratios = ratios;
  }

  muscleStrain(i, strain) { return 1 - this.ratios[i] * (1 - strain); }

  plateStrain(i, strain) { return 1 - (1 - strain) / this.ratios[i]; }

  unitForce(i, strain) { return this.counts[i] * this.units[i].force(this.muscleStrain(i, strain)); }

  force(strain) {
    let sum = 0;
    for (let i = 0; i < this.units.length; i++) sum += this.unitForce(i, strain);
    return sum;
  }

  get largestStrain() {
    return Math.min(...this.units.map((unit, i) => this.plateStrain(i, unit.table.high)));
  }

  // Strains at which a unit's slope jumps, in order.
  kinks(low, high) {
    return this.units
      .flatMap((unit, i) => [unit.free, unit.onset, unit.collapse].map(x => this.plateStrain(i, x)))
      .filter(x => x > low && x < high).sort((a, b) => a - b);
  }

  // Strains from low to high, the kinks among them.
  grid(low, high, count) {
    const even = Array.from({length: count}, (_, i) => low + (high - low) * i / (count - 1));
    return [...even, ...this.kinks(low, high)].sort((a, b) => a - b);
  }

  // Smallest strain of no force [-]: all units pull before the least of their free strains.
  freeStrain(cells = 48) {
    if (this.units.length === 1) return this.plateStrain(0, this.units[0].free);
    const ends = this.units.map((unit, i) => this.plateStrain(i, unit.free));
    const low = Math.min(...ends), high = this.largestStrain;
    if (low === Math.max(...ends)) return low;
    const force = strain => this.force(strain);
    let last = low, value = force(low);
    if (value <= 0) return low;
    for (const strain of this.grid(low, high, cells)) {
      if (strain <= last) continue;
      const next = force(strain);
      if (next <= 0) return findRoot(force, last, strain, value, next);
      last = strain; value = next;
    }
    return Infinity;
  }
}
