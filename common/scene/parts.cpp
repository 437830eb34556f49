#include "common/scene/parts.h"

#include <algorithm>

#include "common/scene/tooth_number.h"

namespace enamel::scene {
namespace {

using cutting::Tissue;

bool Names(const Scene& scene, Tissue tissue) {
  return std::any_of(scene.tissues.begin(), scene.tissues.end(),
                     [&](const TissueSpec& t) { return t.tissue == tissue; });
}

std::string TissueList(const Scene& scene) {
  std::string out;
  for (const TissueSpec& t : scene.tissues) {
    out += (out.empty() ? "" : ", ") + std::string(cutting::TissueName(t.tissue));
  }
  return out;
}

Part Labels(const Scene& scene) {
  if (scene.tissues.size() > 1) {
    return {PartId::kLabels, "labels", true,
            "tissues differ (" + TissueList(scene) + "); only bricks that hold two have them"};
  }
  return {PartId::kLabels, "labels", false, "a single tissue (" + TissueList(scene) + ")"};
}

Part Neighbour(const Scene& scene) {
  bool there = Names(scene, Tissue::kNeighbour);
  return {PartId::kNeighbour, "neighbour", there,
          there ? "the scene has adjacent teeth: the bur may touch them" : "no adjacent tooth"};
}

Part TouchCues(const Exercise& exercise) {
  const TouchCueSpec& c = exercise.touch_cues;
  if (c == TouchCueSpec{}) {
    return {PartId::kTouchCues, "touch cues", false, "the exercise does not ask for them"};
  }
  return {PartId::kTouchCues, "touch cues", true,
          "the exercise asks for a knock of up to " + std::to_string(c.contact_mn) +
              " mN on contact and chatter of up to " + std::to_string(c.chatter_mn) +
              " mN, worth at most " + std::to_string(c.energy_uj) + " uJ and " +
              std::to_string(c.power_uw) + " uW to the hand"};
}

Part OtherBurs(const Exercise& exercise) {
  if (const size_t others = exercise.other_burs.size(); others > 0) {
    return {PartId::kOtherBurs, "other burs", true,
            "the exercise has " + std::to_string(others) + " more to change to"};
  }
  return {PartId::kOtherBurs, "other burs", false,
          "the exercise has one bur, a " + std::string(cutting::BurShapeName(exercise.bur_shape))};
}

// Also in a replay: the state hash covers it.
Part Torque(const Use& use) {
  return {PartId::kTorque, "torque", use.torque,
          use.torque ? "the device has six driven axes" : "the device drives no rotation"};
}

Part Surface(const Use& use) {
  bool shown = use.window && !use.replay;
  return {PartId::kSurface, "surface", shown,
          shown ? "a window shows the tooth; off the tick's thread" : "no window"};
}

// Only drawn: neither the tick nor the score knows it.
Part Mouth(const Scene& scene, const Use& use) {
  const bool shown = use.window && !use.replay, tooth = IsToothNumber(scene.tooth);
  return {PartId::kMouth, "mouth", shown && tooth,
          !shown  ? "no window"
          : tooth ? "a window shows a tooth; --no-mouth leaves it out"
                  : "the scene has no tooth number"};
}

Part RubberDam(const Part& mouth, const Exercise& exercise) {
  const bool dam = exercise.isolation == Isolation::kRubberDam;
  return {PartId::kRubberDam, "rubber dam", mouth.kept && dam,
          !mouth.kept ? mouth.why
          : dam       ? "the exercise asks for it; it takes the gingiva's place"
                      : "the exercise does not ask for it"};
}

Part Antagonist(const Part& mouth) {
  return {PartId::kAntagonist, "antagonist", mouth.kept,
          mouth.kept ? "drawn only where the view or the mirror meets it" : mouth.why};
}

Part BusWrite(const Use& use) {
  return {PartId::kBusWrite, "bus write", !use.replay,
          use.replay ? "a replay has no device" : "the device gets its force every tick"};
}

}  // namespace

// Decisions only; what each costs is measured elsewhere, on the machine at hand
// (station/app/explain.h).
std::vector<Part> ListParts(const Scene& scene, const Exercise& exercise, const Use& use) {
  const Part mouth = Mouth(scene, use);
  return {
      Labels(scene),
      {PartId::kUniform, "uniform bricks", false,
       "air and the deep inside of a tissue are one word"},
      Neighbour(scene),
      {PartId::kTurning, "turning", true, "a bur must not cut by turning, felt or not"},
      Torque(use),
      TouchCues(exercise),
      OtherBurs(exercise),
      Surface(use),
      mouth,
      RubberDam(mouth, exercise),
      Antagonist(mouth),
      {PartId::kMirror, "mirror", false, "drawn only while the other hand holds it"},
      BusWrite(use),
      {PartId::kForceBounds, "force bounds", true,
       "part of the core: a recording replays with them"},
      {PartId::kStateHash, "state hash", true, "part of the core: a divergence must be found"},
  };
}

}  // namespace enamel::scene
