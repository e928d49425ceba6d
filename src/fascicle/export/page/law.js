// The law of a muscle: functions of WebAssembly that were compiled from the library's formulas.
// Constants, pressures [Pa] and strains [-] go in as numbers; nothing here knows any physics but
// how a tuning's table is read and where a curve crosses zero.
const LARGEST_STRAIN = 0.6;
const ROUNDING = 1e-15;  // of a strain at a kink, as in the library

async function loadModule(base64) {
  if (typeof WebAssembly === "undefined") throw new Error("it has no WebAssembly");
  if (typeof DecompressionStream === "undefined") throw new Error("it has no DecompressionStream");
  const bytes = Uint8Array.from(atob(base64), letter => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  const code = await new Response(stream).arrayBuffer();
  return {...(await WebAssembly.instantiate(code, {})).instance.exports};
}

// Value at x of a table, linear between its rows and flat beyond, as the tuning's C1 and C2.
function interpolate(rows, values, x) {
  if (x <= rows[0]) return values[0];
  for (let i = 1; i < rows.length; i++) {
    if (x <= rows[i]) {
      const step = rows[i] - rows[i - 1];
      return values[i - 1] + (values[i] - values[i - 1]) * (x - rows[i - 1]) / step;
    }
  }
  return values[values.length - 1];
}

// The functions of one choice of laws, with their arguments in the module's memory.
class LawFunctions {
  constructor(module, entry, points) {
    const counts = {constants: entry.constants, pressure: 1, state: entry.state, strain: 1,
                    summary: 4, force: 1, z: points, y: points, tube: 3};
    const total = Object.values(counts).reduce((sum, count) => sum + count, 0);
    const pointers = 16;  // at most: arguments and results of one call
    module.next ??= Math.ceil(module.__heap_base.value / 8) * 8;
    let place = module.next;
    module.next += 8 * (total + pointers);
    const missing = module.next - module.memory.buffer.byteLength;
    if (missing > 0) module.memory.grow(Math.ceil(missing / 65536));
    this.module = module;
    this.name = entry.name;
    this.places = {};
    for (const [name, count] of Object.entries(counts)) {
      this.places[name] = [place / 8, count];
      place += 8 * count;
    }
    const table = (names) => {
      const start = place;
      const view = new Uint32Array(module.memory.buffer, start, names.length);
      names.forEach((name, i) => { view[i] = 8 * this.places[name][0]; });
      place += 4 * names.length;
      return start;
    };
    const inputs = table(["constants", "pressure", "state", "strain"]);
    this.calls = {
      at: [module[`${entry.name}_at`], inputs, table(["summary", "state"])],
      force: [module[`${entry.name}_force`], inputs, table(["force"])],
      shape: [module[`${entry.name}_shape`], inputs, table(["z", "y", "tube"])],
    };
    this.loaded = null;
  }

  // Numbers of memory: another law's memory may have made the buffer grow.
  get numbers() {
    if (!this.view || this.view.buffer !== this.module.memory.buffer) {
      this.view = new Float64Array(this.module.memory.buffer);
    }
    return this.view;
  }

  set(name, values) { this.numbers.set(values, this.places[name][0]); }

  get(name) {
    const [start, count] = this.places[name];
    return this.numbers.slice(start, start + count);
  }

  call(name) {
    const [run, inputs, results] = this.calls[name];
    run(inputs, results, 0, 0, 0);
  }
}

// A muscle at a pressure [Pa]: its free strain, onset and collapse strain [-].
class PressurizedMuscle {
  constructor(functions, muscle, pressure) {
    this.functions = functions;
    const [rows, c1, c2] = muscle.table;
    const felt = Math.max(pressure - muscle.dead_band, muscle.least_pressure);
    this.constants = muscle.constants.slice();
    this.constants[muscle.c1] = interpolate(rows, c1, felt);
    this.constants[muscle.c1 + 1] = interpolate(rows, c2, felt);
    this.pressure = pressure;
    functions.set("constants", this.constants);
    functions.set("pressure", [pressure]);
    functions.call("at");
    [this.free, this.collapse, this.onset] = functions.get("summary");
    this.state = functions.get("state");
    functions.loaded = this;
  }

  load(strain) {
    const functions = this.functions;
    if (functions.loaded !== this) {
      functions.set("constants", this.constants);
      functions.set("pressure", [this.pressure]);
      functions.set("state", this.state);
      functions.loaded = this;
    }
    functions.numbers[functions.places.strain[0]] = strain;
  }

  force(strain) {
    this.load(strain);
    this.functions.call("force");
    return this.functions.numbers[this.functions.places.force[0]];
  }

  // Centerline, its deflection and the tube's radius [m], and the fibers' angle [rad]; after
  // collapse radius and angle are those at collapse.
  shape(strain) {
    const evaluate = at => {
      this.load(at);
      this.functions.call("shape");
      return ["z", "y", "tube"].map(name => this.functions.get(name));
    };
    const [z, y, [deflection, radius, angle]] = evaluate(strain);
    if (strain <= this.collapse) return {z, y, deflection, radius, angle};
    const [, , [, fixedRadius, fixedAngle]] = evaluate(this.collapse);
    return {z, y, deflection, radius: fixedRadius, angle: fixedAngle};
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
    return Math.min(...this.units.map((_, i) => this.plateStrain(i, LARGEST_STRAIN)));
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
