// MuJoCo's side of the comparison in README.md: the planar arm's error against the reference, and its speed.
//
//   mujoco arm.xml FOLDER MOTION GEAR FRICTION INTEGRATOR STEPS RUNS
//
//   GEAR        tendon     MuJoCo's dead-band tendon, damped as it is: within the gap too, and pulling
//               law        tendon without forces; torque from a callback: k p + d ẋ on the touching flank, never pulling
//   FRICTION    loss       MuJoCo's frictionloss and damping: Coulomb and viscous
//               stribeck   frictionloss that follows F(v) at every evaluation, made as hard as the step allows
//               linear     F(v) from a callback, with a slope at rest as steep as is stable
//               lugre      MuJoCo's LuGre
//               lugre_S    LuGre with our F(v) from callbacks, bristles of S N·m/rad
//   INTEGRATOR  Euler, RK4, implicit, implicitfast, discrete; explicit: Euler without MuJoCo's implicit joint damping
//   STEPS       a millisecond
//
// Prints: the setting, steps, motion, largest error of an angle [rad], and the CPU time [s] of each run.
#include <math.h>
#include <mujoco/mujoco.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// Order of the joints in arm.xml; the motors are actuators 0 and 1, the bristles follow.
enum { ROTOR1, ROTOR2, LINK1, LINK2, BODIES };
enum { MOTORS = 2, LONGEST = 10000 };
typedef enum { LOSS, STRIBECK, LINEAR, LUGRE, LUGRE_OURS } Friction;

// A body's share of its joint's friction; a joint's F_C, F_S − F_C [N·m] and v_S [rad/s]. Viscous friction is in arm.xml.
static const double share[BODIES] = {0.6, 0.6, 0.4, 0.4};
static const double coulomb[2] = {0.442, 0.173}, excess[2] = {0.509 - 0.442, 0.187 - 0.173}, stribeck[2] = {0.0603, 0.0408};
static const double half_gap[2] = {0.5 * 0.0103, 0.5 * 0.0064}, stiffness = 3000, damping = 2;

static int own_gear;
static Friction friction;
static double slope[BODIES];  // [N·m·s/rad] of friction at rest, LINEAR
static double bristle;        // [N·m/rad], LUGRE_OURS

static double truth[LONGEST][2 + BODIES];

// F(v) without its viscous part.
static double dry(int body, double v) {
  int joint = body % 2;
  return share[body] * (coulomb[joint] + excess[joint] * exp(-fabs(v) / stribeck[joint]));
}

static double gear_torque(int joint, double x, double x_dot) {
  if (x > half_gap[joint]) return fmax(0, stiffness * (x - half_gap[joint]) + damping * x_dot);
  if (x < -half_gap[joint]) return fmin(0, stiffness * (x + half_gap[joint]) + damping * x_dot);
  return 0;
}

static void passive(const mjModel* m, mjData* d) {
  if (own_gear) {
    for (int j = 0; j < 2; j++) {
      double torque = gear_torque(j, d->qpos[j] - d->qpos[LINK1 + j], d->qvel[j] - d->qvel[LINK1 + j]);
      d->qfrc_passive[j] -= torque;
      d->qfrc_passive[LINK1 + j] += torque;
    }
  }
  if (friction == STRIBECK) {
    for (int i = 0; i < d->nf; i++) d->efc_frictionloss[i] = dry(d->efc_id[i], d->qvel[d->efc_id[i]]);
  } else if (friction == LINEAR) {
    for (int b = 0; b < BODIES; b++) {
      double most = dry(b, d->qvel[b]);
      d->qfrc_passive[b] -= fmax(-most, fmin(most, slope[b] * d->qvel[b]));
    }
  } else if (friction == LUGRE_OURS) {
    for (int b = 0; b < BODIES; b++) d->qfrc_passive[b] -= bristle * d->act[MOTORS + b];
  }
}

// ż = v − s |v| z / F(v); for one-step integrators the mean of it over the step, v held: its bristles are too fast for them.
static mjtNum bend(const mjModel* m, const mjData* d, int id) {
  double v = d->qvel[id - MOTORS], z = d->act[id], h = m->opt.timestep;
  double rate = bristle * fabs(v) / dry(id - MOTORS, v);
  if (m->opt.integrator == mjINT_RK4 || rate * h < 1e-9) return v - rate * z;
  return (v / rate - z) * -expm1(-rate * h) / h;
}

static void fail(const char* what) {
  fprintf(stderr, "mujoco: %s\n", what);
  exit(2);
}

static int position(const char* word, const char* const* words, int count) {
  for (int i = 0; i < count; i++)
    if (!strcmp(word, words[i])) return i;
  fail(word);
  return 0;
}

