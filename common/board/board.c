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
  board->slack_n = 2 * p->kc_n_per_m * EnRadius(&p->cell) + EN_RISE_N_PER_S * p->tick_s;
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

// Largest s in [0, 1] with |from + s by| <= most, if |from| <= most.
static double Reach(EnVec from, EnVec by, double most) {
  const double a = EnDot(by, by), b = EnDot(from, by);
  double c = most * most - EnDot(from, from);
  if (!(a > 0)) return 1;
  if (!(c > 0)) c = 0;
  // The root of a s^2 + 2 b s = c, without a difference of nearly equal numbers.
  const double root = sqrt(b * b + a * c);
  const double s = b > 0 ? c / (b + root) : (root - b) / a;
  return s < 1 ? s : 1;
}

// Toward `wish`, and up to what share of the stiffness, the spring may go in this tick (board.h, "No
// wish changes the force at once"). `before`: its last force; `way`: the tip's since then.
typedef struct {
  EnVec wish_m;
  double share;
} Allowed;

static Allowed WithinChange(const EnBoard* board, EnVec tip, EnVec wish, EnVec before, EnVec way) {
  const EnSpring* s = &board->spring;
  const double kc = s->guard.kc_n_per_m, felt = kc * s->share;
  const double most = kc * Length(way) + board->slack_n;
  const EnVec e = EnMinus(tip, s->rest_m), w = EnMinus(wish, s->rest_m);
  // What the force changes by with the rest point where it is, and what all of the wish adds.
  const EnVec stays = EnMinus(EnTimes(e, -felt), before), moves = EnTimes(w, felt);
  const double reach = Reach(stays, moves, most);
  Allowed out = {reach < 1 ? EnPlus(s->rest_m, EnTimes(w, reach)) : wish, 1};
  if (s->share < 1) {
    // The guard may stop anywhere on the way: its two ends bound the stretch and the change so far.
    const double here = Length(stays), there = Length(EnPlus(stays, EnTimes(moves, reach)));
    const double near = Length(e), far = Length(EnMinus(e, EnTimes(w, reach)));
    const double left = most - (here > there ? here : there), longest = near > far ? near : far;
    if (longest > 0) out.share = s->share + (left > 0 ? left / (kc * longest) : 0);
  }
  return out;
}

// The host's force, as near as this tick's change lets it come, and as much of it as the peak leaves
// room for beside the spring's. `before`: the last one.
static EnVec Added(const EnBoard* board, EnVec before) {
  const EnVec none = {0, 0, 0};
  const EnVec wanted = board->silent_s < EN_LOST_S ? board->command.added_n : none;
  const EnVec step = EnMinus(wanted, before);
  const double far = Length(step), most = EN_ADDED_N_PER_S * board->params.tick_s;
  const EnVec added = far <= most ? wanted : EnPlus(before, EnTimes(step, most / far));
  const double room = board->params.peak_n - Length(board->felt_n), length = Length(added);
  if (!(room > 0)) return none;
  return length <= room ? added : EnTimes(added, room / length);
}

EnVec EnBoardTick(EnBoard* board, EnVec tip) {
  const EnVec none = {0, 0, 0};
  const EnVec felt = board->felt_n, added = board->added_n;
  const bool ran = board->running;
  const bool whole = Within(tip, kFarthest_m);
  const EnVec way = ran && whole ? EnMinus(tip, board->tip_m) : none;
  if (ran) board->work_j -= EnDot(felt, way);
  board->silent_s += board->params.tick_s;
  board->running = EnBoardDrives(board) && board->command.spring_on && whole;
  board->felt_n = board->added_n = none;
  if (!whole) {
    board->command.motors_on = false;  // until the next report
    return none;
  }
  board->tip_m = tip;
  if (!ran || !board->running) EnSpringReset(&board->spring, tip);
  if (!board->running) return none;
  EnBeginTick(&board->spring.tank);
  const Allowed to = WithinChange(board, tip, Wish(board, tip), felt, way);
  const double share = board->command.share < to.share ? board->command.share : to.share;
  const EnForce force = EnSpringPull(&board->spring, tip, to.wish_m, Bound(board), share);
  board->flags = force.flags;
  board->felt_n = force.felt_n;
  board->added_n = Added(board, added);
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
