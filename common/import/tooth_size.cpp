#include "common/import/tooth_size.h"

#include <array>
#include <cstddef>

namespace enamel::import {
namespace {

constexpr std::array<ToothSize, 8> kUpper = {{{10.5, 8.5, 7.0},
                                              {9.0, 6.5, 6.0},
                                              {10.0, 7.5, 8.0},
                                              {8.5, 7.0, 9.0},
                                              {8.5, 7.0, 9.0},
                                              {7.5, 10.0, 11.0},
                                              {7.0, 9.0, 11.0},
                                              {6.5, 8.5, 10.0}}};
constexpr std::array<ToothSize, 8> kLower = {{{9.0, 5.0, 6.0},
                                              {9.5, 5.5, 6.5},
                                              {11.0, 7.0, 7.5},
                                              {8.5, 7.0, 7.5},
                                              {8.0, 7.0, 8.0},
                                              {7.5, 11.0, 10.5},
                                              {7.0, 10.5, 10.0},
                                              {7.0, 10.0, 9.5}}};
constexpr std::array<ToothSize, 5> kUpperPrimary = {
    {{6.0, 6.5, 5.0}, {5.6, 5.1, 4.0}, {6.5, 7.0, 7.0}, {5.1, 7.3, 8.5}, {5.7, 8.2, 10.0}}};
constexpr std::array<ToothSize, 5> kLowerPrimary = {
    {{5.0, 4.2, 4.0}, {5.2, 4.1, 4.0}, {6.0, 5.0, 4.8}, {6.0, 7.7, 7.0}, {5.5, 9.9, 8.7}}};

}  // namespace

const ToothSize& MeanSize(int tooth) {
  const int quadrant = tooth / 10;
  const auto place = static_cast<size_t>(tooth % 10 - 1);
  const bool upper = quadrant % 4 == 1 || quadrant % 4 == 2;
  if (quadrant > 4) return upper ? kUpperPrimary.at(place) : kLowerPrimary.at(place);
  return upper ? kUpper.at(place) : kLower.at(place);
}

}  // namespace enamel::import
