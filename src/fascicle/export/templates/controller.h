
/* A controller of the force, by the policy "@policy@", with anti-windup. Its sample time is @dt@ s.
 * Its table has @lines@ x @columns@ cells up to @inverse_highest@ Pa; above, forces are linear. With
 * 160 x 200 cells, those of `fascicle simulate` and of double precision here, a replay of a run has
 * the run's commands; with fewer it may hand over at another time. */
typedef struct {
    @real@ force_integral; /* N */
    @real@ recruited;      /* units, and the part of the way to the next */
    @real@ direction;      /* of that way: 1, 0 or -1 */
    @real@ withheld;       /* from the demand [N] */
    @real@ disturbance;    /* force beyond the model's [N] */
    @real@ demand, rate;   /* of force [N], [N/s] */
    @real@ samples;        /* steps since the start */
} @name@_memory;

/* Before the first step. */
void @name@_begin(@name@_memory *memory);

/* One step, once a sample time: from the force demanded and that measured [N], the units'
 * pressures and the supply's [Pa], the strain and its rate [1/s], to commands of the valves, from -1,
 * open exhaust, to 1, open supply. Returns 1 outside of the table, with valves shut; else 0. */
int @name@_step(@name@_memory *memory, @real@ demand, @real@ force,
                const @real@ pressure[@guard@_UNITS], @real@ supply_pressure, @real@ strain,
                @real@ strain_rate, @real@ command[@guard@_UNITS]);
