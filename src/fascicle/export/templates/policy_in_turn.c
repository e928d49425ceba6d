
/* One unit more where those before no longer suffice, one less where they do by the band. */
static real decide(@name@_memory *memory, const bundle *b, real asked, ends *e)
{
    const int parks = @parked@;
    int k = (int)least(most(memory->recruited + (real)1e-9, 1), (real)UNITS), unit;
    real way = 0;

    if (k < UNITS && b->gains[k] && b->largest[k - 1] - asked < 0)
        way = 1;
    else if (k > 1 && b->largest[k - 2] - asked > band)
        way = -1;
    memory->recruited = least(most((real)k + way, 1), (real)UNITS);
    k = (int)(memory->recruited + (real)1e-9);
    for (unit = 0; unit < UNITS; unit++) {
        e->lower[unit] = parks && unit > 0 && unit < k ? b->parked[unit] : 0;
        e->upper[unit] = unit < k ? b->top : 0;
        e->present[unit] = e->lower[unit];
    }
    return 0;
}