static mjModel* load(const char* path, const char* integrator, int steps) {
  static const char* const integrators[] = {"Euler", "RK4", "implicit", "implicitfast", "discrete", "explicit"};
  char error[500] = "";
  mjSpec* spec = mj_parseXML(path, NULL, error, sizeof error);
  if (!spec) fail(error);
  if (friction != LUGRE && friction != LUGRE_OURS) {
    static const char* const bristles[] = {"bristle_rotor1", "bristle_rotor2", "bristle_link1", "bristle_link2"};
    for (int b = 0; b < BODIES; b++) mjs_delete(spec, mjs_findElement(spec, mjOBJ_ACTUATOR, bristles[b]));
  }
  mjModel* m = mj_compile(spec, NULL);
  if (!m) fail(mjs_getError(spec));
  mj_deleteSpec(spec);
  m->opt.timestep = 1e-3 / steps;
  int index = position(integrator, integrators, 6);
  m->opt.integrator = index < 5 ? index : mjINT_EULER;
  if (index == 5) m->opt.disableflags |= mjDSBL_EULERDAMP;
  for (int j = 0; own_gear && j < 2; j++) m->tendon_stiffness[j] = m->tendon_damping[j] = 0;
  for (int b = 0; b < BODIES; b++) {
    slope[b] = 1.5 / (m->opt.timestep * m->dof_invweight0[b]);  // at 2 it is unstable
    if (friction != LOSS && friction != STRIBECK) m->dof_frictionloss[b] = 0;
    if (friction == STRIBECK) {
      // A body at rest is stopped within one step, and held as hard as MuJoCo lets it.
      m->dof_solref[b * mjNREF] = 2 * m->opt.timestep;
      m->dof_solimp[b * mjNIMP] = m->dof_solimp[b * mjNIMP + 1] = 0.9999;
    }
    if (friction == LUGRE_OURS) {
      m->actuator_dyntype[MOTORS + b] = mjDYN_USER;
      m->actuator_gaintype[MOTORS + b] = mjGAIN_FIXED;
      m->actuator_gainprm[(MOTORS + b) * mjNGAIN] = 0;
      m->actuator_biastype[MOTORS + b] = mjBIAS_NONE;
    }
  }
  mjcb_passive = passive;
  if (friction == LUGRE_OURS) mjcb_act_dyn = bend;
  return m;
}

static int read_truth(const char* folder, const char* motion) {
  char path[4000];
  snprintf(path, sizeof path, "%s/%s.txt", folder, motion);
  FILE* file = fopen(path, "r");
  if (!file) fail(path);
  int length = 0;
  for (double* y = truth[0]; length < LONGEST; y += 2 + BODIES, length++)
    if (fscanf(file, "%lf %lf %lf %lf %lf %lf", y, y + 1, y + 2, y + 4, y + 3, y + 5) != 6) break;
  fclose(file);
  return length;
}

// A run under PI control at 1 kHz: the largest error of an angle [rad].
static double run(const mjModel* m, mjData* d, int length, int steps) {
  static const double kp[2] = {5, 1.5}, ki[2] = {50, 15}, kt[2] = {5.375 * 0.023, 10.0 / 3.0 * 0.023};
  double integral[2] = {0, 0}, worst = 0;
  mj_resetData(m, d);
  for (int k = 0; k < length; k++) {
    for (int j = 0; j < 2; j++) {
      double error = truth[k][j] - d->qvel[j];
      integral[j] += ki[j] * error * 1e-3;
      d->ctrl[j] = (kp[j] * error + integral[j]) / kt[j];
    }
    for (int s = 0; s < steps; s++) mj_step(m, d);
    for (int b = 0; b < BODIES; b++) worst = fmax(worst, fabs(d->qpos[b] - truth[k][2 + b]));
  }
  int unstable = d->warning[mjWARN_BADQACC].number + d->warning[mjWARN_BADQVEL].number + d->warning[mjWARN_BADQPOS].number;
  return unstable ? INFINITY : worst;
}

static void be_quiet(const char* warning) { (void)warning; }

int main(int argc, char** argv) {
  static const char* const gears[] = {"tendon", "law"};
  static const char* const frictions[] = {"loss", "stribeck", "linear", "lugre"};
  if (argc != 9) fail("usage: mujoco arm.xml FOLDER MOTION GEAR FRICTION INTEGRATOR STEPS RUNS");
  int steps = atoi(argv[7]), runs = atoi(argv[8]);
  if (steps < 1 || runs < 1) fail("STEPS and RUNS are 1 or more");
  mju_user_warning = be_quiet;  // an unstable run is reported as one of infinite error
  own_gear = position(argv[4], gears, 2);
  if (!strncmp(argv[5], "lugre_", 6)) {
    friction = LUGRE_OURS;
    bristle = atof(argv[5] + 6);
  } else {
    friction = position(argv[5], frictions, 4);
  }
  int length = read_truth(argv[2], argv[3]);
  mjModel* m = load(argv[1], argv[6], steps);
  mjData* d = mj_makeData(m);
  double worst = 0, times[100];
  for (int r = 0; r < runs; r++) {
    clock_t start = clock();
    worst = run(m, d, length, steps);
    times[r % 100] = (double)(clock() - start) / CLOCKS_PER_SEC;
  }
  printf("mujoco %s/%s/%s %d %s %.9e", argv[4], argv[5], argv[6], steps, argv[3], worst);
  for (int r = 0; r < runs && r < 100; r++) printf(" %.6f", times[r]);
  printf("\n");
  mj_deleteData(d);
  mj_deleteModel(m);
  return 0;
}
