// A robot arm with geared joints, for recordings that owe nothing to this project: MuJoCo gives the links' masses and forces, the rest is here.
//
//   J θ̈ = τ_m − T (1 + e z cos(z θ + φ)) − F_rotor          rotors, joint side
//   M q̈ = T − h(q, q̇) − F_link + effects                    links
//   T = k p + d ṗ on the touching flank, never pulling, p = θ + e sin(z θ + φ) − q beyond half a gap
//   τ_m = ratio K_t i (1 + a sin(n θ_m + φ)) + τ_c sin(n θ_m + φ)
//
// Semi-implicit Euler at STEP; dry friction is set-valued: an impulse that stops the body, or as large as friction allows. The links' impulses
// are found by sweeps of projected Gauss-Seidel. A controller at 1 kHz sees counts of the encoder alone.
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdlib.h>
#include <string.h>

#define STEP 50e-6
enum { JOINTS = 8, CONTROL = 20, REFRESH = 2, SWEEPS = 4, HISTORY = 4096 };

// Parameters of a joint, SI, joint side; Python reads their names from `fields`.
#define FIELDS(X)                                                                                                                   \
  X(rotor) X(stiffness) X(damping) X(half_gap)                                      /* gear */                                      \
  X(coulomb) X(rest) X(stribeck) X(viscous_positive) X(viscous_negative) X(behind)  /* friction; `behind`: the links' share */       \
  X(constant) X(lag) X(limit) X(ratio)                                              /* N·m/A at the joint; current loop [s], [A] */ \
  X(counts) X(low_pass) X(noise) X(resolution)                                      /* counts per rad of the joint; current [A] */  \
  X(kp) X(kv) X(ki)                                                                 /* controller */                                \
  X(asymmetry) X(offset) X(cable) X(cable_rest) X(balancer) X(balancer_angle)       /* effects, as the catalogue defines them */    \
  X(cogging) X(cogging_order) X(cogging_phase) X(ripple) X(ripple_order) X(ripple_phase)                                            \
  X(map) X(map_order) X(map_phase) X(mesh) X(mesh_teeth) X(mesh_phase)                                                              \
  X(by_load) X(warming) X(warming_time) X(drag) X(runout) X(runout_phase)                                                           \
  X(contact) X(contact_angle) X(contact_side)

#define MEMBER(name) double name;
#define NAME(name) #name " "
typedef struct { FIELDS(MEMBER) } Joint;
const char* fields(void) { return FIELDS(NAME); }

typedef struct {
  double theta, omega, current, command, integral;  // rotor, drive, controller
  double counted, velocity;                         // what the encoder and its filter read
  double impulse;                                   // of friction on the link in the last step [N·m·s]
} State;

static double normal(uint64_t* seed) {
  double u[2];
  for (int k = 0; k < 2; k++) {
    *seed ^= *seed << 13, *seed ^= *seed >> 7, *seed ^= *seed << 17;
    u[k] = ((double)(*seed >> 11) + 0.5) / 9007199254740992.0;
  }
  return sqrt(-2 * log(u[0])) * cos(6.283185307179586 * u[1]);
}

// Magnitude of friction at velocity v and angle q, `sign` its direction, with the load T on the gear.
static double friction(const Joint* j, double v, double sign, double q, double load, double time) {
  double dry = j->coulomb * (1 + j->map * cos(j->map_order * q + j->map_phase)) + (j->rest - j->coulomb) * exp(-fabs(v) / j->stribeck);
  double viscous = (sign > 0 ? j->viscous_positive : j->viscous_negative) * (1 + j->warming * exp(-time / j->warming_time));
  return dry * (1 + sign * j->asymmetry) + viscous * fabs(v) + j->drag * v * v + j->by_load * fabs(load);
}

static double reading(const Joint* j, double theta) {
  double shown = theta + j->runout * sin(j->ratio * theta + j->runout_phase);
  return floor(shown * j->counts) / j->counts;
}

// Counts a step of the control period, filters the velocity, and sets the command of the drive.
static void control(const Joint* j, State* s, double position, double velocity) {
  const double period = CONTROL * STEP;
  double counted = reading(j, s->theta);
  s->velocity += (1 - exp(-period / j->low_pass)) * ((counted - s->counted) / period - s->velocity);
  s->counted = counted;
  double error = position - counted;
  double torque = j->kp * error + j->kv * (velocity - s->velocity) + s->integral;
  s->command = fmax(-j->limit, fmin(j->limit, torque / j->constant));
  if (s->command == torque / j->constant) s->integral += j->ki * error * period;
}

// Torque that the link feels beside gear, friction and gravity.
static double outside(const Joint* j, double q) {
  double torque = -j->cable * (q - j->cable_rest) - j->balancer * sin(q - j->balancer_angle);
  double depth = j->contact_side * (q - j->contact_angle);
  return depth > 0 ? torque - j->contact_side * j->contact * depth : torque;
}

