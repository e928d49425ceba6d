
#define @guard@_REACHED 0            /* statuses of @name@_pressures */
#define @guard@_STIFFNESS_TOO_HIGH 1 /* the demand is above what is reachable at this torque */
#define @guard@_STIFFNESS_TOO_LOW 2  /* the demand is below what is reachable at this torque */
#define @guard@_TORQUE_OUT_OF_REACH 3
#define @guard@_OUTSIDE 4 /* angle or supply pressure outside of the limits, or not a number */

/* Two muscles, or bundles whose motor units have one pressure, pull a joint in opposite directions:
 * as the angle [rad], @low@ to @high@, grows, the agonist shortens, whose pressure comes
 * first; a positive torque [N m] turns the joint that way. Pressures in Pa (gauge), 0 to @highest@.
 * The moment arm is @arm@ m, both sides are contracted by @rest@ at the angle 0. */

/* The inverse, (K9) of fascicle's theory: pressures that give a torque and, with open valves, a
 * stiffness [N m/rad], as `Joint.pressures` of fascicle chooses; of a supply above @highest@ Pa only
 * that much is used. Returns a status. If the demand can't be reached, the pressures are those of
 * the nearest stiffness at this torque, or else of the nearest torque. `reached` is the torque and
 * the stiffness that @name@_joint gives at these pressures; it may be NULL. It solves for the
 * table's torque and stiffness. The number of operations is bounded. */
int @name@_pressures(@real@ angle, @real@ torque, @real@ stiffness, @real@ supply_pressure,
                     @real@ pressure[2], @real@ reached[2]);

/* Torque [N m], and stiffness [N m/rad] with open valves, at constant pressures, and with shut
 * ones: the gas in the muscles stays, at the temperature of the room, (K10). Any of the three may be
 * NULL. Returns 1 outside of the table, with NAN; else 0. */
int @name@_joint(const @real@ pressure[2], @real@ angle, @real@ *torque, @real@ *open, @real@ *shut);
