@cubics@
/* the joint: both sides' forces and stiffnesses over pressure at one angle */
#define PARTS @parts@ /* of the curve of one torque: pressures that bracket a root, even in their root */

static const int first_unit[3] = {0, @split@, UNITS}; /* of the agonist, of the antagonist */
static const real moment_arm = @moment_arm@, rest_strain = @rest_strain@;
static const real length_of[2] = {@side_lengths@}; /* [m] */
static const real edge = @edge@;                   /* of the curve */
static const real room = @room@;                   /* [Pa] */

static real strain_of(int which, real angle)
{
    const real shortening = moment_arm * angle / length_of[which];

    return which ? rest_strain - shortening : rest_strain + shortening;
}

static int inside_joint(real angle, real lowest, real highest)
{
    int which, unit, all = lowest >= 0 && highest <= @highest_real@;

    for (which = 0; which < 2; which++)
        for (unit = first_unit[which]; unit < first_unit[which + 1]; unit++) {
            const real eps = own(unit, strain_of(which, angle));

            all = all && eps >= low[kind_of[unit]] && eps <= high[kind_of[unit]];
        }
    return all;
}

/* a pressure by its cell and its coordinate there */
typedef struct {
    int cell;
    real u;
} place;

static place place_of(real pressure)
{
    const real h = root_step[0], line = h * h;
    const real s = pressure > line ? @sqrt@(pressure) / h : 0;
    place at;

    at.cell = s < LINES ? (int)s : LINES - 1;
    at.u = at.cell ? s - (real)at.cell : pressure / line;
    return at;
}

static real pressure_of(place at)
{
    const real h = root_step[0], s = (real)at.cell + at.u;

    return (at.cell ? s * s : at.u) * h * h;
}

static real value_at(const real value[NODES], const real slope[NODES], place at)
{
    real c[4];

    cell_cubic(value, slope, at.cell, c);
    return cubic(c, at.u);
}

/* force [N] and stiffness [N/m] of a side, and their slopes by pressure, at each line of the table;
 * and the supply pressure with its force */
typedef struct {
    place supply;
    real full, force[NODES], slope[NODES], stiffness[NODES], bend[NODES];
} side;

static void fill_side(side *at, int which, real angle, real supply)
{
    int unit, i;

    for (i = 0; i < NODES; i++)
        at->force[i] = at->slope[i] = at->stiffness[i] = at->bend[i] = 0;
    for (unit = first_unit[which]; unit < first_unit[which + 1]; unit++) {
        const int kind = kind_of[unit];
        const real x = (own(unit, strain_of(which, angle)) - low[kind]) / cell[kind];
        const int j = x < COLUMNS ? (int)x : COLUMNS - 1;
        const real w = x - (real)j, v = 1 - w, per = 1 / (cell[kind] * length[kind]);
        const real pull = count_of[unit] * per, turn = -pull * per;
        const real da = pull * 6 * w * v, db = pull * v * (1 - 3 * w), dc = pull * w * (3 * w - 2);
        const real dda = turn * (6 - 12 * w), ddb = turn * (6 * w - 4), ddc = turn * (6 * w - 2);

        for (i = 0; i < NODES; i++) {
            const real *m = nodes[kind][i][j], *n = nodes[kind][i][j + 1];

            at->force[i] += da * (n[0] - m[0]) + db * m[1] + dc * n[1];
            at->slope[i] += da * (n[2] - m[2]) + db * m[3] + dc * n[3];
            at->stiffness[i] += dda * (n[0] - m[0]) + ddb * m[1] + ddc * n[1];
            at->bend[i] += dda * (n[2] - m[2]) + ddb * m[3] + ddc * n[3];
        }
    }
    at->supply = place_of(supply);
    at->full = value_at(at->force, at->slope, at->supply);
}

/* find where a side's force crosses one between an empty and a full side's, on the branch that
 * leads from one to the other; returns 0 if it doesn't */
static int find(const side *at, real force, place *found)
{
    int above = at->force[0] > force, stop = at->supply.cell + 1;
    real c[4];

    *found = at->supply;
    if ((at->full > force) == above) { /* beyond both, if not by rounding */
        if (size(at->full - force) <= meets) return 1;
        if (size(at->force[0] - force) > meets) return 0;
        force = at->force[0];
        above = !(at->full > force);
    }
    found->cell = 0;
    while (stop - found->cell > 1) {
        const int middle = (found->cell + stop) / 2;

        if ((at->force[middle] > force) == above) found->cell = middle; else stop = middle;
    }
    cell_cubic(at->force, at->slope, found->cell, c);
    c[0] -= force;
    found->u = zero(c, 0, found->cell == at->supply.cell ? at->supply.u : 1);
    return 1;
}

/* of an empty and a full side, that which pulls more or less */
static place end_of(const side *at, int more)
{
    return (at->full > at->force[0]) == more ? at->supply : place_of(0);
}

/* find where a side gives a force, or as near as it comes; returns 0 if it doesn't */
static int begin_curve(const side *at, real force, place *found)
{
    const int beyond = force >= larger(at->force[0], at->full);

    if (!beyond && force > smaller(at->force[0], at->full)) return find(at, force, found);
    *found = end_of(at, beyond);
    return 1;
}

/* torque over the moment arm [N], and stiffness over its square [N/m] */
static real pull_of(const side at[2], const place where[2])
{
    return value_at(at[0].force, at[0].slope, where[0])
        - value_at(at[1].force, at[1].slope, where[1]);
}

static real stiffness_of(const side at[2], const place where[2])
{
    return value_at(at[0].stiffness, at[0].bend, where[0])
        + value_at(at[1].stiffness, at[1].bend, where[1]);
}