// The links' velocities after a step under torques `push`, with friction up to `most` [N·m].
static void move_links(int n, const double* inverse, const double* push, const double* most, State* s, double* w) {
  for (int i = 0; i < n; i++)
    for (int k = 0; k < n; k++) w[i] += inverse[i * n + k] * (STEP * push[k] + s[k].impulse);
  for (int sweep = 0; sweep < SWEEPS; sweep++) {
    for (int i = 0; i < n; i++) {
      double wanted = s[i].impulse - w[i] / inverse[i * n + i];
      double bound = STEP * most[i], given = fmax(-bound, fmin(bound, wanted));
      for (int k = 0; k < n; k++) w[k] += inverse[k * n + i] * (given - s[i].impulse);
      s[i].impulse = given;
    }
  }
}

// Simulates until the last of `samples` times. `references`: positions, then velocities, of all joints every millisecond; `late`: steps by which
// currents and positions are recorded late; `out`: position, velocity and current of all joints at each time. 0, or 1 if a joint runs away.
int simulate(const mjModel* m, int n, const Joint* joints, int milliseconds, const double* references, int start, int samples,
             const int64_t* times, const int* late, uint64_t seed, double* out) {
  State s[JOINTS] = {0};
  double q[JOINTS], w[JOINTS] = {0}, inverse[JOINTS * JOINTS], bias[JOINTS] = {0}, identity[JOINTS * JOINTS] = {0};
  double(*history)[3 * JOINTS] = calloc(HISTORY, sizeof *history);
  mjData* d = mj_makeData(m);
  int runaway = n > JOINTS || !history;
  for (int i = 0; i < n; i++) {
    q[i] = s[i].theta = references[i];
    s[i].counted = reading(&joints[i], s[i].theta);
    identity[i * n + i] = 1;
  }
  for (int64_t step = 0, next = 0; next < samples && !runaway; step++) {
    double time = fmax(0, (step - (int64_t)start * CONTROL) * STEP), push[JOINTS], most[JOINTS];
    if (step % CONTROL == 0) {
      int64_t row = step / CONTROL < milliseconds ? step / CONTROL : milliseconds - 1;
      for (int i = 0; i < n; i++) control(&joints[i], &s[i], references[row * 2 * n + i], references[row * 2 * n + n + i]);
    }
    if (step % REFRESH == 0) {
      mju_copy(d->qpos, q, n);
      mju_copy(d->qvel, w, n);
      mj_fwdPosition(m, d);
      mj_fwdVelocity(m, d);
      mju_copy(bias, d->qfrc_bias, n);
      mj_solveM(m, d, inverse, identity, n);
    }
    for (int i = 0; i < n; i++) {
      const Joint* j = &joints[i];
      State* r = &s[i];
      double mesh = j->mesh_teeth * r->theta + j->mesh_phase, slope = 1 + j->mesh * j->mesh_teeth * cos(mesh);
      double twist = r->theta + j->mesh * sin(mesh) - q[i], rate = r->omega * slope - w[i], load = 0;
      if (twist > j->half_gap) load = fmax(0, j->stiffness * (twist - j->half_gap) + j->damping * rate);
      if (twist < -j->half_gap) load = fmin(0, j->stiffness * (twist + j->half_gap) + j->damping * rate);
      r->current += (r->command - r->current) * STEP / j->lag;
      double shaft = j->ratio * r->theta;
      double motor = j->constant * r->current * (1 + j->ripple * sin(j->ripple_order * shaft + j->ripple_phase)) +
                     j->cogging * sin(j->cogging_order * shaft + j->cogging_phase);
      double free = r->omega + STEP / j->rotor * (motor - load * slope);
      double stop = STEP / j->rotor * (1 - j->behind) * friction(j, r->omega, copysign(1, free), q[i], load, time);
      r->omega = fabs(free) <= stop ? 0 : free - copysign(stop, free);
      push[i] = load - bias[i] + outside(j, q[i]);
      most[i] = j->behind * friction(j, w[i], copysign(1, w[i]), q[i], load, time);
    }
    move_links(n, inverse, push, most, s, w);
    double* now = history[step % HISTORY];
    for (int i = 0; i < n; i++) {
      q[i] += STEP * w[i];
      s[i].theta += STEP * s[i].omega;
      now[i] = reading(&joints[i], s[i].theta);
      now[n + i] = s[i].velocity;
      now[2 * n + i] = s[i].current;
      runaway |= !(fabs(s[i].theta) < 50);
    }
    for (; next < samples && times[next] <= step; next++) {
      const double* shown = history[(step + HISTORY - late[1]) % HISTORY];
      const double* drawn = history[(step + HISTORY - late[0]) % HISTORY];
      for (int i = 0; i < n; i++) {
        const Joint* j = &joints[i];
        double current = drawn[2 * n + i] + j->offset + j->noise * normal(&seed);
        out[next * 3 * n + i] = shown[i];
        out[next * 3 * n + n + i] = shown[n + i];
        out[next * 3 * n + 2 * n + i] = j->resolution * round(current / j->resolution);
      }
    }
  }
  mj_deleteData(d);
  free(history);
  return runaway;
}
