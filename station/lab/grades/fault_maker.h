#pragma once

#include <algorithm>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "common/surface/surface.h"
#include "station/lab/grades/faults.h"

// Makes the faults of one exercise, for FaultsOf in faults.h only.
namespace enamel::station::lab {

class FaultMaker {
 public:
  // Both outlive the object and its faults.
  FaultMaker(const scene::BuiltScene& built, const scene::Exercise& exercise, const Task& task,
             bool few);
  std::vector<Fault> Make();

 private:
  static constexpr double kMm = 1e3, kMm3 = 1e9;
  static constexpr double kAngleTolerance_deg = 0.5, kShareTolerance_percent = 1;

  // A fault's size, and whether it reaches its threshold, so that it must cost a point.
  struct Size {
    double value = 0;
    bool must_cost = true;
    double m() const { return value / kMm; }  // of one in mm
  };
  // All of `all`, or only the threshold, which is one of them.
  std::vector<Size> Sizes(std::initializer_list<double> all, double threshold) const;

  void Add(std::string name, Size size, const char* unit, std::string metric, double tolerance,
           Hollow taken, Neighbours neighbours = Neighbours::kSpared);
  // In mm, found within a quarter of a voxel.
  void AddMm(std::string name, Size size, std::string metric, Hollow taken);
  void AddDegrees(std::string name, Size size, std::string metric, Hollow taken);
  // All surfaces farther out, or less far, than wanted by what no eye sees. `moved`: the task so.
  void AddAllSurfaces(std::string metric_over, std::string metric_short,
                      const std::function<Hollow(double by_m)>& moved);
  Hollow Wanted() const;

  // A box: faults_of_cavity.cpp.
  void MakeBox();
  Hollow BoxWith(size_t face, const Face& as) const;
  bool HasWall(size_t wall) const { return wall != 0 || !task_.open_mesial; }
  std::vector<Size> WallSizes(size_t wall) const;
  double RoomBehind_m(size_t wall) const;
  std::vector<Size> LeanSizes(std::initializer_list<double> all) const;
  void MakeLeaningWalls(size_t wall);
  void MoveBox();
  void MakeMargins();
  void AddPillars();
  void AddCaries();

  // A shape on the block, or a layer off a face: faults_of_shape.cpp.
  void MakeShape();
  void MakeLeaningShape();
  scene::Preparation WithOpenEnds();
  double CornerMovesBy() const;
  dvec3 LevelFloor_m() const;
  void MakeFace();
  void MakeUnevenFace();
  void MakeFaceMargin();
  template <typename Over, typename Raised>
  void AddFollowing(const dvec3& at, const Over& over, const Raised& raised);
  // A crown: in faults_of_shape.cpp too.
  void MakeCrown();

  // For all exercises: faults.cpp.
  void AddGouges(const dvec3& lo, const dvec3& hi);
  void AddBump(const dvec3& at);
  void AddMargin(Size size, Hollow taken);
  void AddStoppedEarly();
  double TakenAbove(double z);
  void AddElsewhere();
  bool PlaceElsewhere(dvec3& lo, dvec3& hi) const;
  double TopNear(const dvec3& at) const;
  void AddShaving();
  const surface::Mesh& Surface();
  double AreaWhere_m2(const std::function<bool(const dvec3&)>& counts);
  bool FarFromCut(const dvec3& p) const;
  void AddNeighbour();
  std::optional<dvec3> NearestNeighbour();
  void AddNick(const dvec3& nearest, Size size);
  // Errors that no examiner passes: faults_critical.cpp.
  void AddCriticalPairs();
  void AddCritical(const char* error, Hollow taken, Neighbours neighbours = Neighbours::kSpared);
  bool Is(std::initializer_list<const char*> kinds) const;
  void LookAtTissues();
  void AddPartsOf(const dvec3& voxel_m, std::vector<dvec3>& out) const;
  bool IsAtNeighbour(const dvec3& p) const;
  // The exercise's rubric has this critical error.
  bool Fails(std::string_view error) const;
  double LimitOf(std::string_view error) const;  // in the rubric
  void AddPulpExposed();
  void AddCriticalOfBox();
  void AddCriticalOfCrown();
  void AddSideUntouched();
  std::string CommittedBy(const Fault& fault) const;
  bool HasCaries() const { return exercise_.target.landmark == "caries"; }

  const cutting::Volume& volume_;
  const scene::Exercise& exercise_;
  const Task& task_;
  const bool few_;
  double quarter_m_ = 0, near_m_ = 0;
  dvec3 landmark_m_{0}, grid_lo_m_{0}, grid_hi_m_{0};
  surface::Mesh surface_;                  // of the tooth, computed on first use
  std::vector<float> heights_;             // of points of the task
  std::vector<dvec3> pulp_m_, contact_m_;  // voxels; contact: of the task
  std::vector<dvec3> caries_m_;            // parts of voxels, of the task
  double highest_m_ = 0;
  double task_m3_ = 0;  // without neighbours, computed on first use
  std::vector<Fault> out_;
};

}  // namespace enamel::station::lab