/* both pressures from the agonist's, so that they give a torque; returns 0 if none of the
 * antagonist does */
static int balance(const side at[2], real pull, real agonist, place where[2])
{
    where[0] = place_of(agonist);
    return find(at + 1, value_at(at[0].force, at[0].slope, where[0]) - pull, where + 1);
}

/* along the curve of one torque, the pressures of a stiffness between those at two pressures of the
 * agonist, a and b, which are beyond it by `at_a` and `at_b`: regula falsi (Illinois) */
static void meet(const side at[2], real pull, real stiffness, real a, real at_a, real b, real at_b,
                 place where[2])
{
    real before = a;
    int n, moved = 0;

    for (n = 0; n < ROOT_STEPS; n++) {
        real x = b - at_b * (b - a) / (at_b - at_a), excess;

        if (!(x >= a && x <= b)) x = (a + b) / 2;
        balance(at, pull, x, where);
        excess = stiffness_of(at, where) - stiffness;
        if (excess == 0 || size(x - before) <= digits * b) break;
        before = x;
        if ((excess > 0) == (at_b > 0)) {
            b = x;
            at_b = excess;
            if (moved == 1) at_a /= 2;
            moved = 1;
        } else {
            a = x;
            at_a = excess;
            if (moved == -1) at_b /= 2;
            moved = -1;
        }
    }
}

int @name@_pressures(real angle, real torque, real stiffness, real supply_pressure,
                     real pressure[2], real reached[2])
{
    const real pull = torque / moment_arm, stiff = stiffness / (moment_arm * moment_arm);
    const real supply = smaller(supply_pressure, inverse_top);
    real least, most, sum, a, b, before = 0, excess_before = 0, nearest = INFINITY;
    int k, curve, known = 0, status = @guard@_TORQUE_OUT_OF_REACH;
    place best[2], next[2];
    side at[2];

    pressure[0] = pressure[1] = (real)NAN;
    if (reached) reached[0] = reached[1] = (real)NAN;
    if (!(inside_joint(angle, 0, 0) && supply_pressure > 0) || pull - pull != 0
        || stiff - stiff != 0)
        return @guard@_OUTSIDE;
    fill_side(at, 0, angle, supply);
    fill_side(at + 1, 1, angle, supply);
    /* forces of the agonist that the antagonist balances */
    least = pull + smaller(at[1].force[0], at[1].full);
    most = pull + larger(at[1].force[0], at[1].full);
    sum = at[0].force[0] + at[0].full;
    /* of a torque that no pressures give: the largest or the least */
    best[0] = end_of(at, least + most > sum);
    best[1] = end_of(at + 1, !(least + most > sum));
    /* the curve goes from where one of both is empty to where one is full */
    curve = begin_curve(at, least, next) && begin_curve(at, most, next + 1)
        && least <= larger(at[0].force[0], at[0].full)
        && most >= smaller(at[0].force[0], at[0].full);
    a = smaller(pressure_of(next[0]), pressure_of(next[1]));
    b = larger(pressure_of(next[0]), pressure_of(next[1]));
    for (k = 0; k <= PARTS && curve && status; k++) {
        const real part = (real)k / (real)PARTS;
        const real now = a + (edge + (1 - 2 * edge) * part * part) * (b - a);
        const int exists = balance(at, pull, now, next);
        const real excess = exists ? stiffness_of(at, next) - stiff : 0;

        if (known && exists && excess * excess_before <= 0) {
            status = @guard@_REACHED;
            meet(at, pull, stiff, before, excess_before, now, excess, best);
        } else if (exists && size(excess) < nearest) {
            nearest = size(excess);
            best[0] = next[0];
            best[1] = next[1];
            status = excess < 0 ? @guard@_STIFFNESS_TOO_HIGH : @guard@_STIFFNESS_TOO_LOW;
        }
        known = exists;
        before = now;
        excess_before = excess;
    }
    for (k = 0; k < 2; k++) pressure[k] = smaller(pressure_of(best[k]), supply);
    if (reached) {
        reached[0] = moment_arm * pull_of(at, best);
        reached[1] = moment_arm * moment_arm * stiffness_of(at, best);
    }
    return status;
}

int @name@_joint(const real pressure[2], real angle, real *torque, real *open, real *shut)
{
    const real step = 100; /* Pa: far above rounding, far below a fold */
    const int known = inside_joint(angle, smaller(pressure[0], pressure[1]),
                                   larger(pressure[0], pressure[1]));
    real turning = 0, stiff = 0, gas = 0;
    int which, unit;

    for (which = 0; which < 2 && known; which++) {
        const real p = pressure[which], level = larger(p, step);
        real by_pressure = 0, volume = 0, compliance = 0;

        for (unit = first_unit[which]; unit < first_unit[which + 1]; unit++) {
            const int kind = kind_of[unit];
            const real eps = own(unit, strain_of(which, angle)), count = count_of[unit];
            const point now = muscle_at(kind, p, eps);

            turning += (which ? -count : count) * now.force;
            stiff -= count * now.by_strain / length[kind];
            by_pressure += count * now.by_pressure;
            volume += count * now.volume;
            compliance += count * (muscle_at(kind, level + step, eps).volume
                                   - muscle_at(kind, level - step, eps).volume) / (2 * step);
        }
        gas += by_pressure * by_pressure * (p + room) / (volume + (p + room) * compliance);
    }
    if (torque) *torque = known ? moment_arm * turning : (real)NAN;
    if (open) *open = known ? moment_arm * moment_arm * stiff : (real)NAN;
    if (shut) *shut = known ? moment_arm * moment_arm * (stiff + gas) : (real)NAN;
    return !known;
}
