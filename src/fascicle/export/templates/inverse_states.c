
/* units at supply pressure, and those that share the throttled one, in each recruitment state */
#define STATES @states@
#define NESTED @is_nested@ /* a later state takes no less fluid */
static const unsigned char is_full[STATES][UNITS] = {@full@};
static const unsigned char is_throttled[STATES][UNITS] = {@throttled@};
@fluid_code@
int @name@_pressures(real force, real strain, real supply_pressure, real pressure[UNITS],
                     int *state, real *reached)
{
    solution best = {0, INFINITY, 0};
    real least_fluid = 0, total = 0;
    int k, unit, choice = 0;
    curves at;

    if (!begin_inverse(force, strain, supply_pressure, &at, pressure, state, reached))
        return @guard@_OUTSIDE;
    for (k = 0; k < STATES; k++) {
        real count[KINDS] = {0}, fixed = 0, fluid;
        solution next;

        for (unit = 0; unit < UNITS; unit++) {
            const int kind = kind_of[unit];

            if (is_throttled[k][unit]) count[kind] += count_of[unit];
            else fixed += count_of[unit] * (is_full[k][unit] ? at.full[kind] : at.force[kind][0]);
        }
        next = search(&at, count, force - fixed);
        fluid = @fluid@;
        if (next.meets ? !best.meets || fluid < least_fluid
                       : !best.meets && size(next.excess) < size(best.excess) - tie) {
            best = next;
            least_fluid = fluid;
            choice = k;
        }
        if (best.meets && NESTED) break;
    }
    for (unit = 0; unit < UNITS; unit++)
        pressure[unit] = is_throttled[choice][unit] ? best.pressure
                       : is_full[choice][unit] ? at.supply : 0;
    total = total_force(pressure, strain);
    if (state) *state = choice + 1;
    if (reached) *reached = total;
    return best.meets ? @guard@_REACHED : best.excess < 0 ? @guard@_ABOVE : @guard@_BELOW;
}
