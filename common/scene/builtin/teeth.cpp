#include "common/scene/builtin/teeth.h"

#include <array>

namespace enamel::scene {
namespace {

ToothShape MakeMolar() {
  ToothShape t;
  t.fdi = 46;
  t.name = "molar-46";
  t.title = "Lower right first molar (FDI 46)";
  t.cervical_z = -3.75;
  t.sections.first_z = -7.5;
  t.sections.step_z = 1.5;
  //                    z = -7.5   -6    -4.5    -3   -1.5    0    1.5     3    4.5
  t.sections.mesial = {3.70, 3.95, 4.30, 4.78, 5.35, 5.78, 5.66, 5.00, 3.90};
  t.sections.distal = {3.70, 3.95, 4.30, 4.78, 5.40, 5.70, 5.66, 4.95, 3.90};
  t.sections.buccal = {3.15, 3.55, 4.20, 5.00, 5.22, 5.08, 4.66, 3.75, 2.95};
  t.sections.lingual = {3.05, 3.42, 3.92, 4.45, 4.95, 5.15, 5.02, 4.42, 3.15};
  t.cusps = {{2.40, 2.90, 3.45, 0.86},     // mesiobuccal
             {-0.90, 3.00, 3.30, 0.86},    // distobuccal
             {-3.90, 1.50, 2.90, 0.90},    // distal
             {2.50, -2.90, 4.00, 0.84},    // mesiolingual
             {-2.30, -2.90, 3.85, 0.84}};  // distolingual
  t.ridges = {{4.40, 0, 2.60, 1, 0, 1.0}, {-4.40, 0, 2.45, 1, 0, 1.0}};
  t.fossa_x = -0.10, t.fossa_y = 0.05;
  t.sections.lingual_taper = 0.10;
  t.sections.distal_taper = 0.08;
  t.grooves = {{Face::kBuccal, 0.75, 0.42, 0.42, -1.2},        // mesiobuccal
               {Face::kBuccal, -2.55, 0.34, 0.42, -3.0, 1.0},  // distobuccal, the longer one
               {Face::kLingual, 0.15, 0.36, 0.42}};
  t.trunk_z = -6.9;
  Root mesial, distal;
  mesial.x = {2.35, 2.75, 2.95, 2.75, 2.25};
  mesial.y = {0.00, -0.06, -0.12, -0.19, -0.25};
  mesial.half_x = {1.95, 1.65, 1.40, 1.12, 0.80};
  mesial.half_y = {3.75, 3.45, 2.95, 2.30, 1.55};
  mesial.groove = 0.22;
  distal.x = {-2.35, -2.80, -3.10, -3.25, -3.30};
  distal.y = mesial.y;
  distal.half_x = {1.90, 1.60, 1.32, 1.05, 0.75};
  distal.half_y = {3.45, 3.05, 2.50, 1.90, 1.25};
  distal.groove = 0.10;
  t.roots = {mesial, distal};
  t.pulp.middle = {0, 0, -4.0};
  t.pulp.half = {2.5, 1.7, 1.1};
  t.pulp.depth = 5.5;
  t.pulp.canals = {{0, 1.35, 0.35}, {0, -1.35, -0.65}, {1, 0, 0, 0.9}};
  t.lo = {-6.4, -5.9, -18.2};
  t.hi = {6.4, 5.9, 4.5};
  return t;
}

ToothShape MakeLeftMolar() {
  ToothShape t = LowerFirstMolar();
  t.fdi = 36;
  t.name = "molar-36";
  t.title = "Lower left first molar (FDI 36)";
  return t;
}

// The form of the first permanent molar, smaller, with three buccal cusps of nearly one height, a
// narrow neck, almost no root trunk and roots that stand far apart.
ToothShape MakePrimaryMolar() {
  ToothShape t;
  t.fdi = 85;
  t.name = "primary-molar-85";
  t.title = "Lower right second primary molar (FDI 85)";
  t.cervical_z = -2.75;
  t.sections.first_z = -5.5;
  t.sections.step_z = 1.1;
  //                    z = -5.5  -4.4  -3.3  -2.2  -1.1    0    1.1   2.2   3.3
  t.sections.mesial = {2.90, 3.10, 3.45, 4.10, 4.75, 4.98, 4.85, 4.25, 3.30};
  t.sections.distal = {2.90, 3.10, 3.45, 4.10, 4.75, 4.92, 4.80, 4.20, 3.30};
  t.sections.buccal = {2.40, 2.60, 3.00, 4.00, 4.42, 4.15, 3.55, 2.85, 2.20};
  t.sections.lingual = {2.35, 2.50, 2.85, 3.60, 4.15, 4.25, 3.95, 3.35, 2.45};
  t.sections.lingual_taper = 0.10;
  t.sections.distal_taper = 0.06;
  t.cusps = {{2.10, 2.10, 2.45, 0.80},     // mesiobuccal
             {-0.45, 2.25, 2.50, 0.80},    // distobuccal
             {-2.85, 1.55, 2.30, 0.85},    // distal
             {2.00, -2.20, 2.75, 0.80},    // mesiolingual
             {-1.90, -2.20, 2.65, 0.80}};  // distolingual
  t.ridges = {{3.90, 0, 1.85, 1, 0, 1.0}, {-3.90, 0, 1.75, 1, 0, 1.0}};
  t.fossa_x = -0.10, t.fossa_y = 0.05;
  t.grooves = {{Face::kBuccal, 0.85, 0.32, 0.36, -0.9, 1.1},
               {Face::kBuccal, -1.85, 0.30, 0.36, -1.6, 0.7},
               {Face::kLingual, 0.10, 0.28, 0.36, -0.9, 1.1}};
  t.trunk_z = -3.9;
  t.trunk_blend = 1.0;
  Root mesial, distal;
  mesial.x = {1.95, 2.75, 3.30, 3.25, 2.70};
  mesial.y = {0.00, -0.05, -0.10, -0.15, -0.20};
  mesial.half_x = {1.45, 1.10, 0.85, 0.70, 0.50};
  mesial.half_y = {2.80, 2.55, 2.15, 1.70, 1.10};
  mesial.groove = 0.18;
  mesial.length = 11.3;
  distal = mesial;
  distal.x = {-1.95, -2.80, -3.35, -3.30, -2.75};
  distal.half_y = {2.60, 2.30, 1.90, 1.45, 0.95};
  distal.groove = 0.08;
  t.roots = {mesial, distal};
  t.enamel = {1.25, 0.9, 0.78, 0.45, 0.5, 0};
  t.pulp.middle = {0, 0, -2.0};
  t.pulp.half = {2.75, 2.05, 1.2};
  t.pulp.lean_x = 0.78, t.pulp.lean_y = 0.66, t.pulp.depth = 3.6;
  t.pulp.radius = 0.55, t.pulp.tip_radius = 0.2;
  t.pulp.canals = {
      {0, 1.1, 0.3, 0, 0.4, 0.12}, {0, -1.1, -0.5, 0, 0.4, 0.12}, {1, 0, 0, 0.9, 0.4, 0.12}};
  t.lo = {-5.6, -4.9, -14.5};
  t.hi = {5.6, 4.9, 3.3};
  return t;
}

ToothShape MakePremolar() {
  ToothShape t;
  t.fdi = 14;
  t.name = "premolar-14";
  t.title = "Upper right first premolar (FDI 14)";
  t.cervical_z = -4.25;
  t.sections.first_z = -8.25;
  t.sections.step_z = 1.6;
  //                  z = -8.25 -6.65 -5.05 -3.45 -1.85 -0.25  1.35  2.95  4.55
  t.sections.mesial = {1.75, 2.00, 2.35, 2.65, 3.00, 3.40, 3.50, 3.20, 2.20};
  t.sections.distal = {1.75, 2.00, 2.35, 2.65, 3.00, 3.40, 3.50, 3.20, 2.20};
  t.sections.buccal = {3.05, 3.45, 3.90, 4.25, 4.50, 4.40, 4.05, 3.50, 2.80};
  t.sections.lingual = {3.05, 3.45, 3.85, 4.15, 4.40, 4.50, 4.30, 3.60, 2.40};
  t.sections.round = 1.3;
  t.cusps = {{-0.30, 2.70, 4.25, 1.00}, {0.35, -2.45, 3.30, 0.95}};
  t.ridges = {{2.60, 0, 2.20, 1, 0, 1.0}, {-2.60, 0, 2.15, 1, 0.02, 1.0}};
  t.fossa_x = 0.05, t.fossa_y = -0.15;
  t.edge_blend = 0.9;
  // The mesial developmental depression, and the groove that crosses the mesial marginal ridge.
  t.grooves = {{Face::kMesial, 0, 0.45, 1.3, -9.0, -6.5, -2.6, -0.4}};
  t.fissures = {{1.2, -0.1, 3.6, 0, 0.35, 0.3}};
  t.trunk_z = -7.6;
  Root buccal, lingual;
  buccal.x = {0.00, 0.00, -0.05, -0.15, -0.30};
  buccal.y = {1.60, 1.75, 2.00, 2.20, 2.25};
  buccal.half_x = {2.20, 1.95, 1.65, 1.30, 0.90};
  buccal.half_y = {2.35, 2.10, 1.65, 1.30, 0.90};
  lingual.x = buccal.x;
  lingual.y = {-1.60, -1.75, -1.95, -2.10, -2.10};
  lingual.half_x = {2.15, 1.90, 1.55, 1.20, 0.80};
  lingual.half_y = {2.30, 2.00, 1.55, 1.20, 0.80};
  lingual.length = 13.2;
  t.roots = {buccal, lingual};
  t.enamel = {2.2, 2.4, 0.52, 0.30};
  t.pulp.middle = {0, 0, -4.0};
  t.pulp.half = {0.65, 2.0, 1.5};
  t.pulp.lean_x = 0.7, t.pulp.lean_y = 0.72, t.pulp.depth = 5.4;
  t.pulp.radius = 0.45, t.pulp.tip_radius = 0.2;
  t.pulp.canals = {{0, 0, 0, 0.2, 0.42, 0.15}, {1, 0, 0, 0.2, 0.42, 0.15}};
  t.lo = {-4.2, -5.2, -18.7};
  t.hi = {4.2, 5.2, 4.7};
  return t;
}

ToothShape MakeIncisor() {
  ToothShape t;
  t.fdi = 11;
  t.name = "incisor-11";
  t.title = "Upper right central incisor (FDI 11)";
  t.cervical_z = -5.25;
  t.sections.first_z = -8.65;
  t.sections.step_z = 1.75;
  //                  z = -8.65 -6.9  -5.15 -3.4  -1.65  0.1   1.85  3.6   5.35
  t.sections.mesial = {2.20, 2.75, 3.38, 3.62, 3.85, 4.05, 4.20, 4.25, 4.10};
  t.sections.distal = {2.20, 2.75, 3.38, 3.62, 3.85, 4.05, 4.20, 4.15, 3.80};
  t.sections.buccal = {2.00, 2.55, 3.15, 3.35, 2.75, 2.00, 1.45, 1.05, 0.65};
  t.sections.lingual = {2.00, 2.50, 3.10, 3.35, 2.75, 2.00, 1.45, 1.00, 0.55};
  t.sections.middle_y = {0, 0, 0, 0.10, 0.45, 0.60, 0.55, 0.35, 0.10};
  t.sections.round = 0.9;
  t.ridges = {{0.1, 0, 5.3, 0.006, 0.05, 1.0}};
  t.fossa_x = 0, t.fossa_y = 0;
  t.edge_blend = 0.7;
  t.grooves = {{Face::kLingual, 0, 0.55, 1.9, -3.0, -0.8, 2.5, 4.8}};  // the lingual fossa
  t.trunk_z = -9.2;
  t.trunk_blend = 1.2;
  Root root;
  root.x = {0.00, 0.00, -0.05, -0.10, -0.20};
  root.y = {0.00, 0.00, 0.00, -0.05, -0.10};
  root.half_x = {3.15, 2.80, 2.35, 1.80, 1.10};
  root.half_y = {3.00, 2.75, 2.35, 1.80, 1.10};
  root.length = 13;
  t.roots = {root};
  t.enamel = {1.35, 1.9, 1.0, 2.0, 3.5, 2.5};
  t.pulp.middle = {0, 0, -4.4};
  t.pulp.half = {1.05, 0.52, 3.2};
  t.pulp.canals = {{0, 0, 0, 0, 0.43, 0.16}};
  t.lo = {-4.7, -4.2, -18.7};
  t.hi = {4.7, 4.2, 5.7};
  return t;
}

}  // namespace

const ToothShape& LowerFirstMolar() {
  static const ToothShape shape = MakeMolar();
  return shape;
}

const ToothShape& LowerLeftFirstMolar() {
  static const ToothShape shape = MakeLeftMolar();
  return shape;
}

const ToothShape& PrimarySecondMolar() {
  static const ToothShape shape = MakePrimaryMolar();
  return shape;
}

const ToothShape& UpperFirstPremolar() {
  static const ToothShape shape = MakePremolar();
  return shape;
}

const ToothShape& UpperCentralIncisor() {
  static const ToothShape shape = MakeIncisor();
  return shape;
}

std::span<const ToothShape* const> BuiltinTeeth() {
  static const std::array<const ToothShape*, 5> all = {&LowerFirstMolar(), &LowerLeftFirstMolar(),
                                                       &PrimarySecondMolar(), &UpperFirstPremolar(),
                                                       &UpperCentralIncisor()};
  return all;
}

}  // namespace enamel::scene
