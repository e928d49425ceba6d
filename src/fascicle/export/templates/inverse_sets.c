
/* Each unit has a pressure of its own. Sets of pressurized units, few units before many: those at
 * supply pressure, those whose pressure is free, and the recruitment state of each set. */
#define SETS @states@
static const unsigned char is_full[SETS][UNITS] = {@full@};
static const unsigned char is_throttled[SETS][UNITS] = {@throttled@};
static const int state_of[SETS] = {@owners@};
@fluid_code@
/* pressure [Pa] and force [N] of a muscle or a unit: least, most, at supply pressure and vented */
enum { LEAST, MOST, FULL, VENTED };
typedef struct { real pressure[4], force[4]; } limits;

static limits muscle_limits(const curves *at, int kind)
{
    real count[KINDS] = {0}, beyond = 1;
    limits of;
    int i;

    count[kind] = 1;
    for (i = 0; i < NODES; i++) beyond = larger(beyond, size(at->force[kind][i]));
    beyond *= 10; /* between nodes no curve rises as far */
    for (i = LEAST; i <= MOST; i++) {
        const real target = i == LEAST ? -beyond : beyond;
        const solution nearest = search(at, count, target);

        of.pressure[i] = nearest.pressure;
        of.force[i] = nearest.excess + target;
    }
    of.pressure[FULL] = at->supply;
    of.force[FULL] = at->full[kind];
    of.pressure[VENTED] = 0;
    of.force[VENTED] = at->force[kind][0];
    return of;
}

int @name@_pressures(real force, real strain, real supply_pressure, real pressure[UNITS],
                     int *state, real *reached)
{
    const real close = larger(@close@ * (1 + size(force)), meets);
    real base = 0, least = 0, most = 0, nearest = INFINITY, least_fluid = INFINITY, target, total;
    limits of[UNITS], of_kind[KINDS];
    int unit, k, i, last, choice = 0, is_reached;
    curves at;

    if (!begin_inverse(force, strain, supply_pressure, &at, pressure, state, reached))
        return @guard@_OUTSIDE;
    for (k = 0; k < KINDS; k++) of_kind[k] = muscle_limits(&at, k);
    for (unit = 0; unit < UNITS; unit++) {
        of[unit] = of_kind[kind_of[unit]];
        for (i = LEAST; i <= VENTED; i++) of[unit].force[i] *= count_of[unit];
    }

    /* of the sets that reach the demand the one of least fluid, else the nearest */
    for (k = 0; k < SETS; k++) {
        real fixed = 0, low = 0, high = 0, miss, fluid;

        for (unit = 0; unit < UNITS; unit++) {
            const real *unit_force = of[unit].force;

            fixed += unit_force[is_full[k][unit] ? FULL : VENTED];
            if (!is_throttled[k][unit]) continue;
            low += unit_force[LEAST] - unit_force[VENTED];
            high += unit_force[MOST] - unit_force[VENTED];
        }
        miss = larger(larger(fixed + low - force, force - fixed - high), 0);
        fluid = miss <= meets ? fluid_of(is_throttled[k], strain) + fluid_of(is_full[k], strain)
                              : INFINITY;
        if (fluid < least_fluid || (least_fluid == INFINITY && miss < nearest)) {
            least_fluid = fluid;
            nearest = miss;
            choice = k;
            base = fixed;
            least = fixed + low;
            most = fixed + high;
        }
    }
    is_reached = nearest <= meets;
    target = smaller(larger(force, least), most);

    /* all its units pull most, or resist most, but one that is throttled: the last that can be */
    for (last = UNITS - 1; last >= 0; last--) {
        real fixed = 0, count[KINDS] = {0};
        solution root;

        if (!is_throttled[choice][last]) continue;
        for (unit = 0; unit < UNITS; unit++) {
            i = is_full[choice][unit] ? FULL : !is_throttled[choice][unit] ? VENTED
              : target >= base ? MOST : LEAST;
            pressure[unit] = of[unit].pressure[i];
            if (unit != last) fixed += of[unit].force[i];
        }
        count[kind_of[last]] = count_of[last];
        root = search(&at, count, target - fixed);
        pressure[last] = root.pressure;
        total = total_force(pressure, strain);
        if (!is_reached || size(total - force) <= close) break;
    }
    total = total_force(pressure, strain);
    is_reached = is_reached && size(total - force) <= close;
    if (state) *state = state_of[choice];
    if (reached) *reached = total;
    return is_reached ? @guard@_REACHED : total < force ? @guard@_ABOVE : @guard@_BELOW;
}
