/* fluid [m3] that the units of a state take in from rest to a strain: a polynomial of each unit */
static const real volume_of[UNITS][3] = {@volumes@};

static real fluid_of(const unsigned char is_pressurized[UNITS], real strain)
{
    real fluid = 0;
    int unit;

    for (unit = 0; unit < UNITS; unit++) {
        const real *c = volume_of[unit];

        /* what flows back counts as nothing */
        if (is_pressurized[unit])
            fluid += larger(((c[2] * strain + c[1]) * strain + c[0]) * strain, 0);
    }
    return fluid;
}

