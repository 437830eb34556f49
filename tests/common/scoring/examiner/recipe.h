#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/scene/builtin/builtin.h"
#include "common/surface/surface.h"

// Cuts of another hand: recipes of analytic shapes (../shared/data/cuts/README.md says what each word means), carved into
// an exercise's tooth. Millimetres and degrees from the exercise's landmark.
// Thread safety: const after construction.
namespace enamel::scoring::examiner {

struct Shape {
  std::string kind;  // "cav", "ref", "sphere"; with a "k" before it: what stays standing
  std::map<std::string, double> values;

  double Of(const std::string& key, double otherwise = 0) const;
  bool Has(const std::string& key) const { return values.contains(key); }
};

struct Recipe {
  std::string name;
  std::vector<Shape> shapes;
};
// One a line: name | shape key=value ... shape ... Fails the test where a file cannot be read.
std::vector<Recipe> ReadRecipes(const std::filesystem::path& path);

class Carver {
 public:
  // `built` and `exercise` are kept, not copied.
  Carver(const scene::BuiltScene& built, const scene::Exercise& exercise);
  cutting::Volume Carve(const Recipe& recipe) const;

 private:
  // Signed distances from a shape, mm; `p`: from the landmark.
  double Distance(const Shape& shape, const dvec3& p) const;
  double Target(const Shape& shape, const dvec3& p) const;
  double Box(const Shape& shape, const dvec3& p) const;
  double Shell(const Shape& shape, const dvec3& p) const;
  // A point moved back by what a shape was turned and shifted.
  dvec3 Back(const Shape& shape, dvec3 p) const;
  double All(const Recipe& recipe, const dvec3& p, bool neighbour) const;

  const scene::BuiltScene& built_;
  const scene::Preparation target_;
  dvec3 landmark_mm_{0}, half_mm_{0};
  double depth_mm_ = 0;
  std::optional<surface::DistanceQuery> untouched_;
};

}  // namespace enamel::scoring::examiner
