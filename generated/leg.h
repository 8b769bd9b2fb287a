/* Written by `exoid generate` from the model "standard leg"; never edited by hand.

state (9 per sample): t, theta1, theta2, dtheta1, dtheta2, ddtheta1, ddtheta2, sign1, sign2  [s, rad, rad/s, rad/s^2, -1..1]
linear:
  0: Phi1 [kg·m²]
  1: Phi2 [kg·m²]
  2: Phi3 [kg·m²]
  3: Phi4 [kg·m²]
  4: coulomb:hip [N·m]
  5: viscous:hip [N·m·s/rad]
  6: coulomb:knee [N·m]
  7: viscous:knee [N·m·s/rad]
shape:
  none
memory (one value per sample of each operator with memory):
  none
entries of the regressor:
  0: Y[hip][Phi1]
  1: Y[hip][Phi2]
  2: Y[knee][Phi2]
  3: Y[hip][Phi3]
  4: Y[knee][Phi3]
  5: Y[hip][Phi4]
  6: Y[hip][coulomb:hip]
  7: Y[hip][viscous:hip]
  8: Y[knee][coulomb:knee]
  9: Y[knee][viscous:knee]

`extra` is the torque (hip, knee) for forward_dynamics, `reach` for jacobian, and NULL for the rest. */
#ifndef EXOID_LEG_H
#define EXOID_LEG_H
#ifdef __cplusplus
extern "C" {
#endif

/* non-zero entries of the regressor Y, in the order of the table below */
void leg_columns_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out);

/* torque (hip, knee) in N m for a motion */
void leg_inverse_dynamics_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out);

/* acceleration (hip, knee) in rad/s^2 for a torque; the accelerations in `state` are not used */
void leg_forward_dynamics_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out);

/* M, 2 x 2 by columns, of the rigid leg */
void leg_mass_matrix_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out);

/* Christoffel C, 2 x 2 by columns, of the rigid leg */
void leg_coriolis_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out);

/* G (hip, knee) of the rigid leg, N m */
void leg_gravity_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out);

/* J, 2 x 2 by columns, of a point on the shank `reach` m below the knee */
void leg_jacobian_many(long n, const double *state, const double *linear,
    const double *shape, const double *memory, const double *extra, double *out);

#ifdef __cplusplus
}
#endif
#endif
