#include "common/scoring/registry/registry.h"

namespace enamel::scoring {
namespace {

using cutting::Tissue;

State WithCut(const Measured& m) { return IfMade(m.process->angulation_mean_deg()); }
template <Tissue kTissue>
State WithRemoved(const Measured& m) {
  if (!(Of(m.task.task, kTissue) > 0)) return NoValue::kNotInTask;
  return IfMade(m.process->half_removed_s(kTissue));
}
template <Tissue kTissue>
double Half_s(const Measured& m) {
  return *m.process->half_removed_s(kTissue);
}
template <Tissue kTissue>
double RemovalRate(const Measured& m) {
  return m.process->cutting_s() > 0 ? Removed(m, kTissue) / m.process->cutting_s() : 0;
}

constexpr Entry kEntries[] = {
    {kRecording,
     {"force_sent_p95_n", "N", "Force, 95th percentile",
      "Force that 95 % of the ticks with any force stay within.", "", "", AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->force_sent_p95_n(); }},
    {kRecording,
     {"force_sent_max_n", "N", "Largest force", "Largest force of any tick.", "", "",
      AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->force_sent_max_n(); }},
    {kRecording,
     {"force_sent_mean_cutting_n", "N", "Mean force while cutting",
      "Mean force over the ticks that removed something.", "", "", AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->force_sent_mean_cutting_n(); }},
    {kRecording,
     {"path_length_mm", "mm", "Path length", "Length of the bur tip's path."},
     [](const Measured& m) { return m.process->anchor_path_m() * kMm; }},
    {kRecording,
     {"time_s", "s", "Time", "Duration of the attempt, gaps included."},
     [](const Measured& m) { return m.process->duration_s(); }},
    {kRecording,
     {"cutting_time_s", "s", "Cutting time", "Time less than 50 ms after something was removed."},
     [](const Measured& m) { return m.process->cutting_s(); }},
    {kPathInTime,
     {"dtw_pose_mm", "mm", "Path against the reference",
      "Mean distance of the bur from the reference's along the best alignment in time."},
     [](const Measured& m) { return m.align_pose_m * kMm; }},
    {kPathInTime,
     {"dtw_force_n", "N", "Force against the reference",
      "Mean difference of the force from the reference's along the best alignment in time.", "", "",
      AtLimit::kUnknown},
     [](const Measured& m) { return m.align_force_n; }},
    {kPathInTime,
     {"frechet_pose_mm", "mm", "Farthest from the reference's path",
      "Discrete Frechet distance of the bur's path from the reference's, in time."},
     [](const Measured& m) { return m.frechet_pose_m * kMm; }},
    {kPathByWay,
     {"dtw_way_mm", "mm", "Way against the reference's",
      "Mean distance of the bur from the reference's along the best alignment of their ways."},
     [](const Measured& m) { return m.align_way_m * kMm; }},
    {kPathByWay,
     {"frechet_way_mm", "mm", "Farthest from the reference's way",
      "Discrete Frechet distance of the bur's way from the reference's."},
     [](const Measured& m) { return m.frechet_way_m * kMm; }},
    {kRecording,
     {"idle_time_s", "s", "Time away from the tooth", "Time outside contacts, without gaps."},
     [](const Measured& m) { return m.process->idle_s(); }},
    {kRecording,
     {"contact_count", "count", "Contacts", "How often the bur came to the tooth."},
     [](const Measured& m) { return static_cast<double>(m.process->strokes().contacts()); }},
    {kRecording,
     {"stroke_count", "count", "Strokes", "Contacts that removed something."},
     [](const Measured& m) { return static_cast<double>(m.process->strokes().Strokes().size()); }},
    {kRecording,
     {"angulation_mean_deg", "deg", "Tilt of the bur",
      "Mean angle of the bur's axis against the tooth's while cutting."},
     [](const Measured& m) { return *m.process->angulation_mean_deg(); },
     WithCut},
    {kRecording,
     {"angulation_p95_deg", "deg", "Tilt of the bur, 95th percentile",
      "Angle of the bur's axis against the tooth's that 95 % of the cutting stays within."},
     [](const Measured& m) { return *m.process->angulation_p95_deg(); },
     WithCut},
    {kRecording,
     {"impulse_n_s", "N s", "Impulse", "Force, summed over time.", "", "", AtLimit::kAtLeast},
     [](const Measured& m) { return m.process->impulse_n_s(); }},
    {kRecording,
     {"work_mj", "mJ", "Work of the hand", "What the hand gave to the tool, less what it got back.",
      "", "", AtLimit::kUnknown},
     [](const Measured& m) { return m.process->work_j() * 1e3; }},
    {kRecording,
     {"force_rate_p95_n_per_s", "N/s", "Change of force, 95th percentile",
      "Rate of the force that 95 % of the steps of 10 ms with any force stay within.", "", "",
      AtLimit::kUnknown},
     [](const Measured& m) { return m.process->force_rate_p95_n_per_s(); }},
    {kRecording,
     {"enamel_rate_mm3_per_s", "mm3/s", "Enamel removed, rate", "Of cutting time."},
     RemovalRate<Tissue::kEnamel>,
     WithRemoved<Tissue::kEnamel>},
    {kRecording,
     {"dentin_rate_mm3_per_s", "mm3/s", "Dentin removed, rate", "Of cutting time."},
     RemovalRate<Tissue::kDentin>,
     WithRemoved<Tissue::kDentin>},
    {kRecording,
     {"caries_rate_mm3_per_s", "mm3/s", "Caries removed, rate", "Of cutting time."},
     RemovalRate<Tissue::kCaries>,
     WithRemoved<Tissue::kCaries>},
    {kRecording,
     {"enamel_half_s", "s", "Half of the enamel", "By when half of the removed enamel was gone."},
     Half_s<Tissue::kEnamel>,
     WithRemoved<Tissue::kEnamel>},
    {kRecording,
     {"dentin_half_s", "s", "Half of the dentin", "By when half of the removed dentin was gone."},
     Half_s<Tissue::kDentin>,
     WithRemoved<Tissue::kDentin>},
    {kRecording,
     {"caries_half_s", "s", "Half of the caries", "By when half of the removed caries was gone."},
     Half_s<Tissue::kCaries>,
     WithRemoved<Tissue::kCaries>},
    {kMotion,
     {"smoothness_ldlj", "ratio", "Smoothness, by jerk",
      "Log dimensionless jerk of the bur's speed, median of the strokes; higher is smoother."},
     [](const Measured& m) { return *m.smoothness.log_dimensionless_jerk; },
     [](const Measured& m) { return IfMade(m.smoothness.log_dimensionless_jerk); }},
    {kMotion,
     {"smoothness_sparc", "ratio", "Smoothness, by spectrum",
      "Spectral arc length of the bur's speed, median of the strokes; higher is smoother."},
     [](const Measured& m) { return *m.smoothness.spectral_arc_length; },
     [](const Measured& m) { return IfMade(m.smoothness.spectral_arc_length); }},
    {kMotion,
     {"tremor_um", "um", "Tremor",
      "Root mean square of the hand's position in contact, 8 to 12 Hz."},
     [](const Measured& m) { return *m.process->tremor_m() * 1e6; },
     [](const Measured& m) { return IfMade(m.process->tremor_m()); }},
    {kRecording,
     {"limiter_share_percent", "%", "Device at its limit",
      "Share of the ticks in which the device's peak force bounded the force."},
     [](const Measured& m) {
       return Percent(static_cast<double>(m.process->bounded_ticks()),
                      static_cast<double>(m.process->ticks()));
     }},
};

}  // namespace

std::span<const Entry> RecordingMetrics() { return kEntries; }

}  // namespace enamel::scoring
