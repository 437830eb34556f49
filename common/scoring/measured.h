#pragma once

#include "common/scoring/crown.h"
#include "common/scoring/margins.h"
#include "common/scoring/metrics.h"
#include "common/scoring/mistakes/contact.h"
#include "common/scoring/shape.h"
#include "common/scoring/task.h"
#include "common/scoring/untouched.h"
#include "common/scoring/zones.h"

// Between measuring (metrics.cpp) and the list of metrics (registry/registry.cpp).
namespace enamel::scoring {

// Everything measured about one attempt. Members that the plan leaves out keep their defaults; the
// registry (registry/registry.cpp) picks from the rest.
struct Measured {
  BoxVolume target, leeway, container;  // each box whole, the inner ones included
  TissueVolumes_m3 removed{};
  TaskVolumes task;
  DeviationFigures deviation;
  Deepest deepest_over;
  Walls walls{};
  OutlineFigures outline;
  LineAngleFigures line_angles;
  MarginFigures margin;
  CrownFigures crown;
  std::optional<Contact::Figures> contact;  // none: not in the task
  StumpFigures stump;
  std::array<double, 4> sides_done{1, 1, 1, 1};
  bool has_pulp = false, has_neighbour = false;
  double neighbour_depth_m = 0;
  RemainingDentin remaining_dentin;
  double voxel_m = 0;
  double surface_u_m = 0;  // SurfaceUncertainty_m
  double cut_area_m2 = 0,
         caries_area_m2 = 0;  // of what the attempt cut: all of it; caries that lies open
  double pulp_exposed_m2 = 0;
  double align_pose_m = 0, align_force_n = 0, frechet_pose_m = 0;
  bool reference_recorded = true;  // or there is no path to compare with
  double align_way_m = 0, frechet_way_m = 0;
  ProcessRecorder::Smoothness smoothness;
  const ProcessRecorder* process = nullptr;
};

// Every metric with its value, or why it has none.
MetricSet Collect(const Measured& measured, const MetricPlan& plan);

}  // namespace enamel::scoring
