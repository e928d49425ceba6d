
/* the controller: fascicle.control's cascade of force, pressures, valves */
#define SHARES @shares@ /* cells of a branch's pressures, even in the root of its force */
#define NEWTON 4

static const int branch_of[UNITS] = {@branch_of@};
static const real onsets[@branch_count@][COLUMNS + 1] = {@onsets@};
static const real branches[@branch_count@][COLUMNS + 1][SHARES + 1] = {
@branches@
};
static const real branch_top = @branch_top@, highest = @highest_pressure@; /* [Pa] */
static const real dt = @dt@, force_gain = @force_gain@, force_integral_gain = @force_integral@;
static const real pressure_time = @pressure_time@, flow_limit = @flow_limit@;
static const real band = @band@;   /* [N] */
static const real above = @above@; /* of the supply over the onset, at which a unit is parked */
/* share of a step in the filters of the disturbance and of the demand's rate */
static const real observed = @observed@, filtered = @filtered@;
/* each unit's chamber: its density at a pressure [kg/m3] is `dense` p/room */
static const real room[UNITS] = {@room@}, dead[UNITS] = {@dead@};
static const real dense[UNITS] = {@dense@};
/* ISO 6358 wide open, onward and back: C rho0 sqrt(T0/T) [kg/(s Pa)], b and m */
static const real supply_valve[UNITS][2][3] = {@supply_valve@};
static const real exhaust_valve[UNITS][2][3] = {@exhaust_valve@};

static real least(real a, real b) { return a < b ? a : b; }
static real most(real a, real b) { return a > b ? a : b; }

static point unit_at(int unit, real pressure, real strain)
{
    return muscle_at(kind_of[unit], pressure, strain);
}

/* place among the columns, and how far into it */
static int column(int kind, real strain, real *w)
{
    const real x = (strain - low[kind]) / (high[kind] - low[kind]) * (real)COLUMNS;
    const real y = least(most(x, 0), (real)COLUMNS);
    const int j = (int)least(y, (real)(COLUMNS - 1));

    *w = y - (real)j;
    return j;
}

/* the last pressure at which a muscle pulls as when it is empty */
static real onset(int unit, real strain)
{
    const real *row = onsets[branch_of[unit]];
    const real empty = unit_at(unit, 0, strain).force;
    real w, p, between, reach;
    int j = column(kind_of[unit], strain, &w), i;

    between = p = (1 - w) * row[j] + w * row[j + 1];
    reach = least(between / 2, branch_top / 500);
    for (i = 0; i < 2; i++) {
        const point at = unit_at(unit, p, strain);

        if (between > 0 && at.by_pressure > 0)
            p = least(most(p - (at.force - empty) / at.by_pressure, between - reach),
                      between + reach);
    }
    return least(most(p, 0), branch_top);
}

/* pressure at which one muscle pulls so much; 0 where that is less than an empty one does */
static real branch(int unit, real force, real strain)
{
    const real empty = unit_at(unit, 0, strain).force;
    const real full = unit_at(unit, branch_top, strain).force;
    const real share = full > empty ? (force - empty) / (full - empty) : 0;
    const real size = branch_top / 10;
    real begin, p, w, x, u, left, right;
    const real (*row)[SHARES + 1] = branches[branch_of[unit]];
    int i, j, k;

    if (!(full > empty) || !(share > 0)) return 0;
    if (share >= 1) return branch_top;
    begin = onset(unit, strain);
    j = column(kind_of[unit], strain, &w);
    x = @sqrt@(share) * (real)SHARES;
    i = (int)least(x, (real)(SHARES - 1));
    u = x - (real)i;
    left = (1 - u) * row[j][i] + u * row[j][i + 1];
    right = (1 - u) * row[j + 1][i] + u * row[j + 1][i + 1];
    p = (1 - w) * left + w * right;
    for (k = 0; k < NEWTON; k++) {
        const point at = unit_at(unit, p, strain);
        const real way = at.by_pressure > 0 ? (at.force - force) / at.by_pressure : 0;

        p = least(most(p - most(least(way, size), -size), begin), branch_top);
    }
    return p;
}

/* kg/s from one absolute pressure to another through an open valve */
static real flow(const real valve[2][3], real from, real to)
{
    const int back = from < to;
    const real upper = back ? to : from, lower = back ? from : to;
    const real size = valve[back][0], b = valve[back][1], linear = @linear@;
    const real ratio = lower / (upper > 0 ? upper : 1);
    const real r = ratio < linear ? ratio : linear;
    const real y = r > b ? (r - b) / (1 - b) : 0;
    const real driving = ratio < linear ? upper : (upper - lower) / (1 - linear);
    const real passed = size * @pow@(1 - y * y, valve[back][2]) * driving;

    return back ? -passed : passed;
}

/* kg in a unit's chamber */
static real content(int unit, real pressure, real strain)
{
    const real ratio = (pressure + room[unit]) / room[unit];
    const real volume = count_of[unit] * unit_at(unit, pressure, strain).volume + dead[unit];

    return dense[unit] * volume * ratio;
}

