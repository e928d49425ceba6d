
static int inside(const real pressure[UNITS], real strain)
{
    int unit, all = 1;

    for (unit = 0; unit < UNITS; unit++) {
        const int kind = kind_of[unit];
        const real eps = own(unit, strain), P = pressure[unit];

        all = all && P >= @lowest_pressure_real@ && P <= @highest_real@;
        all = all && eps >= low[kind] && eps <= high[kind];
    }
    return all;
}

int @name@_force(const real pressure[UNITS], real strain, real *force, real by_pressure[UNITS],
                 real *by_strain)
{
    const int known = inside(pressure, strain);
    real pull = 0, slope = 0;
    int unit;

    for (unit = 0; unit < UNITS; unit++) {
        point at = {0, 0, 0, 0, 0};

        if (known) at = muscle_at(kind_of[unit], pressure[unit], own(unit, strain));
        pull += count_of[unit] * at.force;
        slope += count_of[unit] * ratio_of[unit] * at.by_strain;
        if (by_pressure) by_pressure[unit] = known ? count_of[unit] * at.by_pressure : (real)NAN;
    }
    if (force) *force = known ? pull : (real)NAN;
    if (by_strain) *by_strain = known ? slope : (real)NAN;
    return !known;
}

int @name@_volume(const real pressure[UNITS], real strain, real volume[UNITS])
{
    const int known = inside(pressure, strain);
    int unit;

    for (unit = 0; unit < UNITS; unit++) {
        volume[unit] = (real)NAN;
        if (known)
            volume[unit] = count_of[unit]
                * muscle_at(kind_of[unit], pressure[unit], own(unit, strain)).volume;
    }
    return !known;
}
@cubics@@curves@@inverse_source@@controller_source@
