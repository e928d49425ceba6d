
/* The next unit is filled along a path of constant force, (X5) to (X9) of fascicle's theory. */
#define PATH_CELLS 32
static const real dips[@branch_count@][COLUMNS + 1] = {@dips@};                   /* [N] */
static const real dip_pressures[@branch_count@][COLUMNS + 1] = {@dip_pressures@}; /* [Pa] */
static const real lag = @pressure_time@, correction = @correction@; /* [s] */
static const real tolerance = @tolerance@, slack = @slack@, near_supply = @near_supply@;
static const real chord = @chord@, late_share = @late@;

static real interpolated(const real table[][COLUMNS + 1], int unit, real strain)
{
    const real *row = table[branch_of[unit]];
    real w;
    const int j = column(kind_of[unit], strain, &w);

    return (1 - w) * row[j] + w * row[j + 1];
}

/* force that a unit gains with its valve wide open, on the way to near the supply [N/s] */
static real growth(const bundle *b, int unit)
{
    const real end = near_supply * b->top, eps = b->eps[unit];
    const real level = least(most(b->pressure[unit], 0), chord * b->top);
    const real rise = count_of[unit]
        * (unit_at(unit, end, eps).force - unit_at(unit, level, eps).force);
    real time = 0, from = level;
    int leg;

    for (leg = 1; leg <= 4; leg++) {
        const real to = level + (real)leg / 4 * (end - level);
        const real p = most((from + to) / 2, 0) + room[unit];
        const real filled = content(unit, to, eps) - content(unit, from, eps);

        time += most(filled, 0) / most(flow(supply_valve[unit], b->supply + room[unit], p), (real)1e-12);
        from = to;
    }
    return b->gains[unit] ? most(rise, 0) / most(time, (real)1e-9) : 0;
}

/* A path from the unit before `next` to it: the force in reserve, less what the supply is too near
 * for; the next unit's dip, and what of it is ahead [N]; its deepest point, as a share of the path;
 * the speed of the walk, and the fastest [1/s]; whether the next unit adds force. */
typedef struct {
    real reserve, dip, ahead, deepest, speed, fastest;
    int adds;
} path;

static path path_to(const bundle *b, int next, real asked, int vents)
{
    const int last = next - 1, exists = next < UNITS;
    const real eps_last = b->eps[last];
    const real short_of = b->gains[last] ? b->full[last]
        - count_of[last] * unit_at(last, near_supply * b->top, eps_last).force : 0;
    real steepest = (real)1e-9, falling = (real)1e-9, time = 0, before = 0, steady;
    path it = {0, 0, 0, 0, 0, 0, 0};
    int i;

    it.reserve = b->largest[last] - short_of - asked;
    if (exists) {
        const real eps = b->eps[next], size = most(b->parked[next], 1);
        const real p = least(most(b->pressure[next] / size, 0), 1);
        const real end = least(onset(next, eps), near_supply * b->top);
        const real into = flow(supply_valve[next], b->top + room[next], most(end, 0) + room[next]);
        const real out = flow(exhaust_valve[next], late_share * end + room[next], room[next]);
        const real filled = most(content(next, end, eps) - content(next, 0, eps), 0);
        const real here = count_of[next] * unit_at(next, p * b->parked[next], eps).force;

        time = filled / most(vents ? out : into, (real)1e-12);
        it.dip = count_of[next] * interpolated(dips, next, eps);
        it.deepest = least(interpolated(dip_pressures, next, eps) / size, 1);
        it.adds = b->gains[next];
        it.ahead = most(b->empty[next] - here, 0);
        for (i = 0; i <= PATH_CELLS; i++) {
            const real at = (real)i / PATH_CELLS;
            const real pull = count_of[next] * unit_at(next, at * b->parked[next], eps).force;
            const real gain = pull - b->empty[next], change = (gain - before) * PATH_CELLS;

            if (at >= p) it.ahead = most(it.ahead, -gain);
            if (i > 0 && at > p) {
                steepest = most(steepest, most(change, -change));
                falling = most(falling, -change);
            }
            before = gain;
        }
    }
    it.fastest = least(1 / most(time, dt), growth(b, last) / falling) / slack;
    it.fastest = least(it.fastest, tolerance / correction);
    steady = tolerance / 2 * it.dip / (steepest * correction);
    it.speed = most(it.dip > 0 ? least(it.fastest, steady) : it.fastest, (real)1e-3);
    it.fastest = most(it.fastest, (real)1e-3);
    return it;
}

static real decide(@name@_memory *memory, const bundle *b, real asked, ends *e)
{
    const real n = (real)UNITS, rate = most(memory->rate, 0);
    int k = (int)least(most(memory->recruited + (real)1e-9, 1), n), unit, begins, late, down = 0;
    const real part = memory->recruited - (real)k;
    const int walks = part > 0;
    const path on = path_to(b, k, asked, memory->direction < 0);
    real withheld = 0, reserve, hurry, speed, released = 0;
    path back = on;

    /* a demand that has not risen is followed: less force would be a dip as well */
    if (walks && memory->direction > 0)
        withheld = most(least(on.ahead - on.reserve, memory->withheld + memory->rate * dt), 0);
    asked -= withheld;
    reserve = on.reserve + withheld;
    /* up to the deepest point, while the reserve is more than the dip */
    begins = on.adds && reserve <= on.dip + rate * (on.deepest / on.speed + lag)
        && reserve >= on.dip;
    late = on.adds && b->largest[k - 1] < asked;
    if (k > 1) {
        back = path_to(b, k - 1, asked, 1);
        released = back.dip + rate * (back.deepest / back.speed + lag) + band;
        down = !walks && back.reserve > released;
    }
    if (!walks) memory->direction = 0;
    if (down) memory->direction = -1;
    if (begins || late) memory->direction = 1;
    /* as fast as the demand makes it, if need be */
    hurry = most(on.deepest - part, 0) * rate / most(reserve - on.dip, (real)1e-9);
    speed = least(most(on.speed, hurry), on.fastest);
    if (withheld > 0 && part > on.deepest) speed = on.fastest;
    if (down) speed = back.speed;
    /* without a path the unit is recruited at once */
    if (late && !walks) speed = 1 / dt;
    memory->recruited += memory->direction * speed * dt;
    memory->recruited = least(most(memory->recruited, (real)(down ? k - 1 : k)),
                              (real)(down ? k : k + 1));
    memory->recruited = least(memory->recruited, n);
    memory->withheld = withheld;

    k = (int)(memory->recruited + (real)1e-9);
    for (unit = 0; unit < UNITS; unit++) {
        const real ramp = unit == k ? (memory->recruited - (real)k) * b->parked[unit] : 0;
        const real measured = most(b->pressure[unit], 0);
        int differs;

        e->lower[unit] = unit > 0 && unit < k ? b->parked[unit] : ramp;
        e->upper[unit] = unit < k ? b->top : ramp;
        /* of a unit that lags behind, the unit before makes up for the present pressure */
        differs = unit < k ? measured < e->lower[unit]
                           : measured > e->lower[unit] && memory->direction <= 0;
        e->present[unit] = unit > 0 && differs ? measured : e->lower[unit];
    }
    return withheld;
}
