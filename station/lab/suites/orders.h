#pragma once

#include <vector>

#include "station/lab/suites/findings.h"

// How fast the errors of what is computed beside the cut fall with its step, each against a closed form: metrics of
// scores and meshes with the voxel, pictures with the mesh, simulated devices with the time step. Deterministic.
namespace enamel::station::lab {

// Errors at one step, a sample each: grids that lie differently, hands, or starts in a cell.
struct StepErrors {
  double step = 0;
  std::vector<double> errors;
};
// `named` with its figures. `paired`: a sample is the same hand at each step (order.h). Requires: two steps or more,
// coarse to fine, each half of the one before.
OrderRow OrderRowOf(OrderRow named, const std::vector<StepErrors>& coarse_to_fine,
                    bool paired = false);

// A sphere of 1 mm on eight grids: distance of the mesh's vertices and its volume; its outline as seen from one side
// by parallel rays, which is what a picture of it is filled within.
std::vector<OrderRow> MeshOrders(bool quick);

// A cavity in the block of grades/hollow.h, cut by formula, turned off the grid, on eight grids: a wall 0.13 mm too far
// and a floor 0.17 mm too deep, the volume that is, and a wall that leans by 5 degrees.
std::vector<OrderRow> ScoreOrders(bool quick, int threads);

// The device of `model` in eight hands of 0.3 to 5 N/mm that are drawn along at constant speed: the spring's stretch,
// and the energy that the device's damping takes. Then loops closed over a law in a hand of 30 g that pushes and lets
// go, from eight starts in a cell, against a step eight times finer than the finest: the energy that the hand puts in,
// and what it gets back from plain Maxwell.
std::vector<OrderRow> PlantOrders(const DeviceModel& model);

}  // namespace enamel::station::lab
