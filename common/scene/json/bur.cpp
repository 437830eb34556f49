#include "common/scene/json/bur.h"

#include <boost/json.hpp>
#include <string>
#include <string_view>
#include <utility>

namespace enamel::scene {
namespace {

struct OptionalLength {
  const char* name;
  int32_t BurSpec::*member;
};
constexpr OptionalLength kOptionalLengths[] = {{"narrow_radius_um", &BurSpec::narrow_radius_um},
                                               {"shank_radius_um", &BurSpec::shank_radius_um},
                                               {"neck_um", &BurSpec::neck_um}};

// "123 456 789 012 345".
bool IsIsoNumber(std::string_view text) {
  constexpr size_t kSize = 19;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool right = i % 4 == 3 ? text[i] == ' ' : text[i] >= '0' && text[i] <= '9';
    if (!right) return false;
  }
  return text.size() == kSize;
}

std::string ShapeNames() {
  std::string out;
  for (const auto& [shape, name] : cutting::kBurShapeNames) {
    out += (out.empty() ? "" : ", ") + std::string(name);
  }
  return out;
}

}  // namespace

boost::json::object BurJson(const BurSpec& bur) {
  boost::json::object out{{"shape", cutting::BurShapeName(bur.shape)},
                          {"radius_um", bur.radius_um},
                          {"length_um", bur.length_um}};
  for (const OptionalLength& o : kOptionalLengths) {
    // Left out where 0, so that a bur of format 1 keeps its text and with it its document's
    // address.
    if (bur.*o.member != 0) out[o.name] = bur.*o.member;
  }
  return out;
}

BurSpec ReadBur(ObjectReader& in) {
  BurSpec bur;
  std::string shape = in.Name("shape");
  auto known = cutting::BurShapeFromName(shape);
  if (!known) in.Refuse("shape", "one of " + ShapeNames(), "\"" + shape + "\"");
  bur.shape = known.value_or(cutting::BurShape::kSphere);
  bur.radius_um = static_cast<int32_t>(in.Int("radius_um", 50, 5'000));
  bool sphere = bur.shape == cutting::BurShape::kSphere;
  bur.length_um = static_cast<int32_t>(in.Int("length_um", sphere ? 0 : 100, 20'000));
  for (const OptionalLength& o : kOptionalLengths) {
    // From 1: 0 is said by saying nothing, or one bur would have two texts.
    if (in.Has(o.name)) bur.*o.member = static_cast<int32_t>(in.Int(o.name, 1, 20'000));
  }
  if (auto why = cutting::WhyImpossible(bur.metric())) {
    in.Refuse("narrow_radius_um", std::string(*why),
              "radius " + std::to_string(bur.radius_um) + ", length " +
                  std::to_string(bur.length_um) + ", narrow radius " +
                  std::to_string(bur.narrow_radius_um) + " um");
  }
  return bur;
}

boost::json::object NumberedBurJson(const BurSpec& bur) {
  boost::json::object out = BurJson(bur);
  if (!bur.iso_number.empty()) out["iso_number"] = bur.iso_number;
  return out;
}

BurSpec ReadNumberedBur(ObjectReader in) {
  constexpr const char* kNumber = "iso_number";
  BurSpec bur = ReadBur(in);
  if (in.Has(kNumber)) {
    bur.iso_number = in.Text(kNumber, 1, 64);
    // Its last group: the largest diameter, 1/10 mm.
    const int32_t size = (2 * bur.radius_um + 50) / 100;
    const std::string digits = std::to_string(1000 + size).substr(1);
    if (!IsIsoNumber(bur.iso_number)) {
      in.Refuse(kNumber, "five groups of three digits, a space between two",
                "\"" + bur.iso_number + "\"");
    } else if (!bur.iso_number.ends_with(digits)) {
      in.Refuse(kNumber, "a number that ends in " + digits + ", the bur's diameter in 1/10 mm",
                bur.iso_number);
    }
  }
  in.Finish();
  return bur;
}

}  // namespace enamel::scene
