#include "common/board/board.h"

#include <math.h>

#include "common/board/vec.h"

// Up to this far back a report is late, farther is another order (as the host judges ours).
static const uint32_t kLateReports = 1000;
static const double kAll = 65535;  // of a share
static const double kMostU32 = 4294967295.0;

static const double kFarthest_m = 10;  // no board reaches; keeps every square finite
static const double kMostForce_n = 1e6;

// Also false for what is not a number.
static bool Within(EnVec v, double most) {
  return fabs(v.x) < most && fabs(v.y) < most && fabs(v.z) < most;
}
static double Length(EnVec v) { return sqrt(EnDot(v, v)); }

double EnLargestKc(double b, double tick, int delay) {
  const double held = delay + 1.0;  // ticks from a reading to the end of its force
  return 2 * b / (held * held * tick);
}

bool EnBoardStart(EnBoard* board, const EnBoardParams* params) {
  const EnBoard off = {0};
  const EnBoardParams* p = params;
  *board = off;
  // Not a number fails each comparison.
  if (!(p->tick_s > 0) || p->delay_ticks < 0 || !(p->kc_n_per_m > 0) || !(p->peak_n > 0) ||
      !(EnRadius(&p->cell) > 0) || !isfinite(EnRadius(&p->cell)) || !isfinite(p->peak_n) ||
      !(p->kc_n_per_m <= EnLargestKc(p->damping_n_s_per_m, p->tick_s, p->delay_ticks))) {
    return false;
  }
  board->params = *p;
  const EnGuard guard = {p->kc_n_per_m, p->cell, p->delay_ticks, 1};
  board->spring.guard = guard;
  board->spring.share = 1;
  // Enough to turn half of the peak force around.
  const double half = 0.5 * p->peak_n;
  board->spring.tank.cap_j = 0.5 * half * half / p->kc_n_per_m;
  board->spring.tank.inflow_share = 1;
  return true;
}

static bool FiniteCommand(const EnCommand* c) {
  return Within(c->rest_m, kFarthest_m) && Within(c->added_n, kMostForce_n) && isfinite(c->share) &&
         isfinite(c->bound_n) && isfinite(EnRadius(&c->cell));
}

// Late or doubled; an order begins after a silence.
static bool OutOfOrder(const EnBoard* board, uint32_t sequence) {
  return board->heard && board->silent_s < EN_LOST_S && board->sequence - sequence <= kLateReports;
}

bool EnBoardObey(EnBoard* board, const EnCommand* command, uint32_t sequence) {
  if (OutOfOrder(board, sequence) || !FiniteCommand(command)) return false;
  board->command = *command;
  board->sequence = sequence;
  board->heard = true;
  board->silent_s = 0;
  board->last_n = Length(board->felt_n);
  board->spring.guard.cell = EnRadius(&command->cell) > 0 ? command->cell : board->params.cell;
  return true;
}

static EnVec Times(const int32_t v[3], double unit) {
  const EnVec out = {v[0] * unit, v[1] * unit, v[2] * unit};
  return out;
}

static EnVec SmallTimes(const int16_t v[3], double unit) {
  const EnVec out = {v[0] * unit, v[1] * unit, v[2] * unit};
  return out;
}

bool EnBoardReceive(EnBoard* board, const uint8_t* bytes, size_t size) {
  EnCommand command = {0};
  EnForceReport force;
  if (EnReadForce(bytes, size, &force) == kEnWhole)
    return EnBoardObey(board, &command, force.sequence);
  EnSpringReport report;
  if (EnReadSpring(bytes, size, &report) != kEnWhole) return false;
  command.motors_on = report.motors_on;
  command.spring_on = report.spring_on;
  command.follow = report.follow;
  command.rest_m = Times(report.rest_nm, 1e-9);
  command.added_n = SmallTimes(report.force_100un, 1e-4);
  command.share = report.share / kAll;
  command.bound_n = report.bound_mn * 1e-3;
  for (int j = 0; j < 3; ++j)
    command.cell.joint_half_m[j] = SmallTimes(report.cell_nm + 3 * j, 1e-9);
  return EnBoardObey(board, &command, report.sequence);
}

bool EnBoardDrives(const EnBoard* board) {
  return board->heard && board->command.motors_on && board->silent_s < EN_OFF_S;
}

// What the bound is by now: the host's, or what a lost host leaves of it.
static double Bound(const EnBoard* board) {
  double bound = board->command.bound_n;
  if (board->params.peak_n < bound) bound = board->params.peak_n;
  if (board->silent_s < EN_LOST_S) return bound;
  double left = board->last_n * (1 - board->silent_s / EN_FALL_S);
  // A whole step brings the rest point this near. Below it the share would have to fall, and a tank
  // that is empty could not raise it for the host that comes back.
  const double least = board->params.kc_n_per_m * EnRadius(&board->spring.guard.cell);
  if (!(left > least)) left = least;
  return left < bound ? left : bound;
}

static EnVec Wish(const EnBoard* board, EnVec tip) {
  if (board->command.follow || board->silent_s >= EN_FALL_S) return tip;
  return board->silent_s < EN_LOST_S ? board->command.rest_m : board->spring.rest_m;
}

// As much of the host's force as the peak leaves room for beside the spring's.
static EnVec Added(const EnBoard* board) {
  const EnVec none = {0, 0, 0};
  if (board->silent_s >= EN_LOST_S) return none;
  const double room = board->params.peak_n - Length(board->felt_n);
  const double length = Length(board->command.added_n);
  if (!(room > 0) || !(length > 0)) return none;
  return length <= room ? board->command.added_n : EnTimes(board->command.added_n, room / length);
}

EnVec EnBoardTick(EnBoard* board, EnVec tip) {
  const EnVec none = {0, 0, 0};
  const bool ran = board->running;
  if (ran && Within(tip, kFarthest_m))
    board->work_j -= EnDot(board->felt_n, EnMinus(tip, board->tip_m));
  board->silent_s += board->params.tick_s;
  board->running = EnBoardDrives(board) && board->command.spring_on && Within(tip, kFarthest_m);
  board->felt_n = board->added_n = none;
  if (!Within(tip, kFarthest_m)) {
    board->command.motors_on = false;  // until the next report
    return none;
  }
  board->tip_m = tip;
  if (!ran || !board->running) EnSpringReset(&board->spring, tip);
  if (!board->running) return none;
  EnBeginTick(&board->spring.tank);
  const EnForce force =
      EnSpringPull(&board->spring, tip, Wish(board, tip), Bound(board), board->command.share);
  board->flags = force.flags;
  board->felt_n = force.felt_n;
  board->added_n = Added(board);
  return EnPlus(board->felt_n, board->added_n);
}

// Halves away from 0; saturates.
static int32_t Nearest(double v) {
  if (!(v > -2147483647.0)) return -2147483647;
  if (!(v < 2147483647.0)) return 2147483647;
  return (int32_t)(v < 0 ? v - 0.5 : v + 0.5);
}

void EnBoardTell(const EnBoard* board, EnPoseReport* report) {
  const EnVec rest = EnTimes(board->spring.rest_m, 1e9);
  report->rest_nm[0] = Nearest(rest.x);
  report->rest_nm[1] = Nearest(rest.y);
  report->rest_nm[2] = Nearest(rest.z);
  report->share = (uint16_t)Nearest(board->spring.share * kAll);
  const double energy = board->spring.tank.energy_j * 1e9;
  report->energy_nj = energy < kMostU32 ? (uint32_t)energy : UINT32_MAX;
  report->work_nj = (uint32_t)(int64_t)(board->work_j * 1e9);  // modulo 2^32
}
