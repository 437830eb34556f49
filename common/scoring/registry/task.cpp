#include <algorithm>

#include "common/scoring/registry/registry.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;

State WithCaries(const Measured& m) { return Unless(Of(m.task.task, Tissue::kCaries) > 0); }
State WithNeighbour(const Measured& m) { return Unless(m.has_neighbour); }
State WithPulp(const Measured& m) { return Unless(m.has_pulp); }

constexpr Entry kEntries[] = {
    {kTask,
     {"task_done_percent", "%", "Task done",
      "Share of what the reference took away that the attempt took away too."},
     [](const Measured& m) { return Percent(m.task.done_m3(), m.task.task_m3()); }},
    {kTask,
     {"side_done_least_percent", "%", "Least done on one side",
      "Of the task's four sides, divided along its diagonals, the least share that went."},
     [](const Measured& m) { return 100 * *std::ranges::min_element(m.sides_done); }},
    {kTask,
     {"overlap_percent", "%", "Overlap with the reference",
      "Dice coefficient of the volumes that attempt and reference took away."},
     [](const Measured& m) {
       return Percent(2 * m.task.done_m3(), m.task.task_m3() + Sum_m3(m.removed));
     }},
    {kTask,
     {"in_task_percent", "%", "Cut in the task",
      "Of what the attempt took away, the share within the reference's cut or its leeway."},
     [](const Measured& m) {
       const double removed = Sum_m3(m.removed);
       return removed > 0 ? Percent(removed - Sum_m3(m.task.outside), removed) : 100;
     }},
    {kTask,
     {"missed_mm3", "mm3", "Left of the task",
      "Volume that the reference took away and the attempt left."},
     [](const Measured& m) { return Sum_m3(m.task.missed) * kMm3; }},
    {kTask,
     {"left_standing_mm3", "mm3", "Left standing",
      "Of what the reference took away, what the attempt left farther than 0.4 mm from its cut."},
     [](const Measured& m) { return Sum_m3(m.task.standing) * kMm3; }},
    {kTask,
     {"overcut_mm3", "mm3", "Beyond the walls",
      "Volume taken beyond the reference, within the leeway of its cut."},
     [](const Measured& m) { return Sum_m3(m.task.near) * kMm3; }},
    {kTask,
     {"outside_removed_mm3", "mm3", "Cut elsewhere",
      "Volume taken farther than the leeway from the reference's cut, neighbours apart."},
     [](const Measured& m) {
       return (Sum_m3(m.task.outside) - Of(m.task.outside, Tissue::kNeighbour)) * kMm3;
     }},
    {kTask,
     {"damage_percent", "%", "Damage",
      "Volume taken farther than the leeway from the reference's cut, of the task's volume."},
     [](const Measured& m) { return Percent(Sum_m3(m.task.outside), m.task.task_m3()); }},
    {kTask,
     {"neighbour_removed_mm3", "mm3", "Neighbour cut",
      "Volume of the neighbouring teeth that went."},
     [](const Measured& m) { return Removed(m, Tissue::kNeighbour); },
     WithNeighbour},
    {kCover,
     {"neighbour_depth_mm", "mm", "Depth in the neighbour",
      "Deepest place in a neighbouring tooth under its own surface."},
     [](const Measured& m) { return m.neighbour_depth_m * kMm; },
     WithNeighbour},
    {kCover,
     {"contact_left_percent", "%", "Contact left",
      "Share of the contact area that the reference opened on which the attempt left tooth."},
     [](const Measured& m) { return m.contact->closed_percent(); },
     [](const Measured& m) { return Unless(m.contact.has_value()); }},
    {kTask,
     {"caries_left_mm3", "mm3", "Caries left",
      "Volume of caries that the reference took away and the attempt left."},
     [](const Measured& m) { return Of(m.task.missed, Tissue::kCaries) * kMm3; },
     WithCaries},
    {kTask,
     {"caries_left_percent", "%", "Caries left, share",
      "Share of the caries that the reference took away which the attempt left."},
     [](const Measured& m) {
       return Percent(Of(m.task.missed, Tissue::kCaries), Of(m.task.task, Tissue::kCaries));
     },
     WithCaries},
    {kTask,
     {"sound_removed_mm3", "mm3", "Sound tissue too much",
      "Enamel and dentin taken beyond what the reference took, near its cut and elsewhere."},
     [](const Measured& m) {
       double sum = 0;
       for (Tissue t : {Tissue::kEnamel, Tissue::kDentin}) {
         sum += Of(m.task.near, t) + Of(m.task.outside, t);
       }
       return sum * kMm3;
     }},
    {kTask,
     {"removed_enamel_mm3", "mm3", "Enamel removed", "Volume of enamel that went."},
     [](const Measured& m) { return Removed(m, Tissue::kEnamel); }},
    {kTask,
     {"removed_dentin_mm3", "mm3", "Dentin removed", "Volume of dentin that went."},
     [](const Measured& m) { return Removed(m, Tissue::kDentin); }},
    {kTask,
     {"removed_pulp_mm3", "mm3", "Pulp removed", "Volume of pulp that went."},
     [](const Measured& m) { return Removed(m, Tissue::kPulp); }},
    {kTask,
     {"pulp_exposed_mm2", "mm2", "Pulp exposed",
      "Area of the final surface that is pulp and was not surface before."},
     [](const Measured& m) { return m.pulp_exposed_m2 * kMm2; }},
    {kCover,
     {"remaining_dentin_mm",
      "mm",
      "Least cover of the pulp",
      "Least distance from the cut to the pulp, at most 3 mm; 0 where it lies open.",
      {},
      {},
      AtLimit::kSame,
      true},
     [](const Measured& m) { return m.remaining_dentin.least_m * kMm; },
     WithPulp},
};

}  // namespace

std::span<const Entry> TaskMetrics() { return kEntries; }

}  // namespace enamel::scoring
