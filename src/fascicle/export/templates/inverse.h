
#define @guard@_REACHED 0 /* statuses of @name@_pressures */
#define @guard@_ABOVE 1   /* the demand is above what is reachable */
#define @guard@_BELOW 2   /* the demand is below what is reachable */
#define @guard@_OUTSIDE 3 /* strain or supply pressure is outside of the limits, or not a number */

/* The inverse: pressures [Pa] that give a force [N] at a strain, from 0 to the supply's gauge
 * pressure; of a supply above @inverse_highest@ Pa only that much is used. Recruitment is @scheme@, as
 * `Bundle.recruit` of fascicle chooses: the way that takes least fluid, then the lowest pressure.
 * It solves for the table's force; where the table's error moves a demand across the limit of
 * a state, the choice differs from Python's.
 *
 * Returns a status. If the demand can't be reached, the pressures are those of the nearest force
 * that can. `state` is the recruitment state, counted from 1; `reached` the force [N] that
 * @name@_force gives at these pressures. Either may be NULL. A force within @meets_text@ N of the
 * demand meets it. The number of operations is bounded. */
int @name@_pressures(@real@ force, @real@ strain, @real@ supply_pressure,
                     @real@ pressure[@guard@_UNITS], int *state, @real@ *reached);
