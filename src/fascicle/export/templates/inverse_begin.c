
static real total_force(const real pressure[UNITS], real strain)
{
    real force;

    @name@_force(pressure, strain, &force, NULL, NULL);
    return force;
}

/* clear the results and fill the curves; returns 0 for numbers outside of the domain */
static int begin_inverse(real force, real strain, real supply_pressure, curves *at,
                         real pressure[UNITS], int *state, real *reached)
{
    int unit;

    for (unit = 0; unit < UNITS; unit++) pressure[unit] = (real)NAN;
    if (state) *state = 0;
    if (reached) *reached = (real)NAN;
    if (!inside_inverse(force, strain, supply_pressure)) return 0;
    fill_curves(at, strain, smaller(supply_pressure, inverse_top));
    return 1;
}