/* how far a valve opens, so that its chamber comes to a pressure with a time constant */
static real opened(int unit, real target, real pressure, real strain, real rate, real supply)
{
    const real step = 1000, strained = (real)1e-4;
    const real P_r = least(most(target, 0), highest), m = content(unit, pressure, strain);
    const real by_pressure = (content(unit, pressure + step, strain) - m) / step;
    const real by_strain = (content(unit, pressure, strain + strained) - m) / strained;
    const real need = by_pressure * (P_r - pressure) / pressure_time + by_strain * rate;
    const real p = most(pressure, 0) + room[unit];
    const real passed = need > 0 ? flow(supply_valve[unit], supply + room[unit], p)
                                 : flow(exhaust_valve[unit], p, room[unit]);

    /* one that idles is open to the room */
    return P_r > 0 ? least(most(need / most(passed, (real)1e-9), -flow_limit), flow_limit)
                   : -flow_limit;
}

/* what the units can do now, empty and full at the top, [N]: `largest` of all states up to a unit's */
typedef struct {
    real eps[UNITS], pressure[UNITS], parked[UNITS], supply, top;
    real empty[UNITS], full[UNITS], largest[UNITS], none;
    int gains[UNITS];
} bundle;

/* ends between which each unit is filled in turn, and what it has of the lower one by now [Pa] */
typedef struct {
    real lower[UNITS], upper[UNITS], present[UNITS];
} ends;
@policy_code@
void @name@_begin(@name@_memory *memory)
{
    const @name@_memory none = {0, 1, 0, 0, 0, 0, 0, 0};

    *memory = none;
}

int @name@_step(@name@_memory *memory, real demand, real force, const real pressure[UNITS],
                real supply_pressure, real strain, real strain_rate, real command[UNITS])
{
    const real missing = demand - force, commanded = demand + force_gain * missing;
    const real integral = memory->force_integral + force_integral_gain * missing * dt;
    real asked, model = 0, held = 0, after, before = 0, share, withheld;
    bundle b;
    ends e;
    int unit, stuck;

    for (unit = 0; unit < UNITS; unit++) command[unit] = 0;
    if (!inside(pressure, strain)) return 1;
    b.supply = least(supply_pressure, highest);
    b.top = least(b.supply, branch_top);
    b.none = 0;
    for (unit = 0; unit < UNITS; unit++) {
        const real eps = b.eps[unit] = own(unit, strain);

        b.pressure[unit] = pressure[unit];
        b.parked[unit] = least(onset(unit, eps) + above * b.top, b.top);
        b.empty[unit] = count_of[unit] * unit_at(unit, 0, eps).force;
        b.full[unit] = count_of[unit] * unit_at(unit, b.top, eps).force;
        b.gains[unit] = b.full[unit] > b.empty[unit];
        if (!b.gains[unit]) b.full[unit] = b.empty[unit];
        b.none += b.empty[unit];
        model += count_of[unit] * unit_at(unit, pressure[unit], eps).force;
    }
    /* what a state pulls at most: the units before at the top, those after it empty */
    for (unit = 0, after = b.none; unit < UNITS; unit++) {
        held += b.full[unit];
        after -= b.empty[unit];
        b.largest[unit] = held + after;
    }
    /* what the model gets wrong, and the demand's rate, filtered */
    share = observed > 0 && memory->samples == 0 ? 1 : observed;
    memory->disturbance += (force - model - memory->disturbance) * share;
    if (memory->samples > 0) {
        share = most(filtered, 1 / memory->samples);
        memory->rate += ((commanded - memory->demand) / dt - memory->rate) * share;
    }
    memory->demand = commanded;
    memory->samples += 1;

    asked = commanded + memory->force_integral - memory->disturbance;
    withheld = decide(memory, &b, asked, &e);

    /* filled in turn, between these */
    for (unit = 0, after = 0; unit < UNITS; unit++)
        after += count_of[unit] * unit_at(unit, e.present[unit], b.eps[unit]).force;
    for (unit = 0; unit < UNITS; unit++) {
        const real at_low = count_of[unit] * unit_at(unit, e.present[unit], b.eps[unit]).force;
        const real at_high = b.gains[unit]
            ? count_of[unit] * unit_at(unit, e.upper[unit], b.eps[unit]).force : b.empty[unit];
        real target;

        after -= at_low;
        target = branch(unit, (asked - withheld - before - after) / count_of[unit], b.eps[unit]);
        target = least(most(target, e.lower[unit]), e.upper[unit]);
        before += most(at_high, at_low);
        command[unit] = opened(unit, target, pressure[unit], b.eps[unit],
                               ratio_of[unit] * strain_rate, supply_pressure);
    }
    /* the integral stands still while no unit can give what it would ask for */
    stuck = ((asked - withheld > b.largest[UNITS - 1] || withheld > 0)
             && integral > memory->force_integral)
        || (asked - withheld < b.none && integral < memory->force_integral);
    if (!stuck) memory->force_integral = integral;
    return 0;
}
