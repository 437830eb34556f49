#include "station/lab/cutting/voxel_limit.h"

#include <cmath>
#include <cstdio>

#include "station/lab/cutting/cutting_error.h"

namespace enamel::station::lab {
namespace {

constexpr int32_t kFinest_nm = 25'000;

CutCase CaseOf(const cutting::Bur& bur) {
  CutCase c;
  c.bur = bur;
  c.oblique = true;
  return c;
}

}  // namespace

double VoxelForceError(const cutting::Bur& bur, int32_t voxel_nm) {
  CuttingPlan plan;
  plan.cases = {CaseOf(bur)};
  plan.voxels_nm = {voxel_nm};
  plan.ticks = 200;
  plan.replays = 1;
  plan.grids = 4;
  double squares = 0;
  const std::vector<CuttingFigures> found = MeasureCutting(plan);
  for (const CutErrors& e : found[0].grids) squares += e.force * e.force;
  return std::sqrt(squares / static_cast<double>(found[0].grids.size()));
}

VoxelVerdict JudgeVoxel(double force_error, bool graded) {
  if (force_error <= kMostVoxelForceError) return VoxelVerdict::kFine;
  return graded ? VoxelVerdict::kRefused : VoxelVerdict::kWarned;
}

const char* VoxelVerdictName(VoxelVerdict verdict) {
  return verdict == VoxelVerdict::kFine     ? "fine"
         : verdict == VoxelVerdict::kWarned ? "warned"
                                            : "refused";
}

std::string VoxelText(const cutting::Bur& bur, int32_t voxel_nm, double force_error, bool graded,
                      int32_t finer_nm) {
  char text[400];
  std::snprintf(text, sizeof text,
                "voxels of %g um are too coarse for a %s: its force is off by %.0f %%, and %s",
                voxel_nm * 1e-3, BurText(CaseOf(bur)).c_str(), 100 * force_error,
                graded ? "graded work may be off by 10 % at most"
                       : "beyond 10 % practice teaches a wrong hand");
  std::string out = text;
  if (finer_nm > 0) {
    std::snprintf(text, sizeof text, ". Use voxels of %g um or less", finer_nm * 1e-3);
    out += text;
  } else {
    out += ". Use a larger bur: no voxel down to 25 um does";
  }
  return out;
}

int32_t FinerVoxel_nm(const cutting::Bur& bur, int32_t voxel_nm) {
  for (int32_t nm = voxel_nm / 2; nm >= kFinest_nm; nm /= 2) {
    if (VoxelForceError(bur, nm) <= kMostVoxelForceError) return nm;
  }
  return 0;
}

}  // namespace enamel::station::lab
