#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>

#include "common/haptics/coupling.h"
#include "common/haptics/touch_cues.h"

namespace {

thread_local long g_allocations = 0;

}  // namespace

void* operator new(size_t size) {
  ++g_allocations;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, size_t) noexcept { std::free(p); }

namespace enamel::haptics {
namespace {

class Enamel final : public Material {
 public:
  Contact ContactAt(const dvec3&, const dvec3&) noexcept override {
    Contact c;
    c.damping_n_s_per_m = Sym3::Isotropic(6500);
    c.engaged = true;
    return c;
  }
  void AnchorMoved(const dvec3&, const dvec3&) noexcept override {}
};

// Law, estimator and output chain, every one: reading, cutting, resting, resetting.
TEST(AllocationTest, NoTickOrResetOfAnyLawAllocates) {
  for (const LawEntry& law : ForceLaws()) {
    for (const EstimatorEntry& estimator : VelocityEstimators()) {
      CouplingParams p;
      p.law.kind = law.kind;
      p.law.kc_n_per_m = 2500;
      p.law.resolution_m = dvec3(10e-6);
      p.law.estimator.kind = estimator.kind;
      p.peak_force_n = 8;
      p.friction = {dvec3(0.05), true};
      Coupling coupling(p);
      Enamel enamel;
      long before = g_allocations;
      coupling.Reset(dvec3(0));
      for (int k = 0; k < 3000; ++k) {
        double x = std::floor(std::min(k, 2000) * 0.05) * 10e-6;
        coupling.Tick(dvec3(x, 0.5 * x, 0), 1, enamel);
      }
      coupling.Reset(dvec3(0));
      EXPECT_EQ(g_allocations, before) << law.name << " " << estimator.name;
    }
  }
}

TEST(AllocationTest, NoTickOfTheTouchCuesAllocates) {
  TouchCueParams p;
  p.contact_n = p.chatter_n = 0.2;
  p.peak_force_n = 8;
  p.account.energy_j = 1e-4;
  p.account.delay_ticks = CueAccount::kMaxDelay;
  TouchCues cues(p);
  TouchCueInput in;
  in.contact_read = in.engaged = true;
  in.coupling_n = dvec3(1, 0, 0);
  in.tissue_b_n_s_per_m = 6500;
  in.bur_speed_krpm = 400;
  long before = g_allocations;
  for (int k = 0; k < 300; ++k) {
    in.gap = k == 150;
    cues.Tick(in);
  }
  EXPECT_EQ(g_allocations, before);
}

}  // namespace
}  // namespace enamel::haptics
