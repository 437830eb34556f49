#include "common/fidelity/board_loop.h"

namespace enamel::fidelity {
namespace {

constexpr double kWhole = 65535;  // share, as in the report

haptics::CouplingParams OnBoard(haptics::CouplingParams params) {
  params.spring_on_board = true;
  return params;
}

}  // namespace

BoardLoop::BoardLoop(haptics::CouplingParams params, const BoardSpec& spec, double damping)
    : params_(OnBoard(params)), spec_(spec), coupling_(params_) {
  EnBoardParams board{};
  board.tick_s = params.law.tick_s / spec.ticks;
  board.delay_ticks = spec.delay_ticks;
  board.kc_n_per_m = params.law.kc_n_per_m;
  board.cell = params.cell.board();
  board.peak_n = params.peak_force_n;
  board.damping_n_s_per_m = damping;
  ENAMEL_CHECK(EnBoardStart(&board_, &board));
}

void BoardLoop::Reset(const dvec3& tip) {
  coupling_.Reset(tip);
  under_way_.clear();
  until_host_ = 0;
  EnCommand command{};
  command.motors_on = command.spring_on = true;
  command.rest_m = haptics::ToBoard(tip);
  command.share = 1;
  command.bound_n = params_.peak_force_n;
  under_way_.assign(static_cast<size_t>(spec_.late_host_ticks), command);
}

dvec3 BoardLoop::Tick(const dvec3& tip, haptics::Material& material) {
  if (until_host_ == 0) {
    until_host_ = spec_.ticks;
    AskHost(tip, material);
  }
  --until_host_;
  return haptics::FromBoard(EnBoardTick(&board_, haptics::ToBoard(tip)));
}

// What the board reports is of its last tick; the law answers to this reading.
void BoardLoop::AskHost(const dvec3& tip, haptics::Material& material) {
  EnPoseReport told{};
  EnBoardTell(&board_, &told);
  coupling_.TakeSpring(dvec3(told.rest_nm[0], told.rest_nm[1], told.rest_nm[2]) * 1e-9,
                       told.share / kWhole);
  const haptics::CouplingOutput out = coupling_.Tick(tip, 1, material);
  EnCommand command{};
  command.motors_on = command.spring_on = true;
  command.follow = out.follow;
  command.rest_m = haptics::ToBoard(out.wish_m);
  command.share = 1;
  command.bound_n = params_.peak_force_n;
  under_way_.push_back(command);
  EnBoardObey(&board_, &under_way_.front(), ++sequence_);
  under_way_.pop_front();
}

}  // namespace enamel::fidelity
